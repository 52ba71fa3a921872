#include "quad_local_mesh.hpp"

#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <cassert>

namespace tetrakis::detail {

std::pmr::memory_resource* pool_resource() {
    static PoolResource resource;
    return &resource;
}

CornerFan corner_fan(const QuadLocalMesh& mesh, int corner, std::pmr::memory_resource* memory) {
    CornerFan fan{std::pmr::vector<std::uint32_t>(memory)};
    fan.outgoing.reserve(8);
    const std::uint32_t home = static_cast<std::uint32_t>(corner);
    std::uint32_t first = home;
    for (std::uint32_t h = mesh.cw(home); h != home; h = mesh.cw(h)) {
        if (h == QuadLocalMesh::none) {
            fan.boundary = true;
            break;
        }
        first = h;
    }
    if (!fan.boundary) first = home;
    for (std::uint32_t h = first;;) {
        if (h == home) fan.cell_index = fan.outgoing.size();
        fan.outgoing.push_back(h);
        h = mesh.ccw(h);
        if (h == QuadLocalMesh::none || h == first) break;
    }
    return fan;
}

std::pmr::vector<float> fan_sharpness(const QuadLocalMesh& mesh, const CornerFan& fan) {
    std::pmr::vector<float> sharpness(fan.outgoing.get_allocator());
    sharpness.reserve(fan.edges());
    for (std::uint32_t h : fan.outgoing) sharpness.push_back(mesh.sharpness[h]);
    if (fan.boundary) sharpness.push_back(mesh.sharpness[QuadLocalMesh::prev(fan.outgoing.back())]);
    return sharpness;
}

std::pmr::vector<Vec3d> fan_ring(const QuadLocalMesh& mesh, const CornerFan& fan) {
    std::pmr::vector<Vec3d> ring(fan.outgoing.get_allocator());
    ring.reserve(2 * fan.faces() + 2);
    ring.push_back(mesh.points[mesh.origin(fan.outgoing.front())]);
    for (std::size_t i = 0; i < fan.faces(); ++i) {
        ring.push_back(fan_edge(mesh, fan, i));
        ring.push_back(fan_face(mesh, fan, i));
    }
    if (fan.boundary) ring.push_back(fan_edge(mesh, fan, fan.faces()));
    return ring;
}

/// Sharpness of the half of h at its far end, where that half is finite.
float QuadLocalStep::far_half(std::uint32_t h) const {
    const std::uint32_t t = mesh_.twin[h];
    if (half_sharpness_[t] != k_sharpness_infinity) return half_sharpness_[t];
    return mesh_.chaikin ? mesh_.far_half[h] : half_sharpness_[h];
}

/// A fan's values in the order in which they are summed up at a control vertex.
std::pmr::vector<float> QuadLocalStep::from_first(int corner, std::pmr::vector<float> sharpness) const {
    const auto& fan = fans_[static_cast<std::size_t>(corner)].outgoing;
    const auto first = std::find(fan.begin(), fan.end(), mesh_.first_half);
    if (first != fan.end()) std::rotate(sharpness.begin(), sharpness.begin() + (first - fan.begin()), sharpness.end());
    return sharpness;
}

QuadLocalStep::QuadLocalStep(const QuadLocalMesh& mesh, std::pmr::memory_resource* memory)
    : mesh_(mesh),
      memory_(memory),
      face_points_(memory),
      edge_points_(memory),
      fans_{corner_fan(mesh, 0, memory), corner_fan(mesh, 1, memory), corner_fan(mesh, 2, memory),
            corner_fan(mesh, 3, memory)},
      child_sharp_{std::pmr::vector<float>(memory), std::pmr::vector<float>(memory), std::pmr::vector<float>(memory),
                   std::pmr::vector<float>(memory)},
      corner_of_point_(memory),
      half_sharpness_(memory) {
    const std::size_t face_count = mesh.faces.size();
    face_points_.resize(face_count);
    for (std::size_t f = 0; f < face_count; ++f) {
        const auto& c = mesh.faces[f];
        face_points_[f] = 0.25 * (mesh.points[c[0]] + mesh.points[c[1]] + mesh.points[c[2]] + mesh.points[c[3]]);
    }
    edge_points_.assign(4 * face_count, Vec3d(0));
    half_sharpness_.assign(4 * face_count, k_sharpness_infinity);

    // Sharpness of the halves at the cell's corners.
    const std::array<std::pmr::vector<float>, 4> sharp = {fan_sharpness(mesh, fans_[0]), fan_sharpness(mesh, fans_[1]),
                                                          fan_sharpness(mesh, fans_[2]), fan_sharpness(mesh, fans_[3])};
    std::array<std::pmr::vector<float>, 4>& child_sharp = child_sharp_;
    for (int k = 0; k < 4; ++k) {
        child_sharp[k].resize(sharp[k].size());
        const std::pmr::vector<float> around =
            mesh.chaikin ? from_first(k, {sharp[k], memory_}) : std::pmr::vector<float>(memory_);
        for (std::size_t i = 0; i < sharp[k].size(); ++i)
            child_sharp[k][i] =
                mesh.chaikin ? child_sharpness_chaikin(sharp[k][i], around) : child_sharpness(sharp[k][i]);
        for (std::size_t i = 0; i < fans_[k].faces(); ++i) half_sharpness_[fans_[k].outgoing[i]] = child_sharp[k][i];
        child_corner_sharpness_[k] = child_sharpness(mesh.corner_sharpness[k]);
    }

    // Edge points of the edges at the corners.
    const auto edge_point = [&](std::uint32_t h) {
        const Vec3d a = mesh.points[mesh.origin(h)], b = mesh.points[mesh.origin(QuadLocalMesh::next(h))];
        const Vec3d crease = 0.5 * (a + b);
        const std::uint32_t t = mesh.twin[h];
        if (t == QuadLocalMesh::none || mesh.sharpness[h] == k_sharpness_infinity) return crease;
        const Vec3d smooth = 0.25 * (a + b + face_points_[h >> 2] + face_points_[t >> 2]);
        if (mesh.sharpness[h] == 0) return smooth;
        const double w = edge_crease_weight(mesh.sharpness[h], half_sharpness_[h], far_half(h));
        return w * crease + (1 - w) * smooth;
    };
    for (int k = 0; k < 4; ++k)
        for (std::uint32_t h : fans_[k].outgoing) {
            edge_points_[h] = edge_point(h);
            if (mesh.twin[h] != QuadLocalMesh::none) edge_points_[mesh.twin[h]] = edge_points_[h];
            const std::uint32_t back = QuadLocalMesh::prev(h);
            if (mesh.twin[back] == QuadLocalMesh::none) edge_points_[back] = edge_point(back);
        }

    for (int k = 0; k < 4; ++k) {
        const CornerFan& fan = fans_[k];
        const Vec3d& centre = mesh.points[mesh.faces[0][static_cast<std::size_t>(k)]];
        const VertexBlend blend =
            vertex_blend(sharp[k], mesh.corner_sharpness[k], child_sharp[k], child_corner_sharpness_[k]);
        Vec3d point = blend.corner * centre;
        if (blend.smooth != 0) {
            Vec3d edges(0), faces(0);
            for (std::size_t i = 0; i < fan.faces(); ++i) {
                edges += fan_edge(mesh, fan, i);
                faces += face_points_[fan.outgoing[i] >> 2];
            }
            const double n = static_cast<double>(fan.faces());
            point += blend.smooth * ((n - 2) / n * centre + (edges + faces) / (n * n));
        }
        if (blend.crease.weight != 0)
            point += blend.crease.weight *
                     (0.75 * centre + 0.125 * (fan_edge(mesh, fan, static_cast<std::size_t>(blend.crease.a)) +
                                               fan_edge(mesh, fan, static_cast<std::size_t>(blend.crease.b))));
        vertex_points_[k] = point;
    }
    corner_of_point_.assign(mesh.points.size(), -1);
    for (int k = 0; k < 4; ++k) corner_of_point_[mesh.faces[0][k]] = k;
}

QuadLocalMesh QuadLocalStep::child(int corner) const {
    using M = QuadLocalMesh;
    const std::uint32_t home = static_cast<std::uint32_t>(corner);
    // The quarters that touch the child, each by the parent's half-edge at its corner; the child itself first.
    std::pmr::vector<std::uint32_t> parts(memory_), face_of(mesh_.twin.size(), M::none, memory_);
    parts.reserve(12);
    const auto add_part = [&](std::uint32_t h) {
        if (face_of[h] != M::none) return;
        face_of[h] = static_cast<std::uint32_t>(parts.size());
        parts.push_back(h);
    };
    add_part(home);
    for (std::uint32_t h : fans_[corner].outgoing) add_part(h);
    for (std::uint32_t k = 0; k < 4; ++k) add_part(k);
    if (mesh_.twin[home] != M::none) add_part(mesh_.twin[home]);
    if (const std::uint32_t p = mesh_.twin[M::prev(home)]; p != M::none) add_part(M::next(p));

    // Points of the child: numbered at first use; face, edge (by the smaller of its half-edges) and vertex points
    // apart.
    std::pmr::vector<std::uint32_t> face_id(mesh_.faces.size(), M::none, memory_),
        edge_id(mesh_.twin.size(), M::none, memory_);
    std::array<std::uint32_t, 4> vertex_id{M::none, M::none, M::none, M::none};
    M out(memory_);
    out.points.reserve(3 * parts.size() + 4);
    out.chaikin = mesh_.chaikin;
    const auto use = [&](std::uint32_t& id, const Vec3d& p) {
        if (id == M::none) {
            id = static_cast<std::uint32_t>(out.points.size());
            out.points.push_back(p);
        }
        return id;
    };
    const auto edge = [&](std::uint32_t h) {
        const std::uint32_t t = mesh_.twin[h];
        return use(edge_id[t != M::none ? std::min(h, t) : h], edge_points_[h]);
    };
    out.faces.resize(parts.size());
    out.twin.assign(4 * parts.size(), M::none);
    out.sharpness.assign(4 * parts.size(), 0.0f);
    if (out.chaikin) out.far_half.assign(4 * parts.size(), 0.0f);
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
        const std::uint32_t g = parts[i], back = M::prev(g), shift = i == 0 ? home : 0;
        const int v = corner_of_point_[mesh_.origin(g)];
        assert(v >= 0);
        const auto slot = [&](std::uint32_t face, std::uint32_t j) {
            return 4 * face + ((j + (face == 0 ? home : 0)) & 3);
        };
        auto& quad = out.faces[i];
        quad[shift & 3] = use(vertex_id[static_cast<std::size_t>(v)], vertex_points_[static_cast<std::size_t>(v)]);
        quad[(shift + 1) & 3] = edge(g);
        quad[(shift + 2) & 3] = use(face_id[g >> 2], face_points_[g >> 2]);
        quad[(shift + 3) & 3] = edge(back);
        const auto link = [&](std::uint32_t j, std::uint32_t parent, std::uint32_t k) {
            if (parent != M::none && face_of[parent] != M::none) out.twin[slot(i, j)] = slot(face_of[parent], k);
        };
        const std::uint32_t tw = mesh_.twin[g], tb = mesh_.twin[back];
        link(0, tw == M::none ? M::none : M::next(tw), 3);
        link(3, tb, 0);
        link(1, M::next(g), 2);
        link(2, back, 1);
        out.sharpness[slot(i, 0)] = tw == M::none ? k_sharpness_infinity : half_sharpness_[g];
        out.sharpness[slot(i, 3)] = tb == M::none ? k_sharpness_infinity : half_sharpness_[tb];
        if (!out.chaikin) continue;
        if (g == mesh_.first_half) out.first_half = slot(i, 0);
        if (tw != M::none && mesh_.sharpness[g] != k_sharpness_infinity) {
            const float halves[2] = {half_sharpness_[g], far_half(g)};
            out.far_half[slot(i, 0)] = child_sharpness_chaikin(halves[0], halves);
        }
        if (tb != M::none && mesh_.sharpness[back] != k_sharpness_infinity)
            out.far_half[slot(i, 3)] =
                child_sharpness_chaikin(half_sharpness_[tb], from_first(v, {child_sharp_[v], memory_}));
    }
    if (mesh_.first_half != M::none && corner_of_point_[mesh_.origin(mesh_.first_half)] != corner)
        out.first_half = M::none;
    // The child's corners: its own vertex keeps a tag, edge and face points have none.
    out.corner_sharpness = {};
    out.corner_sharpness[static_cast<std::size_t>(corner)] = child_corner_sharpness_[static_cast<std::size_t>(corner)];
    return out;
}

}  // namespace tetrakis::detail
