#include "tetrakis/refine/grid_refinement.hpp"

#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/uniform_cost.hpp"
#include "tetrakis/schemes/catmull_clark.hpp"
#include "tetrakis/schemes/loop.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

/// Points per task: large enough that starting one is nothing, small enough for many on two levels of a small mesh.
constexpr std::uint32_t k_task_points = 8192;

std::uint32_t grain_of(std::uint32_t points_each) { return std::max(1u, k_task_points / (points_each + 8)); }

/// The rules of Loop's regular vertices (valence 6) and edges.
template <class T>
constexpr TriangleWeights<T> loop_weights() {
    return {T(0.625), T(0.0625), static_cast<T>(Loop::edge_end), static_cast<T>(Loop::edge_opposite)};
}

}  // namespace

GridTopology::GridTopology(const ControlMesh& mesh, SchemeKind kind, int level_count, PointRule point_rule)
    : scheme(kind), rule(point_rule), method(mesh.crease_method()), control(control_level(mesh)), levels(level_count) {
    const bool quads = scheme == SchemeKind::catmull_clark;
    if (quads && all_quads(mesh)) control.face_size = 4;
    if (quads && control.face_size != 4) {
        base = refine_to_quads(control, method);
        base_level = 1;
        --levels;
    } else {
        base = std::move(control);
        control = {};
    }
    tags = UniformTags(base, method, levels);
    for (std::uint32_t v = 0; v < base.vertex_count; ++v)
        if (base.vertex_halfedge[v] != none && !(base.has_tags() && base.tagged[v] != 0)) smooth.push_back(v);
    for (int n = 1; n < 64; ++n) masks[n] = quads ? CatmullClark::vertex_mask_quads(n) : Loop::vertex_mask(n);
}

template <class T>
void GridPoints<T>::start(std::span<const Vec3<T>> control, T* out) {
    if (topology_.base_level == 0) {
        static_assert(sizeof(Vec3<T>) == 3 * sizeof(T));
        std::memcpy(static_cast<void*>(out), control.data(), control.size_bytes());
        return;
    }
    // The first refinement of n-gons is the general one, in double.
    std::vector<Vec3d> finer(topology_.base.vertex_count);
    const auto refine = [&](std::span<const Vec3d> points) {
        refine_points(topology_.control, topology_.method, topology_.rule, points, finer);
    };
    if constexpr (std::is_same_v<T, double>) {
        refine(control);
    } else {
        const std::vector<Vec3d> points(control.begin(), control.end());
        refine(points);
    }
    for (std::size_t v = 0; v < finer.size(); ++v)
        for (int i = 0; i < 3; ++i) out[3 * v + i] = static_cast<T>(finer[v][i]);
}

template <class T>
const T* GridPoints<T>::run(std::span<const Vec3<T>> control, T* out, const RunContext& context) {
    const auto buffer = [&](int level) {
        const std::size_t size = 3 * std::size_t{topology_.layout(level).vertex_count()};
        T* data = buffers_[level & 1].reserve(size + k_limit_padding);
        std::fill_n(data + size, k_limit_padding, T(0));
        return data;
    };
    const int levels = topology_.levels;
    const auto target = [&](int level) { return level == levels && out != nullptr ? out : buffer(level); };
    T* now = target(0);
    start(control, now);
    double done = 0;
    for (int l = 0; l < levels; ++l) {
        // Each level takes four times as long as the one before.
        const double next = l + 1 == levels ? 1 : 1.0 / static_cast<double>(std::uint64_t{1} << 2 * (levels - 1 - l));
        T* finer = target(l + 1);
        step(l, now, finer, context, done, next);
        now = finer;
        done = next;
    }
    return now;
}

template <class T>
void GridPoints<T>::step(int level, const T* coarse, T* fine, const RunContext& context, double from, double to) {
    const RootLayout at = topology_.layout(level), finer = topology_.layout(level + 1);
    const TagStep& tags = topology_.tags.step(level);
    context.report("refine", from);
    corners(at, tags, coarse, fine);
    for_each_block(topology_.base.edge_count, grain_of(finer.edge_points()),
                   [&](std::uint32_t begin, std::uint32_t end) {
                       for (std::uint32_t e = begin; e < end; ++e) edge(at, finer, tags, e, coarse, fine);
                   });
    for_each_reported_block(topology_.base.face_count, grain_of(finer.root_points()), context, "refine", from, to,
                            [&](std::uint32_t begin, std::uint32_t end) {
                                for (std::uint32_t f = begin; f < end; ++f) root(at, finer, f, coarse, fine);
                            });
}

