#include "tetrakis/refine/repeated_rows.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/huge_buffer.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/grid_refinement.hpp"
#include "tetrakis/refine/rule_refiner.hpp"
#include "tetrakis/schemes/face_split.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

/// Weights of one row found in two places differ by rounding at most.
constexpr double k_same_weight = 1e-13;
/// Roots per task.
constexpr std::uint32_t k_grain = 4;

/// The first two levels whose lattices are worth a look: 4 and 8 segments a side, or 3 and 9.
constexpr std::uint32_t k_least_segments = 3;

/// Whether nothing turns from sharp to smooth within that many steps.
bool stays_as_it_is(const RuleMesh& mesh, int steps) {
    const auto turns = [&](float sharpness) {
        return is_semi_sharp(sharpness) && sharpness <= static_cast<float>(steps);
    };
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (turns(mesh.sharpness(h))) return false;
    return std::none_of(mesh.vertex_sharpness().begin(), mesh.vertex_sharpness().end(), turns);
}

bool is_closed_and_smooth(const RuleMesh& mesh) {
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (mesh.sharp(h) || mesh.twin(h) == RuleMesh::none) return false;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (is_sharp(mesh.vertex_sharpness(v)) || mesh.first(v) == RuleMesh::none || mesh.ring(v).faces() < 3)
            return false;
    return true;
}

/// Calls visit(i, number(i)) for each i < count of a line of RootLayout, whose inner numbers have one second
/// difference.
template <class Number, class Visit>
void run_of(std::uint32_t count, const Number& number, const Visit& visit) {
    if (count < 6) {
        for (std::uint32_t i = 0; i < count; ++i) visit(i, number(i));
        return;
    }
    visit(0, number(0));
    std::uint32_t v = number(1), step = number(2) - v;
    const std::uint32_t turn = number(3) - number(2) - step;
    for (std::uint32_t i = 1; i + 1 < count; ++i) {
        visit(i, v);
        v += step;
        step += turn;
    }
    visit(count - 1, number(count - 1));
}

}  // namespace

struct RepeatedRows::Work {
    std::vector<Vec3d> lattice;  ///< a root of the coarser level with its sides: rows of N + 1
    std::vector<Vec3d> beyond;   ///< lines of its neighbour beside a side: N + 1 points each
    std::vector<std::uint32_t> numbers;
    /// Of a row along a side: the next point's, and how far on the one after that is.
    struct Term {
        const Vec3d* point;
        std::ptrdiff_t step;
        double weight;
    };
    std::vector<Term> terms;
};

std::unique_ptr<RepeatedRows> RepeatedRows::make(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                                 const RuleOptions& rules, std::unique_ptr<RuleLevels>& levels_by_rules,
                                                 const RunContext& context) {
    const bool triangles = scheme.family == MeshFamily::triangles,
               dual = fan_lattice(scheme, rules) == FanLattice::dual;
    if (scheme.refinement == Refinement::honeycomb) return nullptr;
    if (triangles && !mesh.all_triangles()) return nullptr;  // the rules say what is wrong
    bool quads = true;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) quads = quads && mesh.face_size(FaceId(f)) == 4;
    // Level at which a root has one segment.
    const int base_level = dual ? 1 : triangles || quads ? 0 : 1, last_by_rules = levels - 1;
    if (last_by_rules < base_level + 2) return nullptr;

    RuleLevels& by_rules = *levels_by_rules;
    std::unique_ptr<RepeatedRows> all(new RepeatedRows(scheme.refinement == Refinement::sqrt3 ? 3 : 2));
    all->in_cells_ = dual;
    if (dual) {
        if (!is_closed_and_smooth(by_rules.last())) return nullptr;
        if (!all->set_base(split_polygons(by_rules.last()), by_rules)) return nullptr;
    }
    for (int level = 0; level < base_level; ++level) {
        check_rule_memory(mesh, scheme, level + 1, context);
        const std::vector<int> child = by_rules.advance();
        if (!dual) continue;
        // Root h is at corner h; the children of the corners are the first points.
        if (static_cast<std::size_t>(by_rules.last().vertex_count()) != child.size()) return nullptr;
        all->last_halfedge_ = child;
    }
    if (!dual && !all->set_base(by_rules.last(), by_rules)) return nullptr;
    // The child of each of the roots' half-edges at its origin, level by level.
    // Dual: the half-edge of a root's last cell that stays in its face.
    std::vector<int> first = std::move(all->last_halfedge_);
    if (!dual) {
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
        check_rule_memory(mesh, scheme, level + 1, context);
        const bool stationary =
            segments >= (dual ? 2 : k_least_segments) && stays_as_it_is(by_rules.last(), levels - level);
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
        if (!all->learn(coarse, fine, number, *vertices, by_rules.steps().back())) continue;
        all->vertices_ = std::move(*vertices);
        all->levels_ = std::move(levels_by_rules);
        all->template_segments_ = static_cast<std::ptrdiff_t>(coarse.segments());
        all->segments_ = {segments};
        // More than that no 32-bit numbers can count.
        constexpr std::uint32_t k_most_segments = 1u << 20;
        for (++level; level < levels; ++level)
            all->segments_.push_back(segments = std::min(segments * all->factor_, k_most_segments));
        all->check_size(mesh, levels, context);
        return all;
    }
    return nullptr;
}

void RepeatedRows::check_size(const ControlMesh& mesh, int levels, const RunContext& context) const {
    const auto cells_of = [&](std::uint32_t n) { return std::uint64_t{n} * n * base_.face_count; };
    const std::uint64_t n = segments_.back(), cells = cells_of(segments_.back()),
                        corners = cells * static_cast<std::uint64_t>(base_.face_size);
    // Points on the sides are at most as many as their pieces and ends.
    const std::uint64_t points = cells + n * base_.edge_count + base_.vertex_count;
    if (corners >= std::numeric_limits<std::uint32_t>::max() || points >= std::numeric_limits<std::uint32_t>::max())
        throw Error(ErrorCode::unsupported,
                    std::to_string(levels) + " levels give more elements than 32-bit numbers can count; the last has " +
                        std::to_string(corners) + " face corners",
                    mesh.data().source);
    const std::uint64_t above = cells_of(segments_[segments_.size() < 2 ? 0 : segments_.size() - 2]);
    const std::uint64_t bytes = sizeof(Vec3d) * (points + 2 * above) + 4 * (corners + 2 * cells);
    if (context.max_memory_bytes == 0 || bytes <= context.max_memory_bytes) return;
    throw Error(ErrorCode::memory_limit,
                std::to_string(levels) + " levels, about " + std::to_string(points) + " vertices, need about " +
                    std::to_string(bytes >> 20) + " MiB, and the limit is " +
                    std::to_string(context.max_memory_bytes >> 20) + " MiB; ask for fewer levels",
                mesh.data().source);
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
    for (std::uint32_t f = 0; f < base_.face_count; ++f)
        base_face_[f] = static_cast<std::uint32_t>(
            levels.control_face(in_cells_ ? levels.last().face(static_cast<int>(f)) : static_cast<int>(f)));
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
    for (std::uint32_t f = 0; f < base_.face_count && whole; ++f) {
        // From the last cell back: -x is two turns from +x, -y one more.
        int row = turn(turn(last_halfedge[f]));
        for (std::uint32_t y = n; y-- > 0;) {
            int h = row;
            for (std::uint32_t x = n; x-- > 0;) {
                vertices[number_at(at, f, {x, y})] = mesh.origin(h);
                if (x > 0) h = ahead(h);
            }
            // Down, then to the left again.
            if (y > 0) row = turn(turn(turn(ahead(turn(row)))));
        }
    }
    if (!whole || std::find(vertices.begin(), vertices.end(), -1) != vertices.end()) return std::nullopt;
    return vertices;
}

RepeatedRows::Place RepeatedRows::turned(std::uint32_t n, std::uint32_t side, std::uint32_t a, std::uint32_t b) const {
    if (base_.face_size == 4) {
        const Place places[4] = {{a, b}, {n - b, a}, {n - a, n - b}, {b, n - a}};
        return places[side];
    }
    const Place places[3] = {{a, b}, {n - a - b, a}, {b, n - a - b}};
    return places[side];
}

RepeatedRows::Place RepeatedRows::seen_from(std::uint32_t n, std::uint32_t side, const Place& p) const {
    if (base_.face_size == 4) {
        const Place places[4] = {p, {p.y, n - p.x}, {n - p.x, n - p.y}, {n - p.y, p.x}};
        return places[side];
    }
    const Place places[3] = {p, {p.y, n - p.x - p.y}, {n - p.x - p.y, p.x}};
    return places[side];
}

std::uint32_t RepeatedRows::number(const RootLayout& at, std::uint32_t h, std::uint32_t a, std::uint32_t b) const {
    return number_at(at, h / side_count(), turned(last_place(at.segments()), h % side_count(), a, b));
}

/// Where a point is in the lattice of root f, sides included; nothing if it is not there.
std::optional<RepeatedRows::Place> RepeatedRows::place_in(const RootLayout& at, std::uint32_t f,
                                                          std::uint32_t number) const {
    const std::uint32_t n = at.segments(), sides = side_count(), inner = n - 1;
    if (in_cells_) {
        if (number / (n * n) != f) return std::nullopt;
        return Place{number % n, number / n % n};
    }
    if (number < base_.vertex_count) {
        for (std::uint32_t s = 0; s < sides; ++s)
            if (base_.origin[sides * f + s] == number) return turned(n, s, 0, 0);
        return std::nullopt;
    }
    if (number < at.face_begin(0)) {
        const std::uint32_t e = (number - base_.vertex_count) / inner, j = (number - base_.vertex_count) % inner + 1;
        for (std::uint32_t s = 0; s < sides; ++s) {
            const std::uint32_t side = base_.edge_side[sides * f + s];
            if (side >> 1 == e) return turned(n, s, (side & 1) == 0 ? j : n - j, 0);
        }
        return std::nullopt;
    }
    if (number < at.face_begin(f) || number >= at.face_begin(f) + at.root_points()) return std::nullopt;
    std::uint32_t i = number - at.face_begin(f);
    if (sides == 4) return Place{i % inner + 1, i / inner + 1};
    std::uint32_t y = 1;
    for (; i >= n - 1 - y; ++y) i -= n - 1 - y;
    return Place{i + 1, y};
}

std::optional<RepeatedRows::Term> RepeatedRows::at_corner(const RootLayout& at, std::uint32_t h,
                                                          std::uint32_t number) const {
    const std::uint32_t n = at.segments();
    const auto in = [&](std::uint32_t g, int turn) -> std::optional<Term> {
        const std::uint32_t f = g / side_count();
        const std::optional<Place> p = place_in(at, f, number);
        if (!p) return std::nullopt;
        const Place seen = seen_from(last_place(n), g % side_count(), *p);
        // What lies on the far sides belongs to other corners as well.
        if (!in_cells_ && (seen.x == n || seen.y == n || rest(n, seen.x, seen.y) == 0)) return std::nullopt;
        return Term{static_cast<std::int16_t>(turn), static_cast<std::int16_t>(seen.x),
                    static_cast<std::int16_t>(seen.y), 0};
    };
    std::uint32_t g = h;
    int turn = 0;
    do {
        if (const auto term = in(g, turn)) return term;
        g = base_.twin[base_.prev(g)];
        ++turn;
    } while (g != none && g != h);
    if (g == h) return std::nullopt;
    // A boundary: the other way round, too.
    turn = 0;
    for (g = base_.twin[h]; g != none; g = base_.twin[g]) {
        g = base_.next(g);
        if (const auto term = in(g, --turn)) return term;
    }
    return std::nullopt;
}

std::optional<RepeatedRows::Term> RepeatedRows::at_side(const RootLayout& at, std::uint32_t h,
                                                        std::uint32_t number) const {
    const std::uint32_t n = at.segments();
    int beyond = 0;
    for (const std::uint32_t g : {h, base_.twin[h]}) {
        if (g == none) break;
        if (const std::optional<Place> p = place_in(at, g / side_count(), number)) {
            const Place seen = seen_from(last_place(n), g % side_count(), *p);
            if (!in_cells_ && seen.y == n) return std::nullopt;
            return Term{static_cast<std::int16_t>(beyond), static_cast<std::int16_t>(seen.x),
                        static_cast<std::int16_t>(seen.y), 0};
        }
        ++beyond;
    }
    return std::nullopt;
}

/// The rows inside, and how far from the sides they hold.
bool RepeatedRows::learn_inside(const RootLayout& coarse, const RootLayout& fine, std::span<const int> coarse_number,
                                std::span<const int> fine_vertex, const StencilTable& rows) {
    const std::uint32_t m = fine.segments(), sides = side_count(), last = last_place(m);
    inside_.assign(std::size_t{factor_} * factor_, {});
    const auto offsets = [&](std::uint32_t f, std::uint32_t x, std::uint32_t y, std::vector<Offset>& out) {
        out.clear();
        const int row = fine_vertex[number_at(fine, f, {x, y})];
        const auto points = rows.points(row);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto p = place_in(coarse, f, static_cast<std::uint32_t>(coarse_number[points[i]]));
            if (!p) return false;
            out.push_back({static_cast<int>(p->x) - static_cast<int>(x / factor_),
                           static_cast<int>(p->y) - static_cast<int>(y / factor_), rows.weights(row)[i]});
        }
        std::sort(out.begin(), out.end(),
                  [](const Offset& s, const Offset& t) { return std::pair(s.dy, s.dx) < std::pair(t.dy, t.dx); });
        return true;
    };
    // From the middle of the first root.
    const std::uint32_t middle = sides == 4 ? m / 2 - (in_cells_ ? 1 : 0) : m / 3;
    for (std::uint32_t y = middle; y < middle + factor_; ++y)
        for (std::uint32_t x = middle; x < middle + factor_; ++x)
            if (!offsets(0, x, y, inside_[y % factor_ * factor_ + x % factor_])) return false;
    const auto same = [&](const std::vector<Offset>& s, const std::vector<Offset>& t) {
        return std::equal(s.begin(), s.end(), t.begin(), t.end(), [](const Offset& a, const Offset& b) {
            return a.dx == b.dx && a.dy == b.dy && std::abs(a.weight - b.weight) <= k_same_weight;
        });
    };
    const std::uint32_t least = in_cells_ ? 0 : 1;
    depth_ = least;
    std::vector<Offset> found;
    for (std::uint32_t f = 0; f < base_.face_count; ++f)
        for (std::uint32_t y = least; y + least <= last; ++y)
            for (std::uint32_t x = least; x + least + (sides == 4 ? 0 : y) <= last; ++x) {
                const std::uint32_t nearest =
                    sides == 4 ? std::min({x, y, last - x, last - y}) : std::min({x, y, last - x - y});
                if (nearest < depth_) continue;
                if (!offsets(f, x, y, found) || !same(found, inside_[y % factor_ * factor_ + x % factor_]))
                    depth_ = nearest + 1;
            }
    return true;
}

bool RepeatedRows::learn(const RootLayout& coarse, const RootLayout& fine, std::span<const int> coarse_number,
                         std::span<const int> fine_vertex, const StencilTable& rows) {
    const std::uint32_t m = last_place(fine.segments()), sides = side_count();
    if (!learn_inside(coarse, fine, coarse_number, fine_vertex, rows)) return false;
    // Along a side there must be places for all remainders, as far from one corner as from the other.
    const std::uint32_t longest = sides == 4 ? m : m - depth_ + 1;
    if (depth_ < 1 || longest + 1 < factor_ + 2 * depth_) return false;
    reach_ = (longest + 1 - factor_) / 2;
    corner_places_.clear();
    for (std::uint32_t b = 0; b < reach_; ++b)
        for (std::uint32_t a = 0; a < reach_; ++a)
            if (a < depth_ || b < depth_) corner_places_.push_back({a, b});

    const auto add_row = [&](std::uint32_t h, std::uint32_t a, std::uint32_t b, auto&& term_at, Row& out) {
        out.clear();
        const int row = fine_vertex[number(fine, h, a, b)];
        const auto points = rows.points(row);
        for (std::size_t i = 0; i < points.size(); ++i) {
            std::optional<Term> term = term_at(coarse, h, static_cast<std::uint32_t>(coarse_number[points[i]]));
            if (!term) return false;
            term->weight = rows.weights(row)[i];
            out.push_back(*term);
        }
        std::sort(out.begin(), out.end());
        return true;
    };
    const auto corner_term = [&](auto&&... args) { return at_corner(args...); };
    const auto side_term = [&](auto&&... args) { return at_side(args...); };
    const std::uint32_t halfedges = base_.halfedge_count();
    std::map<Pattern, std::uint32_t> corners, along;
    const auto kept = [](std::map<Pattern, std::uint32_t>& patterns, Pattern& pattern) {
        return patterns.try_emplace(pattern, static_cast<std::uint32_t>(patterns.size())).first->second;
    };
    corner_pattern_.resize(halfedges);
    side_pattern_.resize(halfedges);
    Pattern pattern;
    Row other;
    for (std::uint32_t h = 0; h < halfedges; ++h) {
        pattern.resize(corner_places_.size());
        for (std::size_t i = 0; i < corner_places_.size(); ++i)
            if (!add_row(h, corner_places_[i].x, corner_places_[i].y, corner_term, pattern[i])) return false;
        corner_pattern_[h] = kept(corners, pattern);

        pattern.resize(std::size_t{depth_} * factor_);
        for (std::uint32_t b = 0; b < depth_; ++b)
            for (std::uint32_t a = reach_; rest(m, a, b) >= reach_ && a + b <= m; ++a) {
                Row& row = pattern[b * factor_ + (a - reach_) % factor_];
                if (a < reach_ + factor_) {
                    if (!add_row(h, a, b, side_term, row)) return false;
                    continue;
                }
                // Another place of the same kind: the rows there must be the same ones.
                const int shift = static_cast<int>((a - reach_) / factor_);
                if (!add_row(h, a, b, side_term, other)) return false;
                for (Term& term : other) term.a = static_cast<std::int16_t>(term.a + (term.turn == 0 ? -shift : shift));
                std::sort(other.begin(), other.end());
                if (!std::equal(row.begin(), row.end(), other.begin(), other.end(), [](const Term& s, const Term& t) {
                        return s.turn == t.turn && s.a == t.a && s.b == t.b &&
                               std::abs(s.weight - t.weight) <= k_same_weight;
                    }))
                    return false;
            }
        side_pattern_[h] = kept(along, pattern);
    }
    const auto listed = [](std::map<Pattern, std::uint32_t>& patterns) {
        std::vector<Pattern> list(patterns.size());
        for (const auto& [rows_of, i] : patterns) list[i] = rows_of;
        return list;
    };
    corner_patterns_ = listed(corners);
    side_patterns_ = listed(along);
    return true;
}

void RepeatedRows::refine(std::span<const Vec3d> control, std::span<Vec3d> points, const RunContext& context) const {
    const std::vector<double> net = levels_->net({&control.data()->x, 3 * control.size()}, 3);
    HugeBuffer<double> buffers[2];
    const auto buffer = [&](std::size_t i) -> Vec3d* {
        if (i + 1 == segments_.size()) return points.data();
        return reinterpret_cast<Vec3d*>(
            buffers[i & 1].reserve(3 * std::size_t{points_of(RootLayout(base_, segments_[i]))}));
    };
    Vec3d* now = buffer(0);
    for_each_index(static_cast<std::uint32_t>(vertices_.size()), [&](std::uint32_t i) {
        std::memcpy(static_cast<void*>(now + i), net.data() + 3 * static_cast<std::size_t>(vertices_[i]),
                    sizeof(Vec3d));
    });
    for (std::size_t i = 1; i < segments_.size(); ++i) {
        context.report("refine", static_cast<double>(i) / static_cast<double>(segments_.size()));
        Vec3d* const finer = buffer(i);
        step(RootLayout(base_, segments_[i - 1]), RootLayout(base_, segments_[i]), now, finer);
        now = finer;
    }
}

