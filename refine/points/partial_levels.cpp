#include "partial_levels.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../rules/check_length.hpp"
#include "../rules/limit_search.hpp"
#include "../rules/mesh_part.hpp"
#include "../rules/rule_levels.hpp"
#include "../rules/rule_limit.hpp"
#include "../rules/rule_refiner.hpp"
#include "level_frames.hpp"
#include "level_query.hpp"
#include "level_walk.hpp"
#include "vertex_links.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace tetrakis {

using detail::CellFrame;
using detail::LevelQuery;

namespace {

using Step = RuleStep (*)(const RuleMesh&, const RuleOptions&);

// Addresses that are evaluated together: enough that the rings around their part weigh little beside it, and few enough
// to share the work and bound the memory.
constexpr std::size_t k_block = 1024;
// The same with wide surroundings, which may lie far apart.
constexpr std::size_t k_block_of_others = 256;

/// An address on its way down: a cell of the target level and the point asked for, both in the frame of the cell that
/// it has come to, whose sides are `size` long.
struct Walker {
    CellFrame frame;
    unsigned faces = 0;                     ///< dual: VertexFrame::faces
    std::int64_t x = 0, y = 0;              ///< middle of the wanted cell
    std::int64_t point_x = 0, point_y = 0;  ///< the wanted corner
    std::int64_t size = 0;
    int steps = 0;  ///< levels left
    std::uint32_t index = 0;
};

// Units of a cell's side in which its middle has whole coordinates.
constexpr std::int64_t k_quad_unit = 2, k_triangle_unit = 3;

int quadrant(Walker& w) {
    w.size /= 2;
    const int right = w.x > w.size ? 1 : 0, up = w.y > w.size ? 1 : 0;
    w.x -= right * w.size;
    w.y -= up * w.size;
    w.point_x -= right * w.size;
    w.point_y -= up * w.size;
    constexpr int corner[2][2] = {{0, 1}, {3, 2}};
    return corner[up][right];
}

int triangle_part(Walker& w) {
    w.size /= 2;
    const auto move = [&](std::int64_t dx, std::int64_t dy) {
        w.x -= dx;
        w.y -= dy;
        w.point_x -= dx;
        w.point_y -= dy;
    };
    if (w.x > w.size) {
        move(w.size, 0);
        return 1;
    }
    if (w.y > w.size) {
        move(0, w.size);
        return 2;
    }
    if (w.x + w.y < w.size) return 0;
    for (std::int64_t* c : {&w.x, &w.y, &w.point_x, &w.point_y}) *c = w.size - *c;
    return 3;
}

enum class Asked {
    positions,
    limits,
    limit_positions,  ///< the positions of limits alone; the rest may or may not be there
    frames,
};

bool asks_for_limits(Asked asked) { return asked == Asked::limits || asked == Asked::limit_positions; }

/// Where limits go: whole points, or positions alone, without tangents and normals.
struct LimitsOut {
    std::span<LimitPoint> points;
    std::span<Vec3d> positions;

    bool positions_alone() const { return !positions.empty(); }
    void put(std::uint32_t index, const LimitPoint& point) const {
        if (positions_alone())
            positions[index] = point.position;
        else
            points[index] = point;
    }
};

/// The net about one of its vertices.
LimitPoint frame(const RuleMesh& mesh, std::span<const Vec3d> net, int v) {
    Vec3d normal(0);
    const RuleMesh::Ring ring = mesh.ring(v);
    for (const int h : ring.halfedge) {
        const auto corners = mesh.corners(mesh.face(h));
        for (std::size_t i = 1; i + 1 < corners.size(); ++i)
            normal += glm::cross(net[corners[i]] - net[corners[0]], net[corners[i + 1]] - net[corners[0]]);
    }
    return detail::frame_from(net[v], normal, net[ring.neighbour[0]] - net[v]);
}

}  // namespace

struct PartialLevels::Impl {
    struct Worker {
        detail::MeshPartFinder parts;
        detail::RuleLimitFinder limits;
    };

