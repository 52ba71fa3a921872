#include "tetrakis/refine/sqrt3_rules.hpp"

#include "tetrakis/schemes/sqrt3.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace tetrakis::detail {

const Sqrt3Rules::Masks& Sqrt3Rules::masks(std::size_t valence) {
    if (masks_.size() <= valence) masks_.resize(valence + 1);
    Masks& masks = masks_[valence];
    if (!masks.cosine.empty()) return masks;
    const int n = static_cast<int>(valence);
    masks.vertex = Sqrt3::vertex_mask(n);
    masks.limit = Sqrt3::limit_mask(n);
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        masks.cosine.push_back(std::cos(angle));
        masks.sine.push_back(std::sin(angle));
    }
    return masks;
}

Vec3d Sqrt3Rules::centre(const std::array<Vec3d, 3>& corners) {
    Vec3d sum(0);
    for (const Vec3d& p : corners) sum += (1.0 / 3) * p;
    return sum;
}

Vec3d Sqrt3Rules::beside(const Vec3d& near, const Vec3d& far, const Vec3d* beyond) {
    const Vec3d p = Sqrt3::crease_middle * near + Sqrt3::crease_near * far;
    return p + Sqrt3::crease_far * (beyond != nullptr ? *beyond : 2.0 * near - far);
}

Vec3d Sqrt3Rules::moved(const Sqrt3Ring& ring, bool cuts_boundary) {
    if (!ring.closed) {
        if (!cuts_boundary || ring.corner) return ring.point;
        return Sqrt3::crease_vertex * ring.point + Sqrt3::crease_neighbour * ring.around.front() +
               Sqrt3::crease_neighbour * ring.around.back();
    }
    const RingMask& mask = masks(ring.around.size()).vertex;
    Vec3d sum = mask.vertex * ring.point;
    for (const Vec3d& q : ring.around) sum += mask.edge * q;
    return sum;
}

Vec3d Sqrt3Rules::limit_position(const Sqrt3Ring& ring) {
    const Vec3d& p = ring.point;
    if (!ring.closed)
        return ring.corner ? p
                           : k_crease_limit_mask.vertex * p + k_crease_limit_mask.neighbour * ring.around.front() +
                                 k_crease_limit_mask.neighbour * ring.around.back();
    const RingMask& mask = masks(ring.around.size()).limit;
    Vec3d sum = mask.vertex * p;
    for (const Vec3d& q : ring.around) sum += mask.edge * q;
    return sum;
}

LimitPoint Sqrt3Rules::limit(const Sqrt3Ring& ring) {
    const Vec3d& p = ring.point;
    LimitPoint out;
    out.position = limit_position(ring);
    if (!ring.closed) {
        Vec3d normal(0);
        for (std::size_t i = 0; i + 1 < ring.around.size(); ++i) {
            const Vec3d face = glm::cross(ring.around[i] - p, ring.around[i + 1] - p);
            if (const double length = glm::length(face); length > 0) normal += face / length;
        }
        if (const double length = glm::length(normal); length > 0) out.normal = normal / length;
        return out;
    }
    const Masks& of = masks(ring.around.size());
    for (std::size_t i = 0; i < ring.around.size(); ++i) {
        out.tangent1 += of.cosine[i] * ring.around[i];
        out.tangent2 += of.sine[i] * ring.around[i];
    }
    const Vec3d normal = glm::cross(out.tangent1, out.tangent2);
    if (const double length = glm::length(normal); length > 0) {
        out.normal = normal / length;
        out.has_tangent_plane = true;
    }
    return out;
}

}  // namespace tetrakis::detail
