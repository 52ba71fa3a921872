#include "dual_charts.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../attributes/followed_uvs.hpp"
#include "../attributes/seam_extension.hpp"
#include "../points/row_points.hpp"
#include "../points/vertex_links.hpp"
#include "../rules/triangle_cut.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_unknown = VertexRoots::outside;

[[noreturn]] void refuse(const ControlMesh& mesh, const char* why) {
    throw Error(ErrorCode::unsupported, std::string("the charts of the texture coordinates ") + why,
                mesh.data().source);
}

/// The extended charts as a control mesh; half-edges keep their numbers.
ControlMesh chart_mesh(const detail::SeamExtension& charts) {
    const RuleMesh& mesh = charts.mesh;
    ControlMeshData data;
    data.boundary_rule = BoundaryRule::edge_only;
    data.face_offsets = {0};
    for (const Vec2d& uv : charts.uvs) data.positions.emplace_back(uv.x, uv.y, 0.0);
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (const int v : mesh.corners(f)) data.face_vertices.push_back(static_cast<std::uint32_t>(v));
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (mesh.twin(h) == RuleMesh::none || !mesh.sharp(h)) continue;
        data.creases.push_back({static_cast<std::uint32_t>(mesh.origin(h)), static_cast<std::uint32_t>(mesh.target(h)),
                                mesh.sharpness(h)});
    }
    for (std::size_t v = 0; v < mesh.vertex_sharpness().size(); ++v)
        if (is_sharp(mesh.vertex_sharpness()[v]))
            data.corners.push_back({static_cast<std::uint32_t>(v), mesh.vertex_sharpness()[v]});
    return ControlMesh::build(std::move(data));
}

ControlMesh extended_charts(const ControlMesh& tagged, const SchemeInfo& scheme, const RuleOptions& rules) {
    const std::optional<ControlMesh> untagged = detail::without_ignored_tags(tagged, scheme, rules);
    const ControlMesh& mesh = untagged ? *untagged : tagged;
    return chart_mesh(detail::extend_over_seams(mesh, rule_mesh(mesh), scheme, rules));
}

/// Whether the surface ends at a side of a root: at a boundary or crease.
bool ends(const VertexRoots& roots, std::uint32_t place) {
    return roots.link[place] == VertexRoots::outside || (roots.crease[place / 4] >> place % 4 & 1) != 0;
}

VertexCell corner_cell(std::uint32_t root, std::uint32_t corner, std::uint8_t level) {
    const std::uint32_t last = (1u << level) - 1;
    return {root, {corner == 1 || corner == 2 ? last : 0, corner >= 2 ? last : 0}, level};
}

}  // namespace

DualCharts::DualCharts(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                       const VertexRoots& roots, const RunContext& context)
    : charts_(std::make_unique<ControlMesh>(extended_charts(mesh, scheme, rules))),
      roots_(vertex_roots(*charts_, scheme, rules)),
      points_(detail::row_points(*charts_, scheme, rules, &roots_, context, true)) {
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) root_.push_back(h);
    root_.resize(roots.count(), k_unknown);
    find_roots(roots);
}

// Roots of corners have the same numbers in both meshes. Roots along boundaries and creases are found across side 2
// from a known root; the remaining ones across side 1 or 2, whichever has the same control face.
void DualCharts::find_roots(const VertexRoots& roots) {
    const std::uint32_t corners = charts_->halfedge_count();
    const auto find_beside = [&](std::uint32_t r, std::uint32_t side) {
        const std::uint32_t beside = roots.link[4 * std::size_t{r} + side];
        const std::uint32_t there = 4 * root_[beside / 4] + beside % 4;
        const std::uint32_t found = ends(roots_, there) ? k_unknown : roots_.link[there];
        if (found == k_unknown || found % 4 != side || found / 4 < corners)
            refuse(*charts_, "end otherwise than the surface does");
        root_[r] = found / 4;
    };
    const auto known = [&](std::uint32_t r, std::uint32_t side) {
        return !ends(roots, 4 * r + side) && root_[roots.link[4 * std::size_t{r} + side] / 4] != k_unknown;
    };
    std::vector<std::uint32_t> above;
    for (std::uint32_t r = 0; r < roots.count(); ++r)
        if (root_[r] == k_unknown && known(r, 2)) above.push_back(r);
    for (const std::uint32_t r : above) find_beside(r, 2);
    for (std::uint32_t r = 0; r < roots.count(); ++r) {
        if (root_[r] != k_unknown) continue;
        if (!known(r, 1) || !known(r, 2)) refuse(*charts_, "end otherwise than the surface does");
        find_beside(r, roots.face[roots.link[4 * std::size_t{r} + 1] / 4] == roots.face[r] ? 1 : 2);
    }
    for (std::uint32_t r = 0; r < roots.count(); ++r)
        for (std::uint32_t side = 0; side < 4; ++side)
            if (ends(roots, 4 * r + side) != ends(roots_, 4 * root_[r] + side))
                refuse(*charts_, "end otherwise than the surface does");
}

/// Finds the cells of the charts at the corners of faces.
class DualCharts::Follower {
  public:
    Follower(const DualCharts& charts, const VertexForest& forest, DualFaces& faces)
        : charts_(charts), forest_(forest), faces_(faces) {
        cells_.resize(faces.corners.size());
    }

    detail::FaceUvs run(bool limit) {
        for (std::uint32_t f = 0; f < faces_.control_faces.size(); ++f) face(f);
        return detail::number_uvs(faces_.face_vertices, values(limit));
    }

  private:
    struct Corner {
        VertexCell cell;
        std::uint32_t at;            ///< the cell's corner at the face's point; 4 and above: the point is on a side
        std::uint32_t enter, leave;  ///< sides towards the corner before and the one after
    };
    /// A UV between two cells: the cell of a corner, and `other`.
    struct Between {
        std::size_t corner;
        VertexCell other;
        double along;
    };

