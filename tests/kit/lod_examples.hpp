#pragma once

#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/planet_surface.hpp"
#include "../../eval/lod_surfaces/procedural_surface.hpp"
#include "../../eval/lod_surfaces/subdivision_surface.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/lod_terrain/terrain_tiles.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../eval/terrain/height_source.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "judged_terrain.hpp"
#include "lod_walks.hpp"
#include "meshes.hpp"
#include "scratch_dir.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

/// One example of each kind of surface, for properties that views of all kinds must have.
namespace tetrakis::test {

inline constexpr const char* k_box_obj =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1.5\nf 4 3 2 1\nf 5 6 7 8\n"
    "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
inline constexpr const char* k_octahedron_obj =
    "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1.3\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\n"
    "f 4 2 6\nf 1 4 6\n";
inline constexpr const char* k_open_obj =
    "v 0 0 0\nv 1 0 0.4\nv 2 0 0\nv 0 1 0\nv 1 1 1\nv 2 1 0\nv 0 2 0.5\nv 1 2 0\nf 1 2 5 4\n"
    "f 2 3 6 5\nf 4 5 8 7\n";

inline ControlMesh control_mesh(const char* text) { return ControlMesh::build(parse_obj(text, "test.obj")); }

/// A torus about the z-axis.
class Torus final : public lod::SampledSurface {
  public:
    explicit Torus(const RunContext& context) : SampledSurface(ControlMesh::build(grid(6, false, true)), 3) {
        // Vertex v of the grid is at column v % 6, row v / 6.
        set_bounds(context);
    }
    static constexpr double k_large = 3, k_small = 1;

  private:
    Vec2d parameters(const Site& site) const {
        const auto at = [&](HalfedgeId h) {
            const std::uint32_t v = roots().origin(h).value;
            return Vec2d(v % 6, v / 6);
        };
        const auto near = [](double a, double b) { return b + std::remainder(a - b, 6.0); };
        const Vec2d v = at(site.root), next = at(roots().next(site.root)), prev = at(roots().prev(site.root));
        const double x = std::ldexp(site.at.x, -site.level - 1), y = std::ldexp(site.at.y, -site.level - 1);
        const Vec2d ahead(near(next.x, v.x) - v.x, near(next.y, v.y) - v.y),
            aside(near(prev.x, v.x) - v.x, near(prev.y, v.y) - v.y);
        return (v + x * ahead + y * aside) * (2 * M_PI / 6);
    }
    static Vec3d out(const Vec2d& p) {
        return {std::cos(p.x) * std::cos(p.y), std::sin(p.x) * std::cos(p.y), std::sin(p.y)};
    }
    void positions(std::span<const Site> sites, std::span<Vec3d> positions) const override {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec2d p = parameters(sites[i]);
            positions[i] = k_large * Vec3d(std::cos(p.x), std::sin(p.x), 0) + k_small * out(p);
        }
    }
    void shade(std::span<const Site> sites, std::span<lod::Place> places) const override {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            places[i].normal = out(parameters(sites[i]));
            places[i].uv = parameters(sites[i]) / (2 * M_PI);
        }
    }
    void finest_errors(HalfedgeId, std::span<float> errors) const override {
        // Half the largest second derivative times the square of half the longest side.
        const double step = 2 * M_PI / 6 / 16;
        std::ranges::fill(errors, static_cast<float>(0.5 * (k_large + 2 * k_small) * step * step / 2));
    }
};

inline HeightGrid wave_map(std::uint32_t columns, std::uint32_t rows, double height) {
    return grid_of(columns, rows, [&](double c, double r) {
        return height * std::sin(6 * M_PI * (c + 0.5) / columns) * std::sin(2 * M_PI * r / rows) +
               0.2 * height * std::sin(20 * M_PI * (c + 0.5) / columns + r);
    });
}

inline std::array<HeightGrid, 6> cube_faces(std::uint32_t side) {
    std::array<HeightGrid, 6> faces;
    for (std::size_t f = 0; f < 6; ++f)
        faces[f] = grid_of(side, side, [&](double c, double r) {
            // Zero at the edges, where faces meet.
            return 0.3 * std::sin(M_PI * c / (side - 1)) * std::sin(M_PI * r / (side - 1)) * std::sin(c * r + f);
        });
    return faces;
}

/// A tiled terrain with all tiles in memory.
inline std::shared_ptr<const lod::Surface> loaded_tiles(const HeightGrid& grid, const RunContext& context) {
    const ScratchDir dir;
    lod::write_tiles(*make_height_source(grid), dir / "t.tiles", {.side = 16, .context = context});
    auto terrain = std::make_shared<const lod::TiledTerrain>(dir / "t.tiles");
    lod::View everything(*terrain);
    while (everything.update({}, {.pixel_error = 1e-12}).waiting > 0) terrain->wait(terrain->revision());
    return terrain;
}

struct Example {
    std::string name;
    std::shared_ptr<const lod::Surface> surface;
    Vec3d middle;
    double size;
    std::int64_t euler;
};

