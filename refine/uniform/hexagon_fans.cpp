#include "hexagon_fans.hpp"

#include "../../hier/base/parallel.hpp"
#include "../rules/face_normals.hpp"
#include "../rules/honeycomb_limit.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace tetrakis::detail {

HexagonFans::HexagonFans(const HexagonMesh& mesh) : mesh_(mesh) {
    face_of_.resize(mesh.halfedge_count());
    for_each_index(mesh.face_count(),
                   [&](std::uint32_t f) { std::fill_n(face_of_.begin() + mesh.face_begin(f), mesh.face_size(f), f); });
    tagged_.assign(mesh.vertex_count(), 0);
    for (const HexagonMesh::Tagged& tagged : mesh.tagged()) tagged_[tagged.vertex] = 1;
}

/// The vertices that a limit depends on, in the order of honeycomb_fan(). False where the mesh is another one there.
template <class Visit>
bool HexagonFans::walk(std::uint32_t v, Visit&& visit) const {
    constexpr std::uint32_t k_edges = 3;
    const auto is_hexagon = [&](std::uint32_t f) { return mesh_.face_size(f) == k_hexagon_size; };
    const auto ahead = [](std::uint32_t begin, std::uint32_t h, std::uint32_t steps) {
        const std::uint32_t at = h - begin + steps;
        return begin + (at < k_hexagon_size ? at : at - k_hexagon_size);
    };
    const auto around = mesh_.leaving(v);
    if (around.size() < 2 || tagged_[v] != 0) return false;
    visit(v);
    for (const std::uint32_t h : around) {
        const std::uint32_t f = face_of_[h], begin = mesh_.face_begin(f);
        if (!is_hexagon(f)) return false;
        const std::uint32_t next = ahead(begin, h, 1), e = mesh_.origin(next);
        if (tagged_[e] != 0 || mesh_.leaving(e).size() != k_edges) return false;
        const std::uint32_t across = mesh_.twin(next), beyond = face_of_[across], first = mesh_.face_begin(beyond);
        if (!is_hexagon(beyond)) return false;
        visit(e);
        for (std::uint32_t k = 2; k < 5; ++k) visit(mesh_.origin(ahead(begin, h, k)));
        for (std::uint32_t k = 3; k < k_hexagon_size; ++k) visit(mesh_.origin(ahead(first, across, k)));
    }
    return true;
}

void HexagonFans::need_weights(std::size_t valence) {
    if (weights_.size() <= valence) weights_.resize(valence + 1);
    if (weights_[valence].empty()) weights_[valence] = honeycomb_limit_weights(static_cast<int>(valence));
}

bool HexagonFans::is_plain(std::uint32_t v) const {
    return walk(v, [](std::uint32_t) {});
}

std::optional<Vec3d> HexagonFans::limit(std::uint32_t v, const Vec3d* net) const {
    const std::size_t valence = mesh_.leaving(v).size();
    if (valence >= weights_.size() || weights_[valence].empty()) return std::nullopt;
    const double* weight = weights_[valence].data();
    Vec3d sum(0);
    if (!walk(v, [&](std::uint32_t w) { sum += *weight++ * net[w]; })) return std::nullopt;
    return sum;
}

void HexagonFans::points_of(std::uint32_t face, const Vec3d* net, std::vector<Vec3d>& points) const {
    points.clear();
    const std::uint32_t begin = mesh_.face_begin(face), end = begin + mesh_.face_size(face);
    for (std::uint32_t h = begin; h < end; ++h) points.push_back(net[mesh_.origin(h)]);
}

/// A vertex on the next level.
Vec3d HexagonFans::moved(std::uint32_t v, const Vec3d* net) const {
    if (tagged_[v] != 0) {
        const auto tags = mesh_.tagged();
        const auto tag =
            std::lower_bound(tags.begin(), tags.end(), v,
                             [](const HexagonMesh::Tagged& t, std::uint32_t number) { return t.vertex < number; });
        if (tag->rule == VertexRule::corner) return net[v];
        if (tag->rule == VertexRule::crease) return 0.75 * net[v] + 0.125 * (net[tag->ends[0]] + net[tag->ends[1]]);
    }
    std::vector<Vec3d> points;
    Vec3d sum(0);
    for (const std::uint32_t h : mesh_.leaving(v)) {
        points_of(face_of_[h], net, points);
        sum += mesh_.refine_corner(points, h - mesh_.face_begin(face_of_[h]));
    }
    return sum / static_cast<double>(mesh_.leaving(v).size());
}

Vec3d HexagonFans::limit_below(std::uint32_t v, const Vec3d* net) const {
    const auto around = mesh_.leaving(v);
    const std::size_t n = around.size();
    // On the next level: the faces here with their new corners, and the hexagon of each edge, from the vertex on.
    struct Sector {
        std::vector<Vec3d> face;  ///< from the vertex on
        std::array<Vec3d, k_hexagon_size> hexagon;
    };
    std::vector<Sector> sectors(n);
    std::vector<Vec3d> points;
    Vec3d middle(0);
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t f = face_of_[around[i]];
        points_of(f, net, points);
        std::rotate(points.begin(), points.begin() + (around[i] - mesh_.face_begin(f)), points.end());
        sectors[i].face.resize(points.size());
        mesh_.refine_face(points, sectors[i].face.data());
        middle += sectors[i].face[0] / static_cast<double>(n);
    }
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t f = face_of_[around[i]], next = around[i] + 1,
                            end = mesh_.face_begin(f) + mesh_.face_size(f);
        const std::uint32_t neighbour = mesh_.origin(next < end ? next : mesh_.face_begin(f));
        const std::vector<Vec3d>&left = sectors[i].face, &right = sectors[(i + n - 1) % n].face;
        // Counter-clockwise; the face before the edge lies to its right, and ends with the neighbour.
        sectors[i].hexagon = {middle, right.front(), right.back(), moved(neighbour, net), left[1], left[0]};
    }
    // And on the level after that, where the fan is as walk() has it.
    std::vector<std::array<Vec3d, k_hexagon_size>> corners(n);
    Vec3d fan_middle(0);
    for (std::size_t i = 0; i < n; ++i) {
        mesh_.refine_face(sectors[i].hexagon, corners[i].data());
        fan_middle += corners[i][0] / static_cast<double>(n);
    }
    const double* weight = weights_[n].data();
    Vec3d sum = *weight++ * fan_middle;
    for (std::size_t i = 0; i < n; ++i) {
        const auto &here = corners[i], &after = corners[(i + 1) % n];
        const Vec3d beyond =
            (here[5] + after[1] + mesh_.refine_corner(sectors[i].face, 0)) / 3.0;  // where the hexagons' edge ends
        for (const Vec3d& p : {here[0], here[5], beyond, after[1], here[2], here[3], here[4]}) sum += *weight++ * p;
    }
    return sum;
}

Vec3d HexagonFans::normal(std::uint32_t v, const Vec3d* net) const {
    Vec3d corners(0);
    for (const std::uint32_t h : mesh_.leaving(v)) {
        const std::uint32_t begin = mesh_.face_begin(face_of_[h]), last = begin + mesh_.face_size(face_of_[h]) - 1;
        corners += FaceNormals::at_corner(net[v], net[mesh_.origin(h < last ? h + 1 : begin)],
                                          net[mesh_.origin(h > begin ? h - 1 : last)]);
    }
    if (const Vec3d normal = unit_of_sum(corners); normal != Vec3d(0)) return normal;
    FaceNormals normals;
    std::vector<Vec3d> points;
    for (const std::uint32_t h : mesh_.leaving(v)) {
        const std::uint32_t begin = mesh_.face_begin(face_of_[h]), end = begin + mesh_.face_size(face_of_[h]);
        points.clear();
        for (std::uint32_t c = begin; c < end; ++c) points.push_back(net[mesh_.origin(c)]);
        normals.add(points, h - begin);
    }
    return normals.normal();
}

}  // namespace tetrakis::detail