    std::uint32_t there(std::uint32_t root) const { return charts_.root_[root]; }
    [[noreturn]] void refuse_end() const { refuse(*charts_.charts_, "do not go on beyond their seams"); }

    void face(std::uint32_t f) {
        const std::uint32_t begin = faces_.face_offsets[f];
        const int size = static_cast<int>(faces_.face_offsets[f + 1] - begin);
        corners_.clear();
        bool one_root = true;
        for (int i = 0; i < size; ++i) {
            const auto& [leaf, at] = faces_.corners[begin + static_cast<std::uint32_t>(i)];
            corners_.push_back({forest_.cell(leaf), at, at < 4u ? at : at - 4u, at < 4u ? (at + 3u) % 4u : at - 4u});
            one_root = one_root && corners_.back().cell.root == corners_.front().cell.root;
        }
        const auto corner = [&](int i) -> const Corner& { return corners_[static_cast<std::size_t>(i % size)]; };
        const auto cell = [&](int i) -> VertexCell& { return cells_[begin + static_cast<std::uint32_t>(i % size)]; };
        for (int i = 0; i < size; ++i) {
            cell(i) = corner(i).cell;
            cell(i).root = there(corner(i).cell.root);
        }
        if (one_root) return;
        const auto goes_on = [&](int i) {
            const Corner &a = corner(i), &b = corner(i + 1);
            if (a.cell.root == b.cell.root) return true;
            return charts_.roots_.link[4 * there(a.cell.root) + a.leave] == 4 * there(b.cell.root) + b.enter;
        };
        const auto home = [&](int i) { return forest_.roots().face[corner(i).cell.root].value; };
        const detail::SeamRun run = detail::longest_run(size, goes_on, home);
        if (run.size == size) return;
        if (const std::uint32_t r = corner(run.first).cell.root; forest_.roots().hole[r] == 0)
            faces_.control_faces[f] = FaceId(detail::home_of(run, size, home));

        if (!is_corner_of_root(corner(0))) {
            // The point is on a side of two roots; the chart's continuation takes the place of the other root.
            const auto side = static_cast<int>(corner(run.first + run.size).enter);
            for (int i = run.first + run.size; i < run.first + size; ++i) {
                VertexRoots::Across beside = forest_.roots().across(corner(i).cell, side);
                beside.cell.root = there(beside.cell.root);
                beside = charts_.roots_.across(beside.cell, beside.side);
                if (beside.kind != VertexRoots::Across::Kind::neighbour) refuse_end();
                cell(i) = beside.cell;
            }
            return;
        }
        const VertexRoots::Fan fan = charts_.roots_.fan({cell(run.first), static_cast<int>(corner(run.first).at)});
        if (!fan.closed) refuse_end();
        const int beyond = static_cast<int>(fan.corners.size()) - run.size;
        detail::for_each_beyond(run, size, beyond, [&](int i, std::size_t k, double along) {
            const auto at = [&](std::size_t b) {
                const auto& [seen, number] = fan.corners[static_cast<std::size_t>(run.size) + b];
                return corner_cell(seen.root, static_cast<std::uint32_t>(number), corner(i).cell.level);
            };
            cell(i) = at(along == 1 ? k + 1 : k);
            if (along != 0 && along != 1)
                between_.push_back({begin + static_cast<std::uint32_t>(i % size), at(k + 1), along});
        });
    }

    static bool is_corner_of_root(const Corner& c) {
        return c.at < 4 && c.cell == corner_cell(c.cell.root, c.at, c.cell.level);
    }

    /// UVs per face corner.
    std::vector<Vec2d> values(bool limit) {
        const std::size_t corners = cells_.size();
        for (const Between& b : between_) cells_.push_back(b.other);
        std::vector<VertexCell> once = cells_;
        oneapi::tbb::parallel_sort(once.begin(), once.end());
        once.erase(std::unique(once.begin(), once.end()), once.end());
        std::vector<Vec3d> points(once.size());
        if (limit)
            charts_.points_->limit_positions(cell_sites(once), points);
        else
            written_positions(*charts_.points_, cell_sites(once), points);
        const auto value = [&](std::size_t i) {
            return Vec2d(
                points[static_cast<std::size_t>(std::lower_bound(once.begin(), once.end(), cells_[i]) - once.begin())]);
        };
        std::vector<Vec2d> values(corners);
        for_each_index(static_cast<std::uint32_t>(corners), [&](std::uint32_t i) { values[i] = value(i); });
        for (std::size_t b = 0; b < between_.size(); ++b) {
            Vec2d& v = values[between_[b].corner];
            v = (1 - between_[b].along) * v + between_[b].along * value(corners + b);
        }
        return values;
    }

    const DualCharts& charts_;
    const VertexForest& forest_;
    DualFaces& faces_;
    std::vector<VertexCell> cells_;  ///< per face corner
    std::vector<Between> between_;
    std::vector<Corner> corners_;  ///< of a face
};

detail::FaceUvs DualCharts::uvs(const VertexForest& forest, DualFaces& faces, bool limit) const {
    return Follower(*this, forest, faces).run(limit);
}

void detail::cut_into_triangles(DualFaces& faces, std::vector<std::uint32_t>* face_uvs) {
    const TriangleCut cut = cut_polygons(faces.face_offsets, faces.diagonal_at_first);
    faces.face_offsets = cut.offsets();
    pick(cut.corners, faces.face_vertices);
    pick(cut.faces, faces.control_faces);
    faces.corners.clear();
    if (face_uvs != nullptr) pick(cut.corners, *face_uvs);
}

}  // namespace tetrakis
