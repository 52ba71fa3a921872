#include "cell_kinds.hpp"

#include "../../schemes/rules/averaging.hpp"
#include "../../schemes/rules/modified_butterfly.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Rules of edges look two rings around a cell; those of others, as Kobbelt's virtual points, up to one more; a step of
/// averaging is by half a ring.
int rings_of(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.step == averaging_step) return options.averaging_steps / 2 + 1;
    return scheme.step == modified_butterfly_step || scheme.step == butterfly_step ? 2 : 3;
}

constexpr int k_none = -1, k_many = -2;

int joined(int a, int b) { return a == b || b == k_none ? a : a == k_none ? b : k_many; }

}  // namespace

CellKinds::CellKinds(const SchemeInfo& scheme, const RuleOptions& options)
    : scheme_(scheme),
      options_(options),
      corners_(scheme.family == MeshFamily::triangles ? 3 : 4),
      rings_(rings_of(scheme, options)),
      table_(scheme, options, corners_, rings_) {}

std::optional<CellKinds::Total> CellKinds::total(const FanShape& shape) const {
    const FanLattice lattice = corners_ == 3 ? FanLattice::triangles : FanLattice::quads;
    const CellNorms* const found = table_.find(fan_surroundings(lattice, shape, rings_));
    if (found == nullptr) return std::nullopt;
    Total total{0, false};
    for (const double w : found->weight) total.sum += w;
    for (const CellAnchor& a : found->anchor) total.linear = total.linear || a[0] != 1;
    return total;
}

const CellKind& CellKinds::find(const SurroundingsKey& key) const {
    {
        const std::shared_lock lock(mutex_);
        if (const auto at = kinds_.find(key); at != kinds_.end()) return *at->second;
    }
    auto kind = std::make_unique<CellKind>();
    kind->norms = table_.find(key);
    const std::unique_lock lock(mutex_);
    const auto [at, is_new] = kinds_.try_emplace(key, std::move(kind));
    if (is_new) at->second->key = &at->first;
    return *at->second;
}

const CellKind::Children& CellKinds::children(const CellKind& kind) const {
    std::call_once(kind.once, [&] {
        const CellDescent down = one_level_down(scheme_, options_, *kind.key, corners_, rings_);
        for (std::size_t k = 0; k < kind.children.size(); ++k) {
            CellKind::Child& child = kind.children[k];
            child.kind = &find(down.children[k].key);
            for (const int v : down.children[k].vertices) {
                StencilRow row;
                for (const auto& [point, weight] : down.rows[v]) row.add(point, weight);
                child.rows.push(std::move(row));
            }
        }
    });
    return kind.children;
}

double CellKinds::remainder(const CellKind& kind, std::span<const Vec3d> points) const {
    if (kind.norms == nullptr) return std::numeric_limits<double>::infinity();
    const CellNorms& norms = *kind.norms;
    double sum = 0;
    for (std::size_t i = 0; i < norms.point.size(); ++i) {
        const CellAnchor& a = norms.anchor[i];
        Vec3d expected = a[0] * points[0] + a[1] * points[1] + a[2] * points[2];
        if (corners_ == 4) expected += a[3] * points[3];
        sum += norms.weight[i] * glm::length(points[norms.point[i]] - expected);
    }
    return sum;
}

CellKindFinder::CellKindFinder(const CellKinds& kinds, const RuleMesh& mesh, MeshPartFinder& parts)
    : kinds_(kinds), mesh_(mesh), parts_(parts), near_(mesh.vertex_count(), k_none) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.first(v) == RuleMesh::none || !is_regular_vertex(mesh, v, kinds.corners())) near_[v] = v;
    for (int f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(f) != kinds.corners())
            for (const int v : mesh.corners(f)) near_[v] = k_many;
    std::vector<int> wider;
    for (int ring = 1; ring < kinds.rings(); ++ring) {
        wider = near_;
        for (int f = 0; f < mesh.face_count(); ++f) {
            int all = k_none;
            for (const int v : mesh.corners(f)) all = joined(all, near_[v]);
            for (const int v : mesh.corners(f)) wider[v] = joined(wider[v], all);
        }
        near_.swap(wider);
    }
}

CellKindFinder::Found CellKindFinder::operator()(int halfedge) const {
    int all = k_none;
    for (const int v : mesh_.corners(mesh_.face(halfedge))) all = joined(all, near_[v]);
    if (all == k_many) return {};
    // Beside corners of some angles there are weights only as seen from the corner itself.
    for (int turns = 0; turns < kinds_.corners(); ++turns, halfedge = mesh_.next(halfedge)) {
        std::optional<CellSurroundings> around = cell_surroundings(mesh_, halfedge, kinds_.rings(), parts_);
        if (!around) break;
        const CellKind& kind = kinds_.find(around->key);
        if (kind.norms != nullptr) return {&kind, turns, std::move(around->vertices)};
    }
    return {};
}

}  // namespace tetrakis::detail
