#include "tetrakis/eval/dual_face_bound.hpp"

#include "tetrakis/eval/convex_face.hpp"
#include "tetrakis/eval/plane_measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace tetrakis::detail {

namespace {

constexpr double k_unbounded = std::numeric_limits<double>::infinity();

/// Counter-clockwise by quarter turns.
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

bool is_at_root_corner(const VertexCell& cell, int corner) {
    const std::uint32_t last = (1u << cell.level) - 1;
    return cell.at.x == (corner == 1 || corner == 2 ? last : 0) && cell.at.y == (corner >= 2 ? last : 0);
}

/// The numbers of leaves that are vertices of a mesh.
std::vector<std::uint32_t> vertices_of_leaves(const VertexForest& forest, const DualFaces& faces) {
    std::vector<std::uint32_t> vertex(forest.leaf_slots(), DualCorners::none);
    for (std::uint32_t v = 0; v < faces.leaves.size(); ++v) vertex[faces.leaves[v].value] = v;
    for (const DualFaces::OtherSide& side : faces.other_sides) vertex[side.leaf.value] = side.vertex;
    return vertex;
}

/// Adds the points where creases end.
void add_ends(const VertexForest& forest, const DualCorners& corners, DualNet& net) {
    const auto key = [](const DualCorners::Member& m) { return 4 * m.root + static_cast<std::uint32_t>(m.corner); };
    std::unordered_map<std::uint32_t, LeafId> leaf_at;
    for (const DualCorners::Point& point : corners.points())
        if (!point.is_face())
            for (const DualCorners::Member& m : point.around) leaf_at.emplace(key(m), LeafId{});
    if (leaf_at.empty()) return;
    const std::vector<std::uint32_t> vertex = vertices_of_leaves(forest, net.faces);
    for (std::uint32_t slot = 0; slot < vertex.size(); ++slot) {
        if (vertex[slot] == DualCorners::none) continue;
        const VertexCell cell = forest.cell(LeafId(slot));
        for (int c = 0; c < 4; ++c)
            if (is_at_root_corner(cell, c))
                if (const auto found = leaf_at.find(key({cell.root, c})); found != leaf_at.end())
                    found->second = LeafId(slot);
    }
    for (std::uint32_t p = 0; p < corners.points().size(); ++p) {
        const DualCorners::Point& point = corners.points()[p];
        if (point.is_face()) continue;
        const auto is_there = [&](const DualCorners::Member& m) { return leaf_at[key(m)].valid(); };
        if (!std::all_of(point.around.begin(), point.around.end(), is_there)) continue;  // in a hole
        for (const DualCorners::Member& m : point.around) {
            const LeafId leaf = leaf_at[key(m)];
            net.faces.corners.push_back({leaf, static_cast<std::uint8_t>(m.corner)});
            net.faces.face_vertices.push_back(vertex[leaf.value]);
        }
        net.faces.face_offsets.push_back(static_cast<std::uint32_t>(net.faces.face_vertices.size()));
        net.point.push_back(p);
    }
}

}  // namespace

DualNet dual_net(const VertexForest& forest, const DualCorners& corners) {
    DualNet net;
    net.faces = forest.faces(FaceCorners::leaves);
    net.face_count = net.faces.control_faces.size();
    net.point.resize(net.face_count);
    for (std::size_t f = 0; f < net.face_count; ++f) {
        const DualFaces::Corner& first = net.faces.corners[net.faces.face_offsets[f]];
        const VertexCell cell = forest.cell(first.leaf);
        const bool at_root = first.at < DualFaces::Corner::k_on_side && is_at_root_corner(cell, first.at);
        net.point[f] = at_root ? corners.point(cell.root, first.at) : DualCorners::none;
    }
    add_ends(forest, corners, net);
    return net;
}

DualFaceBound::Corners DualFaceBound::corners_of(std::uint32_t face) const {
    Corners corners;
    for (std::uint32_t i = net_.faces.face_offsets[face]; i < net_.faces.face_offsets[face + std::size_t{1}]; ++i) {
        const DualFaces::Corner& of = net_.faces.corners[i];
        Corner c{};
        c.leaf = of.leaf;
        c.cell = forest_.cell(of.leaf);
        c.turn = of.at % 4;
        c.on_side = of.at >= DualFaces::Corner::k_on_side;
        const DualAxes& axes = surface_.axes(c.cell.root);
        c.at_place = c.on_side ? middle_place(c.cell, c.turn) : corner_place(c.cell, c.turn);
        c.vertex_place = axes.vertex_place(c.cell);
        c.at = axes(c.at_place);
        c.vertex = axes(c.vertex_place);
        c.position = positions_[net_.faces.face_vertices[i]];
        corners.push_back(c);
    }
    return corners;
}

