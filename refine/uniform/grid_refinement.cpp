#include "grid_refinement.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../../schemes/rules/loop.hpp"
#include "uniform_cost.hpp"

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

/// Of a cubic B-spline: along one direction of Catmull-Clark's regular vertices, and along creases.
template <class T>
constexpr QuadWeights<T> k_quad_weights{static_cast<T>(k_crease_vertex_mask.neighbour),
                                        static_cast<T>(k_crease_vertex_mask.vertex)};

const VertexMasks& masks_of(SchemeKind scheme) {
    static const VertexMasks quads(CatmullClark::vertex_mask_quads),
        triangles([](int valence) { return Loop::vertex_mask(valence); });
    return scheme == SchemeKind::catmull_clark ? quads : triangles;
}

}  // namespace

GridTopology::GridTopology(const ControlMesh& mesh, SchemeKind kind, int level_count, PointRule point_rule,
                           RootPlace place)
    : scheme(kind), rule(point_rule), method(mesh.crease_method()), levels(level_count), masks(masks_of(kind)) {
    const bool quads = scheme == SchemeKind::catmull_clark;
    base = control_level(mesh);
    if (quads) base.face_size = all_quads(mesh) ? 4 : 0;
    if (base.face_size == 0 && place == RootPlace::corners) {
        control = std::move(base);
        base = refine_to_quads(control, method);
        base_level = 1;
        --levels;
    }
    tags = UniformTags(base, method, levels);
    for (std::uint32_t v = 0; v < base.vertex_count; ++v)
        if (base.vertex_halfedge[v] != none && !(base.has_tags() && base.tagged[v] != 0)) smooth.push_back(v);
}

template <class T>
void refine_to_base(const GridTopology& topology, std::span<const Vec3<T>> control, T* out) {
    static_assert(sizeof(Vec3<T>) == 3 * sizeof(T));
    if (topology.base_level == 0) {
        std::memcpy(static_cast<void*>(out), control.data(), control.size_bytes());
        return;
    }
    std::vector<Vec3d> finer(topology.base.vertex_count);
    const std::vector<Vec3d> points(control.begin(), control.end());
    refine_points(topology.control, topology.method, topology.rule, points, {topology.control, finer});
    for (std::size_t v = 0; v < finer.size(); ++v)
        for (int k = 0; k < 3; ++k) out[3 * v + static_cast<std::size_t>(k)] = static_cast<T>(finer[v][k]);
}
template void refine_to_base(const GridTopology&, std::span<const Vec3<float>>, float*);
template void refine_to_base(const GridTopology&, std::span<const Vec3<double>>, double*);

template <class T>
void GridPoints<T>::start(std::span<const Vec3<T>> control, T* out) {
    const MeshLevel& base = topology_.base;
    if (base.face_size != 0) return refine_to_base(topology_, control, out);
    // The first refinement of n-gons is the general one, in double.
    const std::size_t corners = base.vertex_count, edges = base.edge_count, count = corners + edges + base.face_count;
    const auto refine = [&](std::span<const Vec3d> points, std::span<Vec3d> finer) {
        refine_points(base, topology_.method, topology_.rule, points,
                      {finer.first(corners), finer.subspan(corners + edges), finer.subspan(corners, edges)});
    };
    if constexpr (std::is_same_v<T, double>) {
        refine(control, {reinterpret_cast<Vec3d*>(out), count});
    } else {
        const std::vector<Vec3d> points(control.begin(), control.end());
        std::vector<Vec3d> finer(count);
        refine(points, finer);
        for (const Vec3d& p : finer)
            for (int i = 0; i < 3; ++i) *out++ = static_cast<T>(p[i]);
    }
}

template <class T>
const T* GridPoints<T>::run(std::span<const Vec3<T>> control, T* out, const RunContext& context) {
    const auto buffer = [&](int level) {
        const std::size_t size = 3 * std::size_t{topology_.layout(level).vertex_count()};
        T* data = buffers_[level & 1].reserve(size + k_limit_padding);
        std::fill_n(data + size, k_limit_padding, T(0));
        return data;
    };
    const int levels = topology_.levels, first = topology_.base.face_size == 0 ? 1 : 0;
    const auto target = [&](int level) { return level == levels && out != nullptr ? out : buffer(level); };
    T* now = target(first);
    start(control, now);
    double done = 0;
    for (int l = first; l < levels; ++l) {
        // Each level takes four times as long as the one before.
        const double next = l + 1 == levels ? 1 : 1.0 / static_cast<double>(std::uint64_t{1} << 2 * (levels - 1 - l));
        T* finer = target(l + 1);
        with_known_size(topology_.layout(l),
                        [&](const auto& at) { step(at, topology_.tags.step(l), now, finer, context, done, next); });
        now = finer;
        done = next;
    }
    return now;
}

template <class T>
template <class Layout>
void GridPoints<T>::step(const Layout& at, const TagStep& tags, const T* coarse, T* fine, const RunContext& context,
                         double from, double to) {
    const Layout finer(topology_.base, 2 * at.segments());
    context.report("refine", from);
    corners(at, tags, coarse, fine);
    for_each_block(topology_.base.edge_count, grain_of(finer.edge_points()),
                   [&](std::uint32_t begin, std::uint32_t end) {
                       Copy left, right;
                       for (std::uint32_t e = begin; e < end; ++e) edge(at, finer, tags, e, coarse, fine, left, right);
                   });
    for_each_reported_block(topology_.base.face_count, grain_of(finer.root_points()), context, "refine", from, to,
                            [&](std::uint32_t begin, std::uint32_t end) {
                                Copy scratch;
                                for (std::uint32_t f = begin; f < end; ++f) {
                                    if (at.is_root(f))
                                        root(at, finer, f, coarse, fine, scratch);
                                    else
                                        other_face(at, finer, f, coarse, fine);
                                }
                            });
}

template <class T>
template <class Layout>
void GridPoints<T>::corners(const Layout& at, const TagStep& step, const T* coarse, T* fine) const {
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
    // The centre of the face between half-edge h and the one before it, its corners added as in its root.
    const auto centre = [&](std::uint32_t h, std::uint32_t before) {
        const Vec3<T> p = point(base.origin[h]), along = point(at.first_along(h)), up = point(at.last_along(before)),
                      across = point(at.diagonal(h));
        return T(0.25) * (h % 2 == 0 ? (p + up) + (along + across) : (p + along) + (up + across));
    };
    const auto smooth = [&](std::uint32_t v) {
        const std::uint32_t start = base.vertex_halfedge[v];
        Vec3<T> edges(0), faces(0);
        std::uint32_t n = 0, h = start;
        do {
            edges += point(at.first_along(h));
            ++n;
            const std::uint32_t before = at.prev(h);
            if (half_steps_)
                faces += centre(h, before);
            else if (quads)
                faces += point(at.diagonal(h));
            h = base.twin[before];
            // A boundary's last edge; only where a vertex is on the way from sharp to smooth.
            if (h == none) {
                edges += point(at.last_along(before));
                ++n;
            }
        } while (h != start && h != none);
        const RingMask m = half_steps_ ? CatmullClark::vertex_mask(static_cast<int>(n)) : topology_.masks(n);
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
                const std::uint32_t before = at.prev(h);
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
template <class Layout>
void GridPoints<T>::edge(const Layout& at, const Layout& finer, const TagStep& step, std::uint32_t e, const T* coarse,
                         T* fine, Copy& left_copy, Copy& right_copy) const {
    const MeshLevel& base = topology_.base;
    const std::uint32_t n = at.segments(), h = base.edge_halfedge[e];
    T* out = fine + 3 * std::uint64_t{finer.edge_begin(e)};
    const PointLine<T> line = points_of(at.side(h), coarse);
    if (topology_.rule == PointRule::linear) return kernels_.refine_line(line, n, {T(0), T(1)}, out);

    const T crease = step.crease.empty() ? T(0) : static_cast<T>(step.crease[e]);
    const std::vector<float>* varying = nullptr;
    if (!step.varying.empty())
        if (const auto found = step.varying.find(e); found != step.varying.end()) varying = &found->second;
    if (varying == nullptr && crease == 1) return kernels_.refine_line(line, n, k_quad_weights<T>, out);
    if (varying == nullptr && crease == 0 && n == 1 && !half_steps_) return only_piece(at, h, coarse, out);

    const std::uint32_t t = base.twin[h];
    const PointLine<T> left = beside(at, h, false, coarse, left_copy), right = beside(at, t, true, coarse, right_copy);
    if (half_steps_)
        kernels_.factored_strip(left, line, right, h % 2 == 0, t % 2 == 0, n, out);
    else if (at.quads())
        kernels_.refine_strip_quads(left, line, right, n, k_quad_weights<T>, out);
    else
        kernels_.refine_strip_triangles(left, line, right, n, loop_weights<T>(), out);
    if (varying == nullptr && crease == 0) return;
    // Mixed point by point: out has the smooth points.
    std::vector<T> sharp(6 * std::uint64_t{n} - 3);
    kernels_.refine_line(line, n, k_quad_weights<T>, sharp.data());
    for (std::uint32_t j = 0; j + 1 < 2 * n; ++j) {
        const T w = varying == nullptr ? crease : static_cast<T>((*varying)[j]);
        for (std::uint64_t i = 3 * std::uint64_t{j}; i < 3 * std::uint64_t{j} + 3; ++i)
            out[i] = w * sharp[i] + (1 - w) * out[i];
    }
}

template <class T>
template <class Layout>
void GridPoints<T>::only_piece(const Layout& at, std::uint32_t h, const T* coarse, T* out) const {
    const MeshLevel& base = topology_.base;
    const auto point = [&](std::uint32_t v) { return coarse + 3 * std::uint64_t{v}; };
    const std::uint32_t t = base.twin[h];
    const T *a = point(base.origin[h]), *b = point(base.origin[t]);
    const T *c = point(base.origin[at.prev(h)]), *d = point(base.origin[at.prev(t)]);
    if (at.quads()) {
        const T *e = point(base.origin[at.next(at.next(h))]), *f = point(base.origin[at.next(at.next(t))]);
        for (int i = 0; i < 3; ++i)
            out[i] = T(CatmullClark::edge_end + CatmullClark::edge_face_point / 2) * (a[i] + b[i]) +
                     T(CatmullClark::edge_face_point / 4) * ((c[i] + e[i]) + (d[i] + f[i]));
        return;
    }
    for (int i = 0; i < 3; ++i) out[i] = T(Loop::edge_end) * (a[i] + b[i]) + T(Loop::edge_opposite) * (c[i] + d[i]);
}

template <class T>
template <class Layout>
[[gnu::always_inline]] inline PointLine<T> GridPoints<T>::beside(const Layout& at, std::uint32_t h, bool reversed,
                                                                 const T* coarse, Copy& copy) const {
    if (!at.is_root(at.face_of(h))) return copied_beside(at, h, reversed, coarse, copy);
    const VertexLine line = at.beside(h);
    return points_of(reversed ? line.reversed(at.segments() + (at.quads() ? 1 : 0)) : line, coarse);
}

template <class T>
template <class Layout>
PointLine<T> GridPoints<T>::copied_beside(const Layout& at, std::uint32_t h, bool reversed, const T* coarse,
                                          Copy& copy) const {
    const std::uint32_t count = at.segments() + (at.quads() ? 1 : 0);
    copy.resize(3 * std::size_t{count} + 1);  // one scalar more may be read
    gather_beside(at, h, reversed, coarse, copy.data());
    return {copy.data(), copy.data() + 3, copy.data() + 3 * std::size_t{count - 1}, 3, 0};
}

template <class T>
template <class Layout>
void GridPoints<T>::root(const Layout& at, const Layout& finer, std::uint32_t f, const T* coarse, T* fine,
                         Copy& scratch) const {
    T* out = fine + 3 * std::uint64_t{finer.face_begin(f)};
    const bool linear = topology_.rule == PointRule::linear;
    if (half_steps_) {
        scratch.resize(3 * at.segments() + 1);
        return kernels_.factored_quad(points_of(at.root(f), coarse), scratch.data(), out);
    }
    if (at.segments() == 1) {
        if (!at.quads()) return;
        const std::uint32_t* v = &topology_.base.origin[at.first_halfedge(f)];
        const auto point = [&](std::uint32_t w) { return coarse + 3 * std::uint64_t{w}; };
        const T *a = point(v[0]), *b = point(v[1]), *c = point(v[2]), *d = point(v[3]);
        for (int i = 0; i < 3; ++i) out[i] = T(0.25) * ((a[i] + b[i]) + (c[i] + d[i]));
        return;
    }
    const RootLines<T> lines = points_of(at.root(f), coarse);
    if (at.quads()) {
        kernels_.refine_quad(lines, linear ? QuadWeights<T>{0, 1} : k_quad_weights<T>, out);
        return;
    }
    kernels_.refine_triangle(lines, linear ? TriangleWeights<T>{1, 0, T(0.5), 0} : loop_weights<T>(), out);
}

template <class T>
template <class Layout>
void GridPoints<T>::other_face(const Layout& at, const Layout& finer, std::uint32_t f, const T* coarse, T* fine) const {
    const std::uint32_t sides = at.size_of(f), n = at.corner_segments();
    const bool linear = topology_.rule == PointRule::linear;
    const auto place = [&](std::uint32_t v) { return fine + 3 * std::uint64_t{v}; };
    const auto point = [&](std::uint32_t v) {
        const T* p = coarse + 3 * std::uint64_t{v};
        return Vec3<T>(p[0], p[1], p[2]);
    };
    Vec3<T> edges(0), corners(0);
    for (std::uint32_t i = 0; i < sides; ++i) {
        const PointLine<T> line = points_of(at.spoke(f, i), coarse);
        T* out = place(finer.spoke_begin(f, i));
        if (linear)
            kernels_.refine_line(line, n, {T(0), T(1)}, out);
        else
            kernels_.refine_strip_quads(points_of(at.left_of_spoke(f, i), coarse), line,
                                        points_of(at.right_of_spoke(f, i), coarse), n, k_quad_weights<T>, out);
        kernels_.refine_quad(points_of(at.corner_root(f, i), coarse), linear ? QuadWeights<T>{0, 1} : k_quad_weights<T>,
                             place(finer.corner_begin(f, i)));
        edges += point(at.before_centre(f, i));
        corners += point(at.diagonal_to_centre(f, i));
    }
    Vec3<T> centre = point(at.centre(f));
    if (!linear) {
        const RingMask m = topology_.masks(sides);
        centre = static_cast<T>(m.vertex) * centre + static_cast<T>(m.edge) * edges + static_cast<T>(m.face) * corners;
    }
    T* out = place(finer.centre(f));
    for (int i = 0; i < 3; ++i) out[i] = centre[i];
}

namespace {

template <class Layout>
void number_cells(const Layout& at, std::span<std::uint32_t> corners, const RunContext& context, KernelSet set) {
    const std::uint32_t n = at.segments(), size = at.quads() ? 4 : 3;
    const RootKernels<double>& kernels = root_kernels<double>(set);
    for_each_reported_block(at.base().face_count, grain_of(n * n), context, "faces", 0, 1,
                            [&](std::uint32_t begin, std::uint32_t end) {
                                std::vector<std::uint32_t> sides(5 * (std::size_t{n} + 1) + 3);
                                std::uint32_t* out = &corners[size * at.cell_begin(begin)];
                                const auto number = [&](const VertexRoot& root) {
                                    const std::uint32_t m = root.segments;
                                    const RootNumbers numbers{.left = sides.data(),
                                                              .right = &sides[m + 1],
                                                              .bottom = &sides[2 * m + 2],
                                                              .top = &sides[3 * m + 3],
                                                              .spare = &sides[4 * m + 4],
                                                              .inner = root.inner,
                                                              .segments = m};
                                    const auto side = [&](const VertexLine& line, std::uint32_t* to) {
                                        to[0] = line.first;
                                        const std::uint32_t step = line.inner.step;
                                        // Four at a time: the last may go beyond the side.
                                        for (std::uint32_t j = 1, v = line.inner.begin; j < m; j += 4, v += 4 * step) {
                                            to[j] = v;
                                            to[j + 1] = v + step;
                                            to[j + 2] = v + 2 * step;
                                            to[j + 3] = v + 3 * step;
                                        }
                                        to[m] = line.last;
                                    };
                                    side(root.left, numbers.left);
                                    side(root.right, numbers.right);
                                    side(root.bottom, numbers.bottom);
                                    side(root.top, numbers.top);
                                    (size == 4 ? kernels.number_quads : kernels.number_triangles)(numbers, out);
                                    out += std::uint64_t{size} * m * m;
                                };
                                for (std::uint32_t f = begin; f < end; ++f) {
                                    if (at.is_root(f)) {
                                        number(at.root(f));
                                        continue;
                                    }
                                    const std::uint32_t count = at.size_of(f);
                                    for (std::uint32_t i = 0; i < count; ++i) number(at.corner_root(f, i));
                                }
                            });
}

}  // namespace

void write_faces(const RootLayout& at, std::span<std::uint32_t> corners, const RunContext& context, KernelSet set) {
    with_known_size(at, [&](const auto& known) { number_cells(known, corners, context, set); });
}

template class GridPoints<float>;
template class GridPoints<double>;

}  // namespace tetrakis::detail
