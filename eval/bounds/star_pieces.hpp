#pragma once

#include "../patches/loop_patches.hpp"
#include "../patches/quad_patches.hpp"
#include "labelled_polygon.hpp"

#include <array>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// What bounds the surface S over a triangle of a cell at an extraordinary vertex, as functions of the points around
/// the cell: norms for the whole triangle; polynomials for its parts in the three regular quarters; norms for the rest.
/// They depend on the valence and the triangle alone.
///
/// Norms bound |S - L|, L the linear interpolant of S at the corners of a triangle. S - L is linear in the points, and
/// zero if they are all equal. Split the points into an affine image of a reference star, and remainders. |S - L| is at
/// most the sum over points of remainder length times largest |weight| in S - L, plus the reference star's |S - L|
/// times the affine map's stretch.
template <class Shape>
class StarPieces {
  public:
    static constexpr int k_most_valence = 32;
    using Corners = std::array<Vec2d, 3>;
    using Points = std::span<const Vec3d>;
    static constexpr int k_degree = Shape::k_corners == 4 ? 6 : 4;
    using Polynomial = BezierTriangle<k_degree>;

    /// For a star whose corner 0 is extraordinary, with a valence of 3 to 32, and whose other corners are regular, and
    /// a triangle that is_common(); null for others. Computed at the first call, and kept. Thread-safe.
    /// @param at  corners of the triangle, where corner 0 of the star is (0, 0) and corner 1 is (1, 0)
    static const StarPieces* of(const Star<Shape::k_corners>& star, const Corners& at);

    /// Points as an affine image of the reference star, with the larger singular value `stretch`, and remainders.
    struct Fit {
        double stretch;
        std::array<double, 2 * k_most_valence + 8> remainder;
    };
    Fit fit(Points points) const;

    struct Norms {
        std::vector<double> of_point;  ///< largest |weight| in S - L
        double of_reference = 0;       ///< the reference star's largest |S - L|
        /// Upper bound on |S - L|, except for rounding.
        double deviation(const Fit& of) const;
    };
    struct RegularPart {
        std::array<int, 3> edge{};  ///< by side: the triangle's side that it lies on, or -1
        std::vector<typename Polynomial::Coordinates> weights;
    };
    struct InnerPart {
        LabelledTriangle piece;  ///< in lengths of the quarter's sides; edges are the triangle's sides
        Norms norms;
        std::vector<BezierTriangle<1>::Coordinates> corners;  ///< weights of its corners
    };
    Norms whole;
    std::vector<RegularPart> regular;
    std::vector<InnerPart> inner;

  private:
    StarPieces(int valence, const Corners& at);

    Corners at_;
    std::vector<Vec2d> reference_;      ///< the reference star's points
    std::vector<Vec3d> fit_;            ///< weights of a star's points in its affine map
    const StarPieces* next_ = nullptr;  ///< another triangle for the same valence
};

extern template class StarPieces<QuadShape>;
extern template class StarPieces<LoopShape>;

}  // namespace tetrakis::detail
