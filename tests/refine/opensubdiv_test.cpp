#include "../kit/nearest.hpp"
#include "../kit/osd_refiner.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <doctest/doctest.h>

#include <string>
#include <utility>

using namespace tetrakis;
namespace Far = OpenSubdiv::Far;

namespace {

// The figure of the issue, relative to the bounding box; measured: 1e-15.
constexpr double k_tolerance = 1e-13;

/// Largest distance of the points of both libraries on one level; points of holes are no part of ours.
double compare(const ControlMesh& mesh, SchemeKind scheme, int levels) {
    const test::FarLevel theirs(mesh.data(), scheme, levels);
    std::vector<char> used(theirs.points.size(), 0);
    for (int f = 0; f < theirs.topology().GetNumFaces(); ++f) {
        if (theirs.topology().IsFaceHole(f)) continue;
        const auto corners = theirs.topology().GetFaceVertices(f);
        for (int i = 0; i < corners.size(); ++i) used[static_cast<std::size_t>(corners[i])] = 1;
    }
    const PolygonMesh ours = refine(mesh, name(scheme), levels);
    CHECK(ours.positions.size() == static_cast<std::size_t>(std::count(used.begin(), used.end(), 1)));
    const PointMatch match(ours.positions);
    double off = 0;
    for (std::size_t v = 0; v < used.size(); ++v) {
        if (used[v] == 0) continue;
        const Vec3d& p = theirs.points[v].p;
        off = std::max(off, glm::length(ours.positions[match.nearest(p)] - p));
    }
    return off / bounding_box(mesh.positions()).diagonal();
}

/// A place that each face corner has for itself, a little way into its face.
template <class Corners, class At>
void add_corner_places(const Corners& corners, int size, const At& at, std::vector<Vec3d>& places) {
    Vec3d centre(0);
    for (int i = 0; i < size; ++i) centre += at(corners[i]) / double(size);
    for (int i = 0; i < size; ++i) places.push_back(0.75 * at(corners[i]) + 0.25 * centre);
}

/// Largest distance of the UVs of both libraries at the corners of one level.
double compare_uvs(const ControlMesh& mesh, SchemeKind scheme, int levels) {
    const test::FarLevel theirs(mesh.data(), scheme, levels);
    const PolygonMesh ours = refine(mesh, name(scheme), levels);
    std::vector<Vec3d> our_places;
    for (std::uint32_t f = 0; f < ours.face_count(); ++f)
        add_corner_places(
            ours.face_vertices.data() + ours.face_offsets[f],
            static_cast<int>(ours.face_offsets[f + 1] - ours.face_offsets[f]),
            [&](std::uint32_t v) { return ours.positions[v]; }, our_places);
    const PointMatch match(our_places);
    const Far::TopologyLevel& level = theirs.topology();
    double off = 0;
    std::size_t count = 0;
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        if (level.IsFaceHole(f)) continue;
        const auto corners = level.GetFaceVertices(f), values = level.GetFaceFVarValues(f);
        std::vector<Vec3d> places;
        add_corner_places(
            corners, corners.size(), [&](int v) { return theirs.points[static_cast<std::size_t>(v)].p; }, places);
        for (int i = 0; i < corners.size(); ++i, ++count) {
            const Vec2d uv = ours.uvs[ours.face_uvs[match.nearest(places[static_cast<std::size_t>(i)])]];
            off = std::max(off, glm::length(uv - Vec2d(theirs.uvs[static_cast<std::size_t>(values[i])].p)));
        }
    }
    CHECK(count == ours.face_vertices.size());
    return off;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[peer] UVs are OpenSubdiv's by every face-varying rule: seams, corners of charts, ends of seams, creases") {
    for (const std::string name : {"head", "knot", "pieces", "sheet"})
        for (const FaceVaryingRule rule :
             {FaceVaryingRule::smooth_all, FaceVaryingRule::corners_only, FaceVaryingRule::corners_plus1,
              FaceVaryingRule::corners_plus2, FaceVaryingRule::boundaries, FaceVaryingRule::linear_all})
            for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop}) {
                CAPTURE(name);
                CAPTURE(static_cast<int>(rule));
                CAPTURE(static_cast<int>(scheme));
                ControlMeshData data =
                    name == "sheet" ? test::grid(4, false) : test::model_data(name == "pieces" ? "pipe3" : name);
                if (name == "sheet") {
                    // Two charts, and corners on the boundary, inside and on the seam.
                    data.corners = {{1, k_infinite_sharpness}, {8, 2}, {12, 1.5f}};
                    for (const double shift : {0.0, 9.0})
                        for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x + 0.1 * p.y * p.y + shift, p.y);
                    for (std::uint32_t c = 0; c < data.face_vertices.size(); ++c)
                        data.face_uvs.push_back(data.face_vertices[c] + (c / 4 % 4 < 2 ? 0 : 25));
                }
                if (name == "pieces") {
                    // Charts of a few faces each, of all shapes, many of them with darts and corners inside the mesh.
                    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers;
                    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f)
                        for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c) {
                            const std::uint32_t v = data.face_vertices[c], chart = f * 7 / 30 % 5;
                            const auto [at, fresh] =
                                numbers.try_emplace({v, chart}, static_cast<std::uint32_t>(data.uvs.size()));
                            if (fresh) data.uvs.emplace_back(0.1 * (v * 37 % 19) + chart, 0.1 * (v * 17 % 23));
                            data.face_uvs.push_back(at->second);
                        }
                }
                data.face_varying_rule = rule;
                ControlMesh mesh = ControlMesh::build(std::move(data));
                if (scheme == SchemeKind::loop) mesh = triangulate(mesh);
                CHECK(compare_uvs(mesh, scheme, 2) < 1e-12 * 10);
            }
}

TEST_CASE("[peer] random meshes with all kinds of tags refine as OpenSubdiv refines them") {
    for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin})
        for (const std::uint64_t seed : test::seeds(10)) {
            ControlMeshData data = test::random_mesh_data(seed, test::random_options(seed));
            data.crease_method = method;
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            const ControlMesh triangles = triangulate(mesh);
            for (int levels = 1; levels <= 3; ++levels) {
                CAPTURE(seed);
                const bool chaikin = method == CreaseMethod::chaikin;
                CAPTURE(chaikin);
                CAPTURE(levels);
                for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop}) {
                    INFO(name(scheme));
                    CHECK(compare(scheme == SchemeKind::loop ? triangles : mesh, scheme, levels) < k_tolerance);
                }
            }
        }
}

TEST_CASE("[peer] Chaikin creases whose sharpness falls from above one to nothing in one step") {
    // The upper ring of a cube: the mean with a nearly smooth neighbour takes more than one.
    ControlMeshData data;
    for (int i = 0; i < 8; ++i) data.positions.push_back({i & 1, i >> 1 & 1, i >> 2});
    data.face_offsets = {0, 4, 8, 12, 16, 20, 24};
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    data.crease_method = CreaseMethod::chaikin;
    data.creases = {{4, 5, 1.2f}, {5, 7, 0.1f}, {7, 6, 1.3f}, {6, 4, 0.3f}};
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    for (int levels = 1; levels <= 3; ++levels) CHECK(compare(mesh, SchemeKind::catmull_clark, levels) < k_tolerance);
}

TEST_SUITE_END();
