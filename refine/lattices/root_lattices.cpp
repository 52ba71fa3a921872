#include "root_lattices.hpp"

#include "../../hier/base/disjoint_sets.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/most_frequent.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/parts/face_split.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_grain = 4;  // roots per task

/// Writes the corners of a root's cells, row by row.
/// @param row   (y, to): writes the numbers of the points of line y
/// @param line  room for two lines
template <class Row>
void number_cells(std::uint32_t n, bool quads, const Row& row, std::uint32_t* line, std::uint32_t* out) {
    std::uint32_t *low = line, *high = line + n + 1;
    row(0, low);
    for (std::uint32_t y = 0; y < n; ++y) {
        row(y + 1, high);
        if (quads) {
            for (std::uint32_t x = 0; x < n; ++x, out += 4) {
                const std::uint32_t corners[4] = {low[x], low[x + 1], high[x + 1], high[x]};
                std::copy_n(corners, 4, out);
            }
        } else {
            const std::uint32_t last = n - y - 1;
            for (std::uint32_t x = 0; x < last; ++x, out += 6) {
                const std::uint32_t corners[6] = {low[x], low[x + 1], high[x], low[x + 1], high[x + 1], high[x]};
                std::copy_n(corners, 6, out);
            }
            const std::uint32_t corners[3] = {low[last], low[last + 1], high[last]};
            out = std::copy_n(corners, 3, out);
        }
        std::swap(low, high);
    }
}

/// A mesh cut along its creases. A vertex has a copy for each sector between creases; the copies are sharp if the
/// vertex is a corner. Half-edges keep their numbers.
RuleMesh cut_creases(const RuleMesh& mesh) {
    int count = mesh.vertex_count();
    std::vector<int> origin(static_cast<std::size_t>(mesh.halfedge_count()));
    std::vector<float> sharpness(static_cast<std::size_t>(count), 0.0f);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const RuleMesh::Ring ring = mesh.ring(v);
        int sharp = 0;
        for (int i = 0; i < ring.edges(); ++i) sharp += is_sharp(ring.sharpness[i]) ? 1 : 0;
        const bool corner = sharp > 2 || (sharp == 2 && is_sharp(mesh.vertex_sharpness(v)));
        if (corner) sharpness[v] = k_sharpness_infinity;
        int copy = v, start = 0;
        while (ring.closed && sharp > 0 && !is_sharp(ring.sharpness[start])) ++start;
        for (int i = 0; i < ring.faces(); ++i) {
            const int at = (start + i) % ring.faces();
            if (i > 0 && is_sharp(ring.sharpness[at])) {
                copy = count++;
                sharpness.push_back(corner ? k_sharpness_infinity : 0);
            }
            origin[ring.halfedge[at]] = copy;
        }
    }
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + mesh.face_size(f); ++h) faces.corner(origin[h]);
        faces.end_face();
    }
    return RuleMesh(count, std::move(faces), std::move(sharpness));
}

struct Bordered {
    RuleMesh mesh;
    /// Pairs of half-edges on its boundary that lie beyond the two sides of one edge.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> glued;
    /// Vertices to which creases shrink from their darts.
    std::vector<std::uint32_t> crease_ends;
};

/// The half-edge that leaves the dart v along its crease; -1: v is no dart.
int dart_halfedge(const RuleMesh& mesh, int v) {
    const RuleMesh::Ring ring = mesh.ring(v);
    const auto sharp = std::find_if(ring.sharpness.begin(), ring.sharpness.end(), is_sharp);
    if (!ring.closed || sharp == ring.sharpness.end() || std::any_of(sharp + 1, ring.sharpness.end(), is_sharp))
        return -1;
    return ring.halfedge[static_cast<int>(sharp - ring.sharpness.begin())];
}

