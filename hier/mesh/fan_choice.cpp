#include "fan_choice.hpp"

#include "../base/error.hpp"
#include "face_cutter.hpp"

#include <fmt/format.h>

namespace tetrakis {

namespace {

/// Appends the n - 2 triangles of a face, n > 3, if the cutter finds free diagonals and all triangles face as the face
/// does; else nothing.
void cut_into_fan(detail::MeshFaceCutter& cutter, FaceId f, std::vector<std::array<std::uint8_t, 3>>& triangles) {
    const std::size_t first = triangles.size();
    bool forward = true;
    const auto rest = cutter.cut(f, [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
        triangles.push_back(
            {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(tip), static_cast<std::uint8_t>(b)});
        forward &= cutter.facing(a, tip, b) > 0;
    });
    if (!rest.empty() || !forward) return triangles.resize(first);
    for (std::size_t i = first; i + 1 < triangles.size(); ++i)  // the last triangle has no new diagonal
        cutter.take(triangles[i][0], triangles[i][2]);
}

/// Two triangles with the same three vertices would enclose no volume, so one of them must keep its centre.
bool repeats_accepted_triangle(const ControlMesh& mesh, FaceId f, const FanChoice& fans) {
    const HalfedgeId h = mesh.face_halfedge(f), t = mesh.twin(h);
    if (!t.valid()) return false;
    const FaceId g = mesh.face(t);
    return mesh.face_size(g) == 3 && fans.has(g) && mesh.origin(mesh.prev(t)) == mesh.origin(mesh.prev(h));
}

}  // namespace

FanChoice choose_fans(const ControlMesh& mesh, std::span<const Vec3d> positions) {
    if (positions.size() != mesh.vertex_count())
        throw Error(ErrorCode::invalid_input,
                    fmt::format("fans need {} positions, got {}", mesh.vertex_count(), positions.size()));
    FanChoice fans;
    fans.offsets.reserve(mesh.face_count() + 1);
    fans.offsets.push_back(0);
    detail::MeshFaceCutter cutter(mesh, positions);
    for (std::uint32_t i = 0; i < mesh.face_count(); ++i) {
        const FaceId f(i);
        const std::uint32_t n = mesh.face_size(f);
        if (!mesh.is_hole(f) && n <= k_max_fan_corners) {
            if (n > 3)
                cut_into_fan(cutter, f, fans.triangles);
            else if (!repeats_accepted_triangle(mesh, f, fans))
                fans.triangles.push_back({0, 1, 2});
        }
        fans.offsets.push_back(static_cast<std::uint32_t>(fans.triangles.size()));
    }
    return fans;
}

}  // namespace tetrakis