    Impl(const ControlMesh& m, const SchemeInfo& s, const RuleOptions& r)
        : mesh(m), scheme(s), rules(r), lattice(fan_lattice(s, r)), reach(rule_rings(s, r)), first_step(s.step) {
        if (scheme.refinement == Refinement::sqrt3 || scheme.family == MeshFamily::hexagons)
            throw Error(ErrorCode::unsupported,
                        std::string(scheme.name) + " has no lattice of cells by which to name its vertices");
        try {
            base = rule_mesh(mesh, rules);
            points.assign(mesh.positions().begin(), mesh.positions().end());
            first_step = first_rule_step(scheme, base);
            if (lattice == FanLattice::triangles && !base.all_faces_have(3)) scheme.step(base, rules);  // says why not
            if (lattice == FanLattice::dual) start_dual();
        } catch (const std::invalid_argument& e) {
            throw Error(ErrorCode::invalid_input, e.what(), mesh.data().source);
        }
    }

    bool dual() const { return lattice == FanLattice::dual; }

    void start_dual() {
        if (boundary_recedes(scheme, rules))
            throw Error(ErrorCode::unsupported, "a boundary that recedes has no vertex quadtrees; replicate it");
        RuleStep step = scheme.step(base, rules);
        std::vector<Vec3d> finer(step.stencils.row_count());
        step.stencils.apply<Vec3d>(points, finer);
        points = std::move(finer);
        // A corner's child has the corner's face at its far corner; at the end of the surface, and on a crease, the
        // faces of a point lie above it.
        roots = detail::vertex_frames(step.mesh);
        root_face.resize(roots.size());
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
            const int child = step.child_halfedge[h], v = step.mesh.origin(child);
            roots[v] = {child, 2};
            root_face[v] = mesh.face(HalfedgeId(h));
        }
        for (const CellFrame& root : roots) {
            const std::array<int, 4> at = detail::vertex_corners(step.mesh, root);
            unsigned faces = 0;
            for (std::size_t c = 0; c < 4; ++c) faces |= at[c] != RuleMesh::none ? 1u << c : 0u;
            root_corners.push_back(faces);
        }
        base = std::move(step.mesh);
    }

    Worker& worker() const { return workers.local(); }
    void run(const std::vector<LevelQuery>& queries, Asked asked, std::span<Vec3d> positions,
             std::span<LimitPoint> points_out, LevelCost* cost) const;
    void limit_positions(const std::vector<LevelQuery>& queries, std::span<Vec3d> positions) const;
    /// Limits: `limit_rings` are raised around each vertex. Returns the addresses that this was not enough for.
    std::vector<std::uint32_t> run_block(const std::vector<LevelQuery>& queries, std::span<const std::uint32_t> block,
                                         Asked asked, int limit_rings, std::span<Vec3d> positions,
                                         std::span<LimitPoint> out, LevelCost& cost) const;
    std::vector<std::uint32_t> write_limits(const RuleMesh& level, std::span<const Vec3d> net,
                                            std::span<const Walker> here, std::span<const int> vertices,
                                            int whole_rings, const LimitsOut& out) const;

    Walker start(const LevelQuery& q, std::uint32_t index) const {
        Walker w;
        w.index = index;
        const std::int64_t n = std::int64_t{1} << q.level;
        const bool triangles = lattice == FanLattice::triangles;
        const std::int64_t unit = triangles ? k_triangle_unit : k_quad_unit;
        w.size = unit * n;
        w.x = unit * q.cell.x + 1;
        w.y = unit * q.cell.y + 1;
        w.point_x = unit * q.point.x;
        w.point_y = unit * q.point.y;
        // Quads: one more step, from the half-edge to its corner cell.
        w.steps = q.level + (lattice == FanLattice::quads ? 1 : 0);
        w.frame = dual() ? roots[q.root] : CellFrame{static_cast<int>(q.root), 0};
        if (dual()) w.faces = root_corners[q.root];
        return w;
    }

    void descend(const RuleMesh& level, const RuleStep& step, Walker& w, bool from_control) const {
        if (lattice == FanLattice::quads && from_control)
            w.frame = {step.child_halfedge[w.frame.halfedge], 0};
        else if (lattice == FanLattice::quads)
            w.frame = detail::quad_child(level, step, w.frame, quadrant(w));
        else if (lattice == FanLattice::triangles)
            w.frame = detail::triangle_child(level, step, w.frame, triangle_part(w));
        else {
            const detail::VertexFrame child = detail::vertex_child(level, step, {w.frame, w.faces}, quadrant(w));
            w.frame = child.frame;
            w.faces = child.faces;
        }
        --w.steps;
        if (w.frame.halfedge == RuleMesh::none)
            throw Error(ErrorCode::invalid_input, "an address leads to where the scheme has no vertex");
    }

    int vertex(const RuleMesh& level, const Walker& w) const {
        if (dual()) return level.origin(w.frame.halfedge);
        const bool right = w.point_x > 0, up = w.point_y > 0;
        if (lattice == FanLattice::triangles)
            return level.origin(detail::face_corner(level, w.frame, up ? 2 : right, 3));
        const int corner = up ? (right ? 2 : 3) : right;
        return level.origin(detail::face_corner(level, w.frame, corner, 4));
    }

    const ControlMesh& mesh;
    const SchemeInfo& scheme;
    RuleOptions rules;
    FanLattice lattice;
    int reach;
    Step first_step;
    RuleMesh base;  // the control mesh; dual: level 1
    std::vector<Vec3d> points;
    std::vector<CellFrame> roots;        // dual; on a crease one for each side
    std::vector<FaceId> root_face;       // dual: of the corners' children
    std::vector<unsigned> root_corners;  // dual: VertexFrame::faces
    mutable oneapi::tbb::enumerable_thread_specific<Worker> workers{[this] {
        return Worker{{}, detail::RuleLimitFinder(scheme, rules)};
    }};
};

