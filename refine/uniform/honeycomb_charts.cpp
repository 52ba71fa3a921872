#include "honeycomb_charts.hpp"

#include "../../hier/base/parallel.hpp"
#include "../attributes/seam_face.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// What the corners of a level are in the charts.
struct Partners {
    std::vector<std::uint32_t> partner;  ///< by half-edge
    std::vector<std::uint32_t> home;     ///< the control face that its origin lies in
};

/// Of the next level. The new corner of a face lies on one side of every seam, and all three half-edges that leave it
/// are its face's; an old vertex goes with the corner after it in a face.
Partners next_partners(const HexagonMesh& surface, const HexagonMesh& finer, const HexagonMesh& chart,
                       const HexagonMesh& finer_chart, const Partners& at) {
    Partners next;
    next.partner.resize(finer.halfedge_count());
    next.home.resize(finer.halfedge_count());
    const auto set = [&](std::uint32_t h, std::uint32_t partner, std::uint32_t home) {
        next.partner[h] = partner;
        next.home[h] = home;
    };
    for_each_index(surface.face_count(), [&](std::uint32_t f) {
        const std::uint32_t begin = surface.face_begin(f), end = begin + surface.face_size(f);
        std::uint32_t before = end - 1;
        for (std::uint32_t h = begin; h < end; before = h++) {
            const std::uint32_t p = at.partner[h], home = at.home[h];
            set(h, p, home);
            // The polygon of the edge has, one after the other, the half-edge's target, the corner there, and this one.
            set(finer.twin(h) + 1, finer_chart.twin(p) + 1, home);
            const std::uint32_t corner = finer.twin(before), there = finer_chart.twin(chart.prev(p));
            set(corner, there, home);
            set(corner - 1, there - 1, home);
        }
    });
    // Before them in a pentagon: half-edges whose edge is sharp.
    for (const HexagonMesh::Sharp& edge : surface.sharp_edges())
        for (const std::uint32_t h : {edge.number, surface.twin(edge.number)}) {
            if (h == HexagonMesh::none) continue;
            const std::uint32_t corner = finer.twin(h) + 1, origin = corner + 1 - k_pentagon_size, target = corner - 2;
            set(origin, finer_chart.next(next.partner[corner]), next.home[corner]);
            set(origin + 1, finer_chart.prev(next.partner[target]), next.home[target]);
        }
    return next;
}

}  // namespace

FollowedUvs follow_hexagons(SeamExtension charts, std::span<const HexagonMesh> levels) {
    const auto chart_faces = static_cast<std::size_t>(charts.mesh.face_count());
    HexagonMesh chart(charts.mesh, std::vector<std::uint32_t>(chart_faces));
    std::vector<Vec3d> points;
    for (const Vec2d& uv : charts.uvs) points.emplace_back(uv, 0);
    charts = {};
    Partners at;
    for (std::uint32_t f = 0; f < levels[0].face_count(); ++f)
        for (std::uint32_t h = levels[0].face_begin(f); h < levels[0].face_begin(f + 1); ++h) {
            at.partner.push_back(h);
            at.home.push_back(f);
        }
    for (std::size_t level = 1; level < levels.size(); ++level) {
        HexagonMesh finer = chart.finer(HexagonMesh::Use::levels);
        std::vector<Vec3d> finer_points(finer.vertex_count());
        chart.refine(points.data(), finer_points.data());
        at = next_partners(levels[level - 1], levels[level], chart, finer, at);
        chart = std::move(finer);
        points = std::move(finer_points);
    }
    const HexagonMesh& last = levels.back();
    FollowedUvs out{{points.begin(), points.end()},
                    std::vector<std::uint32_t>(last.halfedge_count()),
                    std::vector<std::uint32_t>(last.face_count())};
    for (std::uint32_t f = 0; f < last.face_count(); ++f) {
        const std::size_t begin = last.face_begin(f);
        const auto corner = [&](int i) { return begin + static_cast<std::size_t>(i); };
        out.control_face[f] = take_side(
            std::span(out.face_uvs).subspan(begin, last.face_size(f)), [&](int i) { return at.partner[corner(i)]; },
            [&](int i) {
                return SeamOrigin{at.home[corner(i)], 0};
            },
            [&](std::uint32_t p) { return chart.next(p); }, [&](std::uint32_t p) { return chart.origin(p); }, out.uvs);
    }
    return out;
}

}  // namespace tetrakis::detail