void RepeatedRows::step(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const {
    const std::uint32_t n = last_place(coarse.segments()), sides = side_count();
    for (std::uint32_t v = 0; v < base_.vertex_count && !in_cells_; ++v)
        if (base_.vertex_halfedge[v] == none) out[v] = in[v];
    for_each_block(base_.face_count, k_grain, [&](std::uint32_t begin, std::uint32_t end) {
        Work work;
        work.lattice.resize(std::size_t{n + 1} * (n + 1));
        for (std::uint32_t f = begin; f < end; ++f) {
            for (std::uint32_t y = 0; y <= n; ++y) {
                Vec3d* const row = work.lattice.data() + std::size_t{y} * (n + 1);
                const std::uint32_t last = sides == 4 ? n : n - y;
                if (in_cells_) {
                    std::copy_n(in + number_at(coarse, f, {0, y}), last + 1, row);
                    continue;
                }
                const bool side_row = y == 0 || last < 2 || (sides == 4 && y == n);
                if (side_row) {
                    for (std::uint32_t x = 0; x <= last; ++x) row[x] = in[coarse.at(f, x, y)];
                    continue;
                }
                row[0] = in[coarse.at(f, 0, y)];
                row[last] = in[coarse.at(f, last, y)];
                std::copy_n(in + coarse.at(f, 1, y), last - 1, row + 1);
            }
            inside(coarse, fine, f, out, work);
            for (std::uint32_t h = sides * f; h < sides * (f + 1); ++h) {
                side(coarse, fine, h, in, out, work);
                corner(coarse, fine, h, in, out);
            }
        }
    });
}

/// `Points` points that lie `factor` apart, from coarse ones side by side.
template <std::uint32_t Points, class Terms>
inline void combine(const double* at, const Terms& terms, std::ptrdiff_t stride, std::uint32_t factor, Vec3d* to) {
    double sum[3 * Points] = {};
    for (const auto& term : terms) {
        const double* const p = at + 3 * (term.dx + term.dy * stride);
        for (std::uint32_t k = 0; k < 3 * Points; ++k) sum[k] += term.weight * p[k];
    }
    for (std::uint32_t i = 0; i < Points; ++i) to[i * factor] = Vec3d(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]);
}

void RepeatedRows::inside(const RootLayout& coarse, const RootLayout& fine, std::uint32_t f, Vec3d* out,
                          const Work& work) const {
    const std::uint32_t m = last_place(fine.segments()), stride = last_place(coarse.segments()) + 1;
    constexpr std::uint32_t k_block = 4;  // points at a time: 12 numbers, in registers
    for (std::uint32_t y = depth_; y + depth_ <= m; ++y) {
        const std::uint32_t end = base_.face_size == 4 ? m - depth_ : m - depth_ - std::min(y, m - depth_);
        for (std::uint32_t first = depth_; first < depth_ + factor_ && first <= end; ++first) {
            const std::vector<Offset>& terms = inside_[y % factor_ * factor_ + first % factor_];
            const std::uint32_t count = (end - first) / factor_ + 1;
            const double* const at = &work.lattice[std::size_t{y / factor_} * stride + first / factor_].x;
            Vec3d* const to = out + number_at(fine, f, {first, y});
            if (count < k_block) {
                for (std::uint32_t i = 0; i < count; ++i)
                    combine<1>(at + 3 * std::size_t{i}, terms, stride, factor_, to + i * factor_);
                continue;
            }
            for (std::uint32_t i = 0; i < count; i += k_block) {
                // A last block that is not whole: with points before it once more.
                const std::uint32_t begin = std::min(i, count - k_block);
                combine<k_block>(at + 3 * std::size_t{begin}, terms, stride, factor_, to + begin * factor_);
            }
        }
    }
}

