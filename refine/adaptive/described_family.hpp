#pragma once

#include "hierarchy_family.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A family's answers about leaves from its describe(leaf, view), which fills all of a view but the handle's generation
/// (a friend can be private), and its depth(leaf). For many leaves neither is called by way of a table.
template <class Family>
class DescribedFamily : public HierarchyFamily {
  public:
    using HierarchyFamily::view;
    LeafView view(LeafId leaf) const final {
        LeafView view;
        self().describe(leaf, view);
        return view;
    }
    void views(std::span<const LeafId> leaves, std::span<LeafView> views) const final {
        for (std::size_t i = 0; i < leaves.size(); ++i) self().describe(leaves[i], views[i]);
    }
    void remove_below(int least_depth, std::vector<LeafId>& leaves) const final {
        std::erase_if(leaves, [&](LeafId leaf) { return self().depth(leaf) >= least_depth; });
    }

  private:
    const Family& self() const { return static_cast<const Family&>(*this); }
};

}  // namespace tetrakis::detail
