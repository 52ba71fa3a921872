#include "tetrakis/refine/factored_grid.hpp"

#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/schemes/catmull_clark.hpp"

#include <algorithm>
#include <cstring>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

template <class T>
Vec3<T> point(const T* points, std::uint64_t i) {
    return {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
}
template <class T>
void write(T* points, std::uint64_t i, const Vec3<T>& p) {
    points[3 * i] = p.x;
    points[3 * i + 1] = p.y;
    points[3 * i + 2] = p.z;
}

// Points per task, as in the direct refinement.
constexpr std::uint32_t k_task_points = 8192;
std::uint32_t grain_of(std::uint32_t points_each) { return std::max(1u, k_task_points / (points_each + 8)); }

}  // namespace

/// The weight of the crease rule at the points of an edge, by their place on the next level.
template <class T>
struct FactoredGrid<T>::EdgeRule {
    EdgeRule(const TagStep& step, std::uint32_t e)
        : weight(step.crease.empty() ? T(0) : static_cast<T>(step.crease[e])) {
        if (step.varying.empty()) return;
        if (const auto found = step.varying.find(e); found != step.varying.end()) varying = &found->second;
    }
    T at(std::uint32_t finer_point) const {
        return varying == nullptr ? weight : static_cast<T>((*varying)[finer_point - 1]);
    }
    bool crease_alone() const { return varying == nullptr && weight == 1; }

    T weight;
    const std::vector<float>* varying = nullptr;
};

template <class T>
const T* FactoredGrid<T>::run(std::span<const Vec3<T>> control) {
    const auto buffer = [&](int level) {
        const std::size_t size = 3 * std::size_t{topology_.layout(level).vertex_count()};
        T* data = levels_[level & 1].reserve(size + k_limit_padding);
        std::fill_n(data + size, k_limit_padding, T(0));
        return data;
    };
    T* now = buffer(0);
    refine_to_base(topology_, control, now);
    for (int level = 0; level < topology_.levels; ++level) {
        T* fine = buffer(level + 1);
        refine_roots(level, now, fine);
        const RootLayout at = topology_.layout(level), finer = topology_.layout(level + 1);
        const TagStep& tags = topology_.tags.step(level);
        for_each_block(topology_.base.edge_count, grain_of(finer.edge_points()),
                       [&](std::uint32_t begin, std::uint32_t end) {
                           std::vector<T> lines;
                           for (std::uint32_t e = begin; e < end; ++e)
                               refine_edge(at, finer, tags, e, now, lines, fine);
                       });
        move_corners(at, tags, now, fine);
        now = fine;
    }
    return now;
}

template <class T>
void FactoredGrid<T>::refine_roots(int level, const T* old, T* fine) {
    const RootLayout at = topology_.layout(level), finer = topology_.layout(level + 1);
    const std::size_t n = at.segments(), last = n - 1;
    const std::uint32_t faces = topology_.base.face_count;
    T* const rims = rims_.reserve(3 * std::size_t{faces} * 4 * n);
    rims_points_ = rims;
    for_each_block(faces, grain_of(finer.root_points()), [&](std::uint32_t begin, std::uint32_t end) {
        // Kernels read one scalar past a point.
        std::vector<T> lines(12 * (n + 1) + 1), centres(3 * n * n + k_limit_padding),
            moved(3 * last * last + k_limit_padding);
        for (std::uint32_t f = begin; f < end; ++f) {
            const RootRows<T> root = gather(at.root(f), old, lines.data());
            kernels_.factored_centres(root, centres.data(), moved.data());
            kernels_.factored_edges(root, centres.data(), moved.data(), fine + 3 * std::uint64_t{finer.face_begin(f)});
            T* const rim = rims + 3 * (std::size_t{f} * 4 * n);
            for (std::size_t j = 0; j < n; ++j) {
                const std::size_t place[] = {j, j * n + last, last * n + last - j, (last - j) * n};
                for (std::size_t side = 0; side < 4; ++side)
                    std::copy_n(centres.data() + 3 * place[side], 3, rim + 3 * (side * n + j));
            }
        }
    });
}

