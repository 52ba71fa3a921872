#include "ring_limit.hpp"

#include "../parts/dense_eigen.hpp"
#include "catmull_clark.hpp"
#include "loop.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>
#include <numeric>
#include <shared_mutex>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace tetrakis {

namespace {

using std::numbers::pi;

/// Where the ring's points are in a row of weights.
struct RingLayout {
    bool quads;
    int edges, faces;

    RingLayout(SchemeKind scheme, const RingShape& shape)
        : quads(scheme == SchemeKind::catmull_clark), edges(shape.edge_count()), faces(shape.faces) {}

    int size() const { return 1 + edges + (quads ? faces : 0); }
    int edge(int i) const { return quads ? 1 + 2 * i : 1 + i; }
    int face(int i) const { return 2 + 2 * i; }

    bool is_sharp(const RingShape& shape, int i) const {
        return (shape.boundary && (i == 0 || i == edges - 1)) || (!shape.sharp.empty() && shape.sharp[i] != 0);
    }
    std::vector<int> sharp_edges(const RingShape& shape) const {
        std::vector<int> result;
        for (int i = 0; i < edges; ++i)
            if (is_sharp(shape, i)) result.push_back(i);
        return result;
    }
};

/// The mirror at the sharp edge 0 swaps edge i with -i and face i with -1 - i. Symmetric modes live on its orbits.
struct MirrorOrbits {
    std::vector<int> orbit;           ///< of each ring point
    std::vector<int> representative;  ///< of each orbit
    std::vector<int> length;

    MirrorOrbits(const RingLayout& at, int n) : orbit(at.size(), -1) {
        insert(0, 0);
        for (int i = 0; i < n; ++i) insert(at.edge(i), at.edge((n - i) % n));
        for (int i = 0; at.quads && i < n; ++i) insert(at.face(i), at.face(n - 1 - i));
    }
    int count() const { return static_cast<int>(length.size()); }

  private:
    void insert(int a, int b) {
        if (orbit[a] >= 0) return;
        orbit[a] = orbit[b] = count();
        representative.push_back(a);
        length.push_back(a == b ? 1 : 2);
    }
};

/// Limit of a dart: an interior vertex, no corner, whose edge 0 alone is sharp. Left eigenvectors of the ring matrix.
RingLimit dart_limit(SchemeKind scheme, int n) {
    RingShape shape{.faces = n, .sharp = std::vector<std::uint8_t>(n, 0)};
    shape.sharp[0] = 1;
    const RingLayout at(scheme, shape);
    const std::vector<double> full = ring_matrix(scheme, shape);
    const int size = at.size();

    const MirrorOrbits orbits(at, n);
    const int count = orbits.count();
    detail::DenseMatrix<double> m(count);
    for (int a = 0; a < count; ++a)
        for (int j = 0; j < size; ++j)
            m(a, orbits.orbit[j]) += full[static_cast<std::size_t>(orbits.representative[a]) * size + j];
    const auto spread = [&](const std::vector<double>& y, double scale) {
        std::vector<double> weights(size);
        for (int j = 0; j < size; ++j) weights[j] = scale * y[orbits.orbit[j]] / orbits.length[orbits.orbit[j]];
        return weights;
    };

    RingLimit limit;
    const std::vector<double> position = detail::left_eigenvector(m, 1.0);
    limit.position = spread(position, 1 / std::accumulate(position.begin(), position.end(), 0.0));

    const std::vector<detail::Complex> values = detail::eigenvalues(m);
    std::vector<double> magnitude(count);
    for (int i = 0; i < count; ++i) magnitude[i] = std::abs(values[i]);
    std::vector<int> order(count);
    for (int i = 0; i < count; ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](int a, int b) { return magnitude[a] > magnitude[b]; });

    const double angle = 2 * std::numbers::pi / n;
    RingLimit::Sector sector{.first_edge = 0, .faces = n};
    sector.lambda1 = values[order[1]].real();
    const std::vector<double> symmetric = detail::left_eigenvector(m, sector.lambda1);
    // The mode grows towards the crease edge.
    double along = 0;
    const std::vector<double> weights = spread(symmetric, 1);
    for (int i = 0; i < n; ++i) along += weights[at.edge(i)] * std::cos(i * angle);
    sector.tangent1 = spread(symmetric, along < 0 ? -1 : 1);

    // Antisymmetric modes vanish on the crease edge, so the smooth rules' sine mode is theirs as well.
    sector.tangent2.assign(size, 0.0);
    if (at.quads) {
        sector.lambda2 = CatmullClark::mode_eigenvalue(angle);
        const double factor = CatmullClark::tangent_edge_factor(angle);
        for (int i = 0; i < n; ++i) {
            sector.tangent2[at.edge(i)] = n == 2 ? 0 : factor * std::sin(i * angle);
            sector.tangent2[at.face(i)] = std::sin(i * angle) + std::sin((i + 1) * angle);
        }
        if (n == 2) {
            sector.tangent2[at.face(0)] = 1;
            sector.tangent2[at.face(1)] = -1;
        }
    } else {
        sector.lambda2 = Loop::mode_eigenvalue(angle);
        for (int i = 0; n > 2 && i < n; ++i) sector.tangent2[at.edge(i)] = std::sin(i * angle);
    }
    const double third = count > 2 ? magnitude[order[2]] : 0.0;
    sector.has_tangent_plane = n > 2 && third < std::min(sector.lambda1, sector.lambda2);
    limit.sectors.push_back(std::move(sector));
    return limit;
}

// Most faces in a sector beside a crease with which the plain rules still have a tangent plane: up to these the sine
// mode with 2 pi / K is below 1/2, the eigenvalue along the crease.
constexpr int k_plain_faces_quads = 3, k_plain_faces_triangles = 5;

void smooth_sector(const RingLayout& at, RingLimit& limit) {
    const int n = at.faces;
    const RingMask mask = at.quads ? CatmullClark::limit_mask(n) : Loop::limit_mask(n);
    limit.position.assign(at.size(), mask.edge);
    limit.position[0] = mask.vertex;
    for (int i = 0; at.quads && i < n; ++i) limit.position[at.face(i)] = mask.face;

    RingLimit::Sector s{.first_edge = 0, .faces = n};
    s.tangent1.assign(at.size(), 0.0);
    s.tangent2.assign(at.size(), 0.0);
    const double angle = 2 * pi / n;
    s.lambda1 = s.lambda2 = at.quads ? CatmullClark::mode_eigenvalue(angle) : Loop::mode_eigenvalue(angle);
    s.has_tangent_plane = n > 2;
    if (n == 2) {
        // At an angle of pi the closed forms vanish: the two differences are what is left.
        s.tangent1[at.edge(0)] = 1;
        s.tangent1[at.edge(1)] = -1;
        if (at.quads) {
            s.tangent2[at.face(0)] = 1;
            s.tangent2[at.face(1)] = -1;
        }
    } else if (n > 2) {
        const double factor = at.quads ? CatmullClark::tangent_edge_factor(angle) : 1;
        for (int i = 0; i < n; ++i) {
            s.tangent1[at.edge(i)] = factor * std::cos(i * angle);
            s.tangent2[at.edge(i)] = factor * std::sin(i * angle);
            if (!at.quads) continue;
            s.tangent1[at.face(i)] = std::cos(i * angle) + std::cos((i + 1) * angle);
            s.tangent2[at.face(i)] = std::sin(i * angle) + std::sin((i + 1) * angle);
        }
    }
    limit.sectors.push_back(std::move(s));
}

/// A sector of K faces from edge `first` on, at a crease or boundary vertex.
RingLimit::Sector crease_sector(const RingLayout& at, int first, int K) {
    RingLimit::Sector s{.first_edge = first, .faces = K};
    const auto edge = [&](int i) { return at.edge((first + i) % at.edges); };
    const auto face = [&](int i) { return at.face((first + i) % at.faces); };
    s.tangent1.assign(at.size(), 0.0);
    s.tangent2.assign(at.size(), 0.0);
    s.tangent1[edge(0)] += 1;
    s.tangent1[edge(K)] -= 1;
    s.lambda1 = 0.5;
    s.has_tangent_plane = K <= (at.quads ? k_plain_faces_quads : k_plain_faces_triangles);
    if (K == 1) {
        s.tangent2[0] = -2;
        s.tangent2[edge(0)] += 1;
        s.tangent2[edge(1)] += 1;
        s.lambda2 = 0.25;
        return s;
    }
    // The sector's sine mode: weights a sin(i theta) on inner edges and sin(i theta) + sin((i + 1) theta) on faces. The
    // columns of the ends (weight b) and of the centre (weight c) of the ring matrix then read
    //   (lambda - 1/2) b - c / 8 = right_end,   -b + (lambda - 3/4) c = right_centre.
    const double theta = pi / K, sum = 1 / std::tan(theta / 2);  // sum of sin(i theta), 0 < i < K
    double a, right_end, right_centre;
    if (at.quads) {
        s.lambda2 = CatmullClark::mode_eigenvalue(theta);
        a = CatmullClark::tangent_edge_factor(theta);
        right_end = s.lambda2 * std::sin(theta);
        right_centre = (CatmullClark::edge_end_quads * a + 0.5) * sum;
    } else {
        s.lambda2 = Loop::mode_eigenvalue(theta);
        a = 1;
        right_end = Loop::edge_opposite * std::sin(theta);
        right_centre = Loop::edge_end * sum;
    }
    const double determinant = (s.lambda2 - 0.5) * (s.lambda2 - 0.75) - 0.125;
    const double b = (right_end * (s.lambda2 - 0.75) + right_centre / 8) / determinant;
    const double c = ((s.lambda2 - 0.5) * right_centre + right_end) / determinant;
    s.tangent2[0] = c;
    s.tangent2[edge(0)] += b;
    s.tangent2[edge(K)] += b;
    for (int i = 1; i < K; ++i) s.tangent2[edge(i)] = a * std::sin(i * theta);
    for (int i = 0; at.quads && i < K; ++i) s.tangent2[face(i)] = std::sin(i * theta) + std::sin((i + 1) * theta);
    return s;
}

/// A sector of K faces from edge `first` on, at a corner.
RingLimit::Sector corner_sector(const RingLayout& at, int first, int K) {
    RingLimit::Sector s{.first_edge = first, .faces = K};
    const auto edge = [&](int i) { return at.edge((first + i) % at.edges); };
    s.tangent1.assign(at.size(), 0.0);
    s.tangent2.assign(at.size(), 0.0);
    s.lambda1 = s.lambda2 = 0.5;
    // Two triangles: the edge between them goes by 3/8, into the plane of the two sharp ones.
    if (K == 1 || (K == 2 && !at.quads)) {
        s.tangent1[edge(0)] = s.tangent2[edge(K)] = 1;
        s.tangent1[0] = s.tangent2[0] = -1;
        s.has_tangent_plane = true;
        return s;
    }
    for (int i = 0; i <= K; ++i) {
        const double x = std::cos(i * pi / K), y = std::sin(i * pi / K);
        s.tangent1[edge(i)] += x;
        s.tangent1[0] -= x;
        s.tangent2[edge(i)] += y;
        s.tangent2[0] -= y;
    }
    return s;
}

/// A corner tag on a vertex with no sharp edge or one: a fixed point in the middle of one sector all around.
RingLimit::Sector isolated_corner_sector(const RingLayout& at) {
    RingLimit::Sector s{.first_edge = 0, .faces = at.faces, .lambda1 = 0.5, .lambda2 = 0.5};
    s.tangent1.assign(at.size(), 0.0);
    s.tangent2.assign(at.size(), 0.0);
    for (int i = 0; at.edges > 2 && i < at.edges; ++i) {
        s.tangent1[at.edge(i)] = std::cos(2 * pi * i / at.edges);
        s.tangent2[at.edge(i)] = std::sin(2 * pi * i / at.edges);
    }
    if (at.edges == 2) {
        s.tangent1[at.edge(0)] = 1;
        s.tangent1[at.edge(1)] = -1;
    }
    return s;
}

void check(const RingShape& shape) {
    if (shape.faces < 1) throw std::invalid_argument("a ring has at least one face");
    if (!shape.sharp.empty() && static_cast<int>(shape.sharp.size()) != shape.edge_count())
        throw std::invalid_argument("a ring has one sharpness flag per edge");
}

