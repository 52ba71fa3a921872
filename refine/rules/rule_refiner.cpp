#include "rule_refiner.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/mesh_check.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "corner_angles.hpp"
#include "rule_levels.hpp"
#include "rule_limit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

using detail::check_length;

namespace {

/// Half-edges of the next level per half-edge, at most.
std::uint64_t growth(const SchemeInfo& scheme) { return scheme.refinement == Refinement::sqrt3 ? 9 : 4; }

// Per half-edge of a level: connectivity, with what is needed to build it, and the stencils of its points (measured for
// Loop and Catmull-Clark; the long rules of Butterfly, Kobbelt and many averaging steps take up to twice as much).
// With texture coordinates, charts have levels of their own.
constexpr std::uint64_t k_bytes_per_halfedge = 160, k_bytes_with_charts = 240;
constexpr std::uint64_t k_bytes_per_term = sizeof(int) + sizeof(double);

/// Bytes of the terms of those rows where rings are large, for each level.
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

struct RuleRefiner::State {
    std::uint32_t control_vertices;
    RefineOptions options;
    std::unique_ptr<detail::RuleLevels> levels;
    std::string source;
    detail::RuleLimits limits{};

    /// coarse.then(fine), where it finds room.
    StencilTable composed(const StencilTable& coarse, const StencilTable& fine) const;
    /// What levels and limits take, with a table of stencils from the control vertices.
    std::uint64_t bytes_with(const StencilTable& table) const;
    void check_memory(const std::string& what, std::uint64_t bytes) const;

    /// @param points  of the last level, no limits
    void write_normals(const Vec3d* points, std::span<Vec3d> normals) const;
};

void detail::check_length(const char* what, std::size_t length, std::size_t expected) {
    if (length != expected)
        throw Error(ErrorCode::invalid_input, "there are " + std::to_string(length) + " " + what + ", but " +
                                                  std::to_string(expected) + " are needed");
}

void detail::check_rounds(int levels, const RefineOptions& options) {
    if (levels < 0)
        throw Error(ErrorCode::invalid_input, "the number of levels must not be negative; 0 is the control mesh");
    if (options.smoothing < 0)
        throw Error(ErrorCode::invalid_input, "the number of smoothing rounds must not be negative");
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

RuleRefiner::RuleRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options)
    : RuleRefiner(mesh, scheme, levels, options, nullptr) {}

RuleRefiner::RuleRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options,
                         std::unique_ptr<detail::RuleLevels> first_levels) {
    detail::check_rounds(levels, options);
    detail::check_rule_memory(mesh, scheme, levels, levels, options.context);
    if (!first_levels)
        first_levels = std::make_unique<detail::RuleLevels>(mesh, scheme, options.rules, options.smoothing);
    state_ = std::make_unique<State>(State{mesh.vertex_count(), options, std::move(first_levels), mesh.data().source});
    State& s = *state_;
    std::uint64_t done = 0, all = 0;
    for (std::uint64_t i = 0, size = 1; i < static_cast<std::uint64_t>(levels); ++i) all += size *= growth(scheme);
    std::uint64_t size = 1;
    for (int level = 0; level < levels; ++level) {
        options.context.report("refine", static_cast<double>(done) / static_cast<double>(all));
        if (level >= s.levels->level()) s.levels->advance();
        done += size *= growth(scheme);
    }
    options.context.report("refine", 1);
    if (!options.limit && !options.normals) return;
    if (!options.limit && scheme.family == MeshFamily::hexagons) {
        // No tangents: normals are those of the faces.
        s.limits.begin.assign(vertex_count() + std::size_t{1}, 0);
        return;
    }
    // The shortest rows that there are: limits and two tangents of seven terms, or of a fan of honeycomb's ten.
    const std::uint64_t terms = scheme.is_linear() ? 1 : scheme.family == MeshFamily::hexagons ? 10 : 3 * 7;
    s.check_memory("the limits of " + std::to_string(vertex_count()) + " vertices",
                   s.bytes_with({}) + vertex_count() * terms * k_bytes_per_term);
    try {
        s.limits = detail::rule_limits(s.levels->last(), scheme, options.rules);
    } catch (const std::invalid_argument& e) {
        throw detail::NoLimit(e.what(), mesh.data().source);
    }
}

RuleRefiner::~RuleRefiner() = default;
RuleRefiner::RuleRefiner(RuleRefiner&&) noexcept = default;
RuleRefiner& RuleRefiner::operator=(RuleRefiner&&) noexcept = default;

std::uint32_t RuleRefiner::vertex_count() const {
    return static_cast<std::uint32_t>(state_->levels->last().vertex_count());
}
std::uint32_t RuleRefiner::face_count() const {
    return static_cast<std::uint32_t>(state_->levels->last().face_count());
}
const RuleMesh& RuleRefiner::last() const { return state_->levels->last(); }

std::span<const int> RuleRefiner::vertices_beyond() const { return state_->limits.missing; }

std::uint32_t RuleRefiner::control_face(std::uint32_t face) const {
    return static_cast<std::uint32_t>(state_->levels->control_face(static_cast<int>(face)));
}

