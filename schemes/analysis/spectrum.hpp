#pragma once

#include "../core/scheme_table.hpp"
#include "../core/stencil_table.hpp"

#include <complex>
#include <string_view>
#include <vector>

namespace tetrakis {

/// Limit behaviour of the curvature at an extraordinary point. It is bounded if the third eigenvalue is the square of
/// the subdominant one, goes to zero (a flat spot) if it is smaller, and grows without bound if it is larger.
enum class CurvatureClass { bounded, zero, unbounded };
std::string_view name(CurvatureClass curvature);

/// A scheme's local subdivision matrix, computed by its rules. Each row is a point of a fan's inner rings one level
/// down, as a combination of the points of the same rings. Rows and columns are in the order of the labels.
struct LocalMatrix {
    FanLabels labels;
    StencilTable rows;  ///< without zeros

    int size() const { return labels.size(); }
    /// Whether the fan is rotation-symmetric.
    bool turns() const { return !labels.shape().boundary && !labels.shape().dart; }
    /// Row i; its points are columns, in increasing order.
    StencilRow row(int i) const { return rows.row(i); }
    double at(int row, int column) const;
    /// The number of weights that are not zero.
    std::size_t weight_count() const { return rows.points().size(); }
};
/// @throws std::invalid_argument  the scheme has no such shape: fewer than 2 faces (interior) or 1 (boundary) at a
///                                vertex, fewer than 3 corners of a face, no corners or darts, a receding boundary
LocalMatrix local_matrix(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);

struct Eigenvalue {
    std::complex<double> value;
    /// Interior: the Fourier mode, 0 <= frequency <= valence / 2. Boundary and dart: 0 for even modes, 1 for odd ones.
    int frequency;
    int multiplicity;  ///< of this mode: 2 if it has a sine and a cosine
};

struct SpectralAnalysis {
    LocalMatrix matrix;
    std::vector<Eigenvalue> eigenvalues{};  ///< by decreasing magnitude
    /// The two tangents' eigenvalues. Interior: both are the largest of Fourier mode 1; at valence 2, which has no sine
    /// mode, they belong to the directions along the two edges and across them. Boundary: along it, then across.
    double lambda1 = 0, lambda2 = 0;
    double third = 0;  ///< the largest magnitude of the other eigenvalues, without 1
    /// 1 is simple, the tangents' eigenvalues are real and positive, and all others are smaller. Modes that vary along
    /// a boundary alone do not tilt the tangent plane; they need only be smaller than lambda1. Always false at a
    /// boundary of hexagons, where the matrix has only two of the faces.
    bool proper = false;
    CurvatureClass curvature{};  ///< interior only; compares `third` with lambda1 lambda2
    /// Left eigenvectors, in the order of the labels. `limit` sums to one. Tangents sum to zero, with a largest weight
    /// of magnitude one; a tangent is empty if its eigenvalue is not simple within its symmetry class. The one across a
    /// dual scheme's boundary annihilates modes that vary along it alone, which do not count in that class.
    std::vector<double> limit{}, tangent1{}, tangent2{};
};

/// Eigenvalues and left eigenvectors of the local matrix. Interior fans have one block per Fourier mode, which is small
/// at any valence. Other fans are split into even and odd parts, and these into the strongly connected components of
/// their dependency graph. At a boundary a component may be as large as a ring: O(valence^3).
/// @throws std::invalid_argument  as local_matrix()
SpectralAnalysis analyse(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);

/// Masks to use: the scheme's formula where it has one, else the eigenvector of the analysis.
struct SchemeMasks {
    std::vector<double> limit, tangent1, tangent2;  ///< in the order of `analysis.matrix.labels`
    bool limit_is_formula = false, tangent1_is_formula = false, tangent2_is_formula = false;
};
SchemeMasks scheme_masks(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& options);

/// Degree of the polynomials that one step reproduces on the regular mesh, by trial up to 6 (hexagons: as listed).
int reproduction_degree(const SchemeInfo& scheme, const RuleOptions& options);
/// Radius of a basis function on the regular mesh, in rings (dual: in faces to each side, so 1.5 is 3 by 3; hexagons:
/// in rings of faces). It is computed from the distance over which one step spreads a single point.
double support_radius(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis
