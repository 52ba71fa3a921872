#include "repeated_rows.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/corner_angles.hpp"
#include "../rules/face_normals.hpp"
#include "../rules/rule_refiner.hpp"
#include "row_learner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Whether no crease or corner loses its sharpness within `steps` steps.
bool stays_as_it_is(const RuleMesh& mesh, int steps) {
    const auto stays = [&](float sharpness) {
        return !is_semi_sharp(sharpness) || sharpness > static_cast<float>(steps);
    };
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (!stays(mesh.sharpness(h))) return false;
    return std::all_of(mesh.vertex_sharpness().begin(), mesh.vertex_sharpness().end(), stays);
}

/// The same mesh with the sharpness and the corner angles of the next level.
RuleMesh with_later_tags(const RuleMesh& mesh) {
    std::vector<int> halfedges(static_cast<std::size_t>(mesh.halfedge_count()));
    std::iota(halfedges.begin(), halfedges.end(), 0);
    return mesh.with_tags(child_sharpness, child_corner_angles(mesh, halfedges, halfedges.size()));
}

/// Whether a vertex or face has more roots around it than the 16-bit RootLattices::Seen::turn can count.
bool has_too_large_rings(const ControlMesh& mesh) {
    constexpr std::uint32_t k_most = std::numeric_limits<std::int16_t>::max();
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (!mesh.is_isolated(VertexId(v)) && mesh.face_valence(VertexId(v)) > k_most) return true;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(FaceId(f)) > k_most) return true;
    return false;
}

/// Whether no vertex is isolated, and each smooth inner one becomes a face on the next level of a dual scheme.
bool has_whole_faces(const RuleMesh& mesh, bool creases) {
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none) return false;
        const RuleMesh::Ring ring = mesh.ring(v);
        const bool smooth = !creases || std::none_of(ring.sharpness.begin(), ring.sharpness.end(), is_sharp);
        if (ring.closed && smooth && ring.faces() < 3) return false;
    }
    return true;
}

/// Replaces normals that are zero by those of the faces around the point (FaceNormals).
/// @param points  by place
void add_face_normals(const RootLattices& net, const RootLayout& at, const Vec3d* points, std::span<Vec3d> normals,
                      const RunContext& context) {
    std::map<std::uint32_t, FaceNormals> missing;
    for (std::uint32_t i = 0; i < normals.size(); ++i)
        if (normals[i] == Vec3d(0)) missing.try_emplace(missing.end(), i);
    if (missing.empty()) return;
    std::vector<std::uint32_t> roots;
    for (const auto& [v, sum] : missing)
        if (!net.in_cells()) net.for_each_root_of(at, v, [&](std::uint32_t root) { roots.push_back(root); });
    std::sort(roots.begin(), roots.end());
    roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
    const RootLattices::Faces faces = net.faces(at.segments(), context, &roots);
    const RootLattices::Numbers numbers = net.point_numbers(at);
    std::vector<std::uint32_t> place(numbers.count - numbers.first_shared);
    for (std::size_t i = numbers.number.size(); i-- > 0;)
        place[numbers.number[i] - numbers.first_shared] = numbers.first_shared + static_cast<std::uint32_t>(i);
    std::vector<Vec3d> corners;
    for (std::size_t f = 0; f + 1 < faces.offsets.size(); ++f) {
        const std::span face(faces.vertices.data() + faces.offsets[f], faces.offsets[f + 1] - faces.offsets[f]);
        for (std::size_t c = 0; c < face.size(); ++c) {
            if (normals[face[c]] != Vec3d(0)) continue;
            corners.clear();
            for (const std::uint32_t v : face)
                corners.push_back(points[v < numbers.first_shared ? v : place[v - numbers.first_shared]]);
            missing[face[c]].add(corners, c);
        }
    }
    for (const auto& [v, sum] : missing) normals[v] = sum.normal();
}

struct LastLevel {
    double corners = 0, points = 0, bytes = 0;
};

/// @param corners  number of face corners of the last level, which exceeds the number of its points
/// @throws Error  unsupported: more corners than 32-bit numbers can count
void check_corners(double corners, int levels, const std::string& source) {
    if (corners >= std::numeric_limits<std::uint32_t>::max())
        throw Error(ErrorCode::unsupported,
                    fmt::format("{} levels give more elements than 32-bit numbers can count; the last has {:.0f} face "
                                "corners",
                                levels, corners),
                    source);
}