void RuleRefiner::refine(std::span<const double> control, int width, std::span<double> out) const {
    if (width < 1) throw Error(ErrorCode::invalid_input, "an attribute has at least one number per vertex");
    const std::size_t w = static_cast<std::size_t>(width);
    check_length("control values", control.size(), state_->control_vertices * w);
    check_length("values to write", out.size(), vertex_count() * w);
    with_threads(state_->options.context, [&] {
        const detail::RuleLevels& levels = *state_->levels;
        if (state_->options.limit)
            detail::apply(state_->limits.positions, levels.net(control, width).data(), width, out.data());
        else
            levels.net(control, width, out);
    });
}

namespace {

// Points are three numbers side by side.
static_assert(sizeof(Vec3d) == 3 * sizeof(double));

template <class Point>
auto numbers_of(std::span<Point> points) {
    return std::span(&points.data()->x, 3 * points.size());
}

}  // namespace

void RuleRefiner::refine(std::span<const Vec3d> control, std::span<Vec3d> positions, std::span<Vec3d> normals) const {
    const State& s = *state_;
    check_length("control positions", control.size(), s.control_vertices);
    check_length("positions to write", positions.size(), vertex_count());
    if (!normals.empty()) {
        if (!s.options.normals) throw Error(ErrorCode::invalid_input, "the options did not ask for normals");
        check_length("normals to write", normals.size(), vertex_count());
    }
    if (positions.empty()) return;
    with_threads(s.options.context, [&] {
        if (!s.options.limit) {
            s.levels->net(numbers_of(control), 3, numbers_of(positions));
            return s.write_normals(positions.data(), normals);
        }
        const std::vector<double> net = s.levels->net(numbers_of(control), 3);
        detail::apply(s.limits.positions, net.data(), 3, numbers_of(positions).data());
        s.write_normals(reinterpret_cast<const Vec3d*>(net.data()), normals);
    });
}

void RuleRefiner::State::write_normals(const Vec3d* points, std::span<Vec3d> normals) const {
    const std::span net(points, normals.size());
    for_each_index(static_cast<std::uint32_t>(normals.size()), [&](std::uint32_t i) {
        const int v = static_cast<int>(i);
        normals[i] = detail::limit_normal(limits, v, levels->last(), net, v);
    });
}

namespace {

std::uint64_t bytes_of(std::uint64_t rows, std::uint64_t terms) {
    return rows * sizeof(std::size_t) + terms * k_bytes_per_term;
}
std::uint64_t bytes_of(const StencilTable& table) { return bytes_of(table.begins().size(), table.points().size()); }

/// Terms of coarse.then(fine), and of its first rows: from these it guesses how much to reserve.
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

std::uint64_t RuleRefiner::State::bytes_with(const StencilTable& table) const {
    return k_bytes_per_halfedge * static_cast<std::uint64_t>(levels->last().halfedge_count()) +
           bytes_of(limits.positions) + bytes_of(limits.tangent1) + bytes_of(limits.tangent2) + bytes_of(table);
}

void RuleRefiner::State::check_memory(const std::string& what, std::uint64_t bytes) const {
    detail::check_memory(what + ", together with the levels, need", bytes, options.context.max_memory_bytes,
                         "ask for fewer levels", source);
}

StencilTable RuleRefiner::State::composed(const StencilTable& coarse, const StencilTable& fine) const {
    if (options.context.max_memory_bytes != 0) {
        const auto rows = static_cast<std::uint64_t>(fine.row_count());
        const TermCount terms = count_terms(coarse, fine, control_vertices);
        // StencilTable::push_rows() reserves nine eighths of what the first rows say; a table that outgrows that has
        // its weights twice for a while.
        const bool grows = terms.all > terms.first * rows / detail::k_rows_per_block * 9 / 8;
        check_memory("the stencils of " + std::to_string(rows) + " vertices, " + std::to_string(terms.all) +
                         " weights of control vertices,",
                     bytes_with(coarse) + bytes_of(rows, terms.all) + (grows ? terms.all * sizeof(double) : 0));
    }
    return coarse.then(fine);
}

StencilTable RuleRefiner::stencils(std::span<const char> wanted) const {
    const State& s = *state_;
    if (!wanted.empty()) check_length("vertices wanted or not", wanted.size(), vertex_count());
    std::vector<const StencilTable*> tables;
    for (const StencilTable& step : s.levels->steps()) tables.push_back(&step);
    if (s.options.limit) tables.push_back(&s.limits.positions);
    StencilTable all;
    for (int v = 0; v < static_cast<int>(s.control_vertices); ++v) all.push({{v, 1}});
    const bool some = std::ranges::count(wanted, 0) != 0;
    // Rows are left out of the last table, not of the product, which would be there twice then.
    for (const StencilTable* table : tables)
        all = some && table == tables.back() ? s.composed(all, rows_of(*table, wanted)) : s.composed(all, *table);
    return some && tables.empty() ? rows_of(all, wanted) : all;
}

}  // namespace tetrakis
