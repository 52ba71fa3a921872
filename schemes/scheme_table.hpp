#pragma once

#include "tetrakis/schemes/closed_masks.hpp"
#include "tetrakis/schemes/rule_step.hpp"

#include <span>
#include <string>
#include <string_view>

namespace tetrakis {

/// How a scheme's refinement makes its new mesh.
enum class Refinement { face_split, vertex_split, sqrt3, bisection, honeycomb };
/// The faces of its regular mesh.
enum class MeshFamily { triangles, quads, hexagons };

/// One scheme as data. Everything that lists schemes or takes one by name reads scheme_table(); a new scheme is its
/// own file and one line there.
struct SchemeInfo {
    std::string_view name;   ///< on the command line
    std::string_view title;  ///< with authors and year
    Refinement refinement;
    MeshFamily family;
    bool interpolating;
    std::string_view smoothness;  ///< on regular meshes, away from extraordinary points
    int reproduction;             ///< degree of the polynomials that the rules reproduce on regular meshes
    std::string_view generation;  ///< degree of the polynomials that the limit surfaces contain there
    FanLattice lattice;           ///< the neighbourhood that maps to itself
    int rings;                    ///< of it that determine the surface around the middle
    RuleStep (*step)(const RuleMesh&, const RuleOptions&);
    ClosedMasks (*closed_masks)(const FanShape&, const RuleOptions&);
    std::string_view notes;  ///< what it takes, and its choices
    /// Rings around a new point in which its rule looks for extraordinary vertices, to choose one of several rows.
    int choice_rings = 0;
};

std::span<const SchemeInfo> scheme_table();
/// The scheme of that name; nullptr for an unknown one.
const SchemeInfo* find_scheme(std::string_view name);
/// The name in the table that has the text in it, or else is the fewest edits away.
std::string_view nearest_scheme_name(std::string_view name);

std::string_view name(Refinement refinement);
std::string_view name(MeshFamily family);

/// The number of edges at a regular vertex, or of corners of a regular face in a dual scheme.
int regular_valence(const SchemeInfo& scheme, bool boundary);
/// Dual or primal, and how far its rules reach: only repeated averaging depends on its options.
FanLattice fan_lattice(const SchemeInfo& scheme, const RuleOptions& options);
/// The same around one point: a dual scheme's corner is a vertex, and so is a boundary of hexagons.
FanLattice fan_lattice(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);
int fan_rings(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);
/// Averaging steps of repeated averaging and of the biquartic scheme, which is three of them; others have none.
int averaging_steps(const SchemeInfo& scheme, const RuleOptions& options);
/// Whether each step uses up the outer ring of an open mesh (AveragingBoundary).
bool boundary_recedes(const SchemeInfo& scheme, const RuleOptions& options);
/// Whether tags inside a mesh have no effect: longer averages, unless they have Catmull-Clark's rules.
bool ignores_creases(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis
