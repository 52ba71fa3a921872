#include "fan_limit.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

// Beyond it a fan is large, and hardly ever met twice.
constexpr int k_most_sectors = 16;

StencilRow mapped(const StencilRow& row, std::span<const int> to) {
    StencilTable table;
    StencilRow result;
    for (const auto& [point, weight] : row.terms) result.add(to[point], weight);
    table.push(std::move(result));
    return table.row(0);
}

}  // namespace

FanLimits::FanLimits(FanLattice lattice, int reach, int rings, FindRows rows)
    : lattice_(lattice),
      reach_(reach),
      rings_(rings),
      size_(lattice == FanLattice::triangles ? 3 : 4),
      valence_(lattice == FanLattice::triangles ? 6 : 4),
      rows_(std::move(rows)) {}

const FanLimits::Masks& FanLimits::masks(int valence) {
    const auto [at, fresh] = masks_.try_emplace(valence);
    Masks& masks = at->second;
    if (!fresh) return masks;
    const FanShape shape{.faces = valence};
    const SectorFan fan(lattice_, shape, reach_ + rings_ + 1);
    masks.near = FanLabels(lattice_, shape, reach_).size();
    std::vector<int> vertices(masks.near);
    for (int i = 0; i < masks.near; ++i) vertices[i] = i;
    masks.rows = rows_(fan.mesh, vertices);
    int farthest = reach_;
    const auto look_at = [&](const StencilRow& row) {
        for (const auto& [point, weight] : row.terms)
            farthest = std::max(farthest, fan.labels.ring_of(fan.labels.all()[point]));
    };
    for (const std::optional<LimitRows>& rows : masks.rows) {
        if (!rows) continue;
        look_at(rows->limit);
        for (const auto& [t1, t2] : rows->tangents) {
            look_at(t1);
            look_at(t2);
        }
    }
    // The mesh may end too early to see that nothing else is near; then there are no masks, wherever it ends.
    const int seen = farthest + 1;
    if (reach_ + seen + 1 <= rings_) masks.labels.emplace(lattice_, shape, seen);
    return masks;
}

std::vector<int> FanLimits::start(const RuleMesh& mesh, int centre) const {
    std::vector<int> result;
    const bool dual = lattice_ == FanLattice::dual;
    const int first = dual ? mesh.face_begin(centre) : mesh.first(centre);
    int h = first;
    do {
        result.push_back(h);
        h = dual ? mesh.next(h) : mesh.twin(mesh.prev(h));
    } while (h != first);
    return result;
}

bool FanLimits::alone(const RuleMesh& mesh, std::span<const unsigned char> regular, std::span<const int> start,
                      const FanLabels& labels, std::span<const int> fan) const {
    for (int i = 0; i < labels.size(); ++i) {
        if (regular[fan[i]] != 0) continue;
        const FanLabel l = labels.all()[i];
        if (l.a != 0 || l.b != 0) return false;
        // The middle itself: smooth, and regular but for what makes it extraordinary.
        if (is_sharp(mesh.vertex_sharpness(fan[i])) || mesh.on_boundary(fan[i])) return false;
        const RuleMesh::Ring ring = mesh.ring(fan[i]);
        for (const float s : ring.sharpness)
            if (is_sharp(s)) return false;
        const bool dual = lattice_ == FanLattice::dual;
        if (dual && ring.edges() != valence_) return false;
        for (const int h : ring.halfedge)
            if (mesh.face_size(mesh.face(h)) != size_ && !(dual && mesh.face(h) == mesh.face(start[0]))) return false;
    }
    return true;
}

void FanLimits::find(const RuleMesh& mesh, std::span<const unsigned char> regular, std::span<const int> vertices,
                     std::span<std::optional<LimitRows>> rows) {
    const bool dual = lattice_ == FanLattice::dual;
    // Other faces may change the rules of the whole mesh's first step.
    if (vertices.empty() || (!dual && !mesh.all_faces_have(size_))) return;
    std::vector<int> wanted(mesh.vertex_count(), -1), again(vertices.size(), -1);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        again[i] = wanted[vertices[i]];
        wanted[vertices[i]] = static_cast<int>(i);
    }
    const int centres = dual ? mesh.face_count() : mesh.vertex_count();
    for (int c = 0; c < centres; ++c) {
        int valence = 0;
        if (dual) {
            valence = mesh.face_size(c);
            if (valence == size_) continue;
        } else {
            if (regular[c] != 0 || mesh.on_boundary(c)) continue;
            valence = mesh.ring(c).edges();
            if (valence == valence_) continue;
        }
        if (valence < 3 || valence > k_most_sectors) continue;
        const Masks& m = masks(valence);
        if (!m.labels) continue;
        const std::vector<int> begin = start(mesh, c);
        std::vector<int> fan;
        try {
            fan = find_fan(mesh, begin, *m.labels);
        } catch (const std::logic_error&) {
            continue;  // the mesh ends, or something else is near
        }
        if (!alone(mesh, regular, begin, *m.labels, fan)) continue;
        for (int i = 0; i < m.near; ++i) {
            if (!m.rows[i]) continue;
            for (int k = wanted[fan[i]]; k >= 0; k = again[k]) {
                if (rows[k]) continue;
                LimitRows& to = rows[k].emplace();
                to.limit = mapped(m.rows[i]->limit, fan);
                for (const auto& [t1, t2] : m.rows[i]->tangents)
                    to.tangents.push_back({mapped(t1, fan), mapped(t2, fan)});
            }
        }
    }
}

}  // namespace tetrakis::detail
