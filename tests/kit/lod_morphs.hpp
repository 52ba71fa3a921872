#pragma once

#include "../../eval/lod/view.hpp"

#include "lod_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace tetrakis::test {

/// How far LOD alone moves vertices that the camera sees from one update to the next, in pixels. A vertex that comes or
/// goes is on the edge that it halves before and after.
struct MorphWatch {
    double moved = 0;            ///< the largest motion of those that stay
    double came = 0, gone = 0;   ///< of those that come, and that go
    double beyond = -1;          ///< the largest motion less what view.hpp promises of it
    double ends = 0;             ///< how far the ends of an edge are from their places as a vertex comes to it
    double q_ = 0;
    std::size_t came_count = 0, gone_count = 0, end_count = 0;

    void look(const lod::View& view, const lod::Update& update, const lod::Camera& camera) {
        const Sight sight(camera);
        const auto place = [](const std::array<float, 3>& p) { return Vec3d(p[0], p[1], p[2]); };
        const auto shown = [&](const lod::Vertex& v) { return shown_position(v, camera.eye, update.morph_scale); };
        const auto pixels = [&](const lod::Vertex& v, const Vec3d& from, const Vec3d& to) {
            const Vec3d at = place(v.position);
            return sight.sees(at) ? glm::length(to - from) * sight.pixels / glm::length(at - camera.eye) : 0;
        };
        const auto compare = [&](const lod::Vertex& v, const Vec3d& from, double& largest) {
            const double motion = pixels(v, from, shown(v));
            largest = std::max(largest, motion);
            const Vec3d at = place(v.position);
            const double change = glm::length(at - eye_) / glm::length(at - camera.eye) * update.morph_scale / scale_;
            const double promised = update.pixel_error / (1 - lod::k_morph_begin) * std::abs(change - 1);
            beyond = std::max(beyond, motion - promised);
        };
        std::map<Key, lod::Vertex> now;
        std::map<Key, std::vector<lod::Vertex>> around;  // those that come
        for (const auto& t : used(view))
            for (std::size_t k = 0; k < 3; ++k) {
                const lod::Vertex& v = view.vertices()[t[k]];
                now.emplace(v.position, v);
                if (v.error > 0) q_ = std::max(q_, glm::length(place(v.on_edge)-place(v.position))/v.error);
                if (before_.empty() || before_.contains(v.position)) continue;
                for (const std::size_t other : {k + 1, k + 2})
                    around[v.position].push_back(view.vertices()[t[other % 3]]);
            }
        for (const auto& [key, v] : now) {
            if (const auto old = before_.find(key); old != before_.end())
                compare(v, shown_position(old->second, eye_, scale_), moved);
            else if (!before_.empty())
                compare(v, place(v.on_edge), came);
        }
        for (const auto& [key, v] : before_) {
            if (now.contains(key)) continue;
            ++gone_count;
            gone = std::max(gone, pixels(v, place(v.on_edge), shown(v)));
        }
        for (const auto& [key, ring] : around) {
            ++came_count;
            const Vec3d on_edge = place(now.at(key).on_edge);
            for (const lod::Vertex& a : ring)
                for (const lod::Vertex& b : ring) {
                    // The edge passes on_edge.
                    const Vec3d p = place(a.position), q = place(b.position);
                    if (glm::dot(p - on_edge, q - on_edge) > -0.999 * glm::length(p - on_edge) * glm::length(q - on_edge)) continue;
                    ++end_count;
                    ends = std::max({ends, pixels(a, p, shown(a)), pixels(b, q, shown(b))});
                }
        }
        before_ = std::move(now);
        eye_ = camera.eye;
        scale_ = update.morph_scale;
    }

  private:
    using Key = std::array<float, 3>;
    std::map<Key, lod::Vertex> before_;
    Vec3d eye_{};
    double scale_ = 0;
};

}  // namespace tetrakis::test