/// Counts and memory of the last level, computed before it is made.
/// @param n  segments of a root's side on that level
LastLevel last_level(const RootLattices& net, double n, const RepeatedRows::Demand& demand) {
    const RuleMesh& base = net.base();
    const double faces = base.face_count() * n * n, corners = faces * net.side_count(),
                 inner = net.side_count() == 3 ? 0.5 * (n - 1) * (n - 2) : (n - 1) * (n - 1),
                 points = net.in_cells()
                              ? faces
                              : base.face_count() * inner + base.edge_count() * (n - 1) + base.vertex_count();
    // Also the points of the two levels before (1/4 + 1/16); if some points have several places, those of all places.
    const double above = net.shares_points() ? 1.3 : 0.3;
    return {corners, points,
            points * (static_cast<double>(demand.point_bytes) + above * sizeof(Vec3d)) +
                corners * static_cast<double>(demand.corner_bytes) + faces * static_cast<double>(demand.face_bytes)};
}

}  // namespace

/// The kinds of corners that each step sees, and the step from which on rows take over from the rules.
struct RepeatedRows::Plan {
    std::vector<CornerKinds> kinds;    ///< all different
    std::vector<std::size_t> of_step;  ///< index into `kinds` of each step after the current level
    std::size_t of_limits = 0;         ///< index into `kinds` for limits
    int by_rules = 0;                  ///< number of these steps that the rules make
    double cost = 0;  ///< of learning and of the steps by rules, in units of the cost of one point by the rules

    std::size_t add(CornerKinds corners) {
        const auto at = std::find(kinds.begin(), kinds.end(), corners);
        const auto number = static_cast<std::size_t>(at - kinds.begin());
        if (at == kinds.end()) kinds.push_back(std::move(corners));
        return number;
    }
    bool used(std::size_t kind, int from) const {
        return std::find(of_step.begin() + from, of_step.end(), kind) != of_step.end();
    }
    /// Chooses `by_rules` for the least cost; with `early` it is 0.
    /// @param points  number of points of the current level
    void choose(const RootLattices& net, const SchemeInfo& scheme, const RuleOptions& rules, int factor, double points,
                bool limits, bool early) {
        const auto last = static_cast<int>(of_step.size()) - 1;
        for (int step = last; step >= 0; --step) {
            double now = points * (std::pow(factor * factor, step) - 1);
            for (std::size_t i = 0; i < kinds.size(); ++i)
                if (used(i, step) || (limits && i == of_limits))
                    now += learning_cost(kinds[i], net, scheme, rules, factor);
            if (step < last && now > cost && !early) continue;
            by_rules = step;
            cost = now;
        }
    }
};

