#include "whole_levels.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../rules/rule_limit.hpp"
#include "../rules/rule_refiner.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Most vertices of a level; such a level takes some 10 GB, and a minute or two.
constexpr double k_most_vertices = 1u << 25;
/// Most vertices whose limits are found together; their rows take some 60 MB.
constexpr std::size_t k_limits_at_once = std::size_t{1} << 16;

}  // namespace

WholeLevels::WholeLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                         const VertexRoots& roots, const RunContext& context)
    : mesh_(mesh),
      scheme_(scheme),
      rules_(rules),
      roots_(roots),
      lattice_(fan_lattice(scheme, rules)),
      max_memory_bytes_(context.max_memory_bytes),
      search_(scheme, rules) {
    rules_.runner = &runner_;
    levels_[0] = std::make_unique<Level>();
    levels_[0]->step.mesh = rule_mesh(mesh, scheme, rules);
    levels_[0]->points.assign(mesh.positions().begin(), mesh.positions().end());
    if (lattice_ != FanLattice::triangles || mesh.face_count() == 0) return;
    if (!mesh.all_triangles()) level(1);  // throws the scheme's error
    find_lattice(0, nullptr, *levels_[0]);
}

const WholeLevels::Level& WholeLevels::level(int level) {
    const std::lock_guard lock(mutex_);
    if (!levels_[static_cast<std::size_t>(level)]) check_size(level);
    return make(level);
}

/// Checks the size of a level before it is made.
void WholeLevels::check_size(int level) const {
    // A level has about as many vertices as the level before has half-edges.
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
        apply(next->step.stencils, above.points.data(), next->points.data());
        next->step.stencils = {};
        find_lattice(level, &above, *next);
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
            const RuleLimits limits = rule_limits(search_, mesh, some);
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

/// Level of the lattices: they begin at level 0 on triangles, otherwise at level 1.
int WholeLevels::lattice_level(int level) const { return level - (lattice_ == FanLattice::triangles ? 0 : 1); }

std::uint32_t WholeLevels::segments(int level) const {
    std::uint32_t result = 1;
    for (int l = 0; l < lattice_level(level); ++l) result *= scheme_.refinement == Refinement::sqrt3 ? 3 : 2;
    return result;
}

/// Finds the vertices of a new level by their places in the lattices.
void WholeLevels::find_lattice(int level, const Level* above, Level& next) {
    const RuleMesh& mesh = next.step.mesh;
    if (lattice_level(level) > 0) {
        for (const int h : above->corner) next.corner.push_back(next.step.child_halfedge[h]);
    } else if (lattice_ == FanLattice::dual) {
        net_ = RootLattices::of_corners(above->step.mesh, !ignores_creases(scheme_, rules_));
        next.corner = next.step.child_halfedge;
    } else {
        net_ = RootLattices::of_faces(mesh);
        next.corner.resize(static_cast<std::size_t>(mesh.halfedge_count()));
        std::iota(next.corner.begin(), next.corner.end(), 0);
    }
    next.vertex = net_->vertices(net_->layout(segments(level)), mesh, next.corner).value();
}

int WholeLevels::vertex(const Site& site, int level) const {
    const std::uint32_t root = site.root.value;
    if (lattice_level(level) < 0) return levels_[0]->step.mesh.origin(static_cast<int>(root));
    const bool triangles = lattice_ == FanLattice::triangles, dual = lattice_ == FanLattice::dual;
    // Sites of sqrt(3) are canonical, and so are cells.
    const Site own = dual || scheme_.refinement == Refinement::sqrt3 ? site : minimal_level(site);
    const std::uint32_t scale = segments(level) / segments(own.level + (triangles ? 0 : 1)),
                        h = triangles ? root
                            : dual    ? roots_.net_halfedge[root]
                                      : static_cast<std::uint32_t>(levels_[1]->step.child_halfedge[root]);
    return levels_[static_cast<std::size_t>(level)]
        ->vertex[net_->number(net_->layout(segments(level)), h, scale * own.at.x, scale * own.at.y)];
}

}  // namespace tetrakis::detail
