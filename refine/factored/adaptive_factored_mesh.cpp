#include "adaptive_factored_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/nearest_point.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../attributes/used_values.hpp"
#include "../points/row_points.hpp"
#include "../points/vertex_links.hpp"
#include "../uniform/refine.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::unsupported, what); }

ControlMesh without_corner_angles(const ControlMesh& mesh) {
    if (!mesh.has_corner_angles()) return mesh;
    ControlMeshData data = mesh.data();
    data.corner_angles.clear();
    return ControlMesh::build(std::move(data));
}

}  // namespace

struct AdaptiveFactoredMesh::State {
    State(const ControlMesh& mesh, FactoredScheme scheme, const RunContext& run)
        : context(run),
          control(without_corner_angles(mesh)),
          dual(scheme != FactoredScheme::catmull_clark),
          warnings(FactoredMesh(mesh, scheme).mesh().warnings) {
        const SchemeInfo& info = *find_scheme(name(scheme));
        if (dual) {
            for (std::uint32_t e = 0; e < control.edge_count(); ++e)
                if (!control.is_boundary(EdgeId(e)) && is_sharp(control.sharpness(EdgeId(e))))
                    refuse(
                        "half-steps of dual schemes do not adapt on a mesh with creases; refine it by the same number "
                        "of half-steps everywhere");
            roots = vertex_roots(control, info);
            cells = ControlMesh::build(cell_mesh(roots));
        }
        const RuleOptions rules = detail::with_crease_method(control, info, {});
        points = detail::row_points(control, info, rules, dual ? &roots : nullptr, run, false);
        forest.emplace(dual ? cells : control);
    }

    int half_steps(int depth) const { return depth + (dual ? 2 : 1); }

    /// Whether a point of the cell mesh lies on its boundary, which is outside of a dual scheme's surface.
    bool beyond(PointId p) const {
        const Site& s = forest->point_site(p);
        const bool on_edge = s.at.y == 0, on_prev = s.at.x == 0;
        if (on_edge && on_prev) return cells.is_boundary(cells.origin(s.root));
        return (on_edge && !cells.twin(s.root).valid()) || (on_prev && !cells.twin(cells.prev(s.root)).valid());
    }

    /// The corners of a leaf's triangle; nothing if the leaf has none.
    std::optional<std::array<PointId, 3>> triangle(LeafId id) const {
        const BisectionLeaf& leaf = forest->leaf(id);
        const auto& [a, b, apex] = leaf.vertex;
        if (!dual) return leaf.vertex;
        const bool a_beyond = beyond(a), b_beyond = beyond(b);
        if (!a_beyond && !b_beyond && !beyond(apex)) return leaf.vertex;
        // At even depth, base edges cross the boundary edges of the scheme's mesh, which are not cut yet. Two leaves
        // meet there, and their inner halves form one triangle.
        const LeafId across = leaf.neighbour[0];
        if (leaf.depth % 2 != 0 || a_beyond || !across.valid() || forest->depth(across) != leaf.depth)
            return std::nullopt;
        return std::array{a, forest->leaf(across).vertex[2], apex};
    }

    /// Adds the leaves outside of the surface that must be split with these, because the surface of a dual scheme
    /// grows: leaves across a leg, their base neighbours, and (for corners of the boundary) the same again for these.
    std::vector<LeafId> with_leaves_beyond(std::span<const LeafId> marked) const {
        std::vector<LeafId> result(marked.begin(), marked.end());
        std::size_t begin = 0;
        for (int round = 0; dual && round < 2; ++round)
            for (const std::size_t end = result.size(); begin < end; ++begin) {
                const LeafId id = result[begin];
                if (!forest->is_leaf(id)) continue;
                for (const std::size_t leg : {1, 2}) {
                    const LeafId other = forest->leaf(id).neighbour[leg];
                    if (!other.valid() || forest->depth(other) != forest->depth(id) || triangle(other)) continue;
                    result.push_back(other);
                    const LeafId base = forest->leaf(other).neighbour[0];
                    if (base.valid()) result.push_back(base);
                }
            }
        return result;
    }

    Site at_level(const Site& site, int level) const {
        const int shift = level - site.level;
        return {site.root, {site.at.x << shift, site.at.y << shift}, static_cast<std::uint8_t>(level)};
    }

