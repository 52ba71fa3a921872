#include "fan_choice.hpp"

#include "../base/error.hpp"
#include "face_cutter.hpp"

#include <glm/geometric.hpp>

#include <string>
#include <utility>

namespace tetrakis {

namespace {

/// Cuts one face after the other.
class FanCutter {
  public:
    FanCutter(const ControlMesh& mesh, std::span<const Vec3d> positions)
        : mesh_(mesh), positions_(positions), joins_(mesh) {}

    /// Appends the n - 2 triangles of a face, n > 3, that face as it does and share no edge with other triangles but
    /// once; or nothing.
    bool cut(FaceId f, std::vector<std::array<std::uint8_t, 3>>& triangles) {
        const std::uint32_t h = mesh_.face_halfedge(f).value;
        const auto vertex = [&](std::uint32_t corner) { return mesh_.origin(HalfedgeId(h + corner)); };
        points_.clear();
        for (std::uint32_t i = 0; i < mesh_.face_size(f); ++i) points_.push_back(positions_[vertex(i).value]);
        const auto across = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            return glm::cross(points_[b] - points_[a], points_[c] - points_[a]);
        };
        Vec3d normal(0);
        for (std::uint32_t i = 1; i + 1 < points_.size(); ++i) normal += across(0, i, i + 1);
        const std::size_t first = triangles.size();
        bool forward = true;
        taken_.clear();
        const auto rest = cutter_.cut(
            points_, [&](std::uint32_t a, std::uint32_t b) { return !joins_.joined(vertex(a), vertex(b)); },
            [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
                triangles.push_back(
                    {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(tip), static_cast<std::uint8_t>(b)});
                taken_.emplace_back(vertex(a), vertex(b));
                forward &= glm::dot(across(a, tip, b), normal) > 0;
            });
        if (!rest.empty() || !forward) {
            triangles.resize(first);
            return false;
        }
        taken_.pop_back();  // of the last triangle
        for (const auto& [a, b] : taken_) joins_.join(a, b);
        return true;
    }

  private:
    const ControlMesh& mesh_;
    std::span<const Vec3d> positions_;
    detail::VertexJoins joins_;
    detail::FaceCutter cutter_;
    std::vector<Vec3d> points_;
    std::vector<std::pair<VertexId, VertexId>> taken_;
};

/// Two triangles with the same three vertices close up to a pillow: one of them has to keep its centre.
bool repeats_accepted_triangle(const ControlMesh& mesh, FaceId f, const FanChoice& fans) {
    const HalfedgeId h = mesh.face_halfedge(f), t = mesh.twin(h);
    if (!t.valid()) return false;
    const FaceId g = mesh.face(t);
    return mesh.face_size(g) == 3 && fans.accepted[g.value] != 0 &&
           mesh.origin(mesh.prev(t)) == mesh.origin(mesh.prev(h));
}

void require_size(std::size_t size, std::uint32_t wanted, const char* what) {
    if (size != wanted)
        throw Error(ErrorCode::invalid_input,
                    "fans need " + std::to_string(wanted) + " " + what + ", got " + std::to_string(size));
}

}  // namespace

FanChoice choose_fans(const ControlMesh& mesh, std::span<const Vec3d> positions, std::span<const std::uint8_t> wanted) {
    require_size(positions.size(), mesh.vertex_count(), "positions");
    require_size(wanted.size(), mesh.face_count(), "flags");
    FanChoice fans;
    fans.accepted.assign(mesh.face_count(), 0);
    fans.offsets.reserve(mesh.face_count() + 1);
    fans.offsets.push_back(0);
    FanCutter cutter(mesh, positions);
    for (std::uint32_t i = 0; i < mesh.face_count(); ++i) {
        const FaceId f(i);
        const std::uint32_t n = mesh.face_size(f);
        if (wanted[i] != 0 && !mesh.is_hole(f) && n <= k_max_fan_corners) {
            if (n > 3) {
                fans.accepted[i] = cutter.cut(f, fans.triangles);
            } else if (!repeats_accepted_triangle(mesh, f, fans)) {
                fans.accepted[i] = 1;
                fans.triangles.push_back({0, 1, 2});
            }
        }
        fans.offsets.push_back(static_cast<std::uint32_t>(fans.triangles.size()));
    }
    return fans;
}

}  // namespace tetrakis
