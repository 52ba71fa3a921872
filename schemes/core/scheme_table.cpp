#include "scheme_table.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

namespace tetrakis {

std::string_view name(SchemeKind kind) { return kind == SchemeKind::loop ? "loop" : "catmull-clark"; }

std::optional<SchemeKind> scheme_from_name(std::string_view text) {
    for (SchemeKind kind : {SchemeKind::catmull_clark, SchemeKind::loop})
        if (name(kind) == text) return kind;
    return std::nullopt;
}

namespace detail {

#define TETRAKIS_SCHEME(scheme) extern const SchemeInfo scheme##_scheme;
#include "scheme_list.inc"
#undef TETRAKIS_SCHEME

}  // namespace detail

namespace {

using enum Refinement;
using enum MeshFamily;

#define TETRAKIS_SCHEME(scheme) &detail::scheme##_scheme,
constexpr const SchemeInfo* k_table[] = {
#include "scheme_list.inc"
};
#undef TETRAKIS_SCHEME

/// Numbers of edits from a text to each start of a name, from the empty start to the whole name.
std::vector<int> edits(std::string_view text, std::string_view name) {
    std::vector<int> row(name.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (std::size_t i = 1; i <= text.size(); ++i) {
        int diagonal = row[0];
        row[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= name.size(); ++j) {
            const int replaced = diagonal + (text[i - 1] == name[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row;
}

}  // namespace

std::span<const SchemeInfo* const> detail::scheme_list() { return k_table; }

const SchemeInfo* find_scheme(std::string_view name) {
    for (const SchemeInfo& scheme : scheme_table())
        if (scheme.name == name) return &scheme;
    return nullptr;
}

std::string_view nearest_scheme_name(std::string_view text) {
    // A part of a name stands for that name, and so does its start with a mistake or two.
    constexpr std::size_t k_telling = 3;
    const auto distance = [&](const SchemeInfo* scheme) {
        const bool part = text.size() >= k_telling && scheme->name.find(text) != std::string_view::npos;
        const std::vector<int> row = edits(text, scheme->name);
        return std::tuple(part ? 0 : 1, std::min(*std::ranges::min_element(row) + 1, row.back()), row.back());
    };
    return (*std::ranges::min_element(detail::scheme_list(), {}, distance))->name;
}

std::string_view name(Refinement refinement) {
    switch (refinement) {
        case face_split:
            return "face split";
        case vertex_split:
            return "vertex split";
        case Refinement::sqrt3:
            return "sqrt3";
        case bisection:
            return "bisection";
        case honeycomb:
            break;
    }
    return "honeycomb";
}

std::string_view name(MeshFamily family) {
    return family == triangles ? "triangle" : family == quads ? "quad" : "hexagon";
}

int regular_valence(const SchemeInfo& scheme, bool boundary) {
    switch (scheme.family) {
        case triangles:
            return boundary ? 4 : 6;
        case quads:
            return boundary ? 3 : 4;
        case hexagons:
            break;
    }
    return 6;
}

FanLattice fan_lattice(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.has_chosen_steps() && options.averaging_steps % 2 == 0) return FanLattice::quads;
    return scheme.lattice;
}

bool splits_vertices(const SchemeInfo& scheme, const RuleOptions& options) {
    return fan_lattice(scheme, options) == FanLattice::dual && scheme.refinement == Refinement::vertex_split;
}

int averaging_steps(const SchemeInfo& scheme, const RuleOptions& options) {
    return scheme.has_chosen_steps() ? options.averaging_steps : scheme.averaging_steps;
}

int rule_rings(const SchemeInfo& scheme, const RuleOptions& options) {
    return scheme.rule_rings + (scheme.has_chosen_steps() ? options.averaging_steps / 2 : 0);
}

bool boundary_recedes(const SchemeInfo& scheme, const RuleOptions& options) {
    return averaging_steps(scheme, options) > 0 && options.averaging_boundary == AveragingBoundary::recede;
}

bool ignores_creases(const SchemeInfo& scheme, const RuleOptions& options) {
    const int steps = averaging_steps(scheme, options);
    return steps != 0 && (steps != 2 || boundary_recedes(scheme, options));
}

FanLattice fan_lattice(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options) {
    const FanLattice lattice = fan_lattice(scheme, options);
    if (scheme.family == hexagons && shape.boundary) return FanLattice::pentagons;
    return lattice == FanLattice::dual && shape.corner ? FanLattice::quads : lattice;
}

int fan_rings(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options) {
    if (fan_lattice(scheme, shape, options) == FanLattice::pentagons) return 1;
    const int m = options.averaging_steps;
    const int rings = !scheme.has_chosen_steps() ? scheme.rings : m % 2 == 1 ? (m + 1) / 2 : m / 2 + 1;
    // Beside a boundary edge of a dual scheme a ring is two rows deep.
    return fan_lattice(scheme, shape, options) == FanLattice::dual && shape.boundary ? rings - 1 : rings;
}

}  // namespace tetrakis
