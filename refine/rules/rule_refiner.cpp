#include "rule_refiner.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/most_frequent.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/mesh_check.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "corner_angles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

StencilTable smoothing_stencils(const RuleMesh& mesh) {
    StencilTable table;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const VertexRule rule = mesh.first(v) == RuleMesh::none ? VertexRule::corner : mesh.rule(v);
        if (rule == VertexRule::corner) {
            table.push({{v, 1}});
            continue;
        }
        const auto around = rule == VertexRule::crease ? mesh.sharp_neighbours(v) : mesh.ring(v).neighbour;
        StencilRow row{{v, 0.5}};
        for (const int e : around) row.add(e, 0.5 / static_cast<double>(around.size()));
        table.push(std::move(row));
    }
    return table;
}

}  // namespace

RuleLevels::RuleLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, int smoothing)
    : scheme_(scheme), rules_(rules), source_(mesh.data().source), last_(rule_mesh(mesh, scheme, rules)) {
    rules_.runner = &runner_;
    faces_.control_face.resize(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) faces_.control_face[f] = static_cast<int>(f);
    for (int i = 0; i < smoothing; ++i) steps_.push_back(smoothing_stencils(last_));
}

std::vector<int> RuleLevels::advance() {
    RuleStep step;
    try {
        step = scheme_.step(last_, rules_);
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::invalid_input, e.what(), source_);
    }
    if (splits_vertices(scheme_, rules_)) {
        faces_.follow(last_, step);
    } else {
        for (int& face : step.parent_face) face = faces_.control_face[face];
        faces_.control_face = std::move(step.parent_face);
    }
    steps_.push_back(std::move(step.stencils));
    last_ = std::move(step.mesh);
    ++level_;
    return std::move(step.child_halfedge);
}

std::vector<std::uint32_t> RuleLevels::control_face_of_corners() const {
    std::vector<std::uint32_t> of(static_cast<std::size_t>(last_.halfedge_count()));
    for (int h = 0; h < last_.halfedge_count(); ++h)
        of[h] = static_cast<std::uint32_t>(faces_.point_face.empty() ? faces_.control_face[last_.face(h)]
                                                                     : faces_.point_face[h]);
    return of;
}

/// In a dual scheme a point lies in one control face, but a face may lie across several.
void CornerFaces::follow(const RuleMesh& level, const RuleStep& step) {
    const RuleMesh& finer = step.mesh;
    std::vector<int> corners, next;
    // Per point of the finer mesh: the half-edge of its parent corner. Points on boundaries and creases have none.
    std::vector<int> corner_of(static_cast<std::size_t>(finer.vertex_count()), RuleMesh::none);
    for (std::size_t h = 0; h < step.child_halfedge.size(); ++h)
        if (const int child = step.child_halfedge[h]; child != RuleMesh::none)
            corner_of[finer.origin(child)] = static_cast<int>(h);
    if (point_face.empty())
        for (int h = 0; h < level.halfedge_count(); ++h) point_face.push_back(control_face[level.face(h)]);
    std::vector<int> of_points(static_cast<std::size_t>(finer.halfedge_count()));
    for (int f = 0; f < finer.face_count(); ++f) {
        corners.clear();
        for (const int v : finer.corners(f))
            corners.push_back(corner_of[v] != RuleMesh::none ? point_face[corner_of[v]] : RuleMesh::none);
        if (std::all_of(corners.begin(), corners.end(), [](int c) { return c == RuleMesh::none; }))
            corners[0] = control_face[step.parent_face[f]];
        // Points on boundaries and creases take the face of the corner before or after them in their face. Corners that
        // still have none after the first round take the first face of their sector.
        for (bool first_round = true; std::count(corners.begin(), corners.end(), RuleMesh::none) != 0;
             first_round = false) {
            next = corners;
            const std::size_t size = corners.size();
            for (std::size_t i = 0; i < size; ++i) {
                if (corners[i] != RuleMesh::none) continue;
                const int before = corners[(i + size - 1) % size], after = corners[(i + 1) % size];
                const int preferred = first_round ? before : after;
                next[i] = preferred != RuleMesh::none ? preferred : first_round ? after : before;
            }
            corners.swap(next);
        }
        std::copy(corners.begin(), corners.end(), of_points.begin() + finer.face_begin(f));
    }
    // Where a crease ends, its last point lies on both sides; it belongs to the left one, as in vertex_roots().
    for (int h = 0; h < static_cast<int>(step.child_crease.size()); ++h) {
        const int along = step.child_crease[h];
        if (along == RuleMesh::none || level.on_boundary(level.origin(h)) ||
            level.sharp_neighbours(level.origin(h)).size() != 1)
            continue;
        for (const int around : finer.ring(finer.origin(along)).halfedge) of_points[around] = of_points[along];
    }
    point_face = std::move(of_points);
    control_face.resize(static_cast<std::size_t>(finer.face_count()));
    for (int f = 0; f < finer.face_count(); ++f) {
        corners.assign(point_face.begin() + finer.face_begin(f),
                       point_face.begin() + finer.face_begin(f) + finer.face_size(f));
        control_face[f] = most_frequent(corners);
    }
}

