#pragma once

#include "dual_face_pieces.hpp"
#include "dual_links.hpp"

#include <cstdint>
#include <optional>
#include <span>

namespace tetrakis::detail {

class ConvexFace;

/// How far a piece of the mesh and its surface are from surface and mesh at most, by the pieces beside it: where the
/// surface slides along the mesh, which it does everywhere beside an extraordinary point, or crosses sides in other
/// places than the mesh, that is no error, but part of what is known over a piece alone.
///
/// Let F be the flat piece, G its neighbour across a side; their planes meet in that side's line at an angle t.
///
/// From the surface: F and G (or the part of G near the side), dropped onto F's plane, are together a convex polygon K
/// (if not, or without a neighbour, K = F). A point within d of K is within d of F or, b beyond the line, d + (b + d)
/// tan t from G. Distances to convex sets are convex, so that the points whose hull holds a part of the surface bound
/// d, and b.
///
/// From the mesh: drop the surface over F and over its neighbours onto F's plane. It goes around each inner point q of
/// F once, if the outer lines of the neighbours stay beyond those of F's sides, and so meets it: there is a point s of
/// the surface right above or below q. Over F it is no more than that surface's height above F away. Over G, let h be
/// the largest height there above G, and o how far that surface reaches over the line to F's side. s lies above the
/// point g of G's plane. That is no more than o from the line on F's side and h tan t on the other, as s is not beyond
/// the line; so the height of s above F is h + sin t max(o, h tan t) at most. A side without such a neighbour is
/// bounded as for DualBound: q is that far from the line over the side.
///
/// Faces of more than three corners are flattened first; where they are not flat, the two lines are `apart`.
class DualCloseBound {
  public:
    DualCloseBound(const DualSurface& surface, const VertexForest& forest, const DualNet& net, const DualLinks& links,
                   std::span<const Vec3d> positions)
        : surface_(surface), forest_(forest), net_(net), links_(links), positions_(positions) {}

    /// Of all pieces of a face; infinite where nothing is known.
    /// @param give_up_at  where the error is known to be larger, it may be any number above this
    double operator()(std::uint32_t face, const DualFacePieces& pieces, double give_up_at) const;

  private:
    struct Neighbour;
    std::optional<Neighbour> neighbour(const ConvexFace& flat, const DualLinks::Side& side) const;
    double piece_error(std::uint32_t face, const DualFacePieces& pieces, std::uint32_t piece, double give_up_at) const;
    /// How far points of the flat piece may be from the surface for the line over a side without a neighbour: not at
    /// all where that stays beyond the side's.
    static double side_error(const ConvexFace& flat, const DualFacePieces& pieces, std::size_t piece, std::size_t side);
    /// How far the part of a piece in the hull of these points is from the mesh; not looked at closer than `enough`.
    static double part_error(const ConvexFace& flat, std::span<const std::optional<Neighbour>> beside,
                             std::span<const Vec3d> points, double slack, double enough);

    const DualSurface& surface_;
    const VertexForest& forest_;
    const DualNet& net_;
    const DualLinks& links_;
    std::span<const Vec3d> positions_;
};

}  // namespace tetrakis::detail