std::unique_ptr<RepeatedRows> RepeatedRows::make(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                                 const RuleOptions& rules, std::unique_ptr<RuleLevels>& levels_by_rules,
                                                 const Demand& demand, const RunContext& context) {
    const bool triangles = scheme.family == MeshFamily::triangles,
               dual = fan_lattice(scheme, rules) == FanLattice::dual;
    if (scheme.refinement == Refinement::honeycomb) return nullptr;
    if (triangles && !mesh.all_triangles()) return nullptr;  // RuleRefiner reports the error
    bool quads = true;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) quads = quads && mesh.face_size(FaceId(f)) == 4;
    // Level at which a root has one segment.
    int base_level = dual ? 1 : triangles || quads ? 0 : 1;
    if (levels <= base_level) return nullptr;
    const int factor = scheme.refinement == Refinement::sqrt3 ? 3 : 2;
    const bool creases = dual && !ignores_creases(scheme, rules);
    LastLevel last_size;
    if (has_too_large_rings(mesh)) return nullptr;
    const bool recedes = boundary_recedes(scheme, rules);
    if (recedes && mesh.has_boundary()) return nullptr;

    // Checked before any level is made, without the faces that boundaries of dual schemes add.
    if (!demand.any_level)
        check_corners(mesh.halfedge_count() * std::pow(factor * factor, levels), levels, mesh.data().source);
    RuleLevels& by_rules = *levels_by_rules;
    const auto advance = [&] {
        const int to = by_rules.level() + 1;
        check_rule_memory(mesh, scheme, to, levels, context, static_cast<std::uint64_t>(last_size.bytes));
        return by_rules.advance();
    };
    const auto too_many = [&] {
        return static_cast<double>(by_rules.last().vertex_count()) * factor * factor > demand.most_points;
    };
    // The rows of limits change from level to level until no sharpness can run out any more.
    constexpr int k_for_ever = std::numeric_limits<int>::max();
    const bool any_limits = demand.limit || demand.normals;
    // The roots of a dual scheme are at the face corners of the first level all of whose vertices become faces (a
    // vertex with two faces does not). They are separated along creases.
    while (dual && !has_whole_faces(by_rules.last(), creases)) {
        if (levels <= ++base_level || too_many()) return nullptr;
        advance();
    }
    // Chaikin's sharpness varies along a side, so the rules refine until no semi-sharp crease is left. For single
    // points that would be too many levels.
    if (demand.any_level && rules.chaikin_creases && !stays_as_it_is(by_rules.last(), k_for_ever)) return nullptr;
    while (rules.chaikin_creases && !stays_as_it_is(by_rules.last(), k_for_ever)) {
        if (levels <= (base_level = std::max(base_level, by_rules.level() + 1))) return nullptr;
        advance();
    }
    // For each half-edge of the roots, its child at its origin on the current level. Dual: for each root h, which lies
    // at the corner of half-edge h, the half-edge of its last cell that stays in its face.
    std::vector<int> first;
    std::optional<RootLattices> net;
    if (dual) net = RootLattices::of_corners(by_rules.last(), creases, by_rules.control_face_of_corners());
    while (by_rules.level() < base_level) {
        if (too_many()) return nullptr;
        first = advance();
    }
    std::vector<std::uint32_t> corner_halfedges;
    if (base_level == 0 || (base_level == 1 && first.size() == mesh.halfedge_count())) {
        corner_halfedges.resize(mesh.halfedge_count());
        for (std::uint32_t h = 0; h < corner_halfedges.size(); ++h)
            corner_halfedges[h] = dual ? 4 * h : base_level == 0 ? h : static_cast<std::uint32_t>(first[h]);
    }
    if (!dual) {
        std::vector<std::uint32_t> control(static_cast<std::size_t>(by_rules.last().face_count()));
        for (std::size_t f = 0; f < control.size(); ++f)
            control[f] = static_cast<std::uint32_t>(by_rules.control_face(static_cast<int>(f)));
        net = RootLattices::of_faces(by_rules.last(), std::move(control));
        first.resize(net->halfedge_count());
        for (std::size_t h = 0; h < first.size(); ++h) first[h] = static_cast<int>(h);
    }
    if (!net->has_simple_roots()) return nullptr;
    if (!demand.any_level) {
        last_size = last_level(*net, std::pow(factor, levels - by_rules.level()), demand);
        check_corners(last_size.corners, levels, mesh.data().source);
    }
    std::unique_ptr<RepeatedRows> all(new RepeatedRows(std::move(*net)));
    all->corner_halfedges_ = std::move(corner_halfedges);
    std::uint32_t segments = 1;
    const auto go_on = [&] {
        context.report("refine", 0);
        const std::vector<int> child = advance();
        for (int& h : first) {
            h = h < 0 ? h : child[h];
            if (h < 0) return false;
        }
        segments *= static_cast<std::uint32_t>(factor);
        return true;
    };
    // No inner side is sharp in dual schemes, whose roots are separated along creases, nor where boundaries recede.
    const bool tags = !dual && !recedes;
    const int begin = by_rules.level();
    using Sees = CornerKinds::Sees;
    const auto corners = [&](const RuleMesh& at, Sees sees) {
        return CornerKinds(all->net_, at, tags ? first : std::span<const int>(), sees, scheme.takes_corner_angles);
    };
    Plan plan;
    plan.add(corners(by_rules.last(), Sees::one_step));
    plan.of_step.assign(static_cast<std::size_t>(levels - begin), 0);
    if (tags && !stays_as_it_is(by_rules.last(), any_limits ? k_for_ever : levels - begin)) {
        RuleMesh later = with_later_tags(by_rules.last());
        for (std::size_t step = 1; step < plan.of_step.size(); ++step) {
            plan.of_step[step] = plan.add(corners(later, Sees::one_step));
            later = with_later_tags(later);
        }
        if (any_limits) plan.of_limits = plan.add(corners(later, Sees::all));
    }
    if (any_limits) {
        const auto settled = std::find_if(plan.of_step.rbegin(), plan.of_step.rend(),
                                          [&](std::size_t kind) { return kind != plan.of_limits; });
        all->settled_level_ =
            settled == plan.of_step.rbegin() ? k_for_ever : begin + static_cast<int>(plan.of_step.rend() - settled);
    }
    const double roots = all->net_.root_count() / (triangles ? 2.0 : 1.0);
    plan.choose(all->net_, scheme, rules, factor, roots, any_limits, demand.even_if_slower);
    // The rules, which handle the cases refused here, need more memory for a level.
    constexpr double k_most_bytes = 0x1p63;
    check_memory(fmt::format("{} levels, {:.0f} vertices, need", levels, last_size.points),
                 static_cast<std::uint64_t>(std::min(last_size.bytes, k_most_bytes)), context.max_memory_bytes,
                 "ask for fewer levels", mesh.data().source);
    if (!demand.even_if_slower && plan.cost > roots * std::pow(factor * factor, levels - begin)) return nullptr;
    if (plan.cost > demand.most_points) return nullptr;
    if (!all->learn(plan, scheme, rules, demand, context)) return nullptr;
    const auto wide_enough = [&](std::uint32_t n) {
        return static_cast<int>(n) > 2 * scheme.choice_rings && all->fits(n);
    };
    // The last level by the rules is found before these levels are made.
    double last_by_rules = segments;
    for (int level = by_rules.level();
         level < begin + plan.by_rules || !wide_enough(static_cast<std::uint32_t>(last_by_rules)); ++level) {
        if (level + 1 >= levels) return nullptr;
        last_by_rules *= factor;
    }
    if (roots * last_by_rules * last_by_rules > demand.most_points) return nullptr;
    while (by_rules.level() < begin + plan.by_rules || !wide_enough(segments))
        if (!go_on()) return nullptr;
    all->pattern_.erase(all->pattern_.begin(), all->pattern_.begin() + (by_rules.level() - begin));
    std::optional<std::vector<int>> vertices = all->net_.vertices(all->net_.layout(segments), by_rules.last(), first);
    if (!vertices) return nullptr;
    all->vertices_ = std::move(*vertices);
    all->segments_ = {segments};
    for (int level = by_rules.level(); level < levels; ++level)
        all->segments_.push_back(segments *= static_cast<std::uint32_t>(factor));
    const RootLayout last = all->net_.layout(segments);
    if ((all->limit_ && !all->limit_->fits(last)) || (all->normals_ && !all->normals_->fits(last))) return nullptr;
    all->levels_ = std::move(levels_by_rules);
    all->control_count_ = mesh.vertex_count();
    return all;
}

