#include "sqrt3_rules.hpp"

#include "../../hier/base/error.hpp"
#include "../../schemes/analysis/spectrum.hpp"
#include "../../schemes/rules/sqrt3.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

namespace tetrakis::detail {

namespace {

Vec3d sum(std::span<const Vec3d> points) {
    return std::accumulate(points.begin(), points.end(), Vec3d(0), std::plus<Vec3d>());
}

}  // namespace

bool Sqrt3Ring::is_finite() const {
    return is_semi_sharp(vertex_sharpness) ||
           std::any_of(sharp.begin(), sharp.end(), [](const auto& edge) { return is_semi_sharp(edge.second); });
}

float Sqrt3Rules::vertex_sharpness(const ControlMesh& mesh, const Sqrt3Vertex& v, int level) {
    if (v.kind != Sqrt3Vertex::Kind::control) return 0;
    float sharpness = mesh.sharpness(VertexId(static_cast<std::uint32_t>(v.key)));
    for (int k = 1; k < level && is_semi_sharp(sharpness); k += 2) sharpness = child_sharpness(sharpness);
    return sharpness;
}

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

Vec3d Sqrt3Rules::beside_smooth(const Vec3d& near, const Vec3d& opposite, const Vec3d& beyond) {
    return (1.0 / 3) * near + (1.0 / 3) * (opposite + beyond);
}

Vec3d Sqrt3Rules::beside(const Vec3d& near, const Vec3d& far, const Vec3d* beyond) {
    const Vec3d p = Sqrt3::crease_middle * near + Sqrt3::crease_near * far;
    return p + Sqrt3::crease_far * (beyond != nullptr ? *beyond : 2.0 * near - far);
}

Vec3d Sqrt3Rules::moved(const Sqrt3Ring& ring, bool cuts) {
    const VertexRule rule = ring.rule();
    if (rule == VertexRule::corner || (rule == VertexRule::crease && !cuts)) return ring.point;
    if (rule == VertexRule::crease)
        return Sqrt3::crease_vertex * ring.point + Sqrt3::crease_neighbour * ring.around[ring.sharp[0].first] +
               Sqrt3::crease_neighbour * ring.around[ring.sharp[1].first];
    return masked(masks(ring.around.size()).vertex, ring.point, sum(ring.around));
}

// The ring alone decides it: what is around goes to the points of the faces and edges at the vertex.
Sqrt3Ring Sqrt3Rules::after_two_steps(const Sqrt3Ring& ring) {
    const std::size_t count = ring.around.size(), faces = ring.closed ? count : count - 1;
    std::vector<Vec3d> centres;
    for (std::size_t i = 0; i < faces; ++i)
        centres.push_back(centre({ring.point, ring.around[i], ring.around[(i + 1) % count]}));
    // Between the steps: around are the centres, and what sharp edges go to.
    Sqrt3Ring between;
    between.point = moved(ring, false);
    between.closed = ring.closed;
    between.vertex_sharpness = ring.vertex_sharpness;
    std::vector<std::uint8_t> is_sharp_edge(count, 0);
    for (const auto& [at, sharpness] : ring.sharp) is_sharp_edge[at] = 1;
    for (std::size_t i = 0, next = 0; i < count; ++i) {
        if (is_sharp_edge[i] != 0) {
            between.sharp.emplace_back(between.around.size(), ring.sharp[next++].second);
            between.around.push_back(ring.around[i]);
        }
        if (i < faces) between.around.push_back(centres[i]);
    }
    Sqrt3Ring after;
    after.point = moved(between, true);
    after.closed = ring.closed;
    after.vertex_sharpness = child_sharpness(ring.vertex_sharpness);
    const bool crease = ring.rule() == VertexRule::crease;
    for (std::size_t i = 0, next = 0; i < count; ++i) {
        if (is_sharp_edge[i] == 0) {
            after.around.push_back(centre({between.point, centres[(i + faces - 1) % faces], centres[i]}));
            continue;
        }
        const float sharpness = child_sharpness(ring.sharp[next].second);
        if (is_sharp(sharpness)) after.sharp.emplace_back(i, sharpness);
        const Vec3d* beyond = crease ? &ring.around[ring.sharp[1 - next].first] : nullptr;
        after.around.push_back(beside(between.point, ring.around[i], beyond));
        ++next;
    }
    return after;
}

Sqrt3Ring Sqrt3Rules::settled(Sqrt3Ring ring) {
    while (ring.is_finite()) ring = after_two_steps(ring);
    return ring;
}

Vec3d Sqrt3Rules::limit_position(const Sqrt3Ring& ring) {
    if (ring.is_finite()) return limit_position(settled(ring));
    const Vec3d& p = ring.point;
    switch (ring.rule()) {
        case VertexRule::corner:
            return p;
        case VertexRule::crease:
            return k_crease_limit_mask.vertex * p + k_crease_limit_mask.neighbour * ring.around[ring.sharp[0].first] +
                   k_crease_limit_mask.neighbour * ring.around[ring.sharp[1].first];
        case VertexRule::dart:
            return dart_limit(ring).position;
        case VertexRule::smooth:
            break;
    }
    return masked(masks(ring.around.size()).limit, p, sum(ring.around));
}

namespace {

void add_tangent_plane(LimitPoint& out) {
    const Vec3d normal = glm::cross(out.tangent1, out.tangent2);
    if (const double length = glm::length(normal); length > 0) {
        out.normal = normal / length;
        out.has_tangent_plane = true;
    }
}

Vec3d mean_face_normal(const Sqrt3Ring& ring) {
    const Vec3d& p = ring.point;
    const std::size_t count = ring.around.size();
    Vec3d normal(0);
    for (std::size_t i = 0; i + (ring.closed ? 0 : 1) < count; ++i) {
        const Vec3d face = glm::cross(ring.around[i] - p, ring.around[(i + 1) % count] - p);
        if (const double length = glm::length(face); length > 0) normal += face / length;
    }
    const double length = glm::length(normal);
    return length > 0 ? normal / length : normal;
}

}  // namespace

LimitPoint Sqrt3Rules::limit(const Sqrt3Ring& ring) {
    if (ring.is_finite()) return limit(settled(ring));
    if (ring.rule() == VertexRule::dart) return dart_limit(ring);
    LimitPoint out;
    out.position = limit_position(ring);
    if (ring.rule() != VertexRule::smooth) {
        out.normal = mean_face_normal(ring);
        return out;
    }
    const Masks& of = masks(ring.around.size());
    for (std::size_t i = 0; i < ring.around.size(); ++i) {
        out.tangent1 += of.cosine[i] * ring.around[i];
        out.tangent2 += of.sine[i] * ring.around[i];
    }
    add_tangent_plane(out);
    return out;
}

// Has no formula: eigenvectors of the local matrix, which looks at one ring.
const Sqrt3Rules::DartMasks& Sqrt3Rules::dart_masks(std::size_t valence) {
    const auto known = darts_.find(valence);
    if (known != darts_.end()) return known->second;
    if (valence < 3)
        throw Error(ErrorCode::unsupported,
                    "sqrt3 has no limit where a crease ends between two triangles; tag the vertex as a corner");
    const int n = static_cast<int>(valence);
    const SpectralAnalysis analysis = analyse(*find_scheme("sqrt3"), {.faces = n, .dart = true}, {});
    const FanLabels& labels = analysis.matrix.labels;
    const auto around = [&](const std::vector<double>& weights) {
        std::vector<double> result(valence, 0.0);
        for (int i = 0; i < n && !weights.empty(); ++i)
            result[static_cast<std::size_t>(i)] = weights[static_cast<std::size_t>(labels.find({i, 1, 0}))];
        return result;
    };
    DartMasks masks;
    masks.limit = around(analysis.limit);
    masks.tangent1 = around(analysis.tangent1);
    masks.tangent2 = around(analysis.tangent2);
    for (const double weight : masks.limit) masks.vertex -= weight;
    // Outwards: on a flat fan seen from above they turn counter-clockwise.
    double turn[2][2] = {};
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        const auto at = static_cast<std::size_t>(i);
        for (int t = 0; t < 2; ++t) {
            const double weight = t == 0 ? masks.tangent1[at] : masks.tangent2[at];
            turn[t][0] += weight * std::cos(angle);
            turn[t][1] += weight * std::sin(angle);
        }
    }
    if (turn[0][0] * turn[1][1] < turn[0][1] * turn[1][0]) std::swap(masks.tangent1, masks.tangent2);
    return darts_.emplace(valence, std::move(masks)).first->second;
}

LimitPoint Sqrt3Rules::dart_limit(const Sqrt3Ring& ring) {
    const std::size_t count = ring.around.size();
    const DartMasks& masks = dart_masks(count);
    LimitPoint out;
    out.position = masks.vertex * ring.point;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d& q = ring.around[(ring.sharp[0].first + i) % count];
        out.position += masks.limit[i] * q;
        out.tangent1 += masks.tangent1[i] * (q - ring.point);
        out.tangent2 += masks.tangent2[i] * (q - ring.point);
    }
    add_tangent_plane(out);
    // Where its eigenvalues do not tell the directions.
    if (!out.has_tangent_plane) out.normal = mean_face_normal(ring);
    return out;
}

}  // namespace tetrakis::detail
