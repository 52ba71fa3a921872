#include "factored_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../attributes/used_values.hpp"
#include "../rules/rule_refiner.hpp"
#include "../uniform/refine.hpp"
#include "factored_faces.hpp"

#include <algorithm>
#include <limits>
#include <string>

namespace tetrakis::detail {

FactoredFaces::FactoredFaces(const ControlMesh& control) {
    check_halfedge_count(control.halfedge_count(), 1, k_next);
    mesh_ = rule_mesh(control);
    positions_.assign(control.positions().begin(), control.positions().end());
    vertex_.resize(mesh_.vertex_count());
    for (std::size_t v = 0; v < vertex_.size(); ++v) vertex_[v] = static_cast<std::uint32_t>(v);
}

void FactoredFaces::put_centres() {
    centre_.resize(mesh_.face_count());
    for (std::uint32_t& c : centre_) c = add({});
    rest_centres();
}

std::vector<std::uint32_t> FactoredFaces::places() const {
    std::vector<std::uint32_t> result = vertex_;
    result.reserve(vertex_.size() + midpoint_.size() + centre_.size());
    result.insert(result.end(), midpoint_.begin(), midpoint_.end());
    result.insert(result.end(), centre_.begin(), centre_.end());
    return result;
}

void FactoredFaces::check_room(std::uint64_t halfedges, int done, std::string_view which) const {
    const Room needed = room(done);
    check_halfedge_count(halfedges, needed.growth, which);
    check_memory(std::string(which) + " needs", needed.bytes * halfedges, max_memory_bytes_,
                 "ask for fewer half-steps or allow more");
}

void FactoredFaces::check_half_steps(int count) const {
    std::uint64_t at = halfedges();
    int done = done_;
    for (int i = 0; i < count; ++i, ++done) {
        const std::string which = "half-step " + std::to_string(i + 1) + " of " + std::to_string(count);
        if (done == half_steps_per_level()) {
            at *= k_growth;
            done = 0;
        }
        check_room(at, done, which);
    }
}

void FactoredFaces::check_halfedge_count(std::uint64_t halfedges, std::uint64_t growth, std::string_view which) {
    constexpr std::uint64_t k_most = std::numeric_limits<int>::max();  // RuleMesh counts with int
    if (halfedges <= k_most / growth) return;
    throw Error(ErrorCode::unsupported,
                "so many half-steps have more elements than 31 bits can count: " + std::string(which) +
                    " needs up to " + std::to_string(halfedges * growth) + " face corners; ask for fewer half-steps");
}

std::vector<std::array<std::uint32_t, 3>> FactoredFaces::triangles() const {
    std::vector<std::array<std::uint32_t, 3>> result;
    result.reserve(halfedges() * (midpoint_.empty() ? 1 : 2));
    for (int h = 0; h < mesh_.halfedge_count(); ++h) {
        const std::uint32_t u = vertex_[mesh_.origin(h)], w = vertex_[mesh_.target(h)];
        const std::uint32_t c = centre_[mesh_.face(h)];
        const int t = mesh_.twin(h);
        if (!midpoint_.empty()) {
            const std::uint32_t s = midpoint_[mesh_.edge(h)];
            result.push_back({u, s, c});
            result.push_back({s, w, c});
        } else if (whole_ || t == RuleMesh::none || mesh_.sharp(h)) {
            result.push_back({u, w, c});
        } else {
            // The block across the edge still has its diagonal from centre to centre.
            result.push_back({u, centre_[mesh_.face(t)], c});
        }
    }
    return result;
}

PolygonMesh FactoredFaces::polygons(const RuleMesh& faces, std::span<const std::uint32_t> vertex,
                                    std::vector<std::uint32_t>* numbers) const {
    PolygonMesh result;
    result.positions = positions_;
    result.face_offsets.push_back(0);
    for (int f = 0; f < faces.face_count(); ++f) {
        if (!take(result, f)) continue;
        for (const int v : faces.corners(f)) result.face_vertices.push_back(vertex[v]);
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
    }
    std::vector<std::uint32_t> used = drop_unused_vertices(result);
    if (numbers != nullptr) *numbers = std::move(used);
    return result;
}

PolygonMesh FactoredFaces::polygons(std::span<const std::array<std::uint32_t, 3>> triangles,
                                    std::vector<std::uint32_t>* numbers) const {
    PolygonMesh result;
    result.positions = positions_;
    result.face_offsets.push_back(0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (!take(result, face_of_triangle(t))) continue;
        result.face_vertices.insert(result.face_vertices.end(), triangles[t].begin(), triangles[t].end());
        result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
    }
    std::vector<std::uint32_t> used = drop_unused_vertices(result);
    if (numbers != nullptr) *numbers = std::move(used);
    return result;
}

PolygonMesh FactoredFaces::mesh(std::vector<std::uint32_t>* numbers) const { return polygons(triangles(), numbers); }
PolygonMesh FactoredFaces::active_mesh() const { return polygons(mesh_, vertex_); }

void FactoredFaces::insert_midpoints() {
    positions_.reserve(positions_.size() + static_cast<std::size_t>(mesh_.edge_count()));
    midpoint_.resize(mesh_.edge_count());
    for (int e = 0; e < mesh_.edge_count(); ++e) {
        const int h = mesh_.edge_halfedge(e);
        midpoint_[e] = add(0.5 * (positions_[vertex_[mesh_.origin(h)]] + positions_[vertex_[mesh_.target(h)]]));
    }
}

Vec3d FactoredFaces::mean_of_corners(int face) const {
    Vec3d sum(0);
    for (const int v : mesh_.corners(face)) sum += positions_[vertex_[v]];
    return sum / static_cast<double>(mesh_.face_size(face));
}

void FactoredFaces::rest_centres() {
    for_each_index(static_cast<std::uint32_t>(centre_.size()),
                   [&](std::uint32_t f) { positions_[centre_[f]] = mean_of_corners(static_cast<int>(f)); });
}

void FactoredFaces::take_split(const HalfSharpness& halves) {
    vertex_ = places();
    mesh_ = split_polygons(mesh_, halves);
    midpoint_.clear();
    centre_.clear();
    done_ = 0;
}

void FactoredFaces::set_states(bool active_centres) {
    state_.assign(positions_.size(), FactoredVertex::unused);
    for (int v = 0; v < mesh_.vertex_count(); ++v)
        if (mesh_.first(v) != RuleMesh::none) state_[vertex_[v]] = FactoredVertex::active;
    for (const std::uint32_t c : centre_)
        state_[c] = active_centres ? FactoredVertex::active : FactoredVertex::inactive;
    for (const std::uint32_t s : midpoint_) state_[s] = FactoredVertex::active;
}

}  // namespace tetrakis::detail

namespace tetrakis {

namespace {

enum class Family { primal, dual, averaging };
struct Named {
    FactoredScheme scheme;
    std::string_view name;
    Family family;
};
constexpr Named k_schemes[] = {
    {FactoredScheme::catmull_clark, "catmull-clark", Family::primal},
    {FactoredScheme::four_eight, "4-8", Family::primal},
    {FactoredScheme::doo_sabin, "doo-sabin", Family::dual},
    {FactoredScheme::doo_sabin_catmull_clark, "doo-sabin-cc", Family::dual},
    {FactoredScheme::midedge, "midedge", Family::dual},
    {FactoredScheme::midedge_simplest, "midedge-simplest", Family::dual},
    {FactoredScheme::averaging, "averaging", Family::averaging},
    {FactoredScheme::biquartic, "biquartic", Family::averaging},
};

constexpr auto k_list = [] {
    std::array<FactoredScheme, std::size(k_schemes)> list{};
    std::ranges::transform(k_schemes, list.begin(), &Named::scheme);
    return list;
}();

const Named& row(FactoredScheme scheme) {
    for (const Named& n : k_schemes)
        if (n.scheme == scheme) return n;
    return k_schemes[0];
}

constexpr int k_biquartic_steps = 3;

std::unique_ptr<detail::FactoredFaces> make_steps(const ControlMesh& mesh, FactoredScheme scheme, RuleOptions rules) {
    switch (row(scheme).family) {
        case Family::dual:
            return detail::make_factored_dual(mesh, scheme);
        case Family::averaging:
            if (scheme == FactoredScheme::biquartic) rules.averaging_steps = k_biquartic_steps;
            return detail::make_factored_averaging(mesh, rules);
        default:
            return detail::make_factored_primal(mesh, scheme);
    }
}

}  // namespace

std::span<const FactoredScheme> factored_schemes() { return k_list; }
std::string_view name(FactoredScheme scheme) { return row(scheme).name; }
bool half_steps_adapt(FactoredScheme scheme) {
    return row(scheme).family == Family::dual || scheme == FactoredScheme::catmull_clark;
}
std::optional<FactoredScheme> factored_scheme_from_name(std::string_view name) {
    for (const Named& n : k_schemes)
        if (n.name == name) return n.scheme;
    return std::nullopt;
}

struct FactoredMesh::State {
    std::unique_ptr<detail::FactoredFaces> steps;
    std::optional<std::string> warning{};
    int half_steps = 0;
    PolygonMesh warned(PolygonMesh mesh) const {
        if (warning) mesh.warnings.push_back(*warning);
        return mesh;
    }
};

FactoredMesh::FactoredMesh(const ControlMesh& mesh, FactoredScheme scheme, std::uint64_t max_memory_bytes,
                           const RuleOptions& rules)
    : state_(std::make_unique<State>()) {
    state_->steps = make_steps(mesh, scheme, rules);
    state_->steps->limit_memory(max_memory_bytes);
    state_->warning = detail::ignored_creases(mesh, *find_scheme(name(scheme)), rules);
    if (mesh.has_corner_angles())
        state_->warning = (state_->warning ? *state_->warning + "; " : "") +
                          "the corner angles were ignored: half-steps have no rule for them";
}
FactoredMesh::~FactoredMesh() = default;
FactoredMesh::FactoredMesh(FactoredMesh&&) noexcept = default;
FactoredMesh& FactoredMesh::operator=(FactoredMesh&&) noexcept = default;

void FactoredMesh::half_step() {
    state_->steps->half_step();
    ++state_->half_steps;
}
void FactoredMesh::check_half_steps(int count) const { state_->steps->check_half_steps(count); }
int FactoredMesh::half_steps() const { return state_->half_steps; }
int FactoredMesh::half_steps_per_level() const { return state_->steps->half_steps_per_level(); }
std::span<const Vec3d> FactoredMesh::positions() const { return state_->steps->positions(); }
FactoredVertex FactoredMesh::state(std::uint32_t vertex) const {
    if (vertex >= positions().size())
        throw Error(ErrorCode::invalid_input, "vertex " + std::to_string(vertex) + " is none of the " +
                                                  std::to_string(positions().size()) + " vertices");
    return state_->steps->state(vertex);
}
std::vector<std::array<std::uint32_t, 3>> FactoredMesh::triangles() const { return state_->steps->triangles(); }
PolygonMesh FactoredMesh::mesh(std::vector<std::uint32_t>* numbers) const {
    return state_->warned(state_->steps->mesh(numbers));
}
PolygonMesh FactoredMesh::active_mesh() const { return state_->warned(state_->steps->active_mesh()); }

}  // namespace tetrakis
