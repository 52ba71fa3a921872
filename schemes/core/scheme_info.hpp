#pragma once

#include "closed_masks.hpp"
#include "rule_step.hpp"

#include <string_view>

namespace tetrakis {

/// How a scheme's refinement makes its new mesh.
enum class Refinement { face_split, vertex_split, sqrt3, bisection, honeycomb };
/// The faces of its regular mesh.
enum class MeshFamily { triangles, quads, hexagons };

/// One scheme as data, in the file of its rules: `detail::<name>_scheme`, which is a constant from the start of the
/// program. One line in scheme_list.inc makes it known to all that lists schemes or takes one by name.
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
    /// Rings of faces around a face, or around the corner of a face, that the rules of its new points look at; half the
    /// chosen averaging steps come to them.
    int rule_rings;
    /// Whether the rules of all new points around a vertex look at its whole ring, or those in a face at all of that,
    /// on every level: then they are as many terms as there are edges, squared.
    bool sees_rings;
    RuleStep (*step)(const RuleMesh&, const RuleOptions&);
    ClosedMasks (*closed_masks)(const FanShape&, const RuleOptions&);
    std::string_view notes;  ///< what it takes, and its choices
    /// Rings around a new point in which its rule looks for extraordinary vertices, to choose one of several rows.
    int choice_rings = 0;
    /// Steps of repeated averaging that it is made of; k_chosen_steps: as many as RuleOptions::averaging_steps says.
    int averaging_steps = 0;
    static constexpr int k_chosen_steps = -1;
};

}  // namespace tetrakis