template <class T>
void GridPoints<T>::corners(const RootLayout& at, const TagStep& step, const T* coarse, T* fine) const {
    const MeshLevel& base = topology_.base;
    const auto point = [&](std::uint32_t v) {
        const T* p = coarse + 3 * std::uint64_t{v};
        return Vec3<T>(p[0], p[1], p[2]);
    };
    const auto write = [&](std::uint32_t v, const Vec3<T>& p) {
        T* to = fine + 3 * std::uint64_t{v};
        to[0] = p.x;
        to[1] = p.y;
        to[2] = p.z;
    };
    if (topology_.rule == PointRule::linear) {
        std::copy_n(coarse, 3 * std::uint64_t{base.vertex_count}, fine);
        return;
    }
    const bool quads = at.quads();
    const auto smooth = [&](std::uint32_t v) {
        const std::uint32_t start = base.vertex_halfedge[v];
        Vec3<T> edges(0), faces(0);
        std::uint32_t n = 0, h = start;
        do {
            edges += point(at.first_along(h));
            if (quads) faces += point(at.diagonal(h));
            ++n;
            const std::uint32_t before = base.prev(h);
            h = base.twin[before];
            // A boundary's last edge; only where a vertex is on the way from sharp to smooth.
            if (h == none) {
                edges += point(at.last_along(before));
                ++n;
            }
        } while (h != start && h != none);
        const RingMask m = n < 64       ? topology_.masks[n]
                           : at.quads() ? CatmullClark::vertex_mask_quads(static_cast<int>(n))
                                        : Loop::vertex_mask(static_cast<int>(n));
        return static_cast<T>(m.vertex) * point(v) + static_cast<T>(m.edge) * edges + static_cast<T>(m.face) * faces;
    };
    for_each_index(static_cast<std::uint32_t>(topology_.smooth.size()),
                   [&](std::uint32_t i) { write(topology_.smooth[i], smooth(topology_.smooth[i])); });
    const auto tagged = topology_.tags.vertices();
    for_each_index(static_cast<std::uint32_t>(tagged.size()), [&](std::uint32_t i) {
        const std::uint32_t v = tagged[i];
        const VertexBlend& blend = step.blend[i];
        Vec3<T> result = static_cast<T>(blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * point(v);
        if (blend.crease.weight > 0) {
            const T weight = static_cast<T>(blend.crease.weight * k_crease_vertex_mask.neighbour);
            const std::uint32_t start = base.vertex_halfedge[v];
            std::uint32_t h = start;
            int edge = 0;
            Vec3<T> ends(0);
            do {
                if (edge == blend.crease.a || edge == blend.crease.b) ends += point(at.first_along(h));
                ++edge;
                const std::uint32_t before = base.prev(h);
                h = base.twin[before];
                if (h == none && (edge == blend.crease.a || edge == blend.crease.b))
                    ends += point(at.last_along(before));
            } while (h != start && h != none);
            result += weight * ends;
        }
        if (blend.smooth > 0) result += static_cast<T>(blend.smooth) * smooth(v);
        write(v, result);
    });
    // Vertices without faces stay.
    for (std::uint32_t v = 0; v < base.vertex_count; ++v)
        if (base.vertex_halfedge[v] == none) write(v, point(v));
}

template <class T>
void GridPoints<T>::edge(const RootLayout& at, const RootLayout& finer, const TagStep& step, std::uint32_t e,
                         const T* coarse, T* fine) const {
    const MeshLevel& base = topology_.base;
    const std::uint32_t n = at.segments(), h = base.edge_halfedge[e];
    T* out = fine + 3 * std::uint64_t{finer.edge_begin(e)};
    const PointLine<T> line = side_line(at, h, false, coarse);
    if (topology_.rule == PointRule::linear) return kernels_.refine_line(line, n, {T(0), T(1)}, out);

    constexpr QuadWeights<T> crease_weights{static_cast<T>(k_crease_vertex_mask.neighbour),
                                            static_cast<T>(k_crease_vertex_mask.vertex)};
    const T crease = step.crease.empty() ? T(0) : static_cast<T>(step.crease[e]);
    const std::vector<float>* varying = nullptr;
    if (!step.varying.empty())
        if (const auto found = step.varying.find(e); found != step.varying.end()) varying = &found->second;
    if (varying == nullptr && crease == 1) return kernels_.refine_line(line, n, crease_weights, out);

    const PointLine<T> left = beside_line(at, h, false, coarse), right = beside_line(at, base.twin[h], true, coarse);
    if (at.quads())
        kernels_.refine_strip_quads(left, line, right, n, crease_weights, out);
    else
        kernels_.refine_strip_triangles(left, line, right, n, loop_weights<T>(), out);
    if (varying == nullptr && crease == 0) return;
    // Mixed point by point: out has the smooth points.
    std::vector<T> sharp(6 * std::uint64_t{n} - 3);
    kernels_.refine_line(line, n, crease_weights, sharp.data());
    for (std::uint32_t j = 0; j + 1 < 2 * n; ++j) {
        const T w = varying == nullptr ? crease : static_cast<T>((*varying)[j]);
        for (std::uint64_t i = 3 * std::uint64_t{j}; i < 3 * std::uint64_t{j} + 3; ++i)
            out[i] = w * sharp[i] + (1 - w) * out[i];
    }
}

template <class T>
void GridPoints<T>::root(const RootLayout& at, const RootLayout& finer, std::uint32_t f, const T* coarse,
                         T* fine) const {
    const RootLines<T> lines = root_lines(at, f, coarse);
    T* out = fine + 3 * std::uint64_t{finer.root_begin(f)};
    const bool linear = topology_.rule == PointRule::linear;
    if (at.quads()) {
        kernels_.refine_quad(lines, linear ? QuadWeights<T>{0, 1} : QuadWeights<T>{T(0.125), T(0.75)}, out);
        return;
    }
    kernels_.refine_triangle(lines, linear ? TriangleWeights<T>{1, 0, T(0.5), 0} : loop_weights<T>(), out);
}

void write_faces(const RootLayout& at, std::span<std::uint32_t> corners, const RunContext& context, KernelSet set) {
    const std::uint32_t n = at.segments(), size = at.quads() ? 4 : 3;
    const std::uint64_t root_corners = std::uint64_t{size} * n * n;
    const RootKernels<double>& kernels = root_kernels<double>(set);
    for_each_reported_block(at.base().face_count, grain_of(n * n), context, "faces", 0, 1,
                            [&](std::uint32_t begin, std::uint32_t end) {
                                std::vector<std::uint32_t> sides(4 * (std::size_t{n} + 1));
                                RootNumbers root{.left = sides.data(),
                                                 .right = &sides[n + 1],
                                                 .bottom = &sides[2 * n + 2],
                                                 .top = &sides[3 * n + 3],
                                                 .inner = 0,
                                                 .segments = n};
                                for (std::uint32_t f = begin; f < end; ++f) {
                                    const auto number_side = [&](std::uint32_t h, bool reversed, std::uint32_t* line) {
                                        line[reversed ? n : 0] = at.base().origin[h];
                                        line[reversed ? 0 : n] = at.base().origin[at.base().next(h)];
                                        if (n == 1) return;
                                        RootLayout::Run run = at.inner_along(h);
                                        for (std::uint32_t j = 1; j < n; ++j, run.begin += run.step)
                                            line[reversed ? n - j : j] = run.begin;
                                    };
                                    root.inner = at.root_begin(f);
                                    number_side(size * f, false, root.bottom);
                                    number_side(size * f + 1, false, root.right);
                                    number_side(size * f + size - 1, true, root.left);
                                    std::uint32_t* out = &corners[f * root_corners];
                                    if (size == 4) {
                                        number_side(4 * f + 2, true, root.top);
                                        kernels.number_quads(root, out);
                                    } else {
                                        kernels.number_triangles(root, out);
                                    }
                                }
                            });
}

template class GridPoints<float>;
template class GridPoints<double>;

}  // namespace tetrakis::detail
