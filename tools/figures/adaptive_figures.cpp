#include "figure_commands.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/factored/factored_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace tetrakis::figures {

namespace {

using Json = nlohmann::json;

/// Where a mesh is to be fine.
struct Spot {
    int base, level;  ///< everywhere, and within the radius
    Vec3d centre;
    double radius;
    bool near(const Vec3d& p) const { return glm::distance(p, centre) < radius; }
};

struct LevelledMesh {
    PolygonMesh mesh;
    std::vector<int> levels;  ///< per face
};

const SchemeInfo& scheme_named(const std::string& name) {
    if (const SchemeInfo* const scheme = find_scheme(name)) return *scheme;
    throw std::invalid_argument("no scheme is called " + name);
}

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

/// Bisections that make whole cells (cut by a diagonal) of a level; other trees have one split a level.
bool is_bisection(const Hierarchy& h) { return h.family() == "bisection"; }
int depth_of_level(const Hierarchy& h, int level) {
    if (is_bisection(h)) return std::max(2 * level - 1, 0);
    // The roots of a dual scheme are the vertices of its first level.
    if (h.family() == "vertices") return std::max(level - 1, 0);
    // Half a triangle, then the whole one.
    return h.family() == "sqrt3" ? 2 * level : level;
}
int level_of_depth(const Hierarchy& h, int depth) {
    if (is_bisection(h) || h.family() == "sqrt3") return (depth + 1) / 2;
    return h.family() == "vertices" ? depth + 1 : depth;
}

/// Wants the leaves that have their middle or a corner near.
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
        // A face of a dual mesh belongs to all its corners.
        if (h.family() == "vertices")
            for (std::uint32_t i = result.mesh.face_offsets[f]; i < result.mesh.face_offsets[f + 1]; ++i)
                depth = std::max<int>(depth, out.sites[result.mesh.face_vertices[i]].level);
        result.levels.push_back(level_of_depth(h, depth));
    }
    return result;
}

/// The two halves of a cell as one quad; triangles where only one half is left.
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

Json points(const std::vector<Vec3d>& positions) {
    Json list = Json::array();
    for (const Vec3d& p : positions) list.push_back({p.x, p.y, p.z});
    return list;
}

}  // namespace

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
        // Unless it is whole already (sqrt3), where it was to be half.
        if (const auto leaf = h.find(node)) h.refine(*leaf);
        // Children in turn, so that the point is on no grid line of a coarse level.
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

Json factored(const Arguments& arguments) {
    if (arguments.size() != 3) throw std::invalid_argument("factored: IN.obj SCHEME STEPS");
    const auto scheme = factored_scheme_from_name(arguments[1]);
    if (!scheme) throw std::invalid_argument("factored: no factored scheme is called " + arguments[1]);
    FactoredMesh mesh(load_control_mesh(arguments[0]), *scheme);
    for (int i = std::stoi(arguments[2]); i > 0; --i) mesh.half_step();
    const std::vector<Vec3d> positions(mesh.positions().begin(), mesh.positions().end());
    std::vector<bool> active;
    for (std::uint32_t v = 0; v < positions.size(); ++v) active.push_back(mesh.state(v) == FactoredVertex::active);
    const PolygonMesh own = mesh.active_mesh();
    return {{"points", points(positions)},
            {"faces", mesh.triangles()},
            {"active", active},
            {"own", {{"points", points(own.positions)}, {"faces", faces(own)}}}};
}

}  // namespace tetrakis::figures
