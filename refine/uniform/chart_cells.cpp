#include "chart_cells.hpp"

#include "../attributes/seam_face.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis::detail {

ControlMesh chart_mesh(const SeamExtension& charts) {
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

namespace {

/// The cells of the chart beside those of the surface.
class CellFollower {
  public:
    CellFollower(const RootNet& surface, const RootNet& chart, const ChartCorners& corners, std::uint32_t segments,
                 const RootNet::Faces& faces, std::vector<Vec2d>& uvs)
        : surface_(surface),
          chart_(chart),
          corners_(corners),
          at_(chart.layout(segments)),
          numbers_(chart.point_numbers(at_)),
          faces_(faces),
          uvs_(uvs),
          n_(segments) {}

    std::optional<CellUvs> run() {
        if (!find_roots()) return std::nullopt;
        out_.face_uvs.reserve(faces_.vertices.size());
        out_.control_face.reserve(faces_.control.size());
        // In the order of RootNet::faces().
        const MeshLevel& base = surface_.base();
        for (std::uint32_t r = 0; r < base.face_count; ++r)
            for (std::uint32_t y = 0; y + 1 < n_; ++y)
                for (std::uint32_t x = 0; x + 1 < n_; ++x) {
                    for (const auto& [i, k] : {std::pair(0u, 0u), {1u, 0u}, {1u, 1u}, {0u, 1u}})
                        add(chart_.number_at(at_, root_[r], {x + i, y + k}));
                    out_.control_face.push_back(home_[r].home);
                }
        bool whole = true;
        surface_.for_each_inner_edge([&](std::uint32_t h) { whole = whole && across(h); });
        surface_.for_each_inner_vertex([&](std::uint32_t h) { whole = whole && around(h); });
        if (!whole) return std::nullopt;
        return std::move(out_);
    }

  private:
    static constexpr std::uint32_t none = RootNet::none;

    std::uint32_t there(std::uint32_t h) const { return 4 * root_[h / 4] + h % 4; }
    void add(std::uint32_t place) { out_.face_uvs.push_back(numbers_.of(place)); }

    /// Those beyond boundaries and creases, beside earlier ones.
    bool find_roots() {
        const MeshLevel &base = surface_.base(), &charts = chart_.base();
        if (surface_.own_roots() > chart_.own_roots() || surface_.own_roots() != corners_.partner.size()) return false;
        // What a crease shrinks to is the last corner of the root at a dart, which has no side on the boundary.
        const auto at_dart = [](const RootNet& net, std::uint32_t r) {
            return net.base().twin[4 * r + 2] != none &&
                   std::ranges::binary_search(net.crease_ends(), net.base().origin[4 * r + 3]);
        };
        for (std::uint32_t r = 0; r < base.face_count; ++r) {
            if (r < surface_.own_roots()) {
                if (corners_.partner[r] < 0) return false;
                root_.push_back(static_cast<std::uint32_t>(corners_.partner[r]));
                home_.push_back({static_cast<std::uint32_t>(corners_.home[r]),
                                 corners_.corner.empty() ? 0 : static_cast<std::uint32_t>(corners_.corner[r])});
                continue;
            }
            // A corner goes with the edge that starts there.
            const std::uint32_t side = base.twin[4 * r] / 4 < surface_.own_roots() ? 0 : 3,
                                at = base.twin[4 * r + side], beside = charts.twin[there(at)];
            if (beside == none || beside % 4 != side || beside / 4 < chart_.own_roots()) return false;
            if (at_dart(surface_, r) != at_dart(chart_, beside / 4)) return false;
            root_.push_back(beside / 4);
            home_.push_back(home_[at / 4]);
        }
        return true;
    }

    bool across(std::uint32_t h) {
        const MeshLevel &base = surface_.base(), &charts = chart_.base();
        const std::uint32_t t = base.twin[h];
        std::uint32_t ch = there(h), ct = there(t), home = std::min(home_[h / 4].home, home_[t / 4].home);
        if (charts.twin[ch] != ct) {
            // A seam: two corners on either side.
            if (home_[h / 4] == home_[t / 4]) return false;
            const bool here = home_[h / 4] < home_[t / 4];
            if (here)
                ct = charts.twin[ch];
            else
                ch = charts.twin[ct];
            if (ch == none || ct == none) return false;
            home = home_[(here ? h : t) / 4].home;
        }
        out_.control_face.insert(out_.control_face.end(), n_ - 1, home);
        for (std::uint32_t j = 1; j < n_; ++j) {
            add(chart_.number(at_, ct, n_ - j, 0));
            add(chart_.number(at_, ct, n_ - 1 - j, 0));
            add(chart_.number(at_, ch, j, 0));
            add(chart_.number(at_, ch, j - 1, 0));
        }
        return true;
    }

    bool around(std::uint32_t first) {
        const MeshLevel &base = surface_.base(), &charts = chart_.base();
        ring_.clear();
        std::uint32_t h = first;
        do {
            ring_.push_back(h);
            h = base.twin[base.prev(h)];
        } while (h != first);
        const int size = static_cast<int>(ring_.size());
        const auto corner = [&](int i) { return ring_[static_cast<std::size_t>(i)]; };
        const auto turned = [&](std::uint32_t c) { return charts.twin[charts.prev(c)]; };
        const auto home = [&](int i) { return home_[corner(i) / 4].home; };
        const SeamRun run = longest_run(
            size, [&](int i) { return turned(there(corner(i))) == there(corner((i + 1) % size)); },
            [&](int i) { return home_[corner(i) / 4]; });
        if (run.tied) return false;
        const std::size_t begin = out_.face_uvs.size();
        for (const std::uint32_t c : ring_) add(chart_.number(at_, there(c), 0, 0));
        out_.control_face.push_back(home_of(run, size, home));
        if (run.size == size) return true;
        beyond_.clear();
        const std::uint32_t start = there(corner(run.first));
        for (std::uint32_t c = turned(there(corner((run.first + run.size - 1) % size))); c != start; c = turned(c)) {
            if (c == none) return false;
            beyond_.push_back(numbers_.of(chart_.number(at_, c, 0, 0)));
        }
        continue_uvs(run, beyond_, std::span(out_.face_uvs).subspan(begin), uvs_);
        return true;
    }

    const RootNet &surface_, &chart_;
    const ChartCorners& corners_;
    RootLayout at_;
    RootNet::Numbers numbers_;
    const RootNet::Faces& faces_;
    std::vector<Vec2d>& uvs_;
    std::uint32_t n_;
    std::vector<std::uint32_t> root_;  ///< of the chart, for each of the surface
    std::vector<SeamOrigin> home_;     ///< and the corner on whose side of seams it is
    std::vector<std::uint32_t> ring_, beyond_;
    CellUvs out_;
};

}  // namespace

std::optional<CellUvs> cell_uvs(const RootNet& surface, const RootNet& chart, const ChartCorners& corners,
                                std::uint32_t segments, const RootNet::Faces& faces, std::vector<Vec2d>& uvs) {
    return CellFollower(surface, chart, corners, segments, faces, uvs).run();
}

}  // namespace tetrakis::detail
