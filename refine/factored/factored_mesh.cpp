#include "factored_mesh.hpp"

#include "factored_faces.hpp"

#include "../../hier/base/error.hpp"
#include "../uniform/refine.hpp"

#include <algorithm>
#include <string>

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
