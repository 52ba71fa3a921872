#include "../../hier/mesh/control_mesh.hpp"

#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../hier/trees/triangle_cell.hpp"
#include "../../hier/trees/triangle_forest.hpp"

#include <doctest/doctest.h>

#include <type_traits>

using namespace tetrakis;

// What keeps a reference to a mesh takes one that stays, and no temporary.
template <class Forest>
constexpr bool takes_meshes_that_stay =
    std::is_constructible_v<Forest, const ControlMesh&>&& std::is_constructible_v<Forest, ControlMesh&> &&
    !std::is_constructible_v<Forest, ControlMesh> && !std::is_constructible_v<Forest, const ControlMesh>;
static_assert(takes_meshes_that_stay<BisectionForest>);
static_assert(takes_meshes_that_stay<TriangleForest>);
static_assert(takes_meshes_that_stay<TriangleSites>);
static_assert(takes_meshes_that_stay<Sqrt3Forest>);
static_assert(takes_meshes_that_stay<Sqrt3Lattice>);
static_assert(takes_meshes_that_stay<Sqrt3Forest>);

TEST_SUITE_BEGIN("hier");

TEST_CASE("the half-edges of a tetrahedron close up") {
    ControlMeshData data;
    data.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    data.face_offsets = {0, 3, 6, 9, 12};
    data.face_vertices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    const ControlMesh mesh = ControlMesh::build(data);
    CHECK(mesh.edge_count() == 6);
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i);
        REQUIRE(mesh.twin(h).valid());
        CHECK(mesh.twin(mesh.twin(h)) == h);
        CHECK(mesh.origin(mesh.twin(h)) == mesh.target(h));
        CHECK(mesh.next(mesh.next(mesh.next(h))) == h);
        CHECK(mesh.prev(mesh.next(h)) == h);
    }
    for (std::uint32_t v = 0; v < 4; ++v) CHECK(mesh.valence(VertexId(v)) == 3);
}

TEST_SUITE_END();
