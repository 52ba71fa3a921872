#pragma once

#include "../core/scheme_table.hpp"
#include "../core/stencil_table.hpp"

#include <complex>
#include <string_view>
#include <vector>

namespace tetrakis {

/// What happens to the curvature at an extraordinary point: it is bounded where the third eigenvalue is the square of
/// the subdominant one, goes to zero (a flat spot) where it is smaller, and grows without bound where it is larger.
enum class CurvatureClass { bounded, zero, unbounded };
std::string_view name(CurvatureClass curvature);

/// A scheme's local subdivision matrix, from its own rules: the inner rings of a fan one level down, as combinations of
/// the same rings. Rows and columns are in the order of the labels.
struct LocalMatrix {
    FanLabels labels;
    StencilTable rows;  ///< without zeros

    int size() const { return labels.size(); }
    /// Whether the fan turns into itself.
    bool turns() const { return !labels.shape().boundary && !labels.shape().dart; }
    /// A row, whose points are columns in increasing order.
    StencilRow row(int i) const { return rows.row(i); }
    double at(int row, int column) const;
    /// The number of weights that are not zero.
    std::size_t weight_count() const { return rows.points().size(); }
};
/// @throws std::invalid_argument  the shape is not one of the scheme: fewer than 2 faces (interior) or 1 (boundary)
///                                at a vertex, fewer than 3 corners of a face, a corner or dart where it has none
LocalMatrix local_matrix(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);

struct Eigenvalue {
    std::complex<double> value;
    /// Interior: the Fourier mode, 0 <= frequency <= valence / 2. Boundary and dart: 0 even, 1 odd in the mirror image.
    int frequency;
    int multiplicity;  ///< of this mode: 2 if it has a sine and a cosine
};

struct SpectralAnalysis {
    LocalMatrix matrix;
    std::vector<Eigenvalue> eigenvalues{};  ///< by decreasing magnitude
    /// The two tangents' eigenvalues. Interior: both the largest of Fourier mode 1; of valence 2, where that mode has
    /// no sine, along the two edges and across them. Boundary: along, then across.
    double lambda1 = 0, lambda2 = 0;
    double third = 0;  ///< magnitude of the next one
    /// 1 is simple, the tangents' eigenvalues are real and positive, and all others are smaller, but for what varies
    /// along a boundary alone and so does not tilt the plane: smaller than the tangent's along it is enough. Never at a
    /// boundary of hexagons, where the matrix has two faces of many.
    bool proper = false;
    CurvatureClass curvature{};  ///< interior only; the third against lambda1 lambda2
    /// Left eigenvectors, in the order of the labels. Position sums to one, the tangents to zero and their largest
    /// weight is one. A tangent whose eigenvalue is not simple within its symmetry is not determined: empty. Across a
    /// dual scheme's boundary, modes that vary along it alone do not count; the tangent annihilates them.
    std::vector<double> limit{}, tangent1{}, tangent2{};
};

/// Eigenvalues and left eigenvectors of the local matrix. Interior fans are solved Fourier mode by Fourier mode, so any
/// valence is a matter of small blocks. Others are split into even and odd parts, and these into the strongly connected
/// components of their dependency graph, which at a boundary may be as large as a ring: O(valence^3).
/// @throws std::invalid_argument  as local_matrix()
SpectralAnalysis analyse(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);

/// Masks to use: the formula's where the scheme has one, else the analysis's.
struct SchemeMasks {
    std::vector<double> limit, tangent1, tangent2;  ///< in the order of `analysis.matrix.labels`
    bool limit_is_formula = false, tangent1_is_formula = false, tangent2_is_formula = false;
};
SchemeMasks scheme_masks(const SchemeInfo& scheme, const SpectralAnalysis& analysis, const RuleOptions& options);

/// Degree of the polynomials that one step reproduces on the regular mesh, by trial (at most 6).
int reproduction_degree(const SchemeInfo& scheme, const RuleOptions& options);
/// Radius of a basis function on the regular mesh, in rings (dual: in faces to each side, so 1.5 is 3 by 3; hexagons:
/// in rings of faces): from how far one step carries a single point.
double support_radius(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis
