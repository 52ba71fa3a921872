#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/mesh_check.hpp"
#include "meshes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

// Random control meshes for property tests: a grid on a plane, torus or sphere, whose faces are cut into triangles,
// merged into n-gons, removed (for boundaries) and tagged. The same seed gives the same mesh on every platform.
namespace tetrakis::test {

/// splitmix64. Unlike the distributions of the standard library, it gives the same numbers on every platform.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
        return z ^ (z >> 31);
    }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(next() % n); }
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    bool chance(double p) { return uniform() < p; }
    template <class T>
    void shuffle(std::vector<T>& items) {
        for (std::size_t i = items.size(); i > 1; --i)
            std::swap(items[i - 1], items[below(static_cast<std::uint32_t>(i))]);
    }

  private:
    std::uint64_t state_;
};

template <class T>
std::vector<T> random_subset(const std::vector<T>& items, double chance, Random& random) {
    std::vector<T> result;
    for (const T& item : items)
        if (random.chance(chance)) result.push_back(item);
    return result;
}

/// 0 .. count - 1, and the number in the environment variable TETRAKIS_SEED where it is set.
inline std::vector<std::uint64_t> seeds(std::uint64_t count) {
    std::vector<std::uint64_t> result;
    for (std::uint64_t s = 0; s < count; ++s) result.push_back(s);
    if (const char* extra = std::getenv("TETRAKIS_SEED")) result.push_back(std::strtoull(extra, nullptr, 10));
    return result;
}

enum class Topology { plane, torus, sphere };

struct RandomMeshOptions {
    Topology topology = Topology::plane;
    int columns = 5, rows = 4;    ///< cells of the grid; at least 3 each on torus and sphere
    double split = 0.2;           ///< chance of a quad to be cut into two triangles
    double merge = 0.2;           ///< chance of a face to be merged with a neighbour
    double edge_vertices = 0.02;  ///< chance of an edge to get a vertex of valence 2
    int removed_faces = 2;        ///< faces taken out (fewer where the rest would not be a manifold)
    double hole = 0.05;           ///< chance of a face to be tagged as a hole
    double crease = 0.15;         ///< chance of an edge to be tagged, half of them infinitely sharp
    double corner = 0.05;         ///< chance of a vertex to be tagged
    double bumps = 0.3;           ///< random displacement, in grid steps
    bool triangles_only = false;  ///< every face is a triangle
    BoundaryRule boundary_rule = BoundaryRule::edge_and_corner;
};

/// Options drawn from a seed: all topologies, sizes up to 7 x 7, all boundary rules.
inline RandomMeshOptions random_options(std::uint64_t seed) {
    Random random(seed * 7919 + 17);
    RandomMeshOptions o;
    o.topology = static_cast<Topology>(random.below(3));
    o.columns = 3 + static_cast<int>(random.below(5));
    o.rows = 3 + static_cast<int>(random.below(5));
    o.split = random.uniform(0, 0.5);
    o.merge = random.uniform(0, 0.4);
    o.removed_faces = static_cast<int>(random.below(4));
    if (random.chance(0.5)) o.hole = 0;
    o.boundary_rule = static_cast<BoundaryRule>(random.chance(0.2) ? 0 : 1 + random.below(2));
    return o;
}

namespace detail {

using Polygon = std::vector<std::uint32_t>;

class RandomMeshMaker {
  public:
    RandomMeshMaker(std::uint64_t seed, const RandomMeshOptions& options) : random_(seed), o_(options) {}

    ControlMeshData run() {
        o_.topology == Topology::sphere ? make_sphere() : make_grid(o_.topology == Topology::torus);
        if (!o_.triangles_only) merge_faces();
        split_faces();
        if (!o_.triangles_only) add_edge_vertices();
        for (Polygon& p : faces_) std::rotate(p.begin(), p.begin() + random_.below(size(p)), p.end());
        random_.shuffle(faces_);
        remove_faces();
        ControlMeshData data = pack(faces_);
        add_tags(data);
        data.boundary_rule = o_.boundary_rule;
        return data;
    }

