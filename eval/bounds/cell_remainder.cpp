#include "cell_remainder.hpp"

#include "../../schemes/rules/averaging.hpp"
#include "../../schemes/rules/modified_butterfly.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Rules of edges look two rings around a cell; those of others, as Kobbelt's virtual points, up to one more; a step of
/// averaging is by half a ring.
int rings_of(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.step == averaging_step) return options.averaging_steps / 2 + 1;
    return scheme.step == modified_butterfly_step || scheme.step == butterfly_step ? 2 : 3;
}

// The level where hardly any cell is near more than one extraordinary point, so that many have the same surroundings.
constexpr int k_irregular_from = 2;

constexpr int k_none = -1, k_many = -2;

int joined(int a, int b) { return a == b || b == k_none ? a : a == k_none ? b : k_many; }

}  // namespace

CellRemainder::CellRemainder(const SchemeInfo& scheme, const RuleOptions& options)
    : corners_(scheme.family == MeshFamily::triangles ? 3 : 4),
      rings_(rings_of(scheme, options)),
      table_(scheme, options, corners_, rings_) {}

std::optional<CellRemainder::Total> CellRemainder::total(const FanShape& shape) const {
    const FanLattice lattice = corners_ == 3 ? FanLattice::triangles : FanLattice::quads;
    const CellNorms* const found = table_.find(fan_surroundings(lattice, shape, rings_));
    if (found == nullptr) return std::nullopt;
    Total total{0, false};
    for (const double w : found->weight) total.sum += w;
    for (const CellAnchor& a : found->anchor) total.linear = total.linear || a[0] != 1;
    return total;
}

NormedCells::NormedCells(const CellRemainder& remainder, const RuleMesh& mesh, int level)
    : remainder_(remainder),
      mesh_(mesh),
      regular_only_(level < k_irregular_from),
      near_(mesh.vertex_count(), k_none),
      entries_(std::make_unique<Entry[]>(static_cast<std::size_t>(mesh.face_count()))) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.first(v) == RuleMesh::none || !is_regular_vertex(mesh, v, remainder.corners())) near_[v] = v;
    for (int f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(f) != remainder.corners())
            for (const int v : mesh.corners(f)) near_[v] = k_many;
    std::vector<int> wider;
    for (int ring = regular_only_ ? 0 : 1; ring < remainder.rings(); ++ring) {
        wider = near_;
        for (int f = 0; f < mesh.face_count(); ++f) {
            int all = k_none;
            for (const int v : mesh.corners(f)) all = joined(all, near_[v]);
            for (const int v : mesh.corners(f)) wider[v] = joined(wider[v], all);
        }
        near_.swap(wider);
    }
}

const NormedCells::Cell& NormedCells::at(int halfedge, MeshPartFinder& parts) const {
    Entry& entry = entries_[static_cast<std::size_t>(mesh_.face(halfedge))];
    std::call_once(entry.once, [&] { entry.cell = find(halfedge, parts); });
    return entry.cell;
}

NormedCells::Cell NormedCells::find(int halfedge, MeshPartFinder& parts) const {
    int all = k_none;
    for (const int v : mesh_.corners(mesh_.face(halfedge))) all = joined(all, near_[v]);
    if (all == k_many || (regular_only_ && all != k_none)) return {};
    // Beside corners of some angles there are weights only as seen from the corner itself.
    for (int k = 0; k < remainder_.corners(); ++k, halfedge = mesh_.next(halfedge)) {
        const std::optional<CellSurroundings> around = cell_surroundings(mesh_, halfedge, remainder_.rings(), parts);
        if (!around) break;
        const CellNorms* const norms = remainder_.find(around->key);
        if (norms == nullptr) continue;
        Cell cell{norms, halfedge, {}};
        for (const int i : norms->point) cell.points.push_back(around->vertices[i]);
        return cell;
    }
    return {};
}

}  // namespace tetrakis::detail
