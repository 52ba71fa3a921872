#include "tetrakis/refine/repeated_rows.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/grid_refinement.hpp"
#include "tetrakis/refine/rule_refiner.hpp"
#include "tetrakis/schemes/face_split.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Of the first level whose step is worth a look: to 8 segments a side, or 9; in cells to 4.
constexpr std::uint32_t k_least_segments = 3, k_least_segments_in_cells = 2;

/// Whether nothing turns from sharp to smooth within that many steps.
bool stays_as_it_is(const RuleMesh& mesh, int steps) {
    const auto turns = [&](float sharpness) {
        return is_semi_sharp(sharpness) && sharpness <= static_cast<float>(steps);
    };
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (turns(mesh.sharpness(h))) return false;
    return std::none_of(mesh.vertex_sharpness().begin(), mesh.vertex_sharpness().end(), turns);
}

/// Whether nothing inside is sharp or without a face of its own on the next level.
bool is_smooth_inside(const RuleMesh& mesh) {
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (mesh.sharp(h) && mesh.twin(h) != RuleMesh::none) return false;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none) return false;
        if (!mesh.on_boundary(v) && (is_sharp(mesh.vertex_sharpness(v)) || mesh.ring(v).faces() < 3)) return false;
    }
    return true;
}

/// Quads with a row of them beyond the boundary: a dual scheme's points there lie in their cells, the outermost ones on
/// the boundary. First the mesh's own; then one for each half-edge on the boundary, in their order, which is beyond the
/// first half-edge of it; then one at each corner, whose first half-edge is beside the quad of the edge that ends
/// there.
RuleMesh with_border(const RuleMesh& mesh) {
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (const int v : mesh.corners(f)) faces.corner(v);
        faces.end_face();
    }
    int count = mesh.vertex_count();
    struct Outer {
        int ahead = -1, behind = -1, tip = -1;  // seen from the edges that start and end at a vertex
    };
    std::vector<Outer> outer(static_cast<std::size_t>(count));
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (!mesh.on_boundary(v)) continue;
        Outer& o = outer[static_cast<std::size_t>(v)];
        o.ahead = o.behind = count++;
        if (!is_sharp(mesh.vertex_sharpness(v))) continue;
        o.behind = count++;
        o.tip = count++;
    }
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        if (mesh.twin(h) != RuleMesh::none) continue;
        const int u = mesh.origin(h), v = mesh.target(h);
        faces.face({v, u, outer[static_cast<std::size_t>(u)].ahead, outer[static_cast<std::size_t>(v)].behind});
    }
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Outer& o = outer[static_cast<std::size_t>(v)];
        if (o.tip >= 0) faces.face({v, o.behind, o.tip, o.ahead});
    }
    return RuleMesh(count, std::move(faces));
}

/// What the roots of a mesh are.
struct RootKind {
    bool triangles = false;
    bool split = false;     ///< the quads of the first refinement
    bool in_cells = false;  ///< with those beyond the boundary
    int factor = 2;         ///< segments of a level to one of the level above
};

/// What the last level will be, before anything is made.
void check_size(const ControlMesh& mesh, const RootKind& roots, int levels, const RepeatedRows::Demand& demand,
                const RunContext& context) {
    const bool split = roots.split, triangles = roots.triangles;
    double faces = split ? mesh.halfedge_count() : mesh.face_count();
    const double edges = mesh.edge_count() * (split ? 2.0 : 1.0) + (split ? mesh.halfedge_count() : 0.0),
                 vertices = mesh.vertex_count() + (split ? double(mesh.edge_count()) + mesh.face_count() : 0.0),
                 n = std::pow(roots.factor, levels - (split ? 1 : 0));
    // Two for each boundary edge, and at most one more for each of its vertices.
    for (std::uint32_t e = 0; e < mesh.edge_count() && roots.in_cells; ++e)
        if (mesh.is_boundary(EdgeId(e))) faces += 3;
    const double cells = faces * n * n, corners = cells * (triangles ? 3 : 4);
    const double inner = triangles ? 0.5 * (n - 1) * (n - 2) : (n - 1) * (n - 1);
    const double points = roots.in_cells ? cells : faces * inner + edges * (n - 1) + vertices;
    constexpr double k_most = std::numeric_limits<std::uint32_t>::max();
    if (std::max(corners, points) >= k_most)
        throw Error(ErrorCode::unsupported,
                    fmt::format("{} levels give more elements than 32-bit numbers can count; the last has {:.0f} face "
                                "corners",
                                levels, corners),
                    mesh.data().source);
    // The points of the level above, and of that above it.
    constexpr double k_above = 0.3;
    const double bytes = points * (static_cast<double>(demand.point_bytes) + k_above * sizeof(Vec3d)) +
                         corners * static_cast<double>(demand.corner_bytes) +
                         cells * static_cast<double>(demand.face_bytes);
    if (context.max_memory_bytes == 0 || bytes <= static_cast<double>(context.max_memory_bytes)) return;
    throw Error(ErrorCode::memory_limit,
                fmt::format("{} levels, {:.0f} vertices, need about {:.0f} MiB, and the limit is {} MiB; ask for fewer "
                            "levels",
                            levels, points, std::ceil(bytes / (1 << 20)), context.max_memory_bytes >> 20),
                mesh.data().source);
}

}  // namespace

