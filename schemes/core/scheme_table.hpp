#pragma once

#include "fan_labels.hpp"
#include "rule_options.hpp"

#include <optional>
#include <ranges>
#include <span>
#include <string_view>

namespace tetrakis {

class RuleMesh;
struct RuleStep;
struct ClosedMasks;

/// The schemes whose limit surfaces consist of polynomial patches that can be evaluated anywhere.
enum class SchemeKind { catmull_clark, loop };

/// The scheme's name on the command line and in reports: "catmull-clark", "loop".
std::string_view name(SchemeKind kind);
/// The scheme of that name; empty for an unknown one.
std::optional<SchemeKind> scheme_from_name(std::string_view name);

/// How a scheme's refinement makes its new mesh.
enum class Refinement { face_split, vertex_split, sqrt3, bisection, honeycomb };
/// The faces of its regular mesh.
enum class MeshFamily { triangles, quads, hexagons };

/// The polynomial pieces that limit surfaces are evaluated and bounded by; `none` where the library uses none.
enum class SurfacePieces {
    none,
    linear,         ///< the faces of the control mesh themselves: flat, or bilinear
    bicubic,        ///< tensor product B-splines
    quartic_box,    ///< Loop's box spline
    biquadratic,    ///< tensor product B-splines of dual schemes
    quadratic_box,  ///< midedge's four-direction box spline
};

/// One scheme as data, in the file of its rules: `detail::<name>_scheme`, which is a constant from the start of the
/// program. One line in scheme_list.inc adds it to all lists of schemes and to the search by name.
struct SchemeInfo {
    std::string_view name;   ///< on the command line
    std::string_view title;  ///< with authors and year
    Refinement refinement;
    MeshFamily family;
    bool interpolating = false;
    std::string_view smoothness;  ///< on regular meshes, away from extraordinary points
    int reproduction = 1;         ///< degree of the polynomials that the rules reproduce on regular meshes
    std::string_view generation;  ///< degree of the polynomials that the limit surfaces contain there
    FanLattice lattice;           ///< the neighbourhood that maps to itself
    int rings;                    ///< number of its rings that determine the surface around the middle
    /// Rings of faces around a face, or around its corner, that the rules of its new points use. rule_rings() adds half
    /// the chosen averaging steps.
    int rule_rings = 1;
    /// Whether on every level the rules of all new points around a vertex use its whole ring, or those in a face the
    /// whole face. The number of their terms then grows with the square of the valence.
    bool sees_rings = false;
    RuleStep (*step)(const RuleMesh&, const RuleOptions&);
    ClosedMasks (*closed_masks)(const FanShape&, const RuleOptions&);
    std::string_view notes;  ///< its restrictions and options
    /// Rings around a new point in which its rule looks for extraordinary vertices, to choose one of several rows.
    int choice_rings = 0;
    /// Averaging steps in one step of the scheme; k_chosen_steps: as many as RuleOptions::averaging_steps says.
    int averaging_steps = 0;
    static constexpr int k_chosen_steps = -1;
    SurfacePieces pieces = SurfacePieces::none;
    /// Whether the limit of a vertex, by the plain rules, is a combination of its one-ring for any sharpness there.
    bool one_ring_limits = false;
    /// Whether its rules at corners depend on the angle of the sector (RuleMesh::corner_angle()).
    bool takes_corner_angles = false;
    /// The first step on a mesh with faces that are no quads, if it differs from `step`.
    RuleStep (*first_step)(const RuleMesh&, const RuleOptions&) = nullptr;

    bool is_linear() const { return pieces == SurfacePieces::linear; }
    /// Whether RuleOptions::averaging_steps sets its number of averaging steps.
    bool has_chosen_steps() const { return averaging_steps == k_chosen_steps; }
};

namespace detail {
std::span<const SchemeInfo* const> scheme_list();
}

/// All schemes, as a range of `const SchemeInfo&` in the order of scheme_list.inc; usable before main().
inline auto scheme_table() {
    return detail::scheme_list() |
           std::views::transform([](const SchemeInfo* scheme) -> const SchemeInfo& { return *scheme; });
}
/// The scheme of that name; nullptr for an unknown one.
const SchemeInfo* find_scheme(std::string_view name);
/// The scheme's name that contains the text; else the name that has, or whose start has, the fewest edits to it.
std::string_view nearest_scheme_name(std::string_view name);

std::string_view name(Refinement refinement);
std::string_view name(MeshFamily family);

/// The number of edges at a regular vertex, or of corners of a regular face in a dual scheme.
int regular_valence(const SchemeInfo& scheme, bool boundary);
/// The lattice of the scheme's regular mesh. It depends on the options for repeated averaging only.
FanLattice fan_lattice(const SchemeInfo& scheme, const RuleOptions& options);
/// The same around one point: at a dual scheme's corner, and at a boundary of hexagons, the middle is a vertex.
FanLattice fan_lattice(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);
int fan_rings(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);
/// Whether a step makes new faces of faces, edges and vertices; semi-sharp tags then never lose sharpness.
bool splits_vertices(const SchemeInfo& scheme, const RuleOptions& options);
/// Averaging steps of repeated averaging and of the biquartic scheme, which has three; 0 for other schemes.
int averaging_steps(const SchemeInfo& scheme, const RuleOptions& options);
/// SchemeInfo::rule_rings with the chosen averaging steps.
int rule_rings(const SchemeInfo& scheme, const RuleOptions& options);
/// Whether each step makes a mesh with a boundary smaller (AveragingBoundary::recede).
bool boundary_recedes(const SchemeInfo& scheme, const RuleOptions& options);
/// Whether tags inside a mesh have no effect: for averaging steps other than 0 and 2, and where the boundary recedes.
bool ignores_creases(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis
