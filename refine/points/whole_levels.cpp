#include "whole_levels.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../rules/rule_levels.hpp"
#include "../rules/rule_limit.hpp"
#include "../rules/rule_refiner.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Vertices of the largest level: it takes some 10 GB, and a minute or two.
constexpr double k_most_vertices = 1u << 25;
/// Vertices whose limits are found together: their rows take some 60 MB.
constexpr std::size_t k_limits_at_once = std::size_t{1} << 16;

/// A cell of a level on the way down to it, and the wanted corner, in the frame of the cell that has been come to,
/// whose sides are `size` long.
struct Descent {
    std::int64_t x = 0, y = 0;  ///< middle of the wanted cell
    std::int64_t corner_x = 0, corner_y = 0;
    std::int64_t size = 0;

    void move(std::int64_t dx, std::int64_t dy) {
        x -= dx;
        y -= dy;
        corner_x -= dx;
        corner_y -= dy;
    }
    /// Which of four quads.
    int next_quad() {
        size /= 2;
        const bool right = x > size, up = y > size;
        move(right ? size : 0, up ? size : 0);
        return up ? (right ? 2 : 3) : right;
    }
    /// Which of four triangles; the middle one is turned by half a turn.
    int next_triangle() {
        size /= 2;
        if (x > size) return move(size, 0), 1;
        if (y > size) return move(0, size), 2;
        if (x + y < size) return 0;
        turn();
        return 3;
    }
    void turn() {
        for (std::int64_t* c : {&x, &y, &corner_x, &corner_y}) *c = size - *c;
    }
};

/// Units of a cell's side in which its middle has whole coordinates.
constexpr std::int64_t k_quad_unit = 2, k_triangle_unit = 3;

}  // namespace

WholeLevels::WholeLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                         const RunContext& context)
    : mesh_(mesh),
      scheme_(scheme),
      rules_(rules),
      lattice_(fan_lattice(scheme, rules)),
      max_memory_bytes_(context.max_memory_bytes),
      finder_(scheme, rules) {
    rules_.runner = &runner_;
    levels_[0] = std::make_unique<Level>();
    levels_[0]->step.mesh = rule_mesh(mesh, rules);
    levels_[0]->points.assign(mesh.positions().begin(), mesh.positions().end());
    if (lattice_ == FanLattice::triangles && !mesh.all_triangles()) level(1);  // says what is wrong
}

const WholeLevels::Level& WholeLevels::level(int level) {
    const std::lock_guard lock(mutex_);
    if (!levels_[static_cast<std::size_t>(level)]) check_size(level);
    return make(level);
}

/// Before any of it is made.
void WholeLevels::check_size(int level) const {
    // About as many as the level above has half-edges.
    const double vertices = level == 0 ? 0 : std::ldexp(mesh_.halfedge_count(), 2 * (level - 1));
    if (vertices > k_most_vertices)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("level {} has some {:.0f} vertices, too many to be made whole, as it has to be here; take "
                        "fewer levels or a coarser control mesh, and make semi-sharp creases of Chaikin's "
                        "method sharp for good or ones of the normal method",
                        level, vertices),
            mesh_.data().source);
    RunContext limits;
    limits.max_memory_bytes = max_memory_bytes_;
    check_rule_memory(mesh_, scheme_, level, level, limits);
}

const WholeLevels::Level& WholeLevels::make(int level) {
    std::unique_ptr<Level>& made = levels_[static_cast<std::size_t>(level)];
    if (made) return *made;
    const Level& above = make(level - 1);
    const RuleMesh& mesh = above.step.mesh;
    auto next = std::make_unique<Level>();
    // Tasks of callers that wait for the lock must not be taken up by this thread.
    oneapi::tbb::this_task_arena::isolate([&] {
        try {
            next->step = scheme_.step(mesh, rules_);
        } catch (const std::invalid_argument& e) {
            throw Error(ErrorCode::invalid_input, e.what(), mesh_.data().source);
        }
        next->points.resize(static_cast<std::size_t>(next->step.stencils.row_count()));
        apply(next->step.stencils, &above.points.data()->x, 3, &next->points.data()->x);
        next->step.stencils = {};
        if (lattice_ == FanLattice::dual && level == 1) cells_ = first_cells(mesh_, next->step);
    });
    made = std::move(next);
    return *made;
}

