#include "dual_face_pieces.hpp"

namespace tetrakis::detail {

Vec2d turned(const Vec2d& v, int quarters) {
    switch (quarters & 3) {
        case 0:
            return v;
        case 1:
            return {-v.y, v.x};
        case 2:
            return -v;
        default:
            return {v.y, -v.x};
    }
}

Vec2d DualFacePieces::Corner::from_behind(const Vec2d& v) const {
    const Vec2d local = turned(v, -turn);
    return {local.y, local.x};
}

Vec2d DualFacePieces::Corner::from_ahead(const Vec2d& v) const {
    const Vec2d local = turned(v, -turn);
    return on_side ? Vec2d{local.y, -local.x} : local;
}

Vec2d DualFacePieces::Corner::behind_at(double length) const { return turned({length, 0}, turn); }

Vec2d DualFacePieces::Corner::ahead_at(double length) const {
    return turned(on_side ? Vec2d{-length, 0} : Vec2d{0, length}, turn);
}

bool DualFacePieces::agree(const Corner& corner, const Corner& next) const {
    return surface_.axes(corner.cell.root).is_bent_along(corner.side_ahead()) ==
           surface_.axes(next.cell.root).is_bent_along(next.side_behind());
}

DualFacePieces::DualFacePieces(const DualSurface& surface, const VertexForest& forest, const DualNet& net,
                               std::span<const Vec3d> positions, std::uint32_t face)
    : surface_(surface) {
    for (std::uint32_t i = net.faces.face_offsets[face]; i < net.faces.face_offsets[face + std::size_t{1}]; ++i) {
        const DualFaces::Corner& of = net.faces.corners[i];
        Corner c{};
        c.leaf = of.leaf;
        c.cell = forest.cell(of.leaf);
        c.turn = of.at % 4;
        c.on_side = of.at >= DualFaces::Corner::k_on_side;
        const DualAxes& axes = surface.axes(c.cell.root);
        c.at_place = c.on_side ? middle_place(c.cell, c.turn) : corner_place(c.cell, c.turn);
        c.vertex_place = axes.vertex_place(c.cell);
        c.at = axes(c.at_place);
        c.vertex = axes(c.vertex_place);
        c.position = positions[net.faces.face_vertices[i]];
        corners_.push_back(c);
    }
    bool plane = net.point[face] == DualCorners::none;
    for (std::size_t i = 0; plane && i < corners_.size(); ++i)
        plane = agree(corners_[i], corners_[(i + 1) % corners_.size()]);
    if (plane)
        find_plane(net.faces.diagonal_at_first[face] != 0);
    else
        find_crossings(net.open[face] == 0);
}

void DualFacePieces::find_plane(bool diagonal_at_first) {
    // Around the face's point; the first corner's side runs to the right.
    int quarter = 0;
    for (const Corner& c : corners_) {
        turns_.push_back(quarter - c.turn);
        place_.push_back(turned(c.vertex - c.at, turns_.back()));
        quarter += c.on_side ? 2 : 1;
    }
    start_ = corners_.size() == 4 && !diagonal_at_first ? 1 : 0;
}

std::array<Vec2d, 3> DualFacePieces::triangle(std::size_t piece, const Corner& c) const {
    const int back = -turns_[static_cast<std::size_t>(&c - corners_.data())];
    std::array<Vec2d, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = c.at + turned(place_[corner(piece, k)], back);
    return at;
}

void DualFacePieces::find_crossings(bool closed) {
    // On the straight line in a plane with the side between the two; x into the cell, y along the side.
    const auto crossing = [](const Vec2d& here, const Vec2d& there) {
        return here.y + here.x / (here.x + there.x) * (there.y - here.y);
    };
    const std::size_t n = corners_.size();
    crossings_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t j = (i + 1) % n;
        const Corner &c = corners_[i], &next = corners_[j];
        if (j == 0 && !closed) {
            crossings_[i].ahead = c.at;
            crossings_[j].behind = next.at;
        } else if (agree(c, next)) {
            const double along = crossing(c.from_ahead(c.vertex - c.at), next.from_behind(next.vertex - next.at));
            crossings_[i].ahead = c.at + c.ahead_at(along);
            crossings_[j].behind = next.at + next.behind_at(along);
        } else {
            const double along = crossing(c.from_ahead(c.vertex_place - c.at_place),
                                          next.from_behind(next.vertex_place - next.at_place));
            crossings_[i].ahead = surface_.axes(c.cell.root)(c.at_place + c.ahead_at(along));
            crossings_[j].behind = surface_.axes(next.cell.root)(next.at_place + next.behind_at(along));
        }
    }
}

}  // namespace tetrakis::detail
