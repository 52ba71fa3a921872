#pragma once

#include "dual_net.hpp"
#include "dual_surface.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A face of the mesh of a vertex forest's leaves over the surface: the leaves that meet in its point, and its pieces,
/// each a flat polygon of the mesh and the part of the surface that it stands for. Where the surface has coordinates
/// all around the point, pieces are the triangles, cut off along straight lines; elsewhere there is one, all around the
/// point. Lines are those of the two cells that they go through, so that neighbours have the same.
class DualFacePieces {
  public:
    /// A leaf of the face. Sides of its cell are turned so that the face's point lies at the start of side `turn`, or
    /// in the middle of it.
    struct Corner {
        LeafId leaf;
        VertexCell cell;
        int turn;
        bool on_side;
        Vec2d at_place, vertex_place;  ///< of the face's point and the vertex, in sides of the root
        Vec2d at, vertex;              ///< the same in its coordinates
        Vec3d position;

        int side_behind() const { return turn; }
        int side_ahead() const { return on_side ? turn : (turn + 3) % 4; }
        /// Lengths into the cell and along the side to the corner before or behind, which is x or y; of a vector from
        /// the face's point.
        Vec2d from_behind(const Vec2d& v) const;
        Vec2d from_ahead(const Vec2d& v) const;
        /// The point so far along that side.
        Vec2d behind_at(double length) const;
        Vec2d ahead_at(double length) const;
    };

    /// @param positions  of the mesh's vertices
    DualFacePieces(const DualSurface& surface, const VertexForest& forest, const DualNet& net,
                   std::span<const Vec3d> positions, std::uint32_t face);

    std::span<const Corner> corners() const { return corners_; }
    bool plane() const { return !turns_.empty(); }
    std::size_t piece_count() const { return plane() ? corners_.size() - 2 : 1; }
    std::size_t side_count(std::size_t) const { return plane() ? 3 : corners_.size(); }
    /// Of a piece, as a corner of the face. Side i leads from its corner i to the next one.
    std::size_t corner(std::size_t piece, std::size_t i) const {
        return plane() ? (i == 0 ? start_ : (start_ + piece + i) % corners_.size()) : i % corners_.size();
    }
    /// A triangle of a plane face in the coordinates of a corner's root.
    std::array<Vec2d, 3> triangle(std::size_t piece, const Corner& corner) const;

    /// Calls take(points, slack) for points whose hulls hold the piece's surface, but for the slack.
    template <class Take>
    void for_each_hull(std::size_t piece, Take&& take) const;
    /// The same of the line over a side.
    template <class Take>
    void for_each_on_side(std::size_t piece, std::size_t side, Take&& take) const;

  private:
    /// Where the lines from a corner's vertex to the next one's and to the one before leave its cell.
    struct Crossings {
        Vec2d ahead, behind;
    };
    /// Whether cells have the same coordinates along the side between them.
    bool agree(const Corner& corner, const Corner& next) const;
    void find_plane(bool diagonal_at_first);
    void find_crossings(bool closed);
    DualBox box(const Corner& c) const { return box_of(surface_.axes(c.cell.root), c.cell); }
    template <class Take>
    void for_each_over(const Corner& corner, const ShortPolygon& shape, Take&& take) const;

    const DualSurface& surface_;
    std::vector<Corner> corners_;
    // Of a plane face: quarter turns from a corner's coordinates, vertices around the point, corner of the diagonal.
    std::vector<int> turns_;
    std::vector<Vec2d> place_;
    std::size_t start_ = 0;
    std::vector<Crossings> crossings_;  // of the others
};

Vec2d turned(const Vec2d& v, int quarters);  ///< counter-clockwise

template <class Take>
void DualFacePieces::for_each_over(const Corner& corner, const ShortPolygon& shape, Take&& take) const {
    const DualBox cell = box(corner);
    const ShortPolygon part = shape.within(cell.low, cell.high);
    if (part.is_nothing_beside(cell.high - cell.low)) return;
    surface_.visit(
        corner.leaf, corner.cell, part, [&](const DualPart& polynomial) { polynomial.for_each_hull(take); },
        [&](std::uint32_t point) { take(surface_.hull(point), 0.0); });
}

template <class Take>
void DualFacePieces::for_each_hull(std::size_t piece, Take&& take) const {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
        const Corner& c = corners_[i];
        if (plane()) {
            const std::array<Vec2d, 3> at = triangle(piece, c);
            for_each_over(c, {at[0], at[1], at[2]}, take);
        } else {
            for_each_over(c, {c.at, crossings_[i].behind, c.vertex}, take);
            for_each_over(c, {c.at, c.vertex, crossings_[i].ahead}, take);
        }
    }
}

template <class Take>
void DualFacePieces::for_each_on_side(std::size_t piece, std::size_t side, Take&& take) const {
    if (plane()) {
        for (const Corner& c : corners_) {
            const std::array<Vec2d, 3> at = triangle(piece, c);
            for_each_over(c, {at[side], at[(side + 1) % 3]}, take);
        }
        return;
    }
    const std::size_t next = (side + 1) % corners_.size();
    for_each_over(corners_[side], {corners_[side].vertex, crossings_[side].ahead}, take);
    for_each_over(corners_[next], {corners_[next].vertex, crossings_[next].behind}, take);
}

}  // namespace tetrakis::detail