std::unique_ptr<RepeatedRows> RepeatedRows::make(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                                 const RuleOptions& rules, std::unique_ptr<RuleLevels>& levels_by_rules,
                                                 const Demand& demand, const RunContext& context) {
    const bool triangles = scheme.family == MeshFamily::triangles,
               dual = fan_lattice(scheme, rules) == FanLattice::dual;
    if (scheme.refinement == Refinement::honeycomb) return nullptr;
    if (triangles && !mesh.all_triangles()) return nullptr;  // the rules say what is wrong
    bool quads = true;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) quads = quads && mesh.face_size(FaceId(f)) == 4;
    // Level at which a root has one segment.
    const int base_level = dual ? 1 : triangles || quads ? 0 : 1, last_by_rules = levels - 1;
    if (last_by_rules < base_level + 2) return nullptr;
    const int factor = scheme.refinement == Refinement::sqrt3 ? 3 : 2;
    check_size(mesh, {triangles, !triangles && (dual || !quads), dual, factor}, levels, demand, context);

    RuleLevels& by_rules = *levels_by_rules;
    std::unique_ptr<RepeatedRows> all(new RepeatedRows(static_cast<std::uint32_t>(factor)));
    all->in_cells_ = dual;
    if (dual) {
        if (!is_smooth_inside(by_rules.last())) return nullptr;
        const RuleMesh split = split_polygons(by_rules.last());
        if (!all->set_base(with_border(split), by_rules)) return nullptr;
        all->own_roots_ = static_cast<std::uint32_t>(split.face_count());
    }
    // The child of each of the roots' half-edges at its origin, level by level. Dual: the half-edge of a root's last
    // cell that stays in its face; root h is at corner h.
    std::vector<int> first;
    for (int level = 0; level < base_level; ++level) {
        check_rule_memory(mesh, scheme, level + 1, levels, context);
        first = by_rules.advance();
    }
    if (!dual) {
        if (!all->set_base(by_rules.last(), by_rules)) return nullptr;
        first.resize(all->base_.halfedge_count());
        for (std::size_t h = 0; h < first.size(); ++h) first[h] = static_cast<int>(h);
    }
    const auto lattice_of = [&](const RootLayout& at) {
        return dual ? all->cells(at, by_rules.last(), first) : all->lattice(at, by_rules.last(), first);
    };
    std::uint32_t segments = 1;
    std::optional<std::vector<int>> vertices;
    for (int level = base_level; level < last_by_rules; ++level) {
        context.report("refine", 0);
        check_rule_memory(mesh, scheme, level + 1, levels, context);
        const bool stationary = segments >= (dual ? k_least_segments_in_cells : k_least_segments) &&
                                stays_as_it_is(by_rules.last(), levels - level);
        const RootLayout coarse(all->base_, segments);
        std::vector<int> number(stationary ? by_rules.last().vertex_count() : 0, -1);
        if (stationary) {
            vertices = lattice_of(coarse);
            if (!vertices) return nullptr;
            for (std::size_t i = 0; i < vertices->size(); ++i) number[(*vertices)[i]] = static_cast<int>(i);
        }
        const std::vector<int> child = by_rules.advance();
        for (int& h : first) {
            h = h < 0 ? h : child[h];
            if (h < 0) return nullptr;
        }
        segments *= all->factor_;
        if (!stationary) continue;
        const RootLayout fine(all->base_, segments);
        vertices = lattice_of(fine);
        if (!vertices) return nullptr;
        if (!all->learn({coarse, fine, number, *vertices, by_rules.steps().back()})) continue;
        all->vertices_ = std::move(*vertices);
        all->levels_ = std::move(levels_by_rules);
        all->template_segments_ = static_cast<std::ptrdiff_t>(coarse.segments());
        all->segments_ = {segments};
        for (++level; level < levels; ++level) all->segments_.push_back(segments *= all->factor_);
        return all;
    }
    return nullptr;
}

