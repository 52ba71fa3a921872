#include "linear_bound.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"
#include "../triangles/face_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrakis {

LinearBound::LinearBound(const ControlMesh& mesh, const SchemeInfo& scheme)
    : mesh_(mesh), flat_(scheme.family == MeshFamily::triangles) {
    rounding_ = detail::surface_rounding(mesh);
    if (flat_) return;
    face_bound_.resize(mesh.face_count());
    for_each_index(
        mesh.face_count(), [&](std::uint32_t f) { face_bound_[f] = flat_face_bound(FaceId(f)); }, 256);
}

double LinearBound::flat_face_bound(FaceId face) const {
    std::vector<Vec3d> corners;
    for (std::uint32_t i = 0; i < mesh_.face_size(face); ++i)
        corners.push_back(mesh_.position(mesh_.origin(HalfedgeId(mesh_.face_halfedge(face).value + i))));
    const detail::FaceDistance flat(corners);
    return flat.convex() ? 2 * flat.height() + rounding_ : std::numeric_limits<double>::infinity();
}

Vec3d LinearBound::twist(HalfedgeId cell) const {
    const FaceId face = mesh_.face(cell);
    const std::uint32_t size = mesh_.face_size(face), h0 = mesh_.face_halfedge(face).value;
    Vec3d centre(0);
    for (std::uint32_t i = 0; i < size; ++i) centre += mesh_.position(mesh_.origin(HalfedgeId(h0 + i)));
    centre /= static_cast<double>(size);
    return centre - 0.5 * (mesh_.position(mesh_.target(cell)) + mesh_.position(mesh_.origin(mesh_.prev(cell))));
}

double LinearBound::bound(const CellTriangle& t) const {
    if (flat_) return rounding_;
    const double of_face = face_bound_[mesh_.face(t.root).value];
    if (t.level == 0 && t.corner[1].x == 2)  // two flat halves, one over each of two cells
        return std::min(
            of_face, rounding_ + 0.25 * std::max(glm::length(twist(t.root)), glm::length(twist(mesh_.next(t.root)))));
    const double unit = std::ldexp(1.0, -t.level);
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const LatticePoint a = t.corner[k], b = t.corner[(k + 1) % 3];
        const double dx = (static_cast<double>(b.x) - a.x) * unit, dy = (static_cast<double>(b.y) - a.y) * unit;
        most = std::max(most, std::abs(dx * dy));
    }
    return std::min(of_face, rounding_ + 0.25 * most * glm::length(twist(t.root)));
}

double LinearBound::fan_bound(FaceId face) const {
    const std::uint32_t size = mesh_.face_size(face), h0 = mesh_.face_halfedge(face).value;
    if (flat_ || size == 3) return rounding_;
    if (size > 4) return face_bound_[face.value];
    const auto at = [&](std::uint32_t i) { return mesh_.position(mesh_.origin(HalfedgeId(h0 + i))); };
    // The four cells of a quad are one bilinear patch.
    return std::min(face_bound_[face.value], rounding_ + 0.25 * glm::length(at(0) - at(1) + at(2) - at(3)));
}

void LinearBound::bound(std::span<const CellTriangle> triangles, std::optional<double>,
                        std::span<double> errors) const {
    for_each_index(static_cast<std::uint32_t>(triangles.size()),
                   [&](std::uint32_t i) { errors[i] = bound(triangles[i]); });
}

void LinearBound::bound_fans(const FanChoice&, std::span<const FaceId> faces, std::span<const Vec3d>,
                             std::optional<double>, std::span<double> errors) const {
    std::ranges::transform(faces, errors.begin(), [&](FaceId face) { return fan_bound(face); });
}

}  // namespace tetrakis
