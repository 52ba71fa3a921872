#include "dual_bound.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"
#include "../triangles/mesh_sliding.hpp"
#include "patch_bounder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace tetrakis::detail {

namespace {

constexpr double k_unbounded = std::numeric_limits<double>::infinity();
/// Leaves below this level are too small to be looked at.
constexpr int k_deepest_leaf = k_max_level - DualCells::k_hull_levels - 1;

/// `v` turned by quarter turns, counter-clockwise.
Vec2d turned(Vec2d v, int quarters) {
    for (quarters &= 3; quarters > 0; --quarters) v = {-v.y, v.x};
    return v;
}

/// A leaf at a corner of a face; points are in lengths of its cell's sides.
struct FaceCorner {
    VertexCell cell;
    Vec2d point, vertex;
    Vec2d before{0}, after{0};  ///< where the lines from the previous and to the next corner cross the cell's side
    Vec3d position;
};

/// The corners of a face; none if a leaf is too small.
/// @param closed  whether the last leaf is adjacent to the first
std::vector<FaceCorner> corners_of(const DualCells& cells, const VertexForest& forest,
                                   std::span<const DualFaces::Corner> leaves, bool closed) {
    std::vector<FaceCorner> corners;
    for (const DualFaces::Corner& of : leaves) {
        const VertexCell cell = forest.cell(of.leaf);
        if (cell.level > k_deepest_leaf) return {};
        const bool on_side = of.at >= DualFaces::Corner::k_on_side;
        const Vec2d start = turned(Vec2d(on_side ? 0.0 : -0.5, -0.5), of.at % 4) + Vec2d(0.5);
        corners.push_back({cell, start, cells.vertex(cell), start, start, Vec3d(0)});
    }
    for (std::size_t i = 0; i < corners.size() - (closed ? 0 : 1); ++i) {
        const std::size_t j = (i + 1) % corners.size();
        FaceCorner &a = corners[i], &b = corners[j];
        const bool on_side = leaves[i].at >= DualFaces::Corner::k_on_side;
        const double side_a = std::ldexp(1.0, -a.cell.level), side_b = std::ldexp(1.0, -b.cell.level);
        // In a plane with the side between both: x is the distance to it from vertices in the middle; y lies along it.
        const Vec2d along_a = turned(on_side ? Vec2d(-1, 0) : Vec2d(0, 1), leaves[i].at % 4);
        const Vec2d along_b = turned({1, 0}, leaves[j].at % 4);
        const Vec2d here{glm::dot(Vec2d(0.5) - a.point, turned(along_a, -1)), glm::dot(a.vertex - a.point, along_a)};
        const Vec2d there{glm::dot(Vec2d(0.5) - b.point, turned(along_b, 1)), glm::dot(b.vertex - b.point, along_b)};
        const double share = here.x * side_a / (here.x * side_a + there.x * side_b);
        const double y = here.y * side_a + share * (there.y * side_b - here.y * side_a);
        a.after = a.point + y / side_a * along_a;
        b.before = b.point + y / side_b * along_b;
    }
    return corners;
}

/// Bounds the error over pieces of cells against one face, which aim_at() sets.
class PieceBounder : private PatchBounder {
  public:
    PieceBounder(const DualCells& cells, bool midedge, double rounding, const DualBound::Wanted& wanted)
        : PatchBounder(rounding), cells_(cells), midedge_(midedge), wanted_(wanted) {}

    void aim_at(const FaceDistance& face) { face_ = face; }
    double error(const VertexCell& cell, const DualPiece& piece) {
        start(wanted_.decide_at, !wanted_.tight);
        start_with_face();
        const auto on_net = [&](const Net9& net, const DualPiece& part) {
            DualCells::for_each_polynomial(
                net, part, midedge_, [&](const auto& patch, const DualPiece& of) { bound_patch(patch, of.edge); });
        };
        const auto on_hull = [&](std::span<const Vec3d> points) {
            needs_split(0, [&](bool) { return hull_error(points, {-1, -1, -1}, false); });
        };
        cells_.visit(cell, piece, on_net, on_hull);
        const LeafError found = finish();
        return rejected_ ? std::max(found.lower, std::nextafter(wanted_.decide_at, k_unbounded)) : found.upper;
    }

