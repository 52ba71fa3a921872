#include "grid_limit.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/rules/ring_limit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

template <class T>
class GridLimits {
  public:
    GridLimits(const GridTopology& topology, KernelSet set, const T* points, T* positions, T* normals)
        : topology_(topology),
          base_(topology.base),
          kernels_(root_kernels<T>(set)),
          at_(topology.last()),
          n_(at_.segments()),
          points_(points),
          positions_(positions),
          normals_(normals) {}

    void run(const RunContext& context) {
        for_each_block(base_.vertex_count, 256, [&](std::uint32_t begin, std::uint32_t end) {
            VertexRing ring;
            for (std::uint32_t v = begin; v < end; ++v) corner(v, ring);
        });
        if (n_ == 1) return;
        for_each_block(base_.edge_count, 16, [&](std::uint32_t begin, std::uint32_t end) {
            Scratch scratch(n_);
            for (std::uint32_t e = begin; e < end; ++e) edge(e, scratch);
        });
        for_each_reported_block(base_.face_count, 4, context, "limit", 0, 1,
                                [&](std::uint32_t begin, std::uint32_t end) {
                                    Scratch scratch(n_);
                                    for (std::uint32_t f = begin; f < end; ++f) face(f, scratch);
                                });
    }

  private:
    struct Scratch {
        VertexRing ring;
        std::vector<T> lines;  // 3 of N + 1 points, then the sides' 4
        std::vector<T> means;  // the kernels'
        explicit Scratch(std::uint32_t n)
            : lines(21 * (std::size_t{n} + 1) + k_limit_padding),
              means(2 * (3 * (std::size_t{n} + 1) + k_limit_padding)) {}
    };

    bool limit_line(const T* below, const T* at, const T* above, std::uint32_t count, std::uint32_t first,
                    const T* left, const T* right, Scratch& scratch) const {
        const std::uint64_t begin = 3 * std::uint64_t{first};
        return (at_.quads() ? kernels_.limit_quads : kernels_.limit_triangles)(
            below, at, above, count, left, right, positions_ == nullptr ? nullptr : positions_ + begin,
            normals_ == nullptr ? nullptr : normals_ + begin, scratch.means.data());
    }

    void edge(std::uint32_t e, Scratch& scratch) {
        if (!topology_.tags.any() || topology_.tags.is_smooth(e)) {
            const std::uint32_t h = base_.edge_halfedge[e];
            const std::uint64_t length = 3 * (std::uint64_t{n_} + 1);
            T *at = scratch.lines.data(), *above = at + length, *below = above + length;
            gather(at_.side(h), n_ + 1, points_, at);
            gather_beside(at_, h, false, points_, above);
            gather_beside(at_, base_.twin[h], true, points_, below);
            // In the lattice of h's root the line below a triangle's side has its first point at x = 1.
            if (!at_.quads()) below -= 3;
            if (limit_line(below, at, above, n_ - 1, at_.edge_begin(e), nullptr, nullptr, scratch)) return;
        }
        for (std::uint32_t j = 1; j < n_; ++j) edge_point(e, j, scratch.ring);
    }

    void face(std::uint32_t f, Scratch& scratch) {
        if (!at_.is_root(f)) return other_face(f, scratch);
        if (at_.quads())
            quad(at_.root(f), scratch, [&](std::uint32_t x, std::uint32_t y) { return at_.at(f, x, y); });
        else
            triangle(f, scratch);
    }

    RootRows<T> sides(const VertexRoot& root, Scratch& scratch) const {
        return gather(root, points_, scratch.lines.data() + 9 * (std::uint64_t{n_} + 1));
    }

    /// Rows are read in place. `at` gives the root's lattice points.
    template <class At>
    void quad(const VertexRoot& root, Scratch& scratch, const At& at) {
        const std::uint32_t n = root.segments;
        const RootRows<T> rows = sides(root, scratch);
        const std::uint64_t stride = 3 * std::uint64_t{n - 1};
        const auto line = [&](std::uint32_t y) {
            return y == 0 ? rows.bottom : y == n ? rows.top : rows.inner + (y - 1) * stride - 3;
        };
        for (std::uint32_t y = 1; y < n; ++y) {
            const std::uint64_t side = 3 * std::uint64_t{y - 1};
            if (!limit_line(line(y - 1), line(y), line(y + 1), n - 1, root.inner + (y - 1) * (n - 1), rows.left + side,
                            rows.right + side, scratch))
                for (std::uint32_t x = 1; x < n; ++x) inside(x, y, at, scratch.ring);
        }
    }