RingLimit compute(SchemeKind scheme, const RingShape& shape) {
    check(shape);
    const RingLayout at(scheme, shape);
    const std::vector<int> sharp = at.sharp_edges(shape);
    const int count = static_cast<int>(sharp.size());
    const bool corner = shape.corner || count > 2;
    RingLimit limit;
    if (!corner && count == 0) {
        smooth_sector(at, limit);
    } else if (!corner && count == 1) {
        limit = dart_limit(scheme, shape.faces);
        // The dart's first edge is its sharp one: turn the weights to where it is here.
        const int turn = (at.quads ? 2 : 1) * sharp[0];
        RingLimit::Sector& s = limit.sectors[0];
        for (auto* weights : {&limit.position, &s.tangent1, &s.tangent2})
            std::rotate(weights->begin() + 1, weights->end() - turn, weights->end());
        s.first_edge = sharp[0];
    } else {
        limit.position.assign(at.size(), 0.0);
        limit.position[0] = corner ? 1 : k_crease_limit_mask.vertex;
        for (int i = 0; !corner && i < 2; ++i) limit.position[at.edge(sharp[i])] = k_crease_limit_mask.neighbour;
        if (count < 2) limit.sectors.push_back(isolated_corner_sector(at));
        const int sectors = count < 2 ? 0 : shape.boundary ? count - 1 : count;
        for (int i = 0; i < sectors; ++i) {
            const int from = sharp[i], faces = i + 1 < count ? sharp[i + 1] - from : sharp[0] + at.edges - from;
            limit.sectors.push_back(corner ? corner_sector(at, from, faces) : crease_sector(at, from, faces));
        }
    }
    const RingLimit::Sector& first = limit.sectors.front();
    limit.tangent1 = first.tangent1;
    limit.tangent2 = first.tangent2;
    limit.lambda1 = first.lambda1;
    limit.lambda2 = first.lambda2;
    limit.has_tangent_plane = limit.sectors.size() == 1 && first.has_tangent_plane;
    return limit;
}

class Cache {
  public:
    static constexpr int k_small = 256;  // rings up to this many faces are found without a lock

    const RingLimit& plain(SchemeKind scheme, bool boundary, int faces) {
        if (faces < 1) throw std::invalid_argument("a ring has at least one face");
        RingShape shape{.faces = faces, .boundary = boundary};
        if (faces >= k_small) return general(scheme, shape);
        auto& slot = small_[static_cast<int>(scheme)][boundary][faces];
        if (const RingLimit* found = slot.load(std::memory_order_acquire)) return *found;
        const RingLimit& made = general(scheme, shape);
        slot.store(&made, std::memory_order_release);
        return made;
    }

    const RingLimit& general(SchemeKind scheme, const RingShape& shape) {
        thread_local std::string key;
        key.assign({static_cast<char>(scheme), static_cast<char>(shape.boundary), static_cast<char>(shape.corner)});
        key.append(reinterpret_cast<const char*>(&shape.faces), sizeof shape.faces);
        for (const std::uint8_t s : shape.sharp) key.push_back(s != 0 ? 1 : 0);
        {
            std::shared_lock lock(mutex_);
            if (const auto it = map_.find(key); it != map_.end()) return *it->second;
        }
        auto made = std::make_unique<RingLimit>(compute(scheme, shape));
        std::unique_lock lock(mutex_);
        return *map_.try_emplace(key, std::move(made)).first->second;
    }

  private:
    std::array<std::array<std::array<std::atomic<const RingLimit*>, k_small>, 2>, 2> small_{};
    std::shared_mutex mutex_;
    std::unordered_map<std::string, std::unique_ptr<RingLimit>> map_;
};

Cache& cache() {
    static Cache instance;
    return instance;
}

}  // namespace

const RingLimit& ring_limit(SchemeKind scheme, const RingShape& shape) {
    const bool plain = !shape.corner && std::none_of(shape.sharp.begin() + (shape.boundary && !shape.sharp.empty()),
                                                     shape.sharp.end() - (shape.boundary && !shape.sharp.empty()),
                                                     [](std::uint8_t s) { return s != 0; });
    if (plain) {
        check(shape);
        return cache().plain(scheme, shape.boundary, shape.faces);
    }
    return cache().general(scheme, shape);
}

const RingLimit& smooth_ring_limit(SchemeKind scheme, int valence) { return cache().plain(scheme, false, valence); }
const RingLimit& boundary_ring_limit(SchemeKind scheme, int faces) { return cache().plain(scheme, true, faces); }