  private:
    const DualCells& cells_;
    bool midedge_;
    DualBound::Wanted wanted_;
};

/// Bounds on the errors over the parts of the surface at a face's corners.
class FaceErrors {
  public:
    FaceErrors(const PieceBounder& bounder, std::span<const FaceCorner> corners, std::span<double> of_corner)
        : bounder_(bounder), corners_(corners), of_corner_(of_corner) {}

    /// @param sliding  per triangle
    void bound_triangles(std::size_t start, std::span<const EdgeSliding> sliding) {
        const std::size_t n = corners_.size();
        for (std::size_t t = 0; t + 2 < n; ++t) {
            const std::array<std::size_t, 3> corner{start, (start + t + 1) % n, (start + t + 2) % n};
            bounder_.aim_at(FaceDistance({position(corner[0]), position(corner[1]), position(corner[2])}, sliding[t]));
            const int diagonal = n == 3 ? -1 : t == 0 ? 2 : 0;
            const auto diagonal_at = [&](int k) { return diagonal == k || diagonal == (k + 2) % 3 ? diagonal : -1; };
            for (int k = 0; k < 3; ++k)
                if (k != diagonal)
                    bound_side(corner[static_cast<std::size_t>(k)], {k, diagonal_at(k), diagonal_at((k + 1) % 3)});
        }
    }
    /// Bounds the errors against the whole face as one flat polygon.
    /// @param start  the corner that the fan of triangles starts at
    /// @param sliding  per triangle
    void bound_whole(std::size_t start, std::span<const EdgeSliding> sliding) {
        const std::size_t n = corners_.size();
        std::vector<Vec3d> at;
        for (std::size_t i = 0; i < n; ++i) at.push_back(position((start + i) % n));
        FaceDistance face(at);
        if (!face.convex()) {
            // All of the face and of its surface is near the first corner, which is on both.
            bound_by_edge(at[0], at[0]);
        } else {
            for (std::size_t k = 0; k < n; ++k) {
                // The fan's triangle at edge k.
                const std::size_t t = std::clamp<std::size_t>(k, 1, n - 2) - 1, edge = k == 0 ? 0 : k + 1 < n ? 1 : 2;
                const Vec3d normal = unit_or_zero(glm::cross(at[t + 1] - at[0], at[t + 2] - at[0]));
                if (sliding[t].edge[edge]) face.set_sliding(k, sliding[t].fold[edge], sliding[t].flap[edge], normal);
            }
            bounder_.aim_at(face);
            for (std::size_t i = 0; i < n; ++i) bound_side((start + i) % n, {static_cast<int>(i), -1, -1});
        }
        for (std::size_t i = 0; i < n; ++i)
            of_corner_[i] = face.convex() ? of_corner_[i] + 2 * face.height()
                                          : std::max(of_corner_[i], glm::length(position(i) - at[0]));
    }
    /// bound_whole() of a quad, where that gives a smaller error: beside extraordinary points a quad may be flatter
    /// than lines over its diagonal are straight.
    void bound_whole_if_better(double decide_at, std::size_t start, std::span<const EdgeSliding> sliding) {
        const auto largest = [&] { return *std::max_element(of_corner_.begin(), of_corner_.end()); };
        const double before = largest();
        if (before <= decide_at) return;
        const std::vector<double> corner(of_corner_.begin(), of_corner_.end());
        std::fill(of_corner_.begin(), of_corner_.end(), 0.0);
        bound_whole(start, sliding);
        if (largest() >= before) std::copy(corner.begin(), corner.end(), of_corner_.begin());
    }
    void bound_by_edge(const Vec3d& a, const Vec3d& b) {
        bounder_.aim_at(FaceDistance({a, b, b}));
        for (std::size_t i = 0; i < corners_.size(); ++i) bound_side(i, {-1, -1, -1});
    }