void PartialLevels::Impl::run(const std::vector<LevelQuery>& queries, Asked asked, std::span<Vec3d> positions,
                              std::span<LimitPoint> out, LevelCost* cost) const {
    struct Key {
        std::uint32_t root;
        std::uint64_t place;
        std::uint32_t level, index;
        auto operator<=>(const Key&) const = default;
    };
    std::vector<Key> keys(queries.size());
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const LevelQuery& q = queries[i];
        keys[i] = {q.root, detail::curve_place(q), q.level, static_cast<std::uint32_t>(i)};
    }
    if (!std::is_sorted(keys.begin(), keys.end())) std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].index;
    LevelCost all;
    // Returns the addresses that were left, in order.
    const auto run_all = [&](std::span<const std::uint32_t> addresses, std::size_t block_size, int limit_rings) {
        const std::size_t blocks = (addresses.size() + block_size - 1) / block_size;
        std::vector<LevelCost> costs(blocks);
        std::vector<std::vector<std::uint32_t>> left(blocks);
        for_each_index(
            static_cast<std::uint32_t>(blocks),
            [&](std::uint32_t b) {
                const std::size_t begin = b * block_size, count = std::min(block_size, addresses.size() - begin);
                left[b] =
                    run_block(queries, addresses.subspan(begin, count), asked, limit_rings, positions, out, costs[b]);
            },
            1);
        for (const LevelCost& c : costs) {
            all.faces += c.faces;
            all.most_faces = std::max(all.most_faces, c.most_faces);
        }
        std::vector<std::uint32_t> result;
        for (const std::vector<std::uint32_t>& l : left) result.insert(result.end(), l.begin(), l.end());
        return result;
    };
    try {
        if (asks_for_limits(asked)) {
            // Most vertices are regular, and need little around them; the others are raised once more, with more.
            const int most = detail::rule_limit_rings(scheme, rules);
            const int few = worker().limits.regular_rings().value_or(most);
            const std::vector<std::uint32_t> left = run_all(order, k_block, std::min(few, most));
            run_all(left, k_block_of_others, most);
        } else {
            run_all(order, k_block, 0);
        }
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::unsupported, e.what(), mesh.data().source);
    }
    if (cost != nullptr) *cost = all;
}