    /// A face that is no root: its centre, its spokes, the roots at its corners.
    void other_face(std::uint32_t f, Scratch& scratch) {
        const std::uint32_t sides = base_.size_of(f), m = at_.corner_segments();
        VertexRing& ring = scratch.ring;
        restart(ring, at_.centre(f));
        ring.faces = static_cast<int>(sides);
        // Counter-clockwise: a spoke, then the root at the corner after it.
        for (std::uint32_t i = 0; i < sides; ++i) {
            ring.points.push_back(point(at_.before_centre(f, i)));
            ring.points.push_back(point(at_.diagonal_to_centre(f, at_.next_side(f, i))));
        }
        finish(at_.centre(f), false, ring);
        if (m == 1) return;
        const std::uint64_t length = 3 * (std::uint64_t{m} + 1);
        T *at = scratch.lines.data(), *above = at + length, *below = above + length;
        for (std::uint32_t i = 0; i < sides; ++i) {
            gather(at_.spoke(f, i), m + 1, points_, at);
            gather(at_.left_of_spoke(f, i), m + 1, points_, above);
            gather(at_.right_of_spoke(f, i), m + 1, points_, below);
            if (!limit_line(below, at, above, m - 1, at_.spoke_begin(f, i), nullptr, nullptr, scratch))
                for (std::uint32_t j = 1; j < m; ++j) {
                    const auto place = [&](std::uint32_t x, std::uint32_t y) {
                        return (y == 1   ? at_.spoke(f, i)
                                : y == 2 ? at_.left_of_spoke(f, i)
                                         : at_.right_of_spoke(f, i))
                            .at(x, m + 1);
                    };
                    inside(j, 1, place, ring);
                }
            const VertexRoot root = at_.corner_root(f, i);
            quad(root, scratch, [&](std::uint32_t x, std::uint32_t y) { return root.at(x, y); });
        }
    }

    /// Rows get shorter, so they are copied with their ends.
    void triangle(std::uint32_t f, Scratch& scratch) {
        const RootRows<T> rows = sides(at_.root(f), scratch);
        const std::uint64_t length = 3 * (std::uint64_t{n_} + 1);
        T* lines[3] = {scratch.lines.data(), scratch.lines.data() + length, scratch.lines.data() + 2 * length};
        const T* inner = rows.inner;
        const auto copy = [&](T* line, std::uint32_t y) {
            const std::uint32_t last = n_ - y;
            copy_point(line, rows.left, y);
            copy_point(line + 3 * std::uint64_t{last}, rows.right, y);
            if (last < 2) return;
            std::copy_n(inner, 3 * std::uint64_t{last - 1}, line + 3);
            inner += 3 * std::uint64_t{last - 1};
        };
        std::copy_n(rows.bottom, length, lines[0]);
        copy(lines[1], 1);
        std::uint32_t first = at_.face_begin(f);
        for (std::uint32_t y = 1; y + 1 < n_; ++y) {
            copy(lines[2], y + 1);
            const std::uint32_t count = n_ - 1 - y;
            if (!limit_line(lines[0], lines[1], lines[2], count, first, nullptr, nullptr, scratch))
                for (std::uint32_t x = 1; x <= count; ++x)
                    inside(
                        x, y, [&](std::uint32_t i, std::uint32_t j) { return at_.at(f, i, j); }, scratch.ring);
            first += count;
            std::swap(lines[0], lines[1]);
            std::swap(lines[1], lines[2]);
        }
    }

    Vec3d point(std::uint32_t v) const {
        const T* p = points_ + 3 * std::uint64_t{v};
        return Vec3d(p[0], p[1], p[2]);
    }
    void write(std::uint32_t v, const Vec3d& position, const Vec3d& normal) {
        for (int i = 0; i < 3; ++i) {
            if (positions_ != nullptr) positions_[3 * std::uint64_t{v} + i] = static_cast<T>(position[i]);
            if (normals_ != nullptr) normals_[3 * std::uint64_t{v} + i] = static_cast<T>(normal[i]);
        }
    }
    void restart(VertexRing& ring, std::uint32_t centre) const {
        ring.clear();
        ring.boundary = false;
        ring.faces = 0;
        ring.points.push_back(point(centre));
    }

    void corner(std::uint32_t v, VertexRing& ring) {
        restart(ring, v);
        const std::uint32_t start = base_.vertex_halfedge[v];
        if (start == none) return write(v, ring.points[0], Vec3d(0));
        const UniformTags& tags = topology_.tags;
        const bool tagged = tags.any() && base_.tagged[v] != 0;
        const bool chaikin = tagged && topology_.method == CreaseMethod::chaikin;
        std::uint32_t h = start;
        const auto outer = [&](std::uint32_t side) {
            if (!chaikin) return;
            const std::uint32_t e = side >> 1;
            ring.outer_child.push_back((side & 1) == 0 ? tags.half(e, 0, 1) : tags.half(e, n_ - 1, n_ - 1));
        };
        do {
            const std::uint32_t before = base_.prev(h);
            ring.points.push_back(point(at_.first_along(h)));
            if (at_.quads()) ring.points.push_back(point(at_.diagonal(h)));
            if (tagged) ring.sharpness.push_back(tags.at_origin(h));
            outer(base_.edge_side[h]);
            ++ring.faces;
            h = base_.twin[before];
            if (h == none) {
                ring.boundary = true;
                ring.points.push_back(point(at_.last_along(before)));
                ring.sharpness.push_back(tags.at_target(before));
                outer(base_.edge_side[before] ^ 1u);
            }
        } while (h != start && h != none);
        if (tagged) ring.vertex_sharpness = tags.vertex(v);
        finish(v, tagged, ring);
    }

