#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../uniform/repeated_rows.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Weighted sums of control points for the sites of a mesh, by stencil rows that repeat from level to level
/// (RepeatedRows). The rules make the first levels of the mesh whole. On later levels only the vertices that these sums
/// need are evaluated.
class SiteRows {
  public:
    enum class Wanted {
        positions,
        rings,  ///< the point, then its neighbours (RootLattices::around()), if closed with the first one again at the
                ///< end; not for dual schemes
        limits,
        normals  ///< four rows: tangents of one or two sides
    };
    /// As a level: for each site the first level on which it is a vertex.
    static constexpr int k_own_level = -1;

    /// @param roots         of a dual scheme; otherwise empty
    /// @param whole_levels  as in row_points()
    SiteRows(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, const VertexRoots& roots,
             const RunContext& context, bool whole_levels);

    bool dual() const { return roots_.count() != 0; }
    /// Level of the scheme minus level of the site for the same vertex.
    int offset() const { return triangles_ ? 0 : 1; }
    /// The site written at its lowest level. Sites of sqrt(3) and of cells always are.
    Site own_site(const Site& site) const { return dual() || factor_ != 2 ? site : minimal_level(site); }
    int own_level(const Site& site) const { return own_site(site).level + offset(); }

    struct Sums {
        std::vector<Vec3d> value;
        std::uint32_t last_row = 0;
    };
    /// Calls finish(number of the site, sums) for each site that has rows, from several threads.
    /// @return  the numbers of the sites without rows
    std::vector<std::size_t> evaluate(std::span<const Site> sites, Wanted wanted, int level,
                                      const std::function<void(std::size_t, const Sums&)>& finish) const;

  private:
    struct Rows;
    struct Address;
    struct Workspace;

    const Rows* rows_for(std::span<const Site> sites, Wanted wanted, int level) const;
    std::shared_ptr<Rows> make() const;
    std::unique_ptr<const RepeatedRows> repeated_rows(bool limit, bool normals) const;
    void make_whole_levels(Rows& rows, std::span<const Site> sites, Wanted wanted, int level) const;
    void set_middle(Rows& rows) const;
    Address address(const Rows& rows, const Site& any, Wanted wanted, int level) const;
    void evaluate_block(const Rows& rows, std::span<const Site> sites, std::size_t first, Wanted wanted, int level,
                        std::span<std::uint8_t> missing,
                        const std::function<void(std::size_t, const Sums&)>& finish) const;
    static void evaluate_levels(const Rows& rows, std::size_t base, std::size_t deepest, Workspace& work);
    template <class Take>
    static void for_each_term(const Rows& rows, const Address& address, Wanted wanted, const Take& take);

    const ControlMesh& mesh_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    const VertexRoots& roots_;
    bool triangles_, whole_levels_;
    std::uint32_t factor_;  ///< segments of a level / segments of the level before
    std::uint64_t max_memory_bytes_, most_by_rules_, most_whole_;
    mutable std::mutex mutex_;
    mutable bool tried_ = false;
    mutable std::shared_ptr<Rows> rows_;
    mutable oneapi::tbb::enumerable_thread_specific<std::shared_ptr<Workspace>>
        workspaces_{};  ///< what blocks have grown
};

}  // namespace tetrakis::detail
