#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/site.hpp"
#include "tetrakis/schemes/scheme_kind.hpp"

#include <array>
#include <cstdint>
#include <vector>

// Which sites the face corners of a uniformly refined mesh are, from the documented order of its faces.
namespace tetrakis::test {

/// Sites of all face corners of refine_uniform(mesh, scheme, levels), in the order of `face_vertices`; holes left out.
/// Catmull-Clark: levels >= 1.
inline std::vector<Site> uniform_sites(const ControlMesh& mesh, SchemeKind scheme, int levels) {
    struct Point {
        std::uint32_t x, y;
    };
    const bool quads = scheme == SchemeKind::catmull_clark;
    const int depth = quads ? levels - 1 : levels;
    std::vector<Site> sites;
    const auto emit = [&](HalfedgeId root, std::vector<Point> corners) {
        std::vector<std::vector<Point>> faces = {std::move(corners)};
        for (int l = 0; l < depth; ++l) {
            std::vector<std::vector<Point>> finer;
            for (auto face : faces) {
                const std::size_t n = face.size();
                for (Point& p : face) p = {2 * p.x, 2 * p.y};
                const auto middle = [&](std::size_t i) {
                    const Point &a = face[i % n], &b = face[(i + 1) % n];
                    return Point{(a.x + b.x) / 2, (a.y + b.y) / 2};
                };
                const Point centre{(face[0].x + face[2].x) / 2, (face[0].y + face[2].y) / 2};
                for (std::size_t i = 0; i < n; ++i) {
                    if (quads)
                        finer.push_back({face[i], middle(i), centre, middle(i + 3)});
                    else
                        finer.push_back({face[i], middle(i), middle(i + 2)});
                }
                if (!quads) finer.push_back({middle(0), middle(1), middle(2)});
            }
            faces = std::move(finer);
        }
        for (const auto& face : faces)
            for (const Point& p : face) sites.push_back({root, {p.x, p.y}, static_cast<std::uint8_t>(depth)});
    };
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        if (mesh.is_hole(FaceId(f))) continue;
        const HalfedgeId first = mesh.face_halfedge(FaceId(f));
        if (!quads) emit(first, {{0, 0}, {1, 0}, {0, 1}});
        for (std::uint32_t i = 0; quads && i < mesh.face_size(FaceId(f)); ++i)
            emit(HalfedgeId(first.value + i), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    }
    return sites;
}

}  // namespace tetrakis::test