/// Adds quads beyond the boundary, whose cells hold the outer points of a dual scheme; the outermost points are on the
/// boundary. The quads of the mesh come first. Then each boundary half-edge, in their order, has a quad, whose first
/// half-edge is its twin; then each corner has one, whose first half-edge is beside the quad of the edge that ends
/// there; then each dart has one.
///
/// From level to level, a crease ends nearer to the middle of its last edge. The surface closes around the dart like
/// around one more face. The quad of this face lies between both sides of the half edge at the dart; only its last cell
/// is on the remaining crease.
/// @param uncut  the mesh before it was cut, with the same half-edges
Bordered with_border(const RuleMesh& mesh, const RuleMesh& uncut) {
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (const int v : mesh.corners(f)) faces.corner(v);
        faces.end_face();
    }
    int count = mesh.vertex_count(), quads = mesh.face_count();
    struct Outer {
        int ahead = -1, behind = -1, tip = -1;  // seen from the edges that start and end at a vertex
        int quad = -1;                          // a corner's
    };
    std::vector<Outer> outer(static_cast<std::size_t>(count));
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (!mesh.on_boundary(v)) continue;
        Outer& o = outer[v];
        o.ahead = o.behind = count++;
        if (!is_sharp(mesh.vertex_sharpness(v))) continue;
        o.behind = count++;
        o.tip = count++;
    }
    Bordered result;
    struct Dart {
        int out, in;  // half-edges from the dart and to it
    };
    std::vector<Dart> darts;
    std::vector<char> at_dart(static_cast<std::size_t>(mesh.halfedge_count()), 0);
    for (int v = 0; v < uncut.vertex_count(); ++v) {
        const int out = mesh.on_boundary(v) ? dart_halfedge(uncut, v) : -1;
        if (out < 0) continue;
        const int in = uncut.twin(out);
        darts.push_back({out, in});
        at_dart[out] = at_dart[in] = 1;
        Outer &left = outer[mesh.target(out)], &right = outer[mesh.origin(in)];
        right = left;
        result.crease_ends.push_back(static_cast<std::uint32_t>(left.ahead));
    }
    // Two darts at the ends of one edge share a crease end.
    std::sort(result.crease_ends.begin(), result.crease_ends.end());
    result.crease_ends.erase(std::unique(result.crease_ends.begin(), result.crease_ends.end()),
                             result.crease_ends.end());
    std::vector<int> beyond(static_cast<std::size_t>(mesh.halfedge_count()), -1);
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        if (mesh.twin(h) != RuleMesh::none || at_dart[h] != 0) continue;
        const int u = mesh.origin(h), v = mesh.target(h);
        faces.face({v, u, outer[u].ahead, outer[v].behind});
        beyond[h] = quads++;
    }
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        Outer& o = outer[v];
        if (o.tip < 0) continue;
        faces.face({v, o.behind, o.tip, o.ahead});
        o.quad = quads++;
    }
    for (const Dart& d : darts) {
        const int left = mesh.target(d.out), right = mesh.origin(d.in);
        faces.face({left, mesh.origin(d.out), right, outer[left].ahead});
    }
    result.mesh = RuleMesh(count, std::move(faces));
    const auto glue = [&](int a, int b) {
        result.glued.emplace_back(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
    };
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        const int t = uncut.twin(h);
        if (mesh.twin(h) != RuleMesh::none || t == RuleMesh::none || at_dart[h] != 0) continue;
        if (h < t) glue(4 * beyond[h] + 2, 4 * beyond[t] + 2);
        const Outer &ahead = outer[mesh.origin(h)], &behind = outer[mesh.target(t)];
        if (ahead.quad >= 0) glue(4 * ahead.quad + 2, 4 * behind.quad + 1);
    }
    return result;
}

}  // namespace

RootLattices RootLattices::of_faces(const RuleMesh& mesh, std::vector<std::uint32_t> control_face) {
    return RootLattices(mesh, static_cast<std::uint32_t>(mesh.face_count()), std::move(control_face));
}