void RuleLevels::net(std::span<const Vec3d> control, std::span<Vec3d> out) const {
    if (steps_.empty()) std::copy(control.begin(), control.end(), out.begin());
    std::vector<Vec3d> coarser, finer;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
        const bool last = i + 1 == steps_.size();
        if (!last) finer.resize(static_cast<std::size_t>(steps_[i].row_count()));
        apply(steps_[i], i == 0 ? control.data() : coarser.data(), last ? out.data() : finer.data());
        coarser.swap(finer);
    }
}

}  // namespace tetrakis::detail

namespace tetrakis {

namespace {

/// The largest number of half-edges of the next level per half-edge.
std::uint64_t growth(const SchemeInfo& scheme) { return scheme.refinement == Refinement::sqrt3 ? 9 : 4; }

// Bytes per half-edge of a level: its connectivity, the memory to build that, and the stencils of its points (measured
// for Loop and Catmull-Clark; the long rules of Butterfly, Kobbelt and many averaging steps take up to twice as much).
// With texture coordinates, charts have levels too.
constexpr std::uint64_t k_bytes_per_halfedge = 160, k_bytes_with_charts = 240;
constexpr std::uint64_t k_bytes_per_term = sizeof(int) + sizeof(double);

/// Bytes per level for the terms of rows around large faces and around vertices of high valence.
std::uint64_t bytes_of_large_rings(const ControlMesh& mesh, const SchemeInfo& scheme) {
    constexpr std::uint64_t k_large = 32;
    std::uint64_t bytes = 0;
    const auto add = [&](std::uint64_t size) { bytes += size > k_large ? size * size * k_bytes_per_term : 0; };
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) add(mesh.face_size(FaceId(f)));
    for (std::uint32_t v = 0; v < mesh.vertex_count() && scheme.sees_rings; ++v) add(mesh.face_valence(VertexId(v)));
    return bytes;
}

}  // namespace

RuleMesh rule_mesh(const ControlMesh& mesh, const RuleOptions& rules, bool sharp_for_ever) {
    const ControlMeshData& data = mesh.data();
    const auto tag = [&](float sharpness) {
        return sharp_for_ever && is_sharp(sharpness) ? k_sharpness_infinity : sharpness;
    };
    RuleMesh::Builder faces;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h)
            faces.corner(static_cast<int>(data.face_vertices[h]), tag(mesh.sharpness(mesh.edge(HalfedgeId(h)))));
        faces.end_face();
    }
    std::vector<int> twins(mesh.halfedge_count(), RuleMesh::none);
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
        if (const HalfedgeId twin = mesh.twin(HalfedgeId(h)); twin.valid()) twins[h] = static_cast<int>(twin.value);
    faces.set_twins(std::move(twins));
    faces.set_corner_angles(detail::corner_angles(mesh, rules));
    std::vector<float> sharpness(mesh.vertex_count());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) sharpness[v] = tag(mesh.sharpness(VertexId(v)));
    return RuleMesh(static_cast<int>(mesh.vertex_count()), std::move(faces), std::move(sharpness));
}