void RepeatedRows::side(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out,
                        Work& work) const {
    const std::uint32_t n = last_place(coarse.segments()), m = last_place(fine.segments()), t = base_.twin[h],
                        stride = n + 1;
    const std::uint32_t s = h % side_count();
    const Pattern& pattern = side_patterns_[side_pattern_[h]];
    std::uint32_t deepest = 0;
    for (const Row& row : pattern)
        for (const Term& term : row)
            if (term.turn == 1) deepest = std::max(deepest, static_cast<std::uint32_t>(term.b));
    work.beyond.resize(std::size_t{deepest + 1} * stride);
    for (std::uint32_t b = in_cells_ ? 0 : 1; b <= deepest; ++b)
        run_of(
            n - (side_count() == 3 ? b : 0) + 1, [&](std::uint32_t a) { return number(coarse, t, a, b); },
            [&](std::uint32_t a, std::uint32_t v) { work.beyond[std::size_t{b} * stride + a] = in[v]; });
    const auto own = [&](std::uint32_t a, std::uint32_t b) {
        const Place p = turned(n, s, a, b);
        return static_cast<std::ptrdiff_t>(std::size_t{p.y} * stride + p.x);
    };
    const std::ptrdiff_t along = own(1, 0) - own(0, 0), away = own(0, 1) - own(0, 0), origin = own(0, 0);
    const std::ptrdiff_t longer = static_cast<std::ptrdiff_t>(coarse.segments()) - template_segments_;
    const bool owns_edge = in_cells_ || (base_.edge_side[h] & 1) == 0;
    for (std::uint32_t b = owns_edge ? 0 : 1; b < depth_; ++b) {
        const std::uint32_t last = rest(m, reach_, b);
        if (last < reach_) continue;
        const std::uint32_t count = last - reach_ + 1;
        work.numbers.resize(count);
        run_of(
            count, [&](std::uint32_t i) { return number(fine, h, reach_ + i, b); },
            [&](std::uint32_t i, std::uint32_t v) { work.numbers[i] = v; });
        for (std::uint32_t kind = 0; kind < factor_ && kind < count; ++kind) {
            const Row& row = pattern[b * factor_ + kind];
            work.terms.clear();
            for (const Term& term : row) {
                if (term.turn == 0)
                    work.terms.push_back(
                        {work.lattice.data() + origin + term.a * along + term.b * away, along, term.weight});
                else
                    work.terms.push_back(
                        {work.beyond.data() + term.b * static_cast<std::ptrdiff_t>(stride) + term.a + longer, -1,
                         term.weight});
            }
            for (std::uint32_t i = kind; i < count; i += factor_) {
                Vec3d sum(0);
                for (Work::Term& term : work.terms) {
                    sum += term.weight * *term.point;
                    term.point += term.step;
                }
                out[work.numbers[i]] = sum;
            }
        }
    }
}

void RepeatedRows::corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in,
                          Vec3d* out) const {
    const bool owns_vertex = in_cells_ || base_.vertex_halfedge[base_.origin[h]] == h,
               owns_edge = in_cells_ || (base_.edge_side[h] & 1) == 0,
               owns_other = in_cells_ || (base_.edge_side[base_.prev(h)] & 1) == 0;
    const Pattern& pattern = corner_patterns_[corner_pattern_[h]];
    for (std::size_t i = 0; i < corner_places_.size(); ++i) {
        const Place place = corner_places_[i];
        if (place.x == 0 && place.y == 0 ? !owns_vertex : (place.y == 0 && !owns_edge) || (place.x == 0 && !owns_other))
            continue;
        Vec3d sum(0);
        // Terms come by turns, those against the clock first.
        std::uint32_t g = h;
        int turn = 0;
        for (const Term& term : pattern[i]) {
            for (; turn > term.turn; --turn) g = base_.next(base_.twin[g]);
            for (; turn < term.turn; ++turn) g = base_.twin[base_.prev(g)];
            sum += term.weight *
                   in[number(coarse, g, static_cast<std::uint32_t>(term.a), static_cast<std::uint32_t>(term.b))];
        }
        out[number(fine, h, place.x, place.y)] = sum;
    }
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
    const std::uint32_t quads = base_.face_count * inner * inner + base_.edge_count * inner;
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
        base_.edge_count,
        [&](std::uint32_t e) {
            const std::uint32_t h = base_.edge_halfedge[e], t = base_.twin[h];
            std::uint32_t f = base_.face_count * inner * inner + e * inner;
            for (std::uint32_t j = 1; j < n; ++j, ++f) {
                quad(f, number(at, t, n - j, 0), number(at, t, n - 1 - j, 0), number(at, h, j, 0),
                     number(at, h, j - 1, 0));
                faces.control[f] = base_face_[h / 4];
            }
        },
        k_grain);
    for (std::uint32_t v = 0; v < base_.vertex_count; ++v) {
        const std::uint32_t first = base_.vertex_halfedge[v];
        if (first == none) continue;
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