  private:
    static std::uint32_t size(const Polygon& p) { return static_cast<std::uint32_t>(p.size()); }
    double bump() { return random_.uniform(-o_.bumps, o_.bumps); }

    void make_grid(bool torus) {
        const auto w = static_cast<std::uint32_t>(torus ? std::max(3, o_.columns) : o_.columns),
                   h = static_cast<std::uint32_t>(torus ? std::max(3, o_.rows) : o_.rows);
        const std::uint32_t across = torus ? w : w + 1, down = torus ? h : h + 1;  // vertices
        const double tau = 2 * std::numbers::pi;
        for (std::uint32_t y = 0; y < down; ++y)
            for (std::uint32_t x = 0; x < across; ++x) {
                if (!torus) {
                    positions_.emplace_back(x + bump(), y + bump(), 2 * bump());
                    continue;
                }
                const double a = tau * (x + bump()) / w, b = tau * (y + bump()) / h, r = 1 + 0.5 * bump();
                positions_.emplace_back((2.5 + r * std::cos(b)) * std::cos(a), (2.5 + r * std::cos(b)) * std::sin(a),
                                        r * std::sin(b));
            }
        const auto at = [&](std::uint32_t x, std::uint32_t y) { return (y % down) * across + x % across; };
        for (std::uint32_t y = 0; y < h; ++y)
            for (std::uint32_t x = 0; x < w; ++x)
                faces_.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
    }

    /// Meridians and parallels, with triangles at the poles.
    void make_sphere() {
        const auto w = static_cast<std::uint32_t>(std::max(3, o_.columns)),
                   h = static_cast<std::uint32_t>(std::max(3, o_.rows));
        for (std::uint32_t y = 1; y < h; ++y)
            for (std::uint32_t x = 0; x < w; ++x) {
                const double a = 2 * std::numbers::pi * (x + bump()) / w, b = std::numbers::pi * (y + bump()) / h;
                const double r = 2 + 0.5 * bump();
                positions_.emplace_back(r * std::sin(b) * std::cos(a), r * std::sin(b) * std::sin(a), -r * std::cos(b));
            }
        const auto south = static_cast<std::uint32_t>(positions_.size());
        positions_.emplace_back(0, 0, -2);
        positions_.emplace_back(0, 0, 2);
        const auto at = [&](std::uint32_t x, std::uint32_t y) { return (y - 1) * w + x % w; };
        for (std::uint32_t x = 0; x < w; ++x) {
            faces_.push_back({south, at(x + 1, 1), at(x, 1)});
            for (std::uint32_t y = 1; y + 1 < h; ++y)
                faces_.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
            faces_.push_back({south + 1, at(x, h - 1), at(x + 1, h - 1)});
        }
    }

    /// Directed edge -> face.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges() const {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> result;
        for (std::uint32_t f = 0; f < faces_.size(); ++f)
            for (std::uint32_t i = 0; i < faces_[f].size(); ++i)
                result[{faces_[f][i], faces_[f][(i + 1) % faces_[f].size()]}] = f;
        return result;
    }