/// @param context  for the threads that make the surfaces
inline std::vector<Example> examples(const RunContext& context = {}) {
    std::vector<Example> all;
    const auto add = [&](const char* name, std::shared_ptr<const lod::Surface> surface, const Vec3d& middle,
                         double size, std::int64_t euler) {
        all.push_back({name, std::move(surface), middle, size, euler});
    };
    add("terrain", std::make_shared<lod::TerrainSurface>(rough(65, 40, 3), context), {32, -20, 0}, 30, 1);
    add("strip", std::make_shared<lod::TerrainSurface>(rough(300, 2, 3), context), {150, -0.5, 0}, 40, 1);
    add("tiles", loaded_tiles(rough(60, 45, 3), context), {30, -22, 0}, 30, 1);
    std::mt19937 random(1);
    add("noise",
        std::make_shared<lod::TerrainSurface>(
            grid_of(59, 37, [&](double, double) { return 0.02 * double(random() % 8); }), context),
        {32, -16, 0}, 30, 1);
    add("torus", std::make_shared<Torus>(context), {0, 0, 0}, 4, 0);
    add("planet",
        std::make_shared<lod::PlanetSurface>(wave_map(64, 32, 0.4),
                                             lod::PlanetOptions{.radius = 10, .context = context}),
        {0, 0, 0}, 10, 2);
    add("planet of faces",
        std::make_shared<lod::PlanetSurface>(cube_faces(17), lod::PlanetOptions{.radius = 5, .context = context}),
        {0, 0, 0}, 5, 2);
    const ControlMesh box = control_mesh(k_box_obj), open = control_mesh(k_open_obj),
                      octahedron = control_mesh(k_octahedron_obj);
    const auto add_scheme = [&](const char* scheme, const ControlMesh& mesh, const Vec3d& middle, std::int64_t euler) {
        add(scheme,
            std::make_shared<lod::SubdivisionSurface>(mesh, scheme,
                                                      lod::SubdivisionSurfaceOptions{.level = 3, .context = context}),
            middle, 1.5, euler);
    };
    for (const char* scheme : {"catmull-clark", "kobbelt", "bilinear", "midedge"})
        add_scheme(scheme, box, {0, 0, 0}, 2);
    for (const char* scheme : {"catmull-clark", "kobbelt", "bilinear", "doo-sabin"})
        add_scheme(scheme, open, {1, 1, 0}, 1);
    add_scheme("loop", octahedron, {0, 0, 0}, 2);
    add("displaced",
        std::make_shared<lod::SubdivisionSurface>(
            box, "catmull-clark",
            lod::SubdivisionSurfaceOptions{
                .level = 3,
                .displacement = [](const lod::Place& p) { return 0.05 * std::sin(9 * p.position.x + p.position.y); },
                .context = context}),
        {0, 0, 0}, 1.5, 2);
    add("fractal plane",
        std::make_shared<lod::ProceduralSurface>(lod::ProceduralSurface::plane(100, 1, lod::fractal_heights(5, 60, 3))),
        {0, 0, 0}, 50, 1);
    add("fractal ball",
        std::make_shared<lod::ProceduralSurface>(lod::ProceduralSurface::ball(50, 2, lod::fractal_heights(2, 60, 3))),
        {0, 0, 0}, 50, 2);
    return all;
}

/// A camera that circles the middle of an example, moves nearer and farther, and jumps every 25 frames.
inline lod::Camera wander(const Example& example, std::mt19937& random, int frame, double& turn, double& away) {
    std::uniform_real_distribution<double> one(0, 1);
    if (frame % 25 == 0) {
        turn = 6.28 * one(random);
        away = example.size * (1.2 + 3 * one(random));
    }
    turn += 0.05;
    away = std::max(1.1 * example.size, away * (0.9 + 0.2 * one(random)));
    lod::Camera camera;
    const Vec3d out(std::cos(turn), std::sin(turn), 0.5 * std::sin(2 * turn) + 0.2);
    camera.eye = example.middle + away * glm::normalize(out);
    camera.direction = -out + 0.3 * Vec3d(one(random), one(random), one(random));
    camera.width = 640;
    camera.height = 480;
    return camera;
}

/// Largest motions of vertices by LOD alone from one update to the next, in pixels. A vertex appears on the edge that
/// it halves, and disappears there. Only vertices that both cameras see count.
struct MorphWatch {
    double moved = 0, came = 0, gone = 0;  ///< largest motion of vertices that stay, appear, disappear
    double came_off = 0, gone_off = 0;     ///< distance of appearing, disappearing vertices from their edge as shown
    double beyond = -1;    ///< largest excess of a motion over the bound of the lemma in eval/lod/README.md
    double shown_off = 0;  ///< distance of a vertex as shown from its position, relative to the lemma's bound
    double edge_off = 0;   ///< distance of an edge from the vertex that halves it, relative to the vertex's error
    std::size_t came_count = 0, gone_count = 0, edge_count = 0;

    /// The next update is not compared with the last one.
    void look_away() { before_ = {}; }
    void look(const lod::View& view, const lod::Update& update, const lod::Camera& camera) {
        const Sight sight(camera), sight_before(camera_);
        const auto place = [](const std::array<float, 3>& p) { return Vec3d(p[0], p[1], p[2]); };
        const auto shown = [&](const lod::Vertex& v) { return shown_position(v, camera.eye, update.morph_scale); };
        const auto pixels = [&](const lod::Vertex& v, const Vec3d& from, const Vec3d& to) {
            const Vec3d at = place(v.position);
            const bool is_seen = sight.sees(at) && sight_before.sees(at);
            return is_seen ? glm::length(to - from) * sight.pixels / glm::length(at - camera.eye) : 0;
        };
        // The lemma assumes that this ratio is at most 1.
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
        // Distance of a vertex from the edges as shown between two of its neighbours that contain on_edge.
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
    /// Copy of a view's vertices and used triangles.
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
        /// Neighbours of each of the vertices `of`, in no order.
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