std::vector<std::uint32_t> PartialLevels::Impl::run_block(const std::vector<LevelQuery>& queries,
                                                          std::span<const std::uint32_t> block, Asked asked,
                                                          int limit_rings, std::span<Vec3d> positions,
                                                          std::span<LimitPoint> out, LevelCost& cost) const {
    Worker& tools = worker();
    const LimitsOut limits{out, asked == Asked::limit_positions ? positions : std::span<Vec3d>{}};
    std::vector<std::uint32_t> left;
    std::vector<Walker> walkers;
    walkers.reserve(block.size());
    int last = 0;
    for (const std::uint32_t i : block) {
        walkers.push_back(start(queries[i], i));
        last = std::max(last, walkers.back().steps);
    }
    // Rings around the wanted cells. A level's rings give twice as many on the next one, less what the rules reach; the
    // outer faces of a dual mesh, around its vertices, are not whole there.
    std::vector<int> rings(last + 1, 1);
    std::vector<char> ends(last + 1, 0);
    for (const Walker& w : walkers) ends[w.steps] = 1;
    for (int level = last; level >= 0; --level) {
        if (asks_for_limits(asked) && ends[level] != 0) rings[level] = limit_rings + 1;
        if (level == last) continue;
        rings[level] = std::max(rings[level], (rings[level + 1] + (dual() ? 2 : 1)) / 2 + reach);
    }
    const RuleMesh* above = &base;
    std::span<const Vec3d> net = points;
    RuleStep step;
    std::vector<Vec3d> finer;
    for (int level = 0;; ++level) {
        std::vector<int> seeds;
        // Those that are in one cell come one after another.
        int before = RuleMesh::none;
        for (const Walker& w : walkers) {
            if (std::exchange(before, w.frame.halfedge) == w.frame.halfedge) continue;
            if (dual())
                seeds.push_back(above->origin(w.frame.halfedge));
            else
                for (const int v : above->corners(above->face(w.frame.halfedge))) seeds.push_back(v);
        }
        const detail::MeshPart part = tools.parts.find(*above, seeds, rings[level]);
        cost.faces += part.face.size();
        cost.most_faces = std::max(cost.most_faces, static_cast<std::uint32_t>(part.face.size()));
        std::vector<Vec3d> here(part.vertex.size());
        for (std::size_t i = 0; i < here.size(); ++i) here[i] = net[part.vertex[i]];
        before = RuleMesh::none;
        for (int now = RuleMesh::none; Walker & w : walkers) {
            if (std::exchange(before, w.frame.halfedge) != w.frame.halfedge)
                now = part.halfedge(*above, w.frame.halfedge);
            w.frame.halfedge = now;
        }
        const bool any_arrived =
            std::any_of(walkers.begin(), walkers.end(), [](const Walker& w) { return w.steps == 0; });
        const auto arrived = !any_arrived ? walkers.end()
                                          : std::stable_partition(walkers.begin(), walkers.end(),
                                                                  [](const Walker& w) { return w.steps > 0; });
        std::vector<int> vertices;
        for (auto w = arrived; w != walkers.end(); ++w) vertices.push_back(vertex(part.mesh, *w));
        if (asked == Asked::positions)
            for (std::size_t i = 0; i < vertices.size(); ++i) positions[arrived[i].index] = here[vertices[i]];
        else if (asked == Asked::frames)
            for (std::size_t i = 0; i < vertices.size(); ++i)
                out[arrived[i].index] = frame(part.mesh, here, vertices[i]);
        else if (!vertices.empty())
            for (const std::uint32_t i :
                 write_limits(part.mesh, here, {arrived, walkers.end()}, vertices, limit_rings, limits))
                left.push_back(i);
        walkers.erase(arrived, walkers.end());
        if (walkers.empty()) return left;

        const bool from_control = level == 0 && !dual();
        RuleStep next = (from_control ? first_step : scheme.step)(part.mesh, rules);
        for (Walker& w : walkers) descend(part.mesh, next, w, from_control);
        finer.resize(next.stencils.row_count());
        next.stencils.apply<Vec3d>(here, finer);
        step = std::move(next);
        above = &step.mesh;
        net = finer;
    }
}