void DualFaceBound::operator()(std::uint32_t face, std::span<double> of_corner) const {
    const Corners corners = corners_of(face);
    std::fill(of_corner.begin(), of_corner.end(), 0.0);
    for (const Corner& c : corners)
        if (c.cell.level > DualSurface::k_deepest_leaf)
            return std::fill(of_corner.begin(), of_corner.end(), k_unbounded);
    const std::uint32_t point = net_.point[face];
    bool plane = point == DualCorners::none;
    for (std::size_t i = 0; plane && i < corners.size(); ++i)
        plane = agree(corners[i], corners[(i + 1) % corners.size()]);
    if (plane) return bound_regular(face, corners, of_corner);
    const double error =
        face < net_.face_count ? bound_face(corners) : bound_end(corners, surface_.corners().points()[point].closed);
    int coarsest = k_max_level;
    for (const Corner& c : corners) coarsest = std::min<int>(coarsest, c.cell.level);
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (corners[i].cell.level == coarsest) of_corner[i] = error;
}

void DualFaceBound::bound_regular(std::uint32_t face, const Corners& corners, std::span<double> of_corner) const {
    // The plane around the face's point: the first corner's side runs to the right.
    std::vector<int> turns;  // from a root's coordinates
    std::vector<Vec2d> place;
    int quarter = 0;
    for (const Corner& c : corners) {
        turns.push_back(quarter - c.turn);
        place.push_back(turned(c.vertex - c.at, turns.back()));
        quarter += c.on_side ? 2 : 1;
    }
    const std::size_t n = corners.size();
    const std::size_t start = n == 4 && net_.faces.diagonal_at_first[face] == 0 ? 1 : 0;
    for (std::size_t k = 1; k + 1 < n; ++k) {
        const std::array<std::size_t, 3> of = {start, (start + k) % n, (start + k + 1) % n};
        bound_triangle(corners, of, {place[of[0]], place[of[1]], place[of[2]]}, turns, of_corner);
    }
}

void DualFaceBound::bound_triangle(const Corners& corners, const std::array<std::size_t, 3>& of,
                                   const std::array<Vec2d, 3>& place, std::span<const int> turns,
                                   std::span<double> of_corner) const {
    const std::array<Vec3d, 3> position = {corners[of[0]].position, corners[of[1]].position, corners[of[2]].position};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Corner& c = corners[i];
        std::array<Vec2d, 3> at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = c.at + turned(place[k], -turns[i]);
        const ShortPolygon whole{at[0], at[1], at[2]};
        if (!(whole.area() > 0)) {
            of_corner[i] = k_unbounded;
            continue;
        }
        const DualBox box = box_of(surface_.axes(c.cell.root), c.cell);
        const ShortPolygon part = whole.within(box.low, box.high);
        if (part.is_nothing_beside(box.high - box.low)) continue;
        const FlatMap flat(at, position);
        const auto on_part = [&](const DualPart& polynomial) {
            of_corner[i] = std::max(of_corner[i], polynomial.difference(flat));
        };
        const auto on_point = [&](std::uint32_t point) {
            for (const Vec3d& p : surface_.hull(point))
                for (std::size_t k = 0; k < part.size(); ++k)
                    of_corner[i] = std::max(of_corner[i], glm::length(p - flat(part[k])));
        };
        surface_.visit(c.leaf, c.cell, part, on_part, on_point);
    }
}

Vec2d DualFaceBound::Corner::from_behind(const Vec2d& v) const {
    const Vec2d local = turned(v, -turn);
    return {local.y, local.x};
}

Vec2d DualFaceBound::Corner::from_ahead(const Vec2d& v) const {
    const Vec2d local = turned(v, -turn);
    return on_side ? Vec2d{local.y, -local.x} : local;
}

Vec2d DualFaceBound::Corner::behind_at(double length) const { return turned({length, 0}, turn); }

Vec2d DualFaceBound::Corner::ahead_at(double length) const {
    return turned(on_side ? Vec2d{-length, 0} : Vec2d{0, length}, turn);
}

bool DualFaceBound::agree(const Corner& corner, const Corner& next) const {
    return surface_.axes(corner.cell.root).is_bent_along(corner.side_ahead()) ==
           surface_.axes(next.cell.root).is_bent_along(next.side_behind());
}