RuleMesh rule_mesh(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules) {
    for (std::uint32_t f = 0; f < mesh.face_count() && scheme.family == MeshFamily::triangles; ++f)
        if (mesh.face_size(FaceId(f)) != 3)
            throw Error(ErrorCode::invalid_input,
                        std::string(scheme.name) + " takes triangles, and " + detail::face_name(mesh.data(), f) +
                            " has " + std::to_string(mesh.face_size(FaceId(f))) +
                            " corners; triangulate the mesh first",
                        mesh.data().source);
    return rule_mesh(mesh, rules, splits_vertices(scheme, rules));
}

RuleStep (*first_rule_step(const SchemeInfo& scheme, const RuleMesh& mesh))(const RuleMesh&, const RuleOptions&) {
    return scheme.first_step != nullptr && !mesh.all_faces_have(4) ? scheme.first_step : scheme.step;
}

void detail::check_rule_memory(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, int asked,
                               const RunContext& context, std::uint64_t beside) {
    constexpr std::uint64_t most = std::uint64_t{std::numeric_limits<int>::max()} / 2;
    std::uint64_t halfedges = mesh.halfedge_count();
    for (int level = 1; level <= levels; ++level) {
        halfedges *= growth(scheme);
        if (halfedges > most)
            throw Error(ErrorCode::unsupported,
                        std::to_string(asked) +
                            " levels give more elements than the rules can count in 32-bit numbers; level " +
                            std::to_string(level) + " has up to " + std::to_string(halfedges) +
                            " face corners, and the limit is " + std::to_string(most),
                        mesh.data().source);
    }
    const std::uint64_t bytes = beside + halfedges * (mesh.has_uvs() ? k_bytes_with_charts : k_bytes_per_halfedge) +
                                static_cast<std::uint64_t>(levels) * bytes_of_large_rings(mesh, scheme);
    detail::check_memory(std::to_string(asked) + " levels, up to " + std::to_string(halfedges) + " face corners" +
                             (levels < asked ? " in the first " + std::to_string(levels) + " of them" : std::string()) +
                             ", need",
                         bytes, context.max_memory_bytes, "ask for fewer levels", mesh.data().source);
}

RuleRefiner::RuleRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options,
                         std::unique_ptr<detail::RuleLevels> first_levels)
    : control_vertices_(mesh.vertex_count()),
      options_(options),
      levels_(std::move(first_levels)),
      source_(mesh.data().source) {
    detail::check_rule_memory(mesh, scheme, levels, levels, options.context);
    if (!levels_) levels_ = std::make_unique<detail::RuleLevels>(mesh, scheme, options.rules, options.smoothing);
    std::uint64_t done = 0, all = 0;
    for (std::uint64_t i = 0, size = 1; i < static_cast<std::uint64_t>(levels); ++i) all += size *= growth(scheme);
    std::uint64_t size = 1;
    for (int level = 0; level < levels; ++level) {
        options.context.report("refine", static_cast<double>(done) / static_cast<double>(all));
        if (level >= levels_->level()) levels_->advance();
        done += size *= growth(scheme);
    }
    options.context.report("refine", 1);
    if (!options.limit && !options.normals) return;
    if (!options.limit && scheme.family == MeshFamily::hexagons) {
        // No tangents: normals are those of the faces.
        limits_.begin.assign(vertex_count() + std::size_t{1}, 0);
        return;
    }
    // The shortest rows possible: a limit and two tangents of seven terms each, or a fan of ten terms for honeycomb.
    const std::uint64_t terms = scheme.is_linear() ? 1 : scheme.family == MeshFamily::hexagons ? 10 : 3 * 7;
    check_memory("the limits of " + std::to_string(vertex_count()) + " vertices",
                 bytes_with({}) + vertex_count() * terms * k_bytes_per_term);
    try {
        std::vector<int> vertices(vertex_count());
        std::iota(vertices.begin(), vertices.end(), 0);
        detail::LimitSearch search(scheme, options.rules);
        limits_ = detail::rule_limits(search, last(), vertices, boundary_recedes(scheme, options.rules));
    } catch (const std::invalid_argument& e) {
        throw detail::NoLimit(e.what(), mesh.data().source);
    }
}

