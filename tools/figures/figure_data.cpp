// Data for tools/figures.py that the program does not make: meshes refined in one place by any scheme, and curves.
//   figure_data picture MESH CONTROL.obj OUT.png WIDTH HEIGHT AZIMUTH ELEVATION [edges]
//                                            the mesh with the control mesh's edges, dashed where they are hidden;
//                                            "edges": CONTROL has the mesh's own edges, hidden ones are left out
//   figure_data curves                       prints the curves as JSON
//   figure_data adaptive, zoom, simplify     see the functions of these names
#include "../tetrakis/schemes/canvas.hpp"

#include "../../eval/distance/triangle_bvh.hpp"
#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/render/render.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/attributes/used_values.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/curves/curve.hpp"

#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#ifdef TETRAKIS_FIGURES_SIMPLIFY
#    include <meshoptimizer.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace tetrakis;
using Json = nlohmann::json;
using Arguments = std::vector<std::string>;

Json points(const std::vector<Vec3d>& positions) {
    Json list = Json::array();
    for (const Vec3d& p : positions) list.push_back({p.x, p.y, p.z});
    return list;
}

Json picture(const Arguments& arguments) {
    if (arguments.size() < 7)
        throw std::invalid_argument("picture: MESH CONTROL.obj OUT.png WIDTH HEIGHT AZIMUTH ELEVATION [edges]");
    const bool own_edges = arguments.size() > 7 && arguments[7] == "edges";
    const TriangleMesh mesh = read_triangle_mesh(arguments[0]);
    const ControlMesh control = load_control_mesh(arguments[1]);
    const std::vector<Vec3d>& corners = control.data().positions;
    RenderOptions options;
    if (own_edges) options.shading = Shading::flat;
    options.width = std::stoi(arguments[3]);
    options.height = std::stoi(arguments[4]);
    options.view.azimuth_degrees = std::stod(arguments[5]);
    options.view.elevation_degrees = std::stod(arguments[6]);
    std::vector<Vec3d> all = mesh.positions;
    all.insert(all.end(), corners.begin(), corners.end());
    const double aspect = static_cast<double>(options.width) / options.height;
    const Camera camera = fit_camera(all, aspect, options.view);
    options.camera = camera;

    cli::Canvas canvas(options.width, options.height);
    canvas.paste(0, 0, render(mesh, options));
    const Vec3d forward = glm::normalize(camera.target - camera.eye);
    const Vec3d right = glm::normalize(glm::cross(forward, camera.up)), above = glm::cross(right, forward);
    const double scale = options.height / (2 * std::tan(glm::radians(camera.vertical_fov_degrees) / 2));
    const auto project = [&](const Vec3d& p) {
        const Vec3d d = p - camera.eye;
        const double z = glm::dot(d, forward);
        return Vec2d(0.5 * options.width + scale * glm::dot(d, right) / z,
                     0.5 * options.height - scale * glm::dot(d, above) / z);
    };
    // Parts of edges behind the surface are dashed, or left out.
    constexpr int k_dash = 3;
    constexpr double k_touching = 1e-4;  // relative to a point's distance: the point may lie on the surface itself
    const TriangleBvh bvh(mesh);
    const int pieces = own_edges ? 8 : 80;
    const Vec3f ink(0.12f, 0.20f, 0.36f), faint(0.36f, 0.38f, 0.42f);
    for (std::uint32_t e = 0; e < control.edge_count(); ++e) {
        const HalfedgeId h = control.edge_halfedge(EdgeId(e));
        const Vec3d from = corners[control.origin(h).value], to = corners[control.target(h).value];
        const auto at = [&](double piece) { return from + piece / pieces * (to - from); };
        for (int i = 0; i < pieces; ++i) {
            const bool hidden = bvh.occluded(camera.eye, at(i + 0.5) - camera.eye, 0, 1 - k_touching);
            if (!hidden || (!own_edges && i / k_dash % 2 == 0))
                canvas.line(project(at(i)), project(at(i + 1)),
                            own_edges ? 0.6
                            : hidden  ? 0.9
                                      : 1.7,
                            hidden ? faint : ink);
        }
    }
    write_png(arguments[2], canvas.image());
    return {};
}

