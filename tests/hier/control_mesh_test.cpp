#include "../../hier/mesh/control_mesh.hpp"

#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../hier/trees/triangle_cell.hpp"
#include "../../hier/trees/triangle_forest.hpp"

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
