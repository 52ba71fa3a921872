#pragma once

#include "../limit_judge.hpp"
#include "peer_osd.hpp"

#include <functional>
#include <utility>
#include <vector>

namespace tetrakis::bench {

/// Makes a peer's mesh, with normals. Keeps the control mesh's data. Empty where the tolerance cannot be met within 5
/// million triangles.
using PeerWork = std::function<PeerMesh()>;

/// With the least of the rates 1, 2, 3, 4, 6, 8, 12, 16, 24, 32 that meets the tolerance.
/// @param tolerance  from limit to mesh, relative to the limit's diagonal
PeerWork best_uniform_rate(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge, double tolerance);
/// With rates per edge, and the least factor k (to one per cent) with which they meet the tolerance.
PeerWork best_adaptive_rates(const ControlMeshData& data, SchemeKind scheme, const LimitJudge& judge, double tolerance);

/// Points and triangles of a peer's mesh for the judge.
std::pair<std::vector<Vec3d>, std::vector<std::array<std::uint32_t, 3>>> in_double(const PeerMesh& mesh);

}  // namespace tetrakis::bench
