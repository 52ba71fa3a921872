#pragma once

#include "../base/ids.hpp"

#include <vector>

namespace tetrakis {

/// What a change of a forest did to its leaves.
struct ForestChange {
    std::vector<LeafId> created;   ///< new leaves: children of split ones, siblings together; parents of merged ones
    std::vector<LeafId> reshaped;  ///< older leaves that remain, but whose part of the output is another than before
};

}  // namespace tetrakis