    void edge_point(std::uint32_t e, std::uint32_t j, VertexRing& ring) {
        const std::uint32_t h = base_.edge_halfedge[e], t = base_.twin[h], v = at_.along(h, j);
        restart(ring, v);
        const auto add = [&](std::uint32_t w) { ring.points.push_back(point(w)); };
        add(at_.along(h, j + 1));
        if (at_.quads()) {
            add(at_.beside(h, j + 1));
            add(at_.beside(h, j));
            add(at_.beside(h, j - 1));
        } else {
            add(at_.beside(h, j));
            add(at_.beside(h, j - 1));
        }
        add(at_.along(h, j - 1));
        ring.boundary = t == none;
        if (!ring.boundary) {
            const std::uint32_t back = n_ - j;  // the same vertex from the other side
            if (at_.quads()) {
                add(at_.beside(t, back + 1));
                add(at_.beside(t, back));
                add(at_.beside(t, back - 1));
            } else {
                add(at_.beside(t, back));
                add(at_.beside(t, back - 1));
            }
        }
        const int half = at_.quads() ? 2 : 3;  // faces on each side
        ring.faces = ring.boundary ? half : 2 * half;
        const UniformTags& tags = topology_.tags;
        if (tags.any()) {
            const float ahead = tags.piece(e, j), behind = tags.piece(e, j - 1);
            if (is_sharp(ahead) || is_sharp(behind)) {
                ring.sharpness.assign(ring.faces + (ring.boundary ? 1 : 0), 0.0f);
                ring.sharpness[0] = ahead;
                ring.sharpness[half] = behind;
                if (topology_.method == CreaseMethod::chaikin) {
                    ring.outer_child.assign(ring.sharpness.size(), 0.0f);
                    ring.outer_child[0] = tags.half(e, j, j + 1);
                    ring.outer_child[half] = tags.half(e, j - 1, j - 1);
                }
            }
        }
        finish(v, !ring.sharpness.empty(), ring);
    }

    /// `at` gives lattice points.
    template <class At>
    void inside(std::uint32_t x, std::uint32_t y, const At& at, VertexRing& ring) {
        const std::uint32_t v = at(x, y);
        restart(ring, v);
        const auto add = [&](std::uint32_t i, std::uint32_t j) { ring.points.push_back(point(at(i, j))); };
        add(x + 1, y);
        if (at_.quads()) add(x + 1, y + 1);
        add(x, y + 1);
        add(x - 1, y + 1);
        add(x - 1, y);
        if (at_.quads()) add(x - 1, y - 1);
        add(x, y - 1);
        add(x + 1, y - 1);
        ring.faces = at_.quads() ? 4 : 6;
        finish(v, false, ring);
    }

    void finish(std::uint32_t v, bool tagged, VertexRing& ring) {
        Vec3d position, normal(0);
        if (!tagged && smooth(ring, position, normal)) return write(v, position, normal);
        const LimitPoint limit = limit_point(topology_.scheme, topology_.method, ring);
        write(v, limit.position, limit.normal);
    }

    /// The straight way for interior vertices without tags; false where the tangents do not span a plane.
    bool smooth(const VertexRing& ring, Vec3d& position, Vec3d& normal) const {
        // Parallel tangents are left to the general way, which then looks at the faces.
        constexpr double k_sine = k_parallel<T>;
        const RingLimit& limit = smooth_ring_limit(topology_.scheme, ring.faces);
        if (!limit.has_tangent_plane) return false;
        const Vec3d& centre = ring.points[0];
        const std::size_t step = at_.quads() ? 2 : 1, count = ring.points.size();
        Vec3d edges(0), corners(0), a(0), b(0);
        for (std::size_t i = 1; i < count; i += step) edges += ring.points[i] - centre;
        for (std::size_t i = 2; step == 2 && i < count; i += 2) corners += ring.points[i] - centre;
        position = centre + limit.position[1] * edges;
        if (step == 2) position += limit.position[2] * corners;
        if (normals_ == nullptr) return true;
        for (std::size_t i = 1; i < count; ++i) {
            const Vec3d d = ring.points[i] - centre;
            a += limit.tangent1[i] * d;
            b += limit.tangent2[i] * d;
        }
        const Vec3d cross = glm::cross(a, b);
        const double square = glm::dot(cross, cross);
        if (!(square > k_sine * k_sine * glm::dot(a, a) * glm::dot(b, b))) return false;
        normal = cross / std::sqrt(square);
        return true;
    }

    const GridTopology& topology_;
    const MeshLevel& base_;
    const RootKernels<T>& kernels_;
    RootLayout at_;
    std::uint32_t n_;
    const T* points_;
    T *positions_, *normals_;
};

}  // namespace

template <class T>
void grid_limits(const GridTopology& topology, const T* points, T* positions, T* normals, const RunContext& context,
                 KernelSet set) {
    GridLimits<T>(topology, set, points, positions, normals).run(context);
}

template void grid_limits(const GridTopology&, const float*, float*, float*, const RunContext&, KernelSet);
template void grid_limits(const GridTopology&, const double*, double*, double*, const RunContext&, KernelSet);

}  // namespace tetrakis::detail