  private:
    const Vec3d& position(std::size_t i) const { return corners_[i].position; }

    /// Bounds the error between two lines from a corner's vertex. At distance t from the end of the surface, the
    /// surface depends on t^2: lines from the end are parabolas there, cut into k_parts straight parts.
    /// @param edges  numbers of the edges that the lines lie over
    double bound_corner(const FaceCorner& c, const std::array<Vec2d, 2>& to, const std::array<int, 2>& edges) {
        const auto on_line = [&](std::size_t line, int i, int parts) {
            const double share = static_cast<double>(i) / parts;
            const auto along = [&](double from, double end) {
                return from + share * (from == 0.5 ? share : 1) * (end - from);
            };
            return Vec2d(along(c.vertex.x, to[line].x), along(c.vertex.y, to[line].y));
        };
        constexpr int k_parts = 4;
        const int parts = c.vertex == Vec2d(0.5) ? 1 : k_parts;
        double largest = 0;
        for (int i = 0; i < parts; ++i) {
            const Vec2d a = on_line(0, i, parts), b = on_line(0, i + 1, parts), d = on_line(1, i, parts),
                        e = on_line(1, i + 1, parts);
            largest = std::max(largest, bounder_.error(c.cell, {{a, b, e}, {edges[0], -1, i == 0 ? edges[1] : -1}}));
            if (i > 0) largest = std::max(largest, bounder_.error(c.cell, {{a, e, d}, {-1, edges[1], -1}}));
        }
        return largest;
    }
    /// Bounds the error between the line from a corner to the next one and the face's point.
    /// @param edges  the edges that this line and those from both corners to the point lie over; -1: none
    void bound_side(std::size_t i, const std::array<int, 3>& edges) {
        const std::size_t j = (i + 1) % corners_.size();
        const FaceCorner &a = corners_[i], &b = corners_[j];
        of_corner_[i] = std::max(of_corner_[i], bound_corner(a, {a.after, a.point}, {edges[0], edges[1]}));
        of_corner_[j] = std::max(of_corner_[j], bound_corner(b, {b.point, b.before}, {edges[2], edges[0]}));
    }

    PieceBounder bounder_;
    std::span<const FaceCorner> corners_;
    std::span<double> of_corner_;
};

/// Adds the points where creases end, as faces of their cells. Returns these points.
std::vector<const DualCells::Point*> add_ends(const VertexForest& forest, const DualCells& cells, DualFaces& faces) {
    struct Vertex {
        LeafId leaf;
        std::uint32_t number;
    };
    std::unordered_map<std::uint64_t, Vertex> at_end;  // by corner of a root
    const auto key = [](std::uint32_t root, int c) { return 4 * std::uint64_t{root} + static_cast<std::uint64_t>(c); };
    const auto look = [&](LeafId leaf, std::uint32_t number) {
        const VertexCell cell = forest.cell(leaf);
        for (int c = 0; c < 4; ++c)
            if (const std::uint32_t p = cells.point(cell, c); p != DualCells::k_none && !cells.points()[p].is_face())
                at_end[key(cell.root, c)] = {leaf, number};
    };
    for (std::uint32_t v = 0; v < faces.leaves.size(); ++v) look(faces.leaves[v], v);
    for (const DualFaces::LeafOfVertex& side : faces.other_sides) look(side.leaf, side.vertex);
    std::vector<const DualCells::Point*> ends;
    for (const DualCells::Point& point : cells.points()) {
        if (point.is_face()) continue;
        ends.push_back(&point);
        for (const VertexRoots::Corner& c : point.corners) {
            const Vertex& vertex = at_end.at(key(c.cell.root, c.corner));
            faces.corners.push_back({vertex.leaf, static_cast<std::uint8_t>(c.corner)});
            faces.face_vertices.push_back(vertex.number);
        }
        faces.face_offsets.push_back(static_cast<std::uint32_t>(faces.face_vertices.size()));
    }
    return ends;
}

}  // namespace