Json curves(const Arguments&) {
    constexpr double k_tolerance = 1e-4;
    Json json;
    const CurvePoints bezier{{0, 0, 0}, {0.6, 1.9, 0}, {2.4, 2.1, 0}, {3, 0.2, 0}};
    const BezierHalves halves = split_bezier(bezier);
    const BezierHalves quarters = split_bezier(halves.first);
    json["bezier"] = {{"control", points(bezier)},
                      {"first", points(halves.first)},
                      {"second", points(halves.second)},
                      {"first_first", points(quarters.first)},
                      {"first_second", points(quarters.second)},
                      {"curve", points(adaptive_bezier(bezier, k_tolerance).points)}};
    const CurvePoints control{{0, 0, 0}, {0.3, 1.6, 0}, {1.3, 1.9, 0}, {1.6, 0.3, 0}, {2.7, 0.1, 0}, {3, 1.8, 0}};
    for (int degree = 1; degree <= 4; ++degree) {
        json["bspline"].push_back(
            {{"degree", degree},
             {"control", points(control)},
             {"step", points(bspline_step(control, degree, CurveTopology::open))},
             {"curve",
              points(adaptive_bspline(control, degree, CurveTopology::open, CurveEnds::plain, k_tolerance).points)},
             {"closed",
              points(adaptive_bspline(control, degree, CurveTopology::closed, CurveEnds::plain, k_tolerance).points)}});
    }
    json["four_point"] = {
        {"control", points(control)},
        {"step", points(four_point_step(control, CurveTopology::open))},
        {"curve", points(adaptive_four_point(control, CurveTopology::open, FourPointEnds::cubic, k_tolerance).points)},
        {"closed",
         points(adaptive_four_point(control, CurveTopology::closed, FourPointEnds::cubic, k_tolerance).points)}};
    return json;
}

/// Region in which a mesh is refined further.
struct Spot {
    int base, level;  ///< levels outside and inside the radius
    Vec3d centre;
    double radius;
    bool near(const Vec3d& p) const { return glm::distance(p, centre) < radius; }
};

struct LevelledMesh {
    PolygonMesh mesh;
    std::vector<int> levels;  ///< per face
};

ControlMesh control_mesh(const std::string& path, const SchemeInfo& scheme) {
    ControlMesh mesh = load_control_mesh(path);
    if (scheme.family == MeshFamily::triangles && scheme.refinement != Refinement::bisection && !mesh.all_triangles())
        mesh = triangulate(mesh);
    return mesh;
}

Vec3d point(const std::string& text) {
    Vec3d p;
    if (std::sscanf(text.c_str(), "%lf,%lf,%lf", &p.x, &p.y, &p.z) != 3)
        throw std::invalid_argument("no point X,Y,Z: " + text);
    return p;
}

/// Bisection: two splits give the next level of cells, each cut by a diagonal. Other trees have one split a level.
bool is_bisection(const Hierarchy& h) { return h.family() == "bisection"; }
int depth_of_level(const Hierarchy& h, int level) {
    if (is_bisection(h)) return std::max(2 * level - 1, 0);
    // The roots of a dual scheme are the vertices of its first level.
    if (h.family() == "vertices") return std::max(level - 1, 0);
    // sqrt3: a half triangle, then the whole one.
    return h.family() == "sqrt3" ? 2 * level : level;
}
int level_of_depth(const Hierarchy& h, int depth) {
    if (is_bisection(h) || h.family() == "sqrt3") return (depth + 1) / 2;
    return h.family() == "vertices" ? depth + 1 : depth;
}

/// Selects leaves whose centre or a corner is near the spot.
LeafPredicate near_leaves(const Hierarchy& h, const Spot& spot) {
    return [&h, spot](std::span<const LeafView> leaves, std::span<std::uint8_t> wanted) {
        std::vector<Site> sites;
        for (const LeafView& leaf : leaves)
            sites.insert(sites.end(), leaf.corner.begin(), leaf.corner.begin() + leaf.corner_count);
        std::vector<Vec3d> points(sites.size());
        h.limit_positions(sites, points);
        std::size_t next = 0;
        for (std::size_t i = 0; i < leaves.size(); ++i) {
            const std::size_t count = leaves[i].corner_count;
            Vec3d sum(0);
            bool near = false;
            for (std::size_t k = 0; k < count; ++k) {
                near = near || spot.near(points[next + k]);
                sum += points[next + k];
            }
            wanted[i] = near || spot.near(sum / static_cast<double>(count)) ? 1 : 0;
            next += count;
        }
    };
}