bool RepeatedRows::learn(const Plan& plan, const SchemeInfo& scheme, const RuleOptions& rules, const Demand& demand,
                         const RunContext& context) {
    const std::uint32_t factor = scheme.refinement == Refinement::sqrt3 ? 3 : 2;
    if (demand.limit) limit_.emplace(net_, 1, RowPatterns::Kind::points);
    if (demand.normals) normals_.emplace(net_, 1, RowPatterns::Kind::normals);
    pattern_.assign(plan.of_step.size(), 0);
    patterns_.reserve(plan.kinds.size());
    for (std::size_t i = 0; i < plan.kinds.size(); ++i) {
        const RowSource source{net_, plan.kinds[i], scheme, rules, context.max_memory_bytes};
        try {
            if (plan.used(i, plan.by_rules)) {
                for (std::size_t step = 0; step < pattern_.size(); ++step)
                    if (plan.of_step[step] == i) pattern_[step] = patterns_.size();
                if (!learn_step(source, patterns_.emplace_back(net_, factor, RowPatterns::Kind::points))) return false;
            }
            if (i == plan.of_limits && (limit_ || normals_) &&
                !learn_limits(source, limit_ ? &*limit_ : nullptr, normals_ ? &*normals_ : nullptr))
                return false;
        } catch (const std::invalid_argument&) {
            return false;  // RuleRefiner reports the error
        }
    }
    return true;
}