glm::dvec3 limit_normal(SchemeKind scheme, const RingShape& shape, const RingLimit& limit,
                        std::span<const glm::dvec3> ring) {
    // A cross product this much shorter than its factors is rounding, not direction, and so is it where what they add
    // up cancels.
    constexpr double k_parallel = 1e-12;
    const auto apply = [&](const std::vector<double>& weights, double& size) {
        // Differences from the centre: the weights sum to zero, and a far origin must not cost digits.
        glm::dvec3 t(0);
        for (std::size_t i = 1; i < weights.size(); ++i) {
            const glm::dvec3 term = weights[i] * (ring[i] - ring[0]);
            t += term;
            size += std::abs(term.x) + std::abs(term.y) + std::abs(term.z);
        }
        return t;
    };
    glm::dvec3 mean(0);
    bool degenerate = false;
    for (const RingLimit::Sector& s : limit.sectors) {
        double size_a = 0, size_b = 0;
        const glm::dvec3 a = apply(s.tangent1, size_a), b = apply(s.tangent2, size_b), n = glm::cross(a, b);
        const double length = glm::length(n);
        if (!(length > k_parallel * size_a * size_b)) {
            degenerate = true;
            continue;
        }
        mean += n / length;
    }
    double length = glm::length(mean);
    if (length > k_parallel && !(degenerate && limit.sectors.size() == 1)) return mean / length;

    const RingLayout at(scheme, shape);
    mean = glm::dvec3(0);
    for (int i = 0; i < shape.faces; ++i) {
        const glm::dvec3 a = ring[at.edge(i)] - ring[0], b = ring[at.edge((i + 1) % at.edges)] - ring[0];
        mean += at.quads ? glm::cross(ring[at.face(i)] - ring[0], b - a) : glm::cross(a, b);
    }
    length = glm::length(mean);
    double scale = 0;
    for (const glm::dvec3& p : ring) scale = std::max(scale, glm::dot(p - ring[0], p - ring[0]));
    return length > k_parallel * scale ? mean / length : glm::dvec3(0);
}

std::vector<double> ring_matrix(SchemeKind scheme, const RingShape& shape) {
    const RingLayout at(scheme, shape);
    const int n = at.edges, faces = shape.faces, size = at.size();
    const bool quads = scheme == SchemeKind::catmull_clark;
    std::vector<double> matrix(static_cast<std::size_t>(size) * size, 0.0);
    const auto add = [&](int row, int column, double w) { matrix[static_cast<std::size_t>(row) * size + column] += w; };

    const std::vector<int> sharp = at.sharp_edges(shape);
    if (shape.corner || sharp.size() > 2) {
        add(0, 0, 1);
    } else if (sharp.size() == 2) {
        add(0, 0, k_crease_vertex_mask.vertex);
        for (const int i : sharp) add(0, at.edge(i), k_crease_vertex_mask.neighbour);
    } else {
        const RingMask mask = quads ? CatmullClark::vertex_mask_quads(n) : Loop::vertex_mask(n);
        add(0, 0, mask.vertex);
        for (int i = 0; i < n; ++i) add(0, at.edge(i), mask.edge);
        for (int i = 0; quads && i < faces; ++i) add(0, at.face(i), mask.face);
    }
    for (int i = 0; i < n; ++i) {
        const int row = at.edge(i);
        if (at.is_sharp(shape, i)) {
            add(row, 0, 0.5);
            add(row, row, 0.5);
            continue;
        }
        const double end = quads ? CatmullClark::edge_end_quads : Loop::edge_end;
        const double side = quads ? CatmullClark::edge_side_quads : Loop::edge_opposite;
        add(row, 0, end);
        add(row, row, end);
        // A smooth edge has a face on each side, so both neighbours exist.
        add(row, at.edge((i + n - 1) % n), side);
        add(row, at.edge((i + 1) % n), side);
        if (quads) {
            add(row, at.face((i + faces - 1) % faces), side);
            add(row, at.face(i), side);
        }
    }
    for (int i = 0; quads && i < faces; ++i) {
        const int row = at.face(i);
        for (const int column : {0, at.edge(i), at.edge((i + 1) % n), row}) add(row, column, 0.25);
    }
    return matrix;
}

}  // namespace tetrakis