    void merge_faces() {
        const auto map = edges();
        std::vector<bool> used(faces_.size(), false);
        std::vector<Polygon> merged;
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            if (used[f] || !random_.chance(o_.merge)) continue;
            Polygon p = faces_[f];
            std::rotate(p.begin(), p.begin() + random_.below(size(p)), p.end());
            const auto other = map.find({p[1], p[0]});
            if (other == map.end() || used[other->second] || other->second == f) continue;
            Polygon q = faces_[other->second];
            std::rotate(q.begin(), std::find(q.begin(), q.end(), p[1]), q.end());
            const auto common =
                std::count_if(q.begin(), q.end(), [&](auto v) { return std::find(p.begin(), p.end(), v) != p.end(); });
            if (common != 2) continue;
            used[f] = used[other->second] = true;
            // p = (p0, p1, ...), q = (p1, p0, q2, ...): the union runs p1 ... p0 q2 ...
            Polygon sum(p.begin() + 1, p.end());
            sum.push_back(p[0]);
            sum.insert(sum.end(), q.begin() + 2, q.end());
            merged.push_back(std::move(sum));
        }
        for (std::uint32_t f = 0; f < faces_.size(); ++f)
            if (!used[f]) merged.push_back(faces_[f]);
        faces_ = std::move(merged);
    }

    void split_faces() {
        std::vector<Polygon> result;
        // On a small torus two quads can have the same diagonal, or the diagonal of one can be an edge already.
        std::set<std::pair<std::uint32_t, std::uint32_t>> taken;
        for (const auto& [edge, f] : edges()) taken.insert(std::minmax(edge.first, edge.second));
        for (Polygon& p : faces_) {
            if (p.size() == 4 && (o_.triangles_only || random_.chance(o_.split))) {
                std::uint32_t s = random_.below(2);
                if (!taken.insert(std::minmax(p[s], p[s + 2])).second) {
                    s = 1 - s;
                    if (!taken.insert(std::minmax(p[s], p[s + 2])).second && !o_.triangles_only) {
                        result.push_back(std::move(p));
                        continue;
                    }
                }
                result.push_back({p[s], p[s + 1], p[s + 2]});
                result.push_back({p[s + 2], p[(s + 3) % 4], p[s]});
            } else {
                result.push_back(std::move(p));
            }
        }
        faces_ = std::move(result);
    }

    void add_edge_vertices() {
        for (const auto& [edge, f] : edges()) {
            const auto [a, b] = edge;
            if (a > b || !random_.chance(o_.edge_vertices)) continue;
            const auto v = static_cast<std::uint32_t>(positions_.size());
            positions_.push_back(0.5 * (positions_[a] + positions_[b]) + Vec3d(bump(), bump(), bump()) * 0.5);
            for (Polygon& p : faces_)
                for (std::size_t i = 0; i < p.size(); ++i) {
                    const std::uint32_t c = p[i], d = p[(i + 1) % p.size()];
                    if ((c == a && d == b) || (c == b && d == a)) {
                        p.insert(p.begin() + static_cast<std::ptrdiff_t>(i) + 1, v);
                        break;
                    }
                }
        }
    }

    void remove_faces() {
        for (int i = 0; i < o_.removed_faces && faces_.size() > 2; ++i) {
            std::vector<Polygon> fewer = faces_;
            fewer.erase(fewer.begin() + random_.below(static_cast<std::uint32_t>(fewer.size())));
            if (find_faults(pack(fewer)).empty()) faces_ = std::move(fewer);
        }
    }

    /// Vertices without faces are left out.
    ControlMeshData pack(const std::vector<Polygon>& faces) const {
        ControlMeshData data;
        std::vector<std::uint32_t> number(positions_.size(), VertexId::none);
        for (const Polygon& p : faces)
            for (std::uint32_t v : p) number[v] = 0;
        for (std::size_t v = 0; v < positions_.size(); ++v)
            if (number[v] == 0) {
                number[v] = static_cast<std::uint32_t>(data.positions.size());
                data.positions.push_back(positions_[v]);
            }
        data.face_offsets.push_back(0);
        for (const Polygon& p : faces) {
            for (std::uint32_t v : p) data.face_vertices.push_back(number[v]);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
        return data;
    }

    float sharpness() {
        if (random_.chance(0.5)) return k_infinite_sharpness;
        return random_.chance(0.5) ? static_cast<float>(1 + random_.below(4))
                                   : static_cast<float>(random_.uniform(0.1, 4.0));
    }

    void add_tags(ControlMeshData& data) {
        std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
        for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f)
            for (std::uint32_t i = data.face_offsets[f], last = data.face_offsets[f + 1] - 1; i <= last; ++i)
                edges.insert(
                    std::minmax(data.face_vertices[i], data.face_vertices[i == last ? data.face_offsets[f] : i + 1]));
        for (const auto& [a, b] : edges)
            if (random_.chance(o_.crease)) data.creases.push_back({a, b, sharpness(), 0});
        for (std::uint32_t v = 0; v < data.positions.size(); ++v)
            if (random_.chance(o_.corner)) data.corners.push_back({v, sharpness(), 0});
        const auto face_count = static_cast<std::uint32_t>(data.face_offsets.size() - 1);
        for (std::uint32_t f = 0; f < face_count; ++f)
            if (random_.chance(o_.hole) && data.holes.size() + 1 < face_count) data.holes.push_back(f);
    }

    Random random_;
    RandomMeshOptions o_;
    std::vector<Vec3d> positions_;
    std::vector<Polygon> faces_;
};

}  // namespace detail

