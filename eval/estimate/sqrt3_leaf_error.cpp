#include "sqrt3_leaf_error.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../refine/points/sqrt3_points.hpp"
#include "../bounds/point_triangle.hpp"

#include <algorithm>
#include <array>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_leaf_block = 256;      // leaves side by side that share what they find
constexpr std::size_t k_reported_leaves = 8192;  // between two chances to cancel
constexpr std::size_t k_most_limits = 1u << 16;  // kept by one block

/// A half-edge of a level.
struct LevelEdge {
    int level;
    std::uint64_t h;
};

/// Looks at leaves that lie side by side.
class LeafProbe {
  public:
    explicit LeafProbe(const Sqrt3Lattice& lattice) : points_(lattice) {}

    double error(const Sqrt3Leaf& leaf, double decide_at) {
        std::array<Vec3d, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) corner[k] = limit(leaf.vertex_level(k), leaf.leaving(k));
        const PlaneMeasure plane(corner);
        const std::array<LevelEdge, 3> sides = sides_of(leaf);
        double error = plane(inside(leaf));
        for (std::size_t k = 0; k < 3; ++k)
            error = std::max(error, along(sides[k], sides[k], plane, corner[k], corner[(k + 1) % 3]));
        if (error > decide_at) return error;
        // The middle third of each side, then what lies inside of a whole triangle: the edges to its centre.
        for (std::size_t k = 0; k < 3; ++k)
            error = std::max(error, along(middle_of(sides[k]), sides[k], plane, corner[k], corner[(k + 1) % 3]));
        if (!leaf.half)
            for (std::uint64_t h = 3 * leaf.face; h < 3 * leaf.face + 3; ++h)
                for (const Vec3d& p : thirds({leaf.level + 1, 3 * h + 2})) error = std::max(error, plane(p));
        return error;
    }

  private:
    Vec3d limit(int level, std::uint64_t leaving) {
        const Sqrt3Vertex v = points_.lattice().origin(level, leaving);
        if (const auto known = limits_.find(v); known != limits_.end()) return known->second;
        if (limits_.size() > k_most_limits) limits_.clear();
        return limits_.emplace(v, points_.limit(level, leaving).position).first->second;
    }
    bool is_sharp_edge(const LevelEdge& edge) {
        return points_.lattice().twin(edge.level, edge.h) == Sqrt3Lattice::none;
    }
    /// The centre of a face that is not cut.
    Vec3d centre(int level, std::uint64_t face) { return limit(level + 1, 9 * face + 2); }

    /// From corner k to the next one. A half triangle's sides to its apex are edges of the next level.
    std::array<LevelEdge, 3> sides_of(const Sqrt3Leaf& leaf) {
        const int k = leaf.level;
        if (!leaf.half) return {{{k, 3 * leaf.face}, {k, 3 * leaf.face + 1}, {k, 3 * leaf.face + 2}}};
        const std::uint64_t twin = points_.lattice().twin(k, leaf.face);
        return {{{k, leaf.face}, {k + 1, 3 * twin}, {k + 1, 3 * leaf.face + 2}}};
    }
    /// The two points that cut an edge in three: the centres of the triangles that two steps make of it, or those that
    /// a sharp edge gets.
    std::array<Vec3d, 2> thirds(const LevelEdge& edge) {
        const auto [level, h] = edge;
        const std::uint64_t twin = points_.lattice().twin(level, h);
        if (twin != Sqrt3Lattice::none) return {centre(level + 1, h), centre(level + 1, twin)};
        if (level % 2 == 0) return {limit(level + 2, 9 * h), limit(level + 2, 9 * h + 1)};
        return {limit(level + 1, 3 * h), limit(level + 1, 3 * h + 1)};
    }
    /// The edge between these.
    LevelEdge middle_of(const LevelEdge& edge) {
        if (!is_sharp_edge(edge)) return {edge.level + 2, 9 * edge.h + 4};
        return edge.level % 2 == 0 ? LevelEdge{edge.level + 2, 9 * edge.h} : LevelEdge{edge.level + 1, 3 * edge.h};
    }
    /// A point about the middle of the leaf.
    Vec3d inside(const Sqrt3Leaf& leaf) {
        const int k = leaf.level;
        if (leaf.half) return centre(k + 2, 3 * points_.lattice().twin(k, leaf.face) + 1);
        // Of a face whose sharp edge is cut there is no centre, but of the triangle over the middle third.
        const bool cut = k % 2 != 0 && is_sharp_edge({k, 3 * leaf.face});
        return cut ? centre(k + 1, 3 * leaf.face) : centre(k, leaf.face);
    }
    double along(const LevelEdge& edge, const LevelEdge& side, const PlaneMeasure& plane, const Vec3d& a,
                 const Vec3d& b) {
        double error = 0;
        const bool sharp = is_sharp_edge(side);
        for (const Vec3d& p : thirds(edge)) error = std::max(error, sharp ? segment_distance(p, a, b) : plane(p));
        return error;
    }

    Sqrt3Points points_;
    std::unordered_map<Sqrt3Vertex, Vec3d> limits_;
};

}  // namespace

std::vector<double> Sqrt3LeafErrors::errors(std::span<const Sqrt3Leaf> leaves, double decide_at,
                                            const std::function<void(double)>& report) {
    std::vector<double> errors(leaves.size());
    std::vector<std::size_t> unknown;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const auto known = known_.find({leaves[i].face, leaves[i].level, leaves[i].half});
        if (known != known_.end())
            errors[i] = known->second;
        else
            unknown.push_back(i);
    }
    for (std::size_t begin = 0; begin < unknown.size(); begin += k_reported_leaves) {
        report(static_cast<double>(begin) / static_cast<double>(unknown.size()));
        const auto count = static_cast<std::uint32_t>(std::min(k_reported_leaves, unknown.size() - begin));
        for_each_block(count, k_leaf_block, [&](std::uint32_t from, std::uint32_t to) {
            LeafProbe probe(lattice_);
            for (std::uint32_t i = from; i < to; ++i) {
                const std::size_t leaf = unknown[begin + i];
                errors[leaf] = probe.error(leaves[leaf], decide_at);
            }
        });
    }
    for (const std::size_t i : unknown) known_.emplace(Key{leaves[i].face, leaves[i].level, leaves[i].half}, errors[i]);
    return errors;
}

}  // namespace tetrakis::detail
