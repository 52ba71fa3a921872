#include "dual_limits.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/points/level_source.hpp"
#include "../../refine/points/row_points.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../surface/local_frame.hpp"
#include "../triangles/point_triangle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Levels after which the cells around a point stand for that point: each level halves their distance from it.
constexpr int k_to_a_point = 12;

}  // namespace

ControlMesh dual_roots(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules) {
    const VertexRoots roots = vertex_roots(control, scheme, rules);
    if (std::ranges::find(roots.hole, 1) != roots.hole.end())
        throw Error(ErrorCode::unsupported,
                    "LOD takes dual schemes by their certified bound, and there is none where the mesh has holes "
                    "(remove their faces instead)",
                    control.data().source);
    ControlMeshData data = cell_mesh(roots);
    if (control.has_uvs()) {
        data.uvs.resize(data.face_vertices.size());
        data.face_uvs.resize(data.uvs.size());
        std::iota(data.face_uvs.begin(), data.face_uvs.end(), 0u);
    }
    // The first roots are the control faces' corner cells, where positions and UVs are known.
    const std::uint32_t cells = control.halfedge_count();
    const auto at_corner = [&](std::uint32_t c, const auto& value) {
        const HalfedgeId h(c / 4);
        const auto here = value(h);
        if (c % 4 == 0) return here;
        if (c % 4 == 1) return 0.5 * (here + value(control.next(h)));
        if (c % 4 == 3) return 0.5 * (here + value(control.prev(h)));
        auto sum = here;
        for (HalfedgeId g = control.next(h); g != h; g = control.next(g)) sum += value(g);
        return sum / double(control.face_size(control.face(h)));
    };
    const auto position = [&](HalfedgeId h) { return control.position(control.origin(h)); };
    const auto uv = [&](HalfedgeId h) { return control.data().uvs[control.uv_index(h)]; };
    for (std::uint32_t c = 0; c < 4 * cells; ++c) {
        data.positions[data.face_vertices[c]] = at_corner(c, position);
        if (control.has_uvs()) data.uvs[c] = at_corner(c, uv);
    }
    // Other roots share a side with a known root. Those at boundary corners share sides with two such roots instead.
    std::vector<std::uint8_t> known(roots.count(), 0);
    std::fill_n(known.begin(), cells, std::uint8_t{1});
    for (int pass = 0; pass < 2; ++pass)
        for (std::uint32_t r = cells; r < roots.count(); ++r)
            for (std::uint32_t side = 4 * r; known[r] == 0 && side < 4 * r + 4; ++side) {
                const std::uint32_t other = roots.link[side];
                if (other == VertexRoots::outside || known[other / 4] == 0) continue;
                if ((roots.crease[r] >> side % 4 & 1) != 0) continue;
                known[r] = 1;
                // Values are constant away from the common side.
                const std::uint32_t behind = other / 4 * 4 + (other + 1) % 4;
                const std::array<std::uint32_t, 4> from{behind, other, other, behind};
                for (std::uint32_t k = 0; k < 4; ++k) {
                    const std::uint32_t c = 4 * r + (side + k) % 4;
                    if (k > 1) data.positions[data.face_vertices[c]] = data.positions[data.face_vertices[from[k]]];
                    if (control.has_uvs()) data.uvs[c] = data.uvs[from[k]];
                }
            }
    try {
        return ControlMesh::build(std::move(data));
    } catch (const Error& error) {
        if (error.code() != ErrorCode::invalid_input) throw;
        throw Error(ErrorCode::unsupported,
                    "LOD cannot take this mesh by a dual scheme: two of the cells of its first level have two sides in "
                    "common; refine it once with the same scheme and start from there",
                    control.data().source);
    }
}

DualLimits::DualLimits(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules, int level,
                       const RunContext& context)
    : roots_(vertex_roots(control, scheme, rules)),
      level_(level + 1),
      midedge_(scheme.pieces == SurfacePieces::quadratic_box),
      source_(row_points(control, scheme, rules, &roots_, context, false)),
      to_a_point_(std::min(k_to_a_point, source_->max_level() - 1 - level_)),
      cells_(*source_, roots_) {}

VertexRoots::Corner DualLimits::corner(const Site& site) const {
    const std::uint32_t side = 1u << level_, end = side - 1;
    const int shift = level_ - 1 - site.level;
    const std::uint32_t x = site.at.x << shift, y = site.at.y << shift;
    const std::array<LatticePoint, 4> turned{{{x, y}, {side - y, x}, {side - x, side - y}, {y, side - x}}};
    const LatticePoint at = turned[site.root.value % 4];
    const std::uint32_t right = at.x > end ? 1 : 0, up = at.y > end ? 1 : 0;
    return {{site.root.value / 4, {at.x - right, at.y - up}, static_cast<std::uint8_t>(level_)},
            static_cast<int>(up == 0 ? right : 3 - right)};
}