template <class T>
void FactoredGrid<T>::refine_edge(const RootLayout& at, const RootLayout& finer, const TagStep& step, std::uint32_t e,
                                  const T* old, std::vector<T>& lines, T* fine) const {
    const MeshLevel& base = topology_.base;
    const std::uint32_t n = at.segments(), h = base.edge_halfedge[e], t = base.twin[h];
    const std::uint64_t length = 3 * (std::uint64_t{n} + 1);
    lines.resize(3 * length);
    T *line = lines.data(), *left = line + length, *right = left + length;
    gather(at.side(h), n + 1, old, line);
    const EdgeRule rule(step, e);
    if (n > 1 && !rule.crease_alone()) {
        gather_beside(at, h, false, old, left);
        gather_beside(at, t, true, old, right);
    }
    const std::uint64_t out = finer.edge_begin(e);
    // The first half-step: the vertices on the edge.
    for (std::uint32_t j = 1; j < n; ++j) {
        const Vec3<T> p = point(line, j), along = point(line, j - 1) + point(line, j + 1);
        const T w = rule.at(2 * j);
        const Vec3<T> crease =
            static_cast<T>(k_crease_vertex_mask.vertex) * p + static_cast<T>(k_crease_vertex_mask.neighbour) * along;
        Vec3<T> result = crease;
        if (w != 1) {
            const Vec3<T> cells = (point(cell(at, h, j - 1), 0) + point(cell(at, h, j), 0)) +
                                  (point(cell(at, t, n - 1 - j), 0) + point(cell(at, t, n - j), 0));
            const Vec3<T> smooth = T(0.5) * p + T(0.0625) * ((along + (point(left, j) + point(right, j))) + cells);
            result = w == 0 ? smooth : w * crease + (1 - w) * smooth;
        }
        write(fine, out + 2 * j - 1, result);
    }
    // The second: the points between them.
    for (std::uint32_t j = 0; j < n; ++j) {
        const Vec3<T> ends = point(line, j) + point(line, j + 1);
        const T w = rule.at(2 * j + 1);
        Vec3<T> result = T(0.5) * ends;
        if (w != 1) {
            const Vec3<T> smooth = T(0.25) * (ends + (point(cell(at, h, j), 0) + point(cell(at, t, n - 1 - j), 0)));
            result = w == 0 ? smooth : w * result + (1 - w) * smooth;
        }
        write(fine, out + 2 * j, result);
    }
}

template <class T>
void FactoredGrid<T>::move_corners(const RootLayout& at, const TagStep& step, const T* old, T* fine) const {
    const MeshLevel& base = topology_.base;
    /// Calls edge(i, neighbour) and face(centre) around a vertex.
    const auto around = [&](std::uint32_t v, auto&& edge, auto&& face) {
        const std::uint32_t start = base.vertex_halfedge[v];
        std::uint32_t h = start;
        int i = 0;
        do {
            edge(i++, at.first_along(h));
            face(cell(at, h, 0));
            const std::uint32_t before = base.prev(h);
            h = base.twin[before];
            if (h == none) edge(i, at.last_along(before));
        } while (h != start && h != none);
    };
    const auto smooth = [&](std::uint32_t v) {
        Vec3<T> edges(0), faces(0);
        int n = 0;
        around(
            v,
            [&](int, std::uint32_t w) {
                edges += point(old, w);
                ++n;
            },
            [&](const T* centre) { faces += point(centre, 0); });
        const RingMask m = CatmullClark::vertex_mask(n);
        return static_cast<T>(m.vertex) * point(old, v) + static_cast<T>(m.edge) * edges +
               static_cast<T>(m.face) * faces;
    };
    for_each_index(static_cast<std::uint32_t>(topology_.smooth.size()),
                   [&](std::uint32_t i) { write(fine, topology_.smooth[i], smooth(topology_.smooth[i])); });
    const auto tagged = topology_.tags.vertices();
    for_each_index(static_cast<std::uint32_t>(tagged.size()), [&](std::uint32_t i) {
        const std::uint32_t v = tagged[i];
        const VertexBlend& blend = step.blend[i];
        Vec3<T> result =
            static_cast<T>(blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * point(old, v);
        if (blend.crease.weight > 0) {
            Vec3<T> ends(0);
            around(
                v,
                [&](int edge, std::uint32_t w) {
                    if (edge == blend.crease.a || edge == blend.crease.b) ends += point(old, w);
                },
                [](const T*) {});
            result += static_cast<T>(blend.crease.weight * k_crease_vertex_mask.neighbour) * ends;
        }
        if (blend.smooth > 0) result += static_cast<T>(blend.smooth) * smooth(v);
        write(fine, v, result);
    });
    // Vertices without faces stay.
    for (std::uint32_t v = 0; v < base.vertex_count; ++v)
        if (base.vertex_halfedge[v] == none) write(fine, v, point(old, v));
}

template class FactoredGrid<float>;
template class FactoredGrid<double>;

}  // namespace tetrakis::detail
