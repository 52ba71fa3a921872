#include "../../eval/estimate/hierarchy_estimator.hpp"
#include "../../eval/estimate/linear_bound.hpp"
#include "../../eval/patches/limit_surface.hpp"
#include "../../eval/patches/loop_patches.hpp"
#include "../../eval/patches/quad_patches.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../hier/trees/triangle_forest.hpp"
#include "../../refine/uniform/position_refiner.hpp"

#include <type_traits>

using namespace tetrakis;

// What keeps a reference to a mesh or a hierarchy takes one that stays, and no temporary.
template <class Keeper, class Kept, class... Rest>
constexpr bool takes_what_stays =
    std::is_constructible_v<Keeper, const Kept&, Rest...> && !std::is_constructible_v<Keeper, Kept, Rest...> &&
    !std::is_constructible_v<Keeper, const Kept, Rest...>;
static_assert(takes_what_stays<BisectionForest, ControlMesh> && takes_what_stays<TriangleForest, ControlMesh>);
static_assert(takes_what_stays<Sqrt3Forest, ControlMesh>);
static_assert(takes_what_stays<Sqrt3Lattice, ControlMesh> &&
              takes_what_stays<PositionRefiner, ControlMesh, const char*, int>);
static_assert(takes_what_stays<PositionRefiner, ControlMesh, const SchemeInfo&, int, RefineOptions>);
static_assert(takes_what_stays<QuadPatches, ControlMesh> && takes_what_stays<LoopPatches, ControlMesh>);
static_assert(takes_what_stays<LimitSurface, ControlMesh, SchemeKind>);
static_assert(takes_what_stays<LinearBound, ControlMesh, const SchemeInfo&>);
static_assert(takes_what_stays<HierarchyEstimator, Hierarchy, double>);
template <class Mesh, class Scheme>
concept MakesHierarchy = requires(Mesh&& mesh, Scheme scheme) {
    make_hierarchy(std::forward<Mesh>(mesh), scheme);
    make_hierarchy(std::forward<Mesh>(mesh), scheme, {.rules = {}});
};
static_assert(MakesHierarchy<const ControlMesh&, const char*> && MakesHierarchy<ControlMesh&, const SchemeInfo&>);
static_assert(!MakesHierarchy<ControlMesh, const char*> && !MakesHierarchy<const ControlMesh, const SchemeInfo&>);