/// @param levels  whose faces the roots are, or whose half-edges
bool RepeatedRows::set_base(const RuleMesh& mesh, const RuleLevels& levels) {
    const auto H = static_cast<std::size_t>(mesh.halfedge_count());
    base_.face_size = mesh.face_size(0);
    if (!mesh.all_faces_have(base_.face_size) || base_.face_size > 4) return false;
    base_.vertex_count = static_cast<std::uint32_t>(mesh.vertex_count());
    base_.edge_count = static_cast<std::uint32_t>(mesh.edge_count());
    base_.face_count = static_cast<std::uint32_t>(mesh.face_count());
    base_.origin.resize(H);
    base_.twin.resize(H);
    base_.edge_side.resize(H);
    base_.edge_halfedge.resize(base_.edge_count);
    base_.vertex_halfedge.resize(base_.vertex_count);
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        const int e = mesh.edge(h);
        base_.origin[h] = static_cast<std::uint32_t>(mesh.origin(h));
        base_.twin[h] = static_cast<std::uint32_t>(mesh.twin(h));  // none is none
        base_.edge_side[h] = 2 * static_cast<std::uint32_t>(e) + (mesh.edge_halfedge(e) == h ? 0 : 1);
    }
    for (int e = 0; e < mesh.edge_count(); ++e)
        base_.edge_halfedge[e] = static_cast<std::uint32_t>(mesh.edge_halfedge(e));
    for (int v = 0; v < mesh.vertex_count(); ++v) base_.vertex_halfedge[v] = static_cast<std::uint32_t>(mesh.first(v));
    base_face_.resize(base_.face_count);
    const auto own = in_cells_ ? static_cast<std::uint32_t>(levels.last().halfedge_count()) : base_.face_count;
    for (std::uint32_t f = 0; f < own; ++f)
        base_face_[f] = static_cast<std::uint32_t>(
            levels.control_face(in_cells_ ? levels.last().face(static_cast<int>(f)) : static_cast<int>(f)));
    // What lies beyond a side belongs to the face there.
    for (std::uint32_t f = own; f < base_.face_count; ++f) base_face_[f] = base_face_[base_.twin[4 * f] / 4];
    return has_simple_roots();
}

/// Whether each root is between different vertices and edges.
bool RepeatedRows::has_simple_roots() const {
    const std::uint32_t sides = side_count();
    for (std::uint32_t f = 0; f < base_.face_count; ++f)
        for (std::uint32_t i = sides * f; i < sides * (f + 1); ++i)
            for (std::uint32_t j = sides * f; j < i; ++j)
                if (base_.origin[i] == base_.origin[j] || base_.edge(i) == base_.edge(j)) return false;
    return true;
}

