#include "normed_cells.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis::detail {

namespace {

// The level where hardly any cell is near more than one extraordinary point, so that many have the same surroundings.
constexpr int k_irregular_from = 2;

constexpr int k_none = -1, k_many = -2;

int joined(int a, int b) { return a == b || b == k_none ? a : a == k_none ? b : k_many; }

}  // namespace

NormedCells::NormedCells(const CellNormTable& norms, const RuleMesh& mesh, int level)
    : norms_(norms), mesh_(mesh), regular_only_(level < k_irregular_from) {
    if (level < 0) return;
    near_.assign(static_cast<std::size_t>(mesh.vertex_count()), k_none);
    entries_ = std::make_unique<Entry[]>(static_cast<std::size_t>(mesh.face_count()));
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.first(v) == RuleMesh::none || !is_regular_vertex(mesh, v, norms.corners())) near_[v] = v;
    for (int f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(f) != norms.corners())
            for (const int v : mesh.corners(f)) near_[v] = k_many;
    std::vector<int> wider;
    for (int ring = regular_only_ ? 0 : 1; ring < norms.rings(); ++ring) {
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
    for (int k = 0; k < norms_.corners(); ++k, halfedge = mesh_.next(halfedge)) {
        const std::optional<CellSurroundings> around = cell_surroundings(mesh_, halfedge, norms_.rings(), parts);
        if (!around) break;
        const CellNorms* const found = norms_.find(around->key);
        if (found == nullptr) continue;
        Cell cell{found, halfedge, {}};
        for (const int i : found->point) cell.points.push_back(around->vertices[i]);
        return cell;
    }
    return {};
}

}  // namespace tetrakis::detail