RootLattices RootLattices::of_corners(const RuleMesh& mesh, bool creases, std::vector<std::uint32_t> control_face) {
    const RuleMesh split = split_polygons(mesh, detail::HalfSharpness(mesh));
    std::optional<RuleMesh> cut;
    if (creases) cut = cut_creases(split);
    Bordered bordered = with_border(cut ? *cut : split, split);
    RootLattices net(std::move(bordered.mesh), static_cast<std::uint32_t>(mesh.halfedge_count()),
                     std::move(control_face));
    net.in_cells_ = true;
    net.glued_ = std::move(bordered.glued);
    net.crease_ends_ = std::move(bordered.crease_ends);
    // A quad beyond a side has the control face of that side, a quad at a corner that of the edge that starts there.
    for (std::uint32_t f = net.own_roots_; f < net.root_count() && !net.base_face_.empty(); ++f) {
        const std::uint32_t before = net.base_.twin(4 * f) / 4;
        const bool corner = before >= net.own_roots_;
        net.base_face_.push_back(net.base_face_[corner ? net.base_.twin(4 * f + 3) / 4 : before]);
    }
    return net;
}

RootLattices::Numbers RootLattices::point_numbers(const RootLayout& at) const {
    const std::uint32_t places = place_count(at);
    if (glued_.empty()) return {places, places, {}};
    const std::uint32_t begin = number_at(at, own_roots_, {0, 0}), last = at.segments() - 1;
    DisjointSets same(places - begin);
    for (const auto& [g, h] : glued_)
        for (std::uint32_t a = 0; a <= last; ++a)
            same.unite(this->number(at, g, a, 0) - begin, this->number(at, h, last - a, 0) - begin);
    std::vector<std::uint32_t> number(places - begin);
    std::uint32_t count = begin;
    for (std::uint32_t i = 0; i < number.size(); ++i) number[i] = same.find(i) == i ? count++ : number[same.find(i)];
    return {count, begin, std::move(number)};
}

bool RootLattices::has_simple_roots() const {
    const std::uint32_t sides = side_count();
    if (sides > 4 || !base_.all_faces_have(base_.face_size(0))) return false;
    for (std::uint32_t f = 0; f < root_count(); ++f)
        for (std::uint32_t i = sides * f; i < sides * (f + 1); ++i)
            for (std::uint32_t j = sides * f; j < i; ++j)
                if (base_.origin(i) == base_.origin(j) || base_.edge(i) == base_.edge(j)) return false;
    return true;
}

RootLattices::Faces RootLattices::faces(std::uint32_t segments, const RunContext& context,
                                        const std::vector<std::uint32_t>* only) const {
    const RootLayout at(base_, segments);
    if (in_cells_) return cell_faces(at);
    const std::uint32_t size = side_count(), cells = segments * segments,
                        roots = only != nullptr ? static_cast<std::uint32_t>(only->size()) : root_count(),
                        count = cells * roots;
    Faces faces;
    resize_large(faces.offsets, count + std::size_t{1});
    faces.control.resize(roots);
    faces.each = cells;
    resize_large(faces.vertices, std::size_t{size} * count);
    faces.offsets[count] = size * count;
    const auto number_roots = [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<std::uint32_t> lines(2 * (segments + std::size_t{1}));
        for (std::uint32_t f = begin; f < end; ++f) {
            const std::uint32_t root = only != nullptr ? (*only)[f] : f, h = size * root;
            faces.control[f] = base_face_[root];
            const auto row = [&](std::uint32_t y, std::uint32_t* numbers) {
                const std::uint32_t last = size == 4 ? segments : segments - y;
                numbers[0] = at.along(h + size - 1, segments - y);
                numbers[last] = at.along(h + 1, y);
                if (y == 0)
                    at.for_each_along(h, [&](std::uint32_t x, std::uint32_t v) { numbers[x] = v; });
                else if (y < segments)
                    std::iota(numbers + 1, numbers + last, at.inside(root, 1, y));
                else if (size == 4)
                    at.for_each_along(h + 2, [&](std::uint32_t x, std::uint32_t v) { numbers[segments - x] = v; });
            };
            number_cells(segments, size == 4, row, lines.data(), &faces.vertices[std::size_t{size} * cells * f]);
        }
        const std::uint32_t each = size, last_face = cells * end;  // copies, which no store can change
        std::uint32_t* const offsets = faces.offsets.data();
        for (std::uint32_t i = cells * begin; i < last_face; ++i) offsets[i] = each * i;
    };
    for_each_reported_block(roots, k_grain, context, "faces", 0, 1, number_roots);
    return faces;
}