void RuleRefiner::refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals) const {
    std::vector<Vec3d> net(options_.limit ? positions.size() : 0);
    const std::span<Vec3d> points = options_.limit ? std::span(net) : positions;
    levels_->net(control, points);
    if (options_.limit) detail::apply(limits_.positions, points.data(), positions.data());
    for_each_index(static_cast<std::uint32_t>(normals.size()), [&](std::uint32_t i) {
        const int v = static_cast<int>(i);
        normals[i] = detail::limit_normal(limits_, v, last(), points, v);
    });
}

namespace {

std::uint64_t bytes_of(std::uint64_t rows, std::uint64_t terms) {
    return rows * sizeof(std::size_t) + terms * k_bytes_per_term;
}
std::uint64_t bytes_of(const StencilTable& table) { return bytes_of(table.begins().size(), table.points().size()); }

/// Terms of coarse.then(fine): of all rows, and of the first ones, from which push_rows() estimates its reserve.
struct TermCount {
    std::uint64_t all = 0, first = 0;
};
TermCount count_terms(const StencilTable& coarse, const StencilTable& fine, std::uint32_t columns) {
    TermCount count;
    std::vector<int> last_row(columns, -1);
    for (int r = 0; r < fine.row_count(); ++r) {
        for (const int middle : fine.points(r)) {
            for (const int point : coarse.points(middle)) {
                count.all += last_row[point] == r ? 0 : 1;
                last_row[point] = r;
            }
        }
        if (r == detail::k_rows_per_block) count.first = count.all;
    }
    return count;
}

StencilTable rows_of(const StencilTable& table, std::span<const char> wanted) {
    StencilTable rows;
    for (int r = 0; r < table.row_count(); ++r)
        if (wanted[static_cast<std::size_t>(r)] != 0) rows.push(table.row(r));
    return rows;
}

}  // namespace

std::uint64_t RuleRefiner::bytes_with(const StencilTable& table) const {
    return k_bytes_per_halfedge * static_cast<std::uint64_t>(last().halfedge_count()) + bytes_of(limits_.positions) +
           bytes_of(limits_.tangent1) + bytes_of(limits_.tangent2) + bytes_of(table);
}

void RuleRefiner::check_memory(const std::string& what, std::uint64_t bytes) const {
    detail::check_memory(what + ", together with the levels, need", bytes, options_.context.max_memory_bytes,
                         "ask for fewer levels", source_);
}

StencilTable RuleRefiner::composed(const StencilTable& coarse, const StencilTable& fine) const {
    if (options_.context.max_memory_bytes != 0) {
        const auto rows = static_cast<std::uint64_t>(fine.row_count());
        const TermCount terms = count_terms(coarse, fine, control_vertices_);
        // StencilTable::push_rows() reserves nine eighths of the size estimated from the first rows. A table that grows
        // beyond that holds its weights twice for a while.
        const bool grows = terms.all > terms.first * rows / detail::k_rows_per_block * 9 / 8;
        check_memory("the stencils of " + std::to_string(rows) + " vertices, " + std::to_string(terms.all) +
                         " weights of control vertices,",
                     bytes_with(coarse) + bytes_of(rows, terms.all) + (grows ? terms.all * sizeof(double) : 0));
    }
    return coarse.then(fine);
}

StencilTable RuleRefiner::stencils(std::span<const char> wanted) const {
    std::vector<const StencilTable*> tables;
    for (const StencilTable& step : levels_->steps()) tables.push_back(&step);
    if (options_.limit) tables.push_back(&limits_.positions);
    StencilTable all;
    for (int v = 0; v < static_cast<int>(control_vertices_); ++v) all.push({{v, 1}});
    const bool some = std::ranges::count(wanted, 0) != 0;
    // Rows are left out of the last table, not of the product: a copy of the product would need its memory twice.
    for (const StencilTable* table : tables)
        all = some && table == tables.back() ? composed(all, rows_of(*table, wanted)) : composed(all, *table);
    return some && tables.empty() ? rows_of(all, wanted) : all;
}

}  // namespace tetrakis