LevelledMesh leaves_of(const Hierarchy& h, bool triangles = false) {
    HierarchyMesh out = h.to_mesh({.triangles = triangles});
    LevelledMesh result{std::move(out.mesh), {}};
    for (std::uint32_t f = 0; f < result.mesh.face_count(); ++f) {
        int depth = h.node(out.leaves[f]).depth;
        // The depth of a face of a dual mesh is the largest of its corners.
        if (h.family() == "vertices")
            for (std::uint32_t i = result.mesh.face_offsets[f]; i < result.mesh.face_offsets[f + 1]; ++i)
                depth = std::max<int>(depth, out.sites[result.mesh.face_vertices[i]].level);
        result.levels.push_back(level_of_depth(h, depth));
    }
    return result;
}

/// Quads of the two halves of each cell; a triangle if only one half is a leaf.
LevelledMesh quads_of(const Hierarchy& h) {
    const HierarchyMesh out = h.to_mesh();
    LevelledMesh result;
    result.mesh.positions = out.mesh.positions;
    result.mesh.face_offsets = {0};
    for (const LeafHandle leaf : h.leaves()) {
        const LeafView view = h.view(leaf);
        const LeafNeighbours across = h.neighbours(leaf, 0);
        const bool half =
            view.node.depth % 2 != 0 && across.count == 1 && h.node(across.leaf[0]).depth == view.node.depth;
        if (half && across.leaf[0] < leaf) continue;
        std::vector<PointId> corners(view.point.begin(), view.point.begin() + 3);
        if (half) {
            const LeafView other = h.view(across.leaf[0]);
            corners.insert(corners.begin() + 1, other.point[2]);
        }
        for (const PointId p : corners)
            result.mesh.face_vertices.push_back(
                static_cast<std::uint32_t>(std::find(out.points.begin(), out.points.end(), p) - out.points.begin()));
        result.mesh.face_offsets.push_back(static_cast<std::uint32_t>(result.mesh.face_vertices.size()));
        result.levels.push_back(level_of_depth(h, view.node.depth));
    }
    return result;
}

Json faces(const PolygonMesh& mesh) {
    Json list = Json::array();
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        list.push_back(std::vector<std::uint32_t>(mesh.face_vertices.begin() + mesh.face_offsets[f],
                                                  mesh.face_vertices.begin() + mesh.face_offsets[f + 1]));
    return list;
}

/// A mesh that is fine in one place, by each family's own rule:
///   adaptive IN.obj SCHEME BASE:LEVEL X,Y,Z RADIUS OUT [quads | triangles]
/// Leaves with a corner or their centre within RADIUS of the point are refined to LEVEL, all others to BASE. "quads":
/// pairs of triangles of a bisection as quads; "triangles": a dual mesh as triangles of the 4-8 pattern. OUT may be
/// "-": no file.
/// @returns points, faces, level of each face
Json adaptive(const Arguments& arguments) {
    if (arguments.size() < 6)
        throw std::invalid_argument("adaptive: IN.obj SCHEME BASE:LEVEL X,Y,Z RADIUS OUT [quads | triangles]");
    const SchemeInfo& scheme = scheme_named(arguments[1]);
    const ControlMesh mesh = control_mesh(arguments[0], scheme);
    const std::size_t colon = arguments[2].find(':');
    if (colon == std::string::npos) throw std::invalid_argument("adaptive: two levels, BASE:LEVEL");
    const Spot spot{std::stoi(arguments[2].substr(0, colon)), std::stoi(arguments[2].substr(colon + 1)),
                    point(arguments[3]), std::stod(arguments[4])};
    const std::string form = arguments.size() > 6 ? arguments[6] : "";
    Hierarchy h = make_hierarchy(mesh, scheme);
    h.refine_where(each_leaf([](const LeafView&) { return true; }), depth_of_level(h, spot.base));
    h.refine_where(near_leaves(h, spot), depth_of_level(h, spot.level));
    const LevelledMesh result = form == "quads" ? quads_of(h) : leaves_of(h, form == "triangles");
    if (arguments[5] != "-") write_mesh(arguments[5], result.mesh);
    return {{"points", points(result.mesh.positions)}, {"faces", faces(result.mesh)}, {"levels", result.levels}};
}