    /// Adds all cells of a dual scheme's vertices that a point of the cell mesh touches.
    void add_cells_around(const Site& site, std::vector<VertexCell>& out) const {
        // In the frame of root h / 4: the origin of the site's frame is its corner h % 4. A cell is two units wide.
        const std::uint32_t h = site.root.value, size = 1u << site.level;
        std::uint32_t x = site.at.x, y = site.at.y;
        for (std::uint32_t turn = 0; turn < h % 4; ++turn) x = 2 * size - std::exchange(y, x);
        const VertexCell cell{h / 4, {std::min(x / 2, size - 1), std::min(y / 2, size - 1)}, site.level};
        const std::uint32_t dx = x - 2 * cell.at.x, dy = y - 2 * cell.at.y;
        if (dx != 1 && dy != 1) {
            const int corner = dy == 0 ? (dx == 0 ? 0 : 1) : (dx == 0 ? 3 : 2);
            for (const VertexRoots::Corner& c : roots.fan({cell, corner}).corners) out.push_back(c.cell);
            return;
        }
        out.push_back(cell);
        if (dx == 1 && dy == 1) return;
        const VertexRoots::Across other = roots.across(cell, dy == 0 ? 0 : dy == 2 ? 2 : dx == 2 ? 1 : 3);
        if (other.kind == VertexRoots::Across::Kind::neighbour) out.push_back(other.cell);
    }

    void set_positions(std::span<const Site> sites, std::vector<Vec3d>& positions) const {
        positions.resize(sites.size());
        if (!dual) return written_positions(*points, sites, positions);
        std::vector<VertexCell> around;
        std::vector<std::size_t> first{0};
        for (const Site& site : sites) {
            add_cells_around(site, around);
            first.push_back(around.size());
        }
        std::vector<Vec3d> found(around.size());
        written_positions(*points, cell_sites(around), found);
        for (std::size_t p = 0; p < sites.size(); ++p) {
            Vec3d sum(0);
            for (std::size_t i = first[p]; i < first[p + 1]; ++i) sum += found[i];
            positions[p] = sum / static_cast<double>(first[p + 1] - first[p]);
        }
    }

    RunContext context;
    ControlMesh control, cells;
    VertexRoots roots;
    bool dual;
    std::shared_ptr<const LevelSource> points;
    std::vector<std::string> warnings;
    std::optional<BisectionForest> forest;
};

AdaptiveFactoredMesh::AdaptiveFactoredMesh(const ControlMesh& mesh, FactoredScheme scheme, const RunContext& context) {
    if (!half_steps_adapt(scheme))
        refuse("half-steps of " + std::string(name(scheme)) +
               " do not adapt; those of catmull-clark and of dual schemes such as doo-sabin do");
    state_ = std::make_unique<State>(mesh, scheme, context);
}
AdaptiveFactoredMesh::~AdaptiveFactoredMesh() = default;
AdaptiveFactoredMesh::AdaptiveFactoredMesh(AdaptiveFactoredMesh&&) noexcept = default;
AdaptiveFactoredMesh& AdaptiveFactoredMesh::operator=(AdaptiveFactoredMesh&&) noexcept = default;

int AdaptiveFactoredMesh::first_half_step() const { return state_->half_steps(0); }
int AdaptiveFactoredMesh::max_half_steps() const { return state_->half_steps(k_max_bisection_depth); }

void AdaptiveFactoredMesh::refine(std::span<const Leaf> leaves) {
    std::vector<LeafId> ids;
    ids.reserve(leaves.size());
    for (const Leaf& leaf : leaves) {
        // The first child has its parent's slot, so the half-steps are compared as well.
        if (!state_->forest->is_leaf(leaf.id) ||
            state_->half_steps(state_->forest->depth(leaf.id)) != int{leaf.half_steps})
            throw Error(ErrorCode::invalid_input,
                        "a leaf to be refined is none any more; take leaves from mesh() anew");
        ids.push_back(leaf.id);
    }
    // Bytes of a leaf with its triangle, site and cells; closure seldom splits more leaves than were marked.
    constexpr std::uint64_t k_per_leaf = 600;
    detail::check_memory(
        "the next half-step needs", k_per_leaf * (state_->forest->leaf_count() + 2 * std::uint64_t{leaves.size()}),
        state_->context.max_memory_bytes, "ask for fewer half-steps or a smaller radius, or allow more");
    std::vector<LeafId> created;
    state_->forest->refine(state_->with_leaves_beyond(ids), created);
}

