#include "regular_patch.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <utility>

namespace tetrakis::detail {

namespace {

/// The coarse point that a fine one lies beside.
int above(int fine) { return fine >= 0 ? fine / 2 : -((1 - fine) / 2); }

/// The half-edge that leaves a regular vertex next to another, clockwise.
int clockwise(const RuleMesh& mesh, int h) { return mesh.next(mesh.twin(h)); }

}  // namespace

RegularPatch::RegularPatch(const SchemeInfo& scheme, const RuleOptions& options, const RegularLimit& limit, int rings) {
    const RuleMesh mesh = RegularLimit::lattice_mesh(FanLattice::dual, rings);
    const RuleStep step = scheme.step(mesh, options);
    const int n = 2 * rings + 1, middle = RegularLimit::middle(rings);
    int h = mesh.first(middle);
    while (mesh.target(h) != middle + 1) h = clockwise(mesh, h);
    // Towards +x the face at the upper right lies on the left; the others follow clockwise.
    for (const std::size_t child : {3u, 1u, 0u, 2u}) {
        for (const auto& [v, weight] : step.stencils.row(step.mesh.origin(step.child_halfedge[h])).terms)
            lattice_rows_[child].push_back({v % n - rings, v / n - rings, weight});
        h = clockwise(mesh, h);
    }
    radius_ = limit.radius();
    while (!reaches(radius_)) ++radius_;
    side_ = 2 * radius_ + 1;
    for (std::size_t child = 0; child < 4; ++child) rows_[child] = terms(lattice_rows_[child]);
    const auto masks = [&](Masks& to, const auto& of) {
        to.limit = terms(of(limit.limit_terms()));
        to.tangent1 = terms(of(limit.tangent_terms(0)));
        to.tangent2 = terms(of(limit.tangent_terms(1)));
    };
    masks(limit_, [](LatticeTerms t) { return t; });
    for (std::size_t child = 0; child < 4; ++child)
        masks(child_limit_[child], [&](const LatticeTerms& t) { return from_child(child, t); });
    square(0);
}

// Whether a square gives the squares of its children.
bool RegularPatch::reaches(int radius) const {
    for (int parity = 0; parity < 2; ++parity)
        for (int child = 0; child < 2; ++child)
            for (int i = -radius; i <= radius; ++i) {
                const int fine = child + i;
                if ((fine & 1) != parity) continue;
                for (std::size_t row = 0; row < 4; ++row)
                    for (const auto& t : lattice_rows_[row]) {
                        const bool along_x =
                            static_cast<int>(row & 1) == parity && std::abs(above(fine) + t.x) > radius;
                        const bool along_y =
                            static_cast<int>(row >> 1) == parity && std::abs(above(fine) + t.y) > radius;
                        if (along_x || along_y) return false;
                    }
            }
    return true;
}

RegularPatch::Terms RegularPatch::terms(std::span<const RegularLimit::LatticeTerm> lattice) const {
    Terms result;
    for (const auto& t : lattice) result.push_back({t.y * side_ + t.x, t.weight});
    return result;
}

// A combination of the points of a child's square as one of its parent's, in the order of their places.
RegularPatch::LatticeTerms RegularPatch::from_child(std::size_t child,
                                                    std::span<const RegularLimit::LatticeTerm> lattice) const {
    std::map<std::pair<int, int>, double> sum;
    for (const auto& t : lattice) {
        const int x = static_cast<int>(child & 1) + t.x, y = static_cast<int>(child >> 1) + t.y;
        for (const auto& r : lattice_rows_[static_cast<std::size_t>((x & 1) + 2 * (y & 1))])
            sum[{above(y) + r.y, above(x) + r.x}] += t.weight * r.weight;
    }
    LatticeTerms result;
    for (const auto& [at, weight] : sum) result.push_back({at.second, at.first, weight});
    return result;
}

Vec3d* RegularPatch::square(std::size_t depth) {
    const std::size_t size = static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
    if (points_.size() < (depth + 1) * size) points_.resize((depth + 1) * size);
    return &points_[depth * size];
}

bool RegularPatch::gather(const RuleMesh& mesh, std::span<const unsigned char> regular, std::span<const Vec3d> net,
                          int ahead) {
    const auto straight = [&](int h) { return clockwise(mesh, mesh.next(h)); };
    if (regular[mesh.origin(ahead)] == 0) return false;
    // Along the lower side of the square: down, then left, both straight on, then row by row to the right.
    const auto go = [&](int h, int steps, int& at) {
        for (int i = 0; i < steps; ++i) {
            if (regular[mesh.target(h)] == 0) return false;
            h = straight(h);
        }
        at = h;
        return true;
    };
    int h = clockwise(mesh, ahead);
    if (!go(h, radius_, h)) return false;
    h = clockwise(mesh, h);
    if (!go(h, radius_, h)) return false;
    h = clockwise(mesh, h);  // towards +y: the left column, from below
    Vec3d* to = points_.data();
    for (int y = 0; y < side_; ++y) {
        int along = clockwise(mesh, h);
        for (int x = 0; x < side_; ++x) {
            const int v = mesh.origin(along);
            if (regular[v] == 0) return false;
            *to++ = net[v];
            if (x + 1 == side_) break;
            if (regular[mesh.target(along)] == 0) return false;
            along = straight(along);
        }
        if (y + 1 == side_) break;
        if (regular[mesh.target(h)] == 0) return false;
        h = straight(h);
    }
    return true;
}

void RegularPatch::limits(std::span<const Target> targets, const LimitsOut& out) {
    positions_alone_ = out.positions_alone();
    descend(0, targets, out);
}

void RegularPatch::make_child(std::size_t depth, std::size_t child) {
    Vec3d* to = square(depth + 1);
    const Vec3d* const middle = square(depth) + radius_ * side_ + radius_;
    for (int y = -radius_; y <= radius_; ++y)
        for (int x = -radius_; x <= radius_; ++x) {
            const int fine_x = static_cast<int>(child & 1) + x, fine_y = static_cast<int>(child >> 1) + y;
            const auto row = static_cast<std::size_t>((fine_x & 1) + 2 * (fine_y & 1));
            *to++ = sum(rows_[row], middle + above(fine_y) * side_ + above(fine_x));
        }
}

void RegularPatch::descend(std::size_t depth, std::span<const Target> targets, const LimitsOut& out) {
    const auto levels_left = [&](const Target& t) { return t.levels - static_cast<int>(depth); };
    const auto child_of = [&](const Target& t) {
        const int bit = levels_left(t) - 1;
        return static_cast<std::size_t>((t.at.x >> bit & 1) + 2 * (t.at.y >> bit & 1));
    };
    const int to_middle = radius_ * side_ + radius_;
    for (std::size_t begin = 0, end = 0; begin < targets.size(); begin = end) {
        end = begin + 1;
        const int left = levels_left(targets[begin]);
        if (left == 0) {
            const LimitPoint point = limit(limit_, square(depth) + to_middle);
            out.put(targets[begin].index, point);
            for (; end < targets.size() && levels_left(targets[end]) == 0; ++end) out.put(targets[end].index, point);
            continue;
        }
        const std::size_t child = child_of(targets[begin]);
        if (left == 1) {
            // From the parent's square at once: most targets are such.
            LimitPoint point = limit(child_limit_[child], square(depth) + to_middle);
            if (!positions_alone_ && point.normal == Vec3d(0)) {
                make_child(depth, child);
                point.normal = corner_normal(square(depth + 1) + to_middle);
            }
            out.put(targets[begin].index, point);
            continue;
        }
        while (end < targets.size() && levels_left(targets[end]) > 1 && child_of(targets[end]) == child) ++end;
        make_child(depth, child);
        descend(depth + 1, targets.subspan(begin, end - begin), out);
    }
}

LimitPoint RegularPatch::limit(const Masks& masks, const Vec3d* middle) const {
    LimitPoint result;
    result.position = sum(masks.limit, middle);
    if (positions_alone_) return result;
    if (!masks.tangent1.empty()) {
        result.tangent1 = sum(masks.tangent1, middle);
        result.tangent2 = sum(masks.tangent2, middle);
        result.normal = unit_or_zero(glm::cross(result.tangent1, result.tangent2));
        result.has_tangent_plane = result.normal != Vec3d(0);
    }
    if (&masks == &limit_ && result.normal == Vec3d(0)) result.normal = corner_normal(middle);
    return result;
}

// The mean of the normals of the corners of the vertex.
Vec3d RegularPatch::corner_normal(const Vec3d* middle) const {
    const Vec3d around[4] = {middle[1] - *middle, middle[side_] - *middle, middle[-1] - *middle,
                             middle[-side_] - *middle};
    Vec3d normal(0);
    for (int i = 0; i < 4; ++i) normal += unit_or_zero(glm::cross(around[i], around[(i + 1) % 4]));
    return unit_or_zero(normal);
}

}  // namespace tetrakis::detail