std::vector<std::uint32_t> PartialLevels::Impl::write_limits(const RuleMesh& level, std::span<const Vec3d> net,
                                                             std::span<const Walker> here,
                                                             std::span<const int> vertices, int whole_rings,
                                                             const LimitsOut& out) const {
    // Many addresses of a block name the same vertex.
    std::vector<int> once, number(level.vertex_count(), -1);
    for (const int v : vertices)
        if (number[v] < 0) {
            number[v] = static_cast<int>(once.size());
            once.push_back(v);
        }
    std::vector<LimitPoint> points_once(once.size());
    detail::RuleLimitFinder& limits = worker().limits;
    std::vector<char> missing(once.size(), 0);
    if (whole_rings >= detail::rule_limit_rings(scheme, rules))
        limits.points(level, net, once, points_once);
    else
        for (const int i : limits.regular_points(level, net, once, whole_rings, points_once)) missing[i] = 1;
    std::vector<std::uint32_t> left;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const int at = number[vertices[i]];
        if (missing[at] != 0)
            left.push_back(here[i].index);
        else
            out.put(here[i].index, points_once[at]);
    }
    return left;
}

PartialLevels::PartialLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules)
    : impl_(std::make_unique<Impl>(mesh, scheme, rules)) {}
PartialLevels::~PartialLevels() = default;
PartialLevels::PartialLevels(PartialLevels&&) noexcept = default;
PartialLevels& PartialLevels::operator=(PartialLevels&&) noexcept = default;

FanLattice PartialLevels::lattice() const { return impl_->lattice; }

void PartialLevels::control_positions(std::span<const Site> sites, std::span<Vec3d> out, LevelCost* cost) const {
    detail::check_length("positions to write", out.size(), sites.size());
    impl_->run(detail::site_queries(impl_->mesh, impl_->lattice, sites, false), Asked::positions, out, {}, cost);
}

void PartialLevels::control_positions(std::span<const VertexCell> cells, std::span<Vec3d> out, LevelCost* cost) const {
    detail::check_length("positions to write", out.size(), cells.size());
    impl_->run(detail::cell_queries(impl_->lattice, impl_->roots.size(), cells), Asked::positions, out, {}, cost);
}

void PartialLevels::limits(std::span<const Site> sites, std::span<LimitPoint> out, LevelCost* cost) const {
    detail::check_length("points to write", out.size(), sites.size());
    impl_->run(detail::site_queries(impl_->mesh, impl_->lattice, sites, true), Asked::limits, {}, out, cost);
}

void PartialLevels::limits(std::span<const VertexCell> cells, std::span<LimitPoint> out, LevelCost* cost) const {
    detail::check_length("points to write", out.size(), cells.size());
    impl_->run(detail::cell_queries(impl_->lattice, impl_->roots.size(), cells), Asked::limits, {}, out, cost);
}

void PartialLevels::frames(std::span<const Site> sites, std::span<LimitPoint> out) const {
    detail::check_length("points to write", out.size(), sites.size());
    impl_->run(detail::site_queries(impl_->mesh, impl_->lattice, sites, false), Asked::frames, {}, out, nullptr);
}

void PartialLevels::frames(std::span<const VertexCell> cells, std::span<LimitPoint> out) const {
    detail::check_length("points to write", out.size(), cells.size());
    impl_->run(detail::cell_queries(impl_->lattice, impl_->roots.size(), cells), Asked::frames, {}, out, nullptr);
}

void PartialLevels::Impl::limit_positions(const std::vector<LevelQuery>& queries, std::span<Vec3d> positions) const {
    detail::check_length("positions to write", positions.size(), queries.size());
    run(queries, Asked::limit_positions, positions, {}, nullptr);
}

void PartialLevels::positions(std::span<const Site> sites, std::span<Vec3d> positions) const {
    impl_->limit_positions(detail::site_queries(impl_->mesh, impl_->lattice, sites, true), positions);
}

void PartialLevels::positions(std::span<const VertexCell> cells, std::span<Vec3d> positions) const {
    impl_->limit_positions(detail::cell_queries(impl_->lattice, impl_->roots.size(), cells), positions);
}

VertexRoots PartialLevels::vertex_roots() const {
    if (!impl_->dual()) throw Error(ErrorCode::invalid_input, "only dual schemes have vertex quadtrees");
    return detail::vertex_roots(impl_->mesh, impl_->base, impl_->roots, impl_->root_face);
}

}  // namespace tetrakis