void DualLimits::points(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals) const {
    std::vector<Corner> corners(sites.size());
    std::ranges::transform(sites, corners.begin(), [&](const Site& site) { return corner(site); });
    points(corners, positions, normals);
}

/// @param normals  may be empty
void DualLimits::points(std::span<const Corner> corners, std::span<Vec3d> positions, std::span<Vec3d> normals) const {
    std::vector<VertexCell> around;
    std::vector<std::size_t> begin{0};
    for (const Corner& at : corners) {
        const VertexRoots::Fan fan = roots_.fan(at);
        // At a boundary or crease the points are those of its curve; a corner of the boundary stays where it is.
        const bool stays = fan.closed ? fan.is_face() : fan.corners.size() <= 2;
        for (const Corner& c : fan.corners) {
            VertexCell cell = c.cell;
            if (!stays) {
                const std::uint32_t last = (1u << to_a_point_) - 1;
                cell.level = static_cast<std::uint8_t>(cell.level + to_a_point_);
                cell.at.x = (cell.at.x << to_a_point_) + (c.corner == 1 || c.corner == 2 ? last : 0);
                cell.at.y = (cell.at.y << to_a_point_) + (c.corner >= 2 ? last : 0);
            }
            around.push_back(cell);
        }
        begin.push_back(around.size());
    }
    const std::vector<Site> cells = cell_sites(around);
    std::vector<Vec3d> found(cells.size());
    // Calls set(number of the corner, sum of what was found in the cells around it).
    const auto for_each_sum = [&](const auto& set) {
        for (std::size_t i = 0; i < corners.size(); ++i) {
            Vec3d sum(0);
            for (std::size_t k = begin[i]; k < begin[i + 1]; ++k) sum += found[k];
            set(i, sum);
        }
    };
    written_positions(*source_, cells, found);
    for_each_sum([&](std::size_t i, const Vec3d& sum) { positions[i] = sum / double(begin[i + 1] - begin[i]); });
    if (normals.empty()) return;
    source_->normals(cells, found);
    for_each_sum([&](std::size_t i, const Vec3d& sum) { normals[i] = unit_or_zero(sum); });
}

void DualLimits::bound(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    const std::uint32_t n = 1u << (level_ - 1);
    std::vector<Corner> lattice;  // of the whole corner cell
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x)
            lattice.push_back(corner({triangles[0].root, {x, y}, static_cast<std::uint8_t>(level_ - 1)}));
    std::vector<Vec3d> positions(lattice.size());
    points(lattice, positions, {});
    std::vector<VertexCell> squares;
    std::vector<DualPiece> pieces;
    for (const CellTriangle& triangle : triangles) {
        std::array<LatticePoint, 3> at;
        for (std::size_t k = 0; k < 3; ++k) {
            const Corner c = corner({triangle.root, triangle.corner[k], triangle.level});
            at[k] = {c.cell.at.x + (c.corner == 1 || c.corner == 2 ? 1 : 0), c.cell.at.y + (c.corner >= 2 ? 1 : 0)};
        }
        const LatticePoint low{std::min({at[0].x, at[1].x, at[2].x}), std::min({at[0].y, at[1].y, at[2].y})};
        squares.push_back({triangle.root.value / 4, low, static_cast<std::uint8_t>(level_)});
        DualPiece piece;
        for (std::size_t k = 0; k < 3; ++k) piece.at[k] = Vec2d(at[k].x - low.x, at[k].y - low.y);
        pieces.push_back(piece);
    }
    DualCells cells = cells_;
    cells.find(
        squares, [](double) {}, to_a_point_);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        double error = 0;
        const auto corner_at = [&](std::size_t k) {
            const LatticePoint& p = triangles[t].corner[k];
            return positions[std::size_t{p.y} * (n + 1) + p.x];
        };
        const auto distance = [&](std::span<const Vec3d> hull) {
            double squared = 0;
            for (const Vec3d& p : hull)
                squared = std::max(squared,
                                   nearest_on_triangle(p, corner_at(0), corner_at(1), corner_at(2)).squared_distance);
            return std::sqrt(squared);
        };
        // The surface lies in the hull of its control points.
        cells.visit(
            squares[t], pieces[t],
            [&](const Net9& net, const DualPiece& piece) {
                DualCells::for_each_polynomial(net, piece, midedge_, [&](const auto& polynomial, const auto&) {
                    error = std::max(error, distance(polynomial.points()));
                });
            },
            [&](std::span<const Vec3d> hull) { error = std::max(error, distance(hull)); }, to_a_point_);
        errors[t] = error;
    }
}

}  // namespace tetrakis::detail
