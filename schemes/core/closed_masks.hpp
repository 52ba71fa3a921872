#pragma once

#include "sector_fan.hpp"

#include <utility>
#include <vector>

namespace tetrakis {

/// Limit and tangent masks as formulas, for the schemes and shapes where there are any; an empty mask has no formula.
/// Limit weights sum to one, tangent weights to zero; the tangents' scale is free, and at a boundary the first one is
/// along it.
struct ClosedMasks {
    using Mask = std::vector<std::pair<FanLabel, double>>;
    Mask limit, tangent1, tangent2;
    double lambda1 = 0, lambda2 = 0;  ///< eigenvalues of the tangents
};

}  // namespace tetrakis