/// The rules' numbers of a level's points in the order of its layout; nothing where its faces are no such lattices.
std::optional<std::vector<int>> RepeatedRows::lattice(const RootLayout& at, const RuleMesh& mesh,
                                                      std::span<const int> corner_halfedge) const {
    const std::uint32_t n = at.segments(), sides = side_count();
    if (at.vertex_count() != static_cast<std::uint32_t>(mesh.vertex_count())) return std::nullopt;
    std::vector<int> vertices(at.vertex_count(), -1);
    for (std::uint32_t v = 0; v < base_.vertex_count; ++v)
        if (base_.vertex_halfedge[v] == none) vertices[v] = static_cast<int>(v);
    const auto across = [&](int h) { return h < 0 ? h : mesh.twin(h); };
    for (std::uint32_t f = 0; f < base_.face_count; ++f) {
        // Along the bottom edges of each row's cells (triangles: of those that point up).
        int row = corner_halfedge[sides * f];
        for (std::uint32_t y = 0; y < n; ++y) {
            if (row < 0) return std::nullopt;
            int h = row;
            const std::uint32_t last = sides == 4 ? n : n - y;
            for (std::uint32_t x = 0; x < last; ++x) {
                if (h < 0) return std::nullopt;
                vertices[at.at(f, x, y)] = mesh.origin(h);
                const int up = mesh.next(h);
                if (x + 1 == last) vertices[at.at(f, x + 1, y)] = mesh.origin(up);
                if (y + 1 == n) {
                    vertices[at.at(f, x, n)] = mesh.origin(mesh.prev(h));
                    if (sides == 4 && x + 1 == n) vertices[at.at(f, n, n)] = mesh.target(up);
                }
                if (x + 1 == last) break;
                h = across(up);
                if (h >= 0) h = mesh.next(h);
                if (sides == 3) {
                    h = across(h);
                    if (h >= 0) h = mesh.next(h);
                }
            }
            if (y + 1 == n) break;
            row = sides == 4 ? across(mesh.next(mesh.next(row))) : across(mesh.next(row));
            if (sides == 3 && row >= 0) row = across(mesh.next(mesh.next(row)));
        }
    }
    if (std::find(vertices.begin(), vertices.end(), -1) != vertices.end()) return std::nullopt;
    return vertices;
}

/// The rules' numbers of the points of a dual scheme's level, all of which have four neighbours.
std::optional<std::vector<int>> RepeatedRows::cells(const RootLayout& at, const RuleMesh& mesh,
                                                    std::span<const int> last_halfedge) const {
    const std::uint32_t n = at.segments();
    if (points_of(at) != static_cast<std::uint32_t>(mesh.vertex_count())) return std::nullopt;
    std::vector<int> vertices(points_of(at), -1);
    std::vector<int> out_of(points_of(at), -1);  // the half-edge along -x; beyond the boundary along y
    bool whole = true;
    const auto turn = [&](int h) {
        const int left = mesh.twin(mesh.prev(h));
        whole = whole && left >= 0;
        return left >= 0 ? left : h;
    };
    const auto ahead = [&](int h) {
        const int back = mesh.twin(h);
        whole = whole && back >= 0;
        return back >= 0 ? turn(turn(back)) : h;
    };
    for (std::uint32_t f = 0; f < own_roots_ && whole; ++f) {
        // From the last cell back: -x is two turns from +x, -y one more.
        int row = turn(turn(last_halfedge[f]));
        for (std::uint32_t y = n; y-- > 0;) {
            int h = row;
            for (std::uint32_t x = n; x-- > 0;) {
                vertices[number_at(at, f, {x, y})] = mesh.origin(h);
                out_of[number_at(at, f, {x, y})] = h;
                if (x > 0) h = ahead(h);
            }
            // Down, then to the left again.
            if (y > 0) row = turn(turn(turn(ahead(turn(row)))));
        }
    }
    for (std::uint32_t f = own_roots_; f < base_.face_count && whole; ++f) {
        const std::uint32_t h = base_.twin[4 * f], root = h / 4;
        if (root < own_roots_) {
            // Outwards from the cells along the side. Four neighbours have all but the last, on the boundary.
            for (std::uint32_t x = 0; x < n; ++x) {
                int out = out_of[number(at, h, n - 1 - x, 0)];
                for (std::uint32_t i = 0; i < (h + 1) % 4; ++i) out = turn(out);
                for (std::uint32_t y = 0; y < n; ++y) {
                    vertices[number_at(at, f, {x, y})] = mesh.target(out);
                    if (y + 1 < n) out = out_of[number_at(at, f, {x, y})] = ahead(out);
                }
            }
            continue;
        }
        // A corner's: sideways from the quads of both edges, but for the last cell, which is beside two that are not.
        const std::uint32_t other = base_.twin[4 * f + 3] / 4;
        for (std::uint32_t i = 0; i + 1 < n; ++i) {
            int left = turn(out_of[number_at(at, root, {0, i})]);
            int right = turn(turn(turn(out_of[number_at(at, other, {n - 1, i})])));
            for (std::uint32_t k = 0; k < n; ++k) {
                vertices[number_at(at, f, {i, k})] = mesh.target(left);
                vertices[number_at(at, f, {k, i})] = mesh.target(right);
                if (i + 2 == n && k + 2 == n)
                    vertices[number_at(at, f, {n - 1, n - 1})] = mesh.target(mesh.next(ahead(right)));
                if (k + 1 == n) break;
                left = ahead(left);
                right = ahead(right);
            }
        }
    }
    if (!whole) return std::nullopt;
    // A level that is made otherwise has other points.
    std::vector<char> found(vertices.size(), 0);
    for (const int v : vertices) {
        if (v < 0 || found[static_cast<std::size_t>(v)] != 0) return std::nullopt;
        found[static_cast<std::size_t>(v)] = 1;
    }
    return vertices;
}