inline ControlMeshData random_mesh_data(std::uint64_t seed, const RandomMeshOptions& options) {
    return detail::RandomMeshMaker(seed, options).run();
}
inline ControlMesh random_mesh(std::uint64_t seed, const RandomMeshOptions& options) {
    return ControlMesh::build(random_mesh_data(seed, options));
}
/// A mesh with everything drawn from the seed.
inline ControlMesh random_mesh(std::uint64_t seed) { return random_mesh(seed, random_options(seed)); }

/// UVs in two charts, far from each other; every third face is in the second one.
inline void add_charts(ControlMeshData& data) {
    const auto count = static_cast<std::uint32_t>(data.positions.size());
    for (const double shift : {0.0, 100.0})
        for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x + shift, p.y + 0.5 * p.z);
    for (std::size_t f = 0; f + 1 < data.face_offsets.size(); ++f)
        for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c)
            data.face_uvs.push_back(data.face_vertices[c] + (f % 3 == 2 ? count : 0));
}

/// A grid of n x n quads, all of different shapes.
inline ControlMeshData skewed_grid(std::uint32_t n) {
    ControlMeshData data = grid(n);
    for (std::uint32_t i = 0; i < data.positions.size(); ++i) {
        const std::uint32_t x = i % (n + 1), y = i / (n + 1);
        data.positions[i] = {x + 0.1 * y, y - 0.05 * x * x, 0.3 * ((x * 7 + y * 5) % 4)};
    }
    return data;
}

}  // namespace tetrakis::test

// Random meshes that vertex quadtrees take.
namespace tetrakis::test {

enum class DualTags { infinitely_sharp, of_all_kinds };

/// n-gons, boundaries with and without corners, holes, genus 0 and 1, creases and corners as the options say. Tags are
/// all infinitely sharp, or half of them, the others up to 4. The first of seed, seed + 1000, ... is used whose mesh
/// has no inner vertex of valence 2.
inline ControlMesh random_dual_mesh(std::uint64_t seed, RandomMeshOptions options,
                                    DualTags tags = DualTags::infinitely_sharp) {
    options.edge_vertices = 0;
    for (;; seed += 1000) {
        ControlMeshData data = random_mesh_data(seed, options);
        if (tags == DualTags::infinitely_sharp) {
            for (auto& crease : data.creases) crease.sharpness = k_infinite_sharpness;
            for (auto& corner : data.corners) corner.sharpness = k_infinite_sharpness;
        }
        ControlMesh mesh = ControlMesh::build(std::move(data));
        bool valence2 = false;  // merged faces can leave such vertices
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            valence2 = valence2 || (!mesh.is_boundary(VertexId(v)) && mesh.face_valence(VertexId(v)) == 2);
        if (!valence2) return mesh;
    }
}
/// The same without inner creases and without tagged corners.
inline ControlMesh random_dual_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.crease = options.corner = 0;
    return random_dual_mesh(seed, options);
}
/// The same with creases that end at boundaries or inside, cross, or are closed, and corners on them and elsewhere.
inline ControlMesh random_creased_dual_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.crease = 0.25;
    options.corner = 0.1;
    return random_dual_mesh(seed, options);
}

}  // namespace tetrakis::test
