#include "linear_bound.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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
    constexpr double k_none = std::numeric_limits<double>::infinity();
    const std::uint32_t size = mesh_.face_size(face), h0 = mesh_.face_halfedge(face).value;
    const auto at = [&](std::uint32_t i) { return mesh_.position(mesh_.origin(HalfedgeId(h0 + i % size))); };
    Vec3d normal(0), centre(0);
    for (std::uint32_t i = 0; i < size; ++i) centre += at(i) / static_cast<double>(size);
    for (std::uint32_t i = 0; i < size; ++i) normal += glm::cross(at(i) - centre, at(i + 1) - centre);
    const double length = glm::length(normal);
    if (!(length > 0)) return k_none;
    normal /= length;
    // Turning left at every corner, once around in all: convex.
    double off = 0, turned = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
        const auto flat = [&](const Vec3d& d) { return d - glm::dot(normal, d) * normal; };
        const Vec3d in = flat(at(i + 1) - at(i)), out = flat(at(i + 2) - at(i + 1));
        const double sine = glm::dot(normal, glm::cross(in, out)), cosine = glm::dot(in, out);
        if (!(sine > 0)) return k_none;
        turned += std::atan2(sine, cosine);
        off = std::max(off, std::abs(glm::dot(normal, at(i) - centre)));
    }
    constexpr double k_once = 3 * std::numbers::pi;  // once around is 2 pi, twice 4
    return turned < k_once ? 2 * off + rounding_ : k_none;
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
    if (t.level == 0 && t.corner[1].x == 2)  // two flat halves, each of one cell
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

void LinearBound::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    for_each_index(static_cast<std::uint32_t>(triangles.size()),
                   [&](std::uint32_t i) { errors[i] = bound(triangles[i]); });
}

bool LinearBound::has_fan_bound(FaceId face) const { return std::isfinite(fan_bound(face)); }

void LinearBound::estimate_fans(const FanChoice&, std::span<const FaceId> faces, std::span<const Vec3d>,
                                std::span<double> out) const {
    for (std::size_t i = 0; i < faces.size(); ++i) out[i] = fan_bound(faces[i]);
}

double LinearBound::largest(std::span<const CellTriangle> triangles, double known) const {
    for (const CellTriangle& t : triangles) known = std::max(known, bound(t));
    return known;
}

double LinearBound::largest_of_fans(const FanChoice&, std::span<const FaceId> faces, std::span<const Vec3d>,
                                    double known) const {
    for (const FaceId f : faces) known = std::max(known, fan_bound(f));
    return known;
}

}  // namespace tetrakis