/// Refinement towards one inner point of a face, as deep as LEVEL, and coarse elsewhere: zoom IN.obj SCHEME LEVEL FACE
/// @returns points in the tangent plane of that point, which is the origin; faces, level of each face, leaf count
Json zoom(const Arguments& arguments) {
    if (arguments.size() != 4) throw std::invalid_argument("zoom: IN.obj SCHEME LEVEL FACE");
    const SchemeInfo& scheme = scheme_named(arguments[1]);
    const ControlMesh mesh = control_mesh(arguments[0], scheme);
    Hierarchy h = make_hierarchy(mesh, scheme);
    const auto face = static_cast<std::uint32_t>(std::stoul(arguments[3]));
    const auto start = std::find_if(h.leaves().begin(), h.leaves().end(),
                                    [&](const LeafHandle leaf) { return h.view(leaf).face.value == face; });
    if (start == h.leaves().end()) throw std::invalid_argument("zoom: no such face");
    HierarchyNode node = h.node(*start);
    const int depth = depth_of_level(h, std::stoi(arguments[2]));
    while (node.depth < depth) {
        // With sqrt3, the node may be no leaf: where a half was expected there can be a whole triangle already.
        if (const auto leaf = h.find(node)) h.refine(*leaf);
        // Alternate between children, so that the point lies on no grid line of a coarse level.
        const std::vector<HierarchyNode> children = h.children(node);
        node = children[static_cast<std::size_t>(node.depth / 3) % children.size()];
    }
    LevelledMesh out = leaves_of(h);
    const NodeView view = h.view(node);
    Vec3d middle(0);
    for (std::size_t k = 0; k < view.corner_count; ++k)
        middle += h.limit(view.corner[k]).position / static_cast<double>(view.corner_count);
    const Vec3d normal = h.normal(view.corner[0]);
    const Vec3d side = glm::normalize(glm::cross(std::abs(normal.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0), normal));
    const Vec3d above = glm::cross(normal, side);
    for (Vec3d& p : out.mesh.positions) {
        const Vec3d d = p - middle;
        p = Vec3d(glm::dot(d, side), glm::dot(d, above), glm::dot(d, normal));
    }
    return {{"points", points(out.mesh.positions)},
            {"faces", faces(out.mesh)},
            {"levels", out.levels},
            {"leaves", h.leaf_count()},
            {"roots", make_hierarchy(mesh, scheme).leaf_count()},
            {"bytes", h.memory_bytes()}};
}

/// A control mesh from a scan: simplify IN.obj TRIANGLES OUT.obj. @throws std::runtime_error  built without
/// meshoptimizer
Json simplify(const Arguments& arguments) {
    if (arguments.size() != 3) throw std::invalid_argument("simplify: IN.obj TRIANGLES OUT.obj");
#ifdef TETRAKIS_FIGURES_SIMPLIFY
    const TriangleMesh mesh = read_triangle_mesh(arguments[0]);
    std::vector<unsigned> indices;
    for (const auto& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
    std::vector<float> positions;
    for (const Vec3d& p : mesh.positions)
        for (int i = 0; i < 3; ++i) positions.push_back(static_cast<float>(p[i]));
    PolygonMesh result;
    result.positions = mesh.positions;
    result.face_vertices = indices;
    result.face_offsets = {0};
    // The number of triangles is the limit, not the error.
    constexpr float k_any_error = 1;
    result.face_vertices.resize(meshopt_simplify(result.face_vertices.data(), indices.data(), indices.size(),
                                                 positions.data(), mesh.positions.size(), 3 * sizeof(float),
                                                 3 * std::stoul(arguments[1]), k_any_error));
    while (result.face_offsets.back() < result.face_vertices.size())
        result.face_offsets.push_back(result.face_offsets.back() + 3);
    detail::drop_unused_vertices(result);
    write_mesh(arguments[2], result);
    return {{"triangles", result.face_count()}};
#else
    throw std::runtime_error("built without meshoptimizer (libmeshoptimizer-dev)");
#endif
}

}  // namespace

int main(int count, char** values) {
    const std::map<std::string, Json (*)(const Arguments&)> commands{
        {"picture", picture}, {"curves", curves}, {"adaptive", adaptive}, {"zoom", zoom}, {"simplify", simplify}};
    try {
        const auto found = commands.find(count > 1 ? values[1] : "");
        if (found == commands.end()) throw std::invalid_argument("picture, curves, adaptive, zoom or simplify");
        std::cout << found->second({values + 2, values + count}) << '\n';
        return 0;
    } catch (const std::exception& e) {
        std::cerr << "figure_data: " << e.what() << '\n';
        return 1;
    }
}