std::vector<DualFaceBound::Crossings> DualFaceBound::crossings(const Corners& corners) const {
    // On the straight line in a plane with the side between the two; x into the cell, y along the side.
    const auto crossing = [](const Vec2d& here, const Vec2d& there) {
        return here.y + here.x / (here.x + there.x) * (there.y - here.y);
    };
    std::vector<Crossings> crossings(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::size_t j = (i + 1) % corners.size();
        const Corner &c = corners[i], &next = corners[j];
        if (agree(c, next)) {
            const double along = crossing(c.from_ahead(c.vertex - c.at), next.from_behind(next.vertex - next.at));
            crossings[i].ahead = c.at + c.ahead_at(along);
            crossings[j].behind = next.at + next.behind_at(along);
        } else {
            const double along = crossing(c.from_ahead(c.vertex_place - c.at_place),
                                          next.from_behind(next.vertex_place - next.at_place));
            crossings[i].ahead = surface_.axes(c.cell.root)(c.at_place + c.ahead_at(along));
            crossings[j].behind = surface_.axes(next.cell.root)(next.at_place + next.behind_at(along));
        }
    }
    return crossings;
}

template <class Take>
void DualFaceBound::for_each_within(const Corner& corner, const ShortPolygon& polygon, Take&& take) const {
    const DualBox box = box_of(surface_.axes(corner.cell.root), corner.cell);
    if (polygon.is_nothing_beside(box.high - box.low)) return;
    for_each_over(corner, polygon, take);
}

template <class Take>
void DualFaceBound::for_each_over(const Corner& corner, const ShortPolygon& shape, Take&& take) const {
    surface_.visit(
        corner.leaf, corner.cell, shape, [&](const DualPart& part) { part.for_each_point(take); },
        [&](std::uint32_t point) {
            for (const Vec3d& p : surface_.hull(point)) take(p, 0.0);
        });
}

template <class Take>
void DualFaceBound::for_each_around(const Corner& corner, const Crossings& crossings, Take&& take) const {
    for_each_within(corner, {corner.at, crossings.behind, corner.vertex}, take);
    for_each_within(corner, {corner.at, corner.vertex, crossings.ahead}, take);
}

template <class Take>
void DualFaceBound::for_each_on_line(const Corner& corner, const Vec2d& crossing, Take&& take) const {
    for_each_over(corner, {corner.vertex, crossing}, take);
}

double DualFaceBound::bound_blindly(const Corners& corners, const std::vector<Crossings>& crossings) const {
    const Vec3d first = corners[0].position;
    double error = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        error = std::max(error, glm::length(corners[i].position - first));
        for_each_around(corners[i], crossings[i],
                        [&](const Vec3d& p, double slack) { error = std::max(error, glm::length(p - first) + slack); });
    }
    return error;
}

double DualFaceBound::bound_face(const Corners& corners) const {
    const std::size_t n = corners.size();
    const std::vector<Crossings> crossing = crossings(corners);
    std::vector<Vec3d> position;
    for (const Corner& c : corners) position.push_back(c.position);
    const ConvexFace face(position);
    if (!face.convex()) return bound_blindly(corners, crossing);
    double forward = 0, backward = 0;
    for (std::size_t i = 0; i < n; ++i) {
        for_each_around(corners[i], crossing[i],
                        [&](const Vec3d& p, double slack) { forward = std::max(forward, face.distance(p) + slack); });
        double off = 0, in_plane = 0;
        const auto on_side = [&](const Vec3d& p, double slack) {
            off = std::max(off, face.side_distance(p, i) + slack);
            in_plane = std::max(in_plane, face.side_distance_in_plane(p, i) + slack);
        };
        for_each_on_line(corners[i], crossing[i].ahead, on_side);
        for_each_on_line(corners[(i + 1) % n], crossing[(i + 1) % n].behind, on_side);
        backward = std::max(backward, in_plane + off);
    }
    return std::max(forward, backward) + face.height();
}

double DualFaceBound::bound_end(const Corners& corners, bool closed) const {
    const std::size_t n = corners.size();
    std::vector<Crossings> crossing = crossings(corners);
    if (!closed) crossing[n - 1].ahead = corners[n - 1].at, crossing[0].behind = corners[0].at;
    // The vertices of the two sides of the crease are the same.
    const Vec3d a = corners[0].position, b = corners[1].position;
    double error = 0;
    for (std::size_t i = 0; i < n; ++i)
        for_each_around(corners[i], crossing[i], [&](const Vec3d& p, double slack) {
            error = std::max(error, segment_distance(p, a, b) + slack);
        });
    return error;
}

}  // namespace tetrakis::detail
