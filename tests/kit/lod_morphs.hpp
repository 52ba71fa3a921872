#pragma once

#include "../../eval/lod/view.hpp"

#include "lod_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace tetrakis::test {

/// How far LOD alone moves vertices from one update to the next, in pixels. A vertex that comes or goes is on the edge
/// that it halves before and after. Counted is what both cameras see.
struct MorphWatch {
    double moved = 0, came = 0, gone = 0;  ///< the largest motion of vertices that stay, come, go
    double came_off = 0, gone_off = 0;     ///< how far those that come or go are from the edge as it is shown
    double beyond = -1;                    ///< the largest motion less what the lemma in eval/lod/README.md allows
    double shown_off = 0;  ///< how far a vertex is shown from its place, as a part of what the lemma allows
    double edge_off = 0;   ///< how far an edge is from the vertex that halves it, as a part of its error
    std::size_t came_count = 0, gone_count = 0, edge_count = 0;

    void look(const lod::View& view, const lod::Update& update, const lod::Camera& camera) {
        const Sight sight(camera), sight_before(camera_);
        const auto place = [](const std::array<float, 3>& p) { return Vec3d(p[0], p[1], p[2]); };
        const auto shown = [&](const lod::Vertex& v) { return shown_position(v, camera.eye, update.morph_scale); };
        const auto pixels = [&](const lod::Vertex& v, const Vec3d& from, const Vec3d& to) {
            const Vec3d at = place(v.position);
            const bool is_seen = sight.sees(at) && sight_before.sees(at);
            return is_seen ? glm::length(to - from) * sight.pixels / glm::length(at - camera.eye) : 0;
        };
        // The lemma is about edges no farther away than the error.
        const auto far = [&](const lod::Vertex& v) {
            return v.error > 0 ? glm::length(place(v.position) - place(v.on_edge)) / double{v.error} : 0;
        };
        const auto compare = [&](const lod::Vertex& v, const Vec3d& from, double& largest) {
            const double motion = pixels(v, from, shown(v));
            largest = std::max(largest, motion);
            const Vec3d at = place(v.position);
            const double ratio =
                glm::length(at - camera_.eye) / glm::length(at - camera.eye) * update.morph_scale / scale_;
            const double allowed = update.pixel_error / (1 - lod::k_morph_begin) * std::abs(ratio - 1);
            beyond = std::max(beyond, motion - allowed * std::max(1.0, far(v)));
        };
        // How far a vertex is from an edge between two of its neighbours that passes on_edge.
        const auto off_edge = [&](const lod::Vertex& v, const std::vector<lod::Vertex>& ring, double& largest) {
            const Vec3d on_edge = place(v.on_edge);
            for (const lod::Vertex& a : ring)
                for (const lod::Vertex& b : ring) {
                    const Vec3d to_a = place(a.position) - on_edge, to_b = place(b.position) - on_edge;
                    if (glm::dot(to_a, to_b) > -(1 - 1e-6) * glm::length(to_a) * glm::length(to_b)) continue;
                    ++edge_count;
                    const Vec3d from = shown(a), along = shown(b) - from;
                    const double t = glm::dot(on_edge - from, along) / glm::dot(along, along);
                    largest = std::max(largest, pixels(v, on_edge, from + t * along));
                }
        };
        Shown now(view);
        std::vector<std::uint32_t> came_now, gone_now;
        for (const auto& [key, number] : now.at) {
            const lod::Vertex& v = now.vertices[number];
            edge_off = std::max(edge_off, far(v));
            const double off = pixels(v, place(v.position), shown(v));
            shown_off = std::max(shown_off, off / (update.pixel_error * std::max(1.0, far(v))));
            if (before_.at.empty()) continue;
            if (const auto old = before_.at.find(key); old != before_.at.end()) {
                compare(v, shown_position(before_.vertices[old->second], camera_.eye, scale_), moved);
                continue;
            }
            came_now.push_back(number);
            compare(v, place(v.on_edge), came);
        }
        for (const auto& [key, number] : before_.at) {
            if (now.at.contains(key)) continue;
            gone_now.push_back(number);
            const lod::Vertex& v = before_.vertices[number];
            gone = std::max(gone, pixels(v, place(v.on_edge), shown(v)));
        }
        came_count += came_now.size();
        gone_count += gone_now.size();
        for (const auto& [number, ring] : now.rings(came_now)) off_edge(now.vertices[number], ring, came_off);
        for (const auto& [number, ring] : before_.rings(gone_now)) off_edge(before_.vertices[number], ring, gone_off);
        before_ = std::move(now);
        camera_ = camera;
        scale_ = update.morph_scale;
    }

  private:
    /// What a view shows.
    struct Shown {
        std::vector<lod::Vertex> vertices;
        std::vector<lod::Triangle> triangles;
        std::map<std::array<float, 3>, std::uint32_t> at;  ///< vertices in use, by place

        Shown() = default;
        explicit Shown(const lod::View& view)
            : vertices(view.vertices().begin(), view.vertices().end()), triangles(used(view)) {
            std::vector<char> is_known(vertices.size(), 0);
            for (const lod::Triangle& t : triangles)
                for (const std::uint32_t v : t)
                    if (std::exchange(is_known[v], 1) == 0) at.emplace(vertices[v].position, v);
        }
        /// The neighbours of some vertices.
        std::map<std::uint32_t, std::vector<lod::Vertex>> rings(const std::vector<std::uint32_t>& of) const {
            std::vector<char> is_wanted(vertices.size(), 0);
            for (const std::uint32_t v : of) is_wanted[v] = 1;
            std::map<std::uint32_t, std::vector<lod::Vertex>> result;
            for (const lod::Triangle& t : triangles)
                for (std::size_t k = 0; k < 3; ++k)
                    if (is_wanted[t[k]] != 0)
                        for (const std::size_t other : {k + 1, k + 2}) result[t[k]].push_back(vertices[t[other % 3]]);
            return result;
        }
    };
    Shown before_;
    lod::Camera camera_;
    double scale_ = 0;
};

}  // namespace tetrakis::test