bool RepeatedRows::uses_all_points() const {
    bool all = !net_.in_cells();
    for (int v = 0; v < net_.base().vertex_count(); ++v) all = all && net_.base().first(v) != RuleMesh::none;
    return all;
}

bool RepeatedRows::fits(std::uint32_t segments) const {
    return std::all_of(patterns_.begin(), patterns_.end(),
                       [&](const RowPatterns& patterns) { return patterns.fits(net_.layout(segments)); });
}

std::uint32_t RepeatedRows::segments(int level) const {
    const auto at = static_cast<std::size_t>(level - first_level());
    std::uint32_t segments = segments_[std::min(at, segments_.size() - 1)];
    for (std::size_t l = segments_.size(); l <= at; ++l) segments *= factor();
    return segments;
}

std::optional<int> RepeatedRows::limit_level() const {
    const int steps = static_cast<int>(pattern_.size());
    for (int level = std::max(first_level(), settled_level_); level <= first_level() + steps; ++level) {
        const RootLayout at = net_.layout(segments(level));
        if ((!limit_ || limit_->fits(at)) && (!normals_ || normals_->fits(at))) return level;
    }
    return std::nullopt;
}

void RepeatedRows::first_points(std::span<const Vec3d> control, Vec3d* out) const {
    std::vector<Vec3d> first(static_cast<std::size_t>(levels_->last().vertex_count()));
    levels_->net(control, first);
    for_each_index(static_cast<std::uint32_t>(vertices_.size()),
                   [&](std::uint32_t i) { out[i] = first[vertices_[i]]; });
}

void RepeatedRows::refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                          const RunContext& context) const {
    const bool shared = net_.shares_points();
    PodArray<Vec3d> buffers[2];
    const auto buffer = [&](std::size_t i) -> Vec3d* {
        if (i + 1 == segments_.size() && !limit_ && !shared) return points.data();
        buffers[i & 1] = {};  // freed first: resizing would copy the old contents
        buffers[i & 1].resize(net_.place_count(net_.layout(segments_[i])));
        return buffers[i & 1].data();
    };
    Vec3d* now = buffer(0);
    first_points(control, now);
    double done = 0;
    const auto progress = [&](double to) { return RowPatterns::Progress{context, std::exchange(done, to), to}; };
    for (std::size_t i = 1; i < segments_.size(); ++i) {
        // Each level takes four times as long as the one before, or nine times.
        const double part = static_cast<double>(segments_[i]) / segments_.back();
        Vec3d* const finer = buffer(i);
        patterns_[pattern_[i - 1]].apply(net_.layout(segments_[i - 1]), net_.layout(segments_[i]), now, finer,
                                         progress(part * part));
        now = finer;
    }
    const RootLayout last = net_.layout(segments_.back());
    if (shared) {
        at_shared_places(last, now, points, normals, progress(1));
    } else {
        if (limit_) limit_->apply(last, last, now, points.data(), progress(1));
        if (!normals.empty()) normals_->apply(last, last, now, normals.data(), progress(1));
    }
    add_face_normals(net_, last, now, normals, context);
}

/// A point with several places takes its position from the first one; its normal is the mean of their normals.
void RepeatedRows::at_shared_places(const RootLayout& last, const Vec3d* now, std::span<Vec3d> points,
                                    std::span<Vec3d> normals, const RowPatterns::Progress& progress) const {
    const RootLattices::Numbers numbers = net_.point_numbers(last);
    const std::uint32_t places = net_.place_count(last);
    PodArray<Vec3d> buffer;
    buffer.resize(places);
    const auto results = [&](const RowPatterns& patterns) {
        patterns.apply(last, last, now, buffer.data(), progress);
        return buffer.data();
    };
    const Vec3d* const at = limit_ ? results(*limit_) : now;
    for (std::uint32_t place = places; place-- > 0;) points[numbers.of(place)] = at[place];
    if (normals.empty()) return;
    const Vec3d* const sides = results(*normals_);
    std::fill(normals.begin(), normals.end(), Vec3d(0));
    for (std::uint32_t place = 0; place < places; ++place) normals[numbers.of(place)] += sides[place];
    for (std::size_t i = numbers.first_shared; i < normals.size(); ++i) normals[i] = unit_of_sum(normals[i]);
}

}  // namespace tetrakis::detail
