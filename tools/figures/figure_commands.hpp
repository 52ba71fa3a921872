#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace tetrakis::figures {

using Arguments = std::vector<std::string>;

/// A mesh that is fine in one place, by each family's own rule:
///   adaptive IN.obj SCHEME BASE:LEVEL X,Y,Z RADIUS OUT [quads | triangles]
/// Leaves that come within RADIUS of the point are refined to LEVEL, all others to BASE. "quads": pairs of triangles of
/// a bisection as the quads that they are halves of; "triangles": a dual mesh in triangles of the 4-8 pattern. OUT may
/// be "-": no file.
/// @returns points, faces, level of each face
nlohmann::json adaptive(const Arguments& arguments);

/// Refinement towards one inner point of a face, as deep as LEVEL, and coarse elsewhere: zoom IN.obj SCHEME LEVEL FACE
/// @returns points in the tangent plane of that point, which is the origin; faces, level of each face, leaf count
nlohmann::json zoom(const Arguments& arguments);

/// The half-steps of a factored scheme: factored IN.obj SCHEME STEPS
/// @returns points, faces of the 4-8 mesh, active (per point), own: points and faces of the scheme's own mesh after
///          the last whole step
nlohmann::json factored(const Arguments& arguments);

/// A control mesh from a scan: simplify IN.obj TRIANGLES OUT.obj. @throws std::runtime_error  built without
/// meshoptimizer
nlohmann::json simplify(const Arguments& arguments);

}  // namespace tetrakis::figures