void WholeLevels::find_limits(int level, std::span<const int> vertices) {
    const std::lock_guard lock(mutex_);
    make(level);
    Level& made = *levels_[static_cast<std::size_t>(level)];
    const RuleMesh& mesh = made.step.mesh;
    made.limits.resize(made.points.size());
    made.has_limit.resize(made.points.size(), 0);
    std::vector<int> wanted;
    for (const int v : vertices)
        if (made.has_limit[static_cast<std::size_t>(v)] == 0) wanted.push_back(v);
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    try {
        for (std::size_t begin = 0; begin < wanted.size(); begin += k_limits_at_once) {
            const auto some = std::span(wanted).subspan(begin, std::min(k_limits_at_once, wanted.size() - begin));
            const RuleLimits limits = finder_.find(mesh, some);
            for (std::size_t i = 0; i < some.size(); ++i) {
                const auto v = static_cast<std::size_t>(some[i]);
                made.limits[v] = limit_point(limits, static_cast<int>(i), mesh, made.points, some[i]);
                made.has_limit[v] = 1;
            }
        }
    } catch (const std::invalid_argument& e) {
        throw NoLimit(e.what(), mesh_.data().source);
    }
}

/// Of a scheme that cuts a triangle into nine.
int WholeLevels::ternary_vertex(const Site& site, int level) const {
    std::int64_t scale = 1, size = k_triangle_unit;
    for (int l = site.level; l < level; ++l) scale *= 3;
    for (int l = 0; l < level; ++l) size *= 3;
    const std::int64_t x = k_triangle_unit * scale * site.at.x, y = k_triangle_unit * scale * site.at.y;
    const bool last = x + y == size;
    Descent way{x + 1 - (last && x > 0 ? k_triangle_unit : 0), y + 1 - (last && x == 0 ? k_triangle_unit : 0), x, y,
                size};
    int h = static_cast<int>(site.root.value);
    for (int at = 1; at <= level; ++at) {
        const RuleStep& step = levels_[static_cast<std::size_t>(at)]->step;
        way.size /= 3;
        h = ninth_child(step, h, way.x / way.size, way.y / way.size);
        way.move(way.x / way.size * way.size, way.y / way.size * way.size);
        if (way.x + way.y < way.size) continue;
        h = turned_neighbour(step.mesh, h);
        way.turn();
    }
    const RuleMesh& mesh = levels_[static_cast<std::size_t>(level)]->step.mesh;
    if (way.corner_x > 0) return mesh.target(h);
    return mesh.origin(way.corner_y > 0 ? mesh.prev(h) : h);
}

int WholeLevels::vertex(const Site& site, int level) const {
    if (scheme_.refinement == Refinement::sqrt3) return ternary_vertex(site, level);
    const auto mesh = [&](int l) -> const RuleMesh& { return levels_[static_cast<std::size_t>(l)]->step.mesh; };
    const auto step_to = [&](int l) -> const RuleStep& { return levels_[static_cast<std::size_t>(l)]->step; };
    const bool triangles = lattice_ == FanLattice::triangles, dual = lattice_ == FanLattice::dual;
    if (level == 0 && !triangles) return mesh(0).origin(static_cast<int>(site.root.value));
    // The cell whose corner the site is, or whose vertex.
    const int lattice_level = level - (triangles ? 0 : 1);
    const Site minimal = dual ? site : minimal_level(site);
    const int deeper = lattice_level - minimal.level;
    const std::int64_t n = std::int64_t{1} << lattice_level, x = std::int64_t{minimal.at.x} << deeper,
                       y = std::int64_t{minimal.at.y} << deeper, unit = triangles ? k_triangle_unit : k_quad_unit;
    std::int64_t cell_x = x, cell_y = y;
    if (!triangles) {
        cell_x = std::min(x, n - 1);
        cell_y = std::min(y, n - 1);
    } else if (x + y == n) {
        --(x > 0 ? cell_x : cell_y);
    }
    Descent way{unit * cell_x + 1, unit * cell_y + 1, unit * x, unit * y, unit * n};
    int at = 1;
    VertexFrame cell;
    if (dual)
        cell = cells_.frames[site.root.value];
    else if (triangles)
        cell.frame = {static_cast<int>(site.root.value), at = 0};
    else
        cell.frame = {step_to(1).child_halfedge[site.root.value], 0};
    for (; at < level; ++at) {
        const RuleStep& next = step_to(at + 1);
        if (dual)
            cell = vertex_child(mesh(at), next, cell, way.next_quad());
        else if (triangles)
            cell.frame = triangle_child(mesh(at), next, cell.frame, way.next_triangle());
        else
            cell.frame = quad_child(mesh(at), next, cell.frame, way.next_quad());
    }
    if (dual) return mesh(level).origin(cell.frame.halfedge);
    const bool right = way.corner_x > 0, up = way.corner_y > 0;
    const int corner = triangles ? (up ? 2 : right) : up ? (right ? 2 : 3) : right;
    return mesh(level).origin(face_corner(mesh(level), cell.frame, corner, triangles ? 3 : 4));
}

}  // namespace tetrakis::detail