bool DualBound::has(const SchemeInfo& scheme) {
    return scheme.pieces == SurfacePieces::biquadratic || scheme.pieces == SurfacePieces::quadratic_box;
}

DualBound::DualBound(const LevelSource& points, const SchemeInfo& scheme, const VertexRoots& roots,
                     const ControlMesh& mesh)
    : cells_(points, roots),
      midedge_(scheme.pieces == SurfacePieces::quadratic_box),
      rounding_(surface_rounding(mesh)) {}

DualBound::Errors DualBound::errors(const VertexForest& forest, const DualTriangles& mesh,
                                    std::span<const Vec3d> positions, const Wanted& wanted,
                                    const std::function<void(double)>& report) {
    std::vector<VertexCell> leaves;
    const auto add = [&](LeafId leaf) {
        if (forest.level(leaf) <= k_deepest_leaf) leaves.push_back(forest.cell(leaf));
    };
    for (const LeafId leaf : mesh.faces.leaves) add(leaf);
    for (const DualFaces::LeafOfVertex& side : mesh.faces.other_sides) add(side.leaf);
    cells_.find(leaves, [&](double done) { report(0.5 * done); });

    DualFaces faces = forest.faces(FaceCorners::leaves);
    const std::size_t face_count = faces.control_faces.size();
    const auto ends = add_ends(forest, cells_, faces);
    std::vector<std::array<std::uint32_t, 3>> triangles(mesh.triangle_count());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) triangles[t] = mesh.triangle(t);
    const MeshSliding of_mesh(triangles, positions);

    Errors errors;
    errors.of_vertex.assign(mesh.vertex_count(), 0.0);
    std::vector<double> of_corner(faces.face_vertices.size(), 0.0);
    constexpr std::uint32_t k_grain = 32;
    report(0.5);
    for_each_index(
        static_cast<std::uint32_t>(faces.face_offsets.size() - 1),
        [&](std::uint32_t f) {
            const std::size_t begin = faces.face_offsets[f], n = faces.face_offsets[f + std::size_t{1}] - begin;
            const auto here = std::span(of_corner).subspan(begin, n);
            const bool is_face = f < face_count;
            const bool closed = is_face || ends[f - face_count]->closed;
            auto corners = corners_of(cells_, forest, std::span(faces.corners).subspan(begin, n), closed);
            for (std::size_t i = 0; i < corners.size(); ++i)
                corners[i].position = positions[faces.face_vertices[begin + i]];
            if (corners.empty()) {
                std::ranges::fill(here, k_unbounded);
                return;
            }
            FaceErrors bound({cells_, midedge_, rounding_, wanted}, corners, here);
            if (!is_face) return bound.bound_by_edge(corners[0].position, corners[n > 1 ? 1 : 0].position);
            // Every face before this one has two triangles less than corners.
            std::vector<EdgeSliding> sliding(n - 2);
            for (std::size_t t = 0; t < sliding.size(); ++t)
                sliding[t] = of_mesh.of(static_cast<std::uint32_t>(begin - 2 * std::size_t{f} + t), {true, true, true});
            const std::size_t start = n == 4 && faces.diagonal_at_first[f] == 0 ? 1 : 0;
            if (n > 4) return bound.bound_whole(start, sliding);
            bound.bound_triangles(start, sliding);
            if (n == 4) bound.bound_whole_if_better(wanted.decide_at, start, sliding);
        },
        k_grain);
    for (std::size_t i = 0; i < of_corner.size(); ++i) {
        double& most = errors.of_vertex[faces.face_vertices[i]];
        most = std::max(most, of_corner[i]);
        errors.largest = std::max(errors.largest, of_corner[i]);
    }
    return errors;
}

}  // namespace tetrakis::detail