RepeatedRows::Faces RepeatedRows::faces(const RunContext& context) const {
    if (in_cells_) return cell_faces();
    const RootLayout at(base_, segments_.back());
    const std::uint32_t size = side_count(), count = static_cast<std::uint32_t>(at.cell_count()),
                        cells = at.segments() * at.segments();
    Faces faces;
    faces.offsets.resize(count + std::size_t{1});
    faces.control.resize(count);
    faces.vertices.resize(std::size_t{size} * count);
    for_each_index(count + 1, [&](std::uint32_t f) { faces.offsets[f] = size * f; });
    for_each_index(count, [&](std::uint32_t f) { faces.control[f] = base_face_[f / cells]; });
    write_faces(at, faces.vertices, context);
    return faces;
}

/// Root by root the faces inside, edge by edge those across it, those around the corners.
RepeatedRows::Faces RepeatedRows::cell_faces() const {
    const RootLayout at(base_, segments_.back());
    const std::uint32_t n = at.segments(), inner = n - 1;
    std::vector<std::uint32_t> inner_edges;
    for (std::uint32_t e = 0; e < base_.edge_count; ++e)
        if (base_.twin[base_.edge_halfedge[e]] != none) inner_edges.push_back(e);
    const auto across = static_cast<std::uint32_t>(inner_edges.size());
    const std::uint32_t quads = base_.face_count * inner * inner + across * inner;
    Faces faces;
    faces.offsets.reserve(quads + std::size_t{base_.vertex_count} + 1);
    faces.offsets.resize(quads + std::size_t{1});
    for_each_index(quads + 1, [&](std::uint32_t f) { faces.offsets[f] = 4 * f; });
    faces.control.resize(quads);
    faces.vertices.reserve(4 * std::size_t{quads} + base_.halfedge_count());
    faces.vertices.resize(4 * std::size_t{quads});
    const auto quad = [&](std::uint32_t f, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        const std::uint32_t corners[4] = {a, b, c, d};
        std::copy_n(corners, 4, &faces.vertices[4 * std::size_t{f}]);
    };
    for_each_index(
        base_.face_count,
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
            const std::uint32_t h = base_.edge_halfedge[inner_edges[i]], t = base_.twin[h];
            std::uint32_t f = base_.face_count * inner * inner + i * inner;
            for (std::uint32_t j = 1; j < n; ++j, ++f) {
                quad(f, number(at, t, n - j, 0), number(at, t, n - 1 - j, 0), number(at, h, j, 0),
                     number(at, h, j - 1, 0));
                faces.control[f] = base_face_[h / 4];
            }
        },
        k_grain);
    for (std::uint32_t v = 0; v < base_.vertex_count; ++v) {
        const std::uint32_t first = base_.vertex_halfedge[v];
        if (first == none || base_.twin[first] == none) continue;  // the outermost points are the boundary
        std::uint32_t h = first;
        do {
            faces.vertices.push_back(number(at, h, 0, 0));
            h = base_.twin[base_.prev(h)];
        } while (h != first);
        faces.offsets.push_back(static_cast<std::uint32_t>(faces.vertices.size()));
        faces.control.push_back(base_face_[first / 4]);
    }
    return faces;
}

}  // namespace tetrakis::detail