/// Faces inside each root come first, then faces across each edge between roots, then faces around the roots' corners.
RootLattices::Faces RootLattices::cell_faces(const RootLayout& at) const {
    const std::uint32_t n = at.segments(), inner = n - 1;
    std::vector<std::uint32_t> inner_edges;
    for (std::uint32_t h = 0; h < halfedge_count(); ++h)
        if (base_.leads(h) && base_.twin(h) != RuleMesh::none) inner_edges.push_back(h);
    const auto across = static_cast<std::uint32_t>(inner_edges.size());
    const std::uint32_t quads = root_count() * inner * inner + across * inner;
    Faces faces;
    reserve_large(faces.offsets, quads + static_cast<std::size_t>(base_.vertex_count()) + 1);
    resize_large(faces.offsets, quads + std::size_t{1});
    for_each_index(quads + 1, [&](std::uint32_t f) { faces.offsets[f] = 4 * f; });
    faces.control.resize(quads);
    reserve_large(faces.vertices, 4 * std::size_t{quads} + halfedge_count());
    resize_large(faces.vertices, 4 * std::size_t{quads});
    const auto quad = [&](std::uint32_t f, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        const std::uint32_t corners[4] = {a, b, c, d};
        std::copy_n(corners, 4, &faces.vertices[4 * std::size_t{f}]);
    };
    for_each_index(
        root_count(),
        [&](std::uint32_t r) {
            std::uint32_t f = r * inner * inner;
            for (std::uint32_t y = 0; y < inner; ++y)
                for (std::uint32_t x = 0; x < inner; ++x, ++f) {
                    const std::uint32_t low = number_at(at, r, {x, y}), high = low + n;
                    quad(f, low, low + 1, high + 1, high);
                    faces.control[f] = base_face_[r];
                }
        },
        k_grain);
    for_each_index(
        across,
        [&](std::uint32_t i) {
            const std::uint32_t h = inner_edges[i], t = base_.twin(h);
            std::uint32_t f = root_count() * inner * inner + i * inner;
            for (std::uint32_t j = 1; j < n; ++j, ++f) {
                quad(f, number(at, t, n - j, 0), number(at, t, n - 1 - j, 0), number(at, h, j, 0),
                     number(at, h, j - 1, 0));
                faces.control[f] = std::min(base_face_[h / 4], base_face_[t / 4]);
            }
        },
        k_grain);
    std::vector<std::uint32_t> around;
    // The outermost points are the boundary. Around a point where creases end from both sides, which has two roots,
    // there is no face.
    for (int v = 0; v < base_.vertex_count(); ++v) {
        const std::uint32_t first = base_.first(v);
        if (base_.on_boundary(v) || turned(turned(first)) == first) continue;
        around.clear();
        base_.for_each_leaving(v, [&](std::uint32_t h) {
            faces.vertices.push_back(number(at, h, 0, 0));
            around.push_back(base_face_[h / 4]);
        });
        faces.offsets.push_back(static_cast<std::uint32_t>(faces.vertices.size()));
        faces.control.push_back(most_frequent(around));
    }
    if (shares_points()) {
        const Numbers numbers = point_numbers(at);
        for (std::uint32_t& v : faces.vertices) v = numbers.of(v);
    }
    return faces;
}

}  // namespace tetrakis::detail