void AdaptiveFactoredMesh::refine_near(const Vec3d& centre, double radius, int half_steps) {
    if (!std::isfinite(centre.x) || !std::isfinite(centre.y) || !std::isfinite(centre.z))
        throw Error(ErrorCode::invalid_input, "the centre of the sphere is not finite");
    if (!std::isfinite(radius) || radius <= 0)
        throw Error(ErrorCode::invalid_input, "the radius of the sphere must be finite and greater than 0");
    if (half_steps > max_half_steps())
        refuse(std::to_string(half_steps) + " half-steps are too many here; there can be " +
               std::to_string(max_half_steps()));
    for (;;) {
        const Output now = mesh();
        std::vector<Leaf> marked;
        int least = half_steps;
        for (std::size_t t = 0; t < now.leaves.size(); ++t) {
            const int done = now.leaves[t].half_steps;
            if (done >= half_steps) continue;
            std::array<Vec3d, 3> corner;
            for (std::size_t k = 0; k < 3; ++k) corner[k] = now.mesh.positions[now.mesh.face_vertices[3 * t + k]];
            double longest = 0;
            for (std::size_t k = 0; k < 3; ++k)
                longest = std::max(longest, glm::length(corner[(k + 1) % 3] - corner[k]));
            const double reach = radius + 0.5 * longest;
            if (detail::nearest_on_triangle(centre, corner[0], corner[1], corner[2]).squared_distance > reach * reach)
                continue;
            marked.push_back(now.leaves[t]);
            least = std::min(least, done);
        }
        if (marked.empty()) return;
        state_->context.report("refine", static_cast<double>(least) / half_steps);
        refine(marked);
    }
}

AdaptiveFactoredMesh::Output AdaptiveFactoredMesh::mesh() const {
    const State& state = *state_;
    const ExportedTriangles exported = state.forest->exported();
    std::vector<std::uint32_t> number(state.forest->point_slots());
    for (std::uint32_t p = 0; p < exported.points.size(); ++p) number[exported.points[p].value] = p;

    Output out;
    out.mesh.warnings = state.warnings;
    const ControlMeshData& data = state.control.data();
    if (!state.dual) {
        out.mesh.materials = data.materials;
        out.mesh.groups = data.groups;
    }
    out.mesh.face_offsets.push_back(0);
    std::vector<std::uint8_t> depth(exported.sites.size(), 0);
    for (std::size_t t = 0; t < exported.leaves.size(); ++t) {
        const LeafId id = exported.leaves[t];
        const auto triangle = state.triangle(id);
        if (!triangle) continue;
        const int d = state.forest->depth(id);
        for (const PointId p : *triangle) {
            const std::uint32_t v = number[p.value];
            out.mesh.face_vertices.push_back(v);
            depth[v] = std::max(depth[v], static_cast<std::uint8_t>(d));
        }
        out.mesh.face_offsets.push_back(static_cast<std::uint32_t>(out.mesh.face_vertices.size()));
        out.leaves.push_back({static_cast<std::uint8_t>(state.half_steps(d)), id});
        if (state.dual) continue;
        const std::uint32_t face = exported.faces[t].value;
        if (!data.face_material.empty()) out.mesh.face_material.push_back(data.face_material[face]);
        if (!data.face_group.empty()) out.mesh.face_group.push_back(data.face_group[face]);
    }
    // Points outside of the surface are removed; the others keep their order.
    std::vector<Site> sites = exported.sites;
    const std::vector<std::uint32_t> used = detail::number_used(out.mesh.face_vertices, sites.size());
    detail::keep_used(used, sites);
    detail::keep_used(used, depth);
    for (std::size_t v = 0; v < sites.size(); ++v) {
        sites[v] = state.at_level(sites[v], lattice_level(depth[v]));
        out.half_steps.push_back(static_cast<std::uint8_t>(state.half_steps(depth[v])));
        const bool centre = sites[v].at.x % 2 == 0 && sites[v].at.y % 2 == 0;
        out.states.push_back(state.dual && centre ? FactoredVertex::inactive : FactoredVertex::active);
    }
    state.set_positions(sites, out.mesh.positions);
    return out;
}

}  // namespace tetrakis
