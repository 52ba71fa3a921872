#include "row_patterns.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>

// Reads stencil rows off the templates of corners, in coordinates that hold on all levels.
namespace tetrakis::detail {

namespace {

/// Largest number of ghost rings that interior rows may read.
constexpr std::uint32_t k_most_rings = 5;

/// Replaces two tangent rows by a basis that depends only on the plane that they span and its orientation. In this
/// basis the first large column is (1, 0), and the first column with a large second entry is (0, +-1).
template <class Column>
void make_canonical(std::vector<Column>& columns) {
    // Not a simple fraction: ratios of some masks' weights are, and rounding would then decide which column is large.
    constexpr double k_large = 0.0871;
    const auto first_large = [&](const auto& size) {
        double largest = 0;
        for (const Column& c : columns) largest = std::max(largest, size(c));
        return std::find_if(columns.begin(), columns.end(),
                            [&](const Column& c) { return size(c) > 0 && size(c) >= k_large * largest; });
    };
    // Column sizes in the metric of the Gram matrix: another basis only multiplies all of them by one factor.
    double g11 = 0, g12 = 0, g22 = 0;
    for (const Column& c : columns) {
        g11 += c.w1 * c.w1;
        g12 += c.w1 * c.w2;
        g22 += c.w2 * c.w2;
    }
    const auto pivot = first_large([&](const Column& c) {
        return std::sqrt(std::max(0.0, g22 * c.w1 * c.w1 - 2 * g12 * c.w1 * c.w2 + g11 * c.w2 * c.w2));
    });
    if (pivot == columns.end()) return;
    const double length = std::hypot(pivot->w1, pivot->w2), c1 = pivot->w1 / length, c2 = pivot->w2 / length;
    for (Column& c : columns) {
        const double along = (c1 * c.w1 + c2 * c.w2) / length, across = (c1 * c.w2 - c2 * c.w1) / length;
        c.w1 = along;
        c.w2 = across;
    }
    pivot->w1 = 1;
    pivot->w2 = 0;
    const auto other = first_large([](const Column& c) { return std::abs(c.w2); });
    if (other == columns.end()) return;
    const double scale = 1 / std::abs(other->w2), factor = other->w1 / other->w2;
    for (Column& c : columns) {
        c.w1 -= factor * c.w2;
        c.w2 *= scale;
    }
    other->w1 = 0;
}

/// Makes a pair of tangent rows canonical. Both are sorted by point, before and after.
template <class Row>
void make_canonical(Row& first_row, Row& second_row) {
    struct Column {
        decltype(Row::value_type::at) at;
        double w1, w2;
    };
    std::vector<Column> columns;
    for (auto a = first_row.begin(), b = second_row.begin(); a != first_row.end() || b != second_row.end();) {
        const bool first = b == second_row.end() || (a != first_row.end() && a->at <= b->at),
                   second = a == first_row.end() || (b != second_row.end() && b->at <= a->at);
        columns.push_back({first ? a->at : b->at, first ? a->weight : 0, second ? b->weight : 0});
        if (first) ++a;
        if (second) ++b;
    }
    make_canonical(columns);
    first_row.clear();
    second_row.clear();
    constexpr double k_zero_weight = 1e-12;
    for (const Column& c : columns) {
        if (std::abs(c.w1) > k_zero_weight) first_row.push_back({c.at, c.w1});
        if (std::abs(c.w2) > k_zero_weight) second_row.push_back({c.at, c.w2});
    }
}

/// Sorts the terms by point, and adds up the weights of terms with the same point.
template <class Row>
void sort_terms(Row& row) {
    std::sort(row.begin(), row.end(), [](const auto& s, const auto& t) { return s.at < t.at; });
    std::size_t count = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        if (count > 0 && row[count - 1].at == row[i].at)
            row[count - 1].weight += row[i].weight;
        else
            row[count++] = row[i];
    }
    row.resize(count);
}

}  // namespace

RowPatterns::RowPatterns(const RootLattices& net, std::uint32_t factor, Kind kind)
    : net_(net), factor_(factor), kind_(kind), regular_corners_(regular_corners(net)) {}

/// Weights of the same row read at two places differ by rounding only; tangents also by errors of the eigenvectors.
double RowPatterns::tolerance() const { return kind_ == Kind::points ? 1e-13 : 1e-11; }

template <class At>
bool RowPatterns::same(const RowOf<At>& a, const RowOf<At>& b) const {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const TermOf<At>& s, const TermOf<At>& t) {
        return s.at == t.at && std::abs(s.weight - t.weight) <= tolerance();
    });
}

/// Reads the rows of a result, sorted by point; without tangents they are empty. False: some point is not seen.
/// @param seen_only  skip surfaces with points that are not seen; false: only if none is left
template <class At, class SeenAt>
bool RowPatterns::rows_of(const CornerRows& source, int row, const SeenAt& seen_at, std::span<RowOf<At>> out,
                          bool seen_only) const {
    for (RowOf<At>& to : out) to.clear();
    if (row < 0) return false;
    const auto terms = [&](const StencilTable& table, int from, RowOf<At>& to) {
        const auto points = table.points(from);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::optional<At> seen = seen_at(static_cast<std::uint32_t>(points[i]));
            if (!seen) return false;
            to.push_back({*seen, table.weights(from)[i]});
        }
        sort_terms(to);
        return true;
    };
    if (kind_ == Kind::points) return terms(source.rows.positions, row, out[0]);

    const int begin = source.rows.begin[static_cast<std::size_t>(row)],
              end = source.rows.begin[static_cast<std::size_t>(row) + 1];
    std::size_t found = 0;
    for (int i = begin; i < end; ++i) {
        if (2 * found + 2 > out.size()) return false;
        RowOf<At>* const pair = &out[2 * found];
        if (!terms(source.rows.tangent1, i, pair[0]) || !terms(source.rows.tangent2, i, pair[1])) {
            if (!seen_only) return false;
            pair[0].clear();
            pair[1].clear();
            continue;
        }
        make_canonical(pair[0], pair[1]);
        ++found;
    }
    if (seen_only && begin < end && found == 0) return false;
    if (found == 2) {
        // The rules leave the order of two surfaces open: the one with the lower points comes first.
        const auto less = [&](const RowOf<At>& a, const RowOf<At>& b) {
            return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                                [](const auto& s, const auto& t) { return s.at < t.at; });
        };
        if (less(out[2], out[0]) || (!less(out[0], out[2]) && less(out[3], out[1]))) {
            std::swap(out[0], out[2]);
            std::swap(out[1], out[3]);
        }
    }
    return true;
}

/// Reads the rows at the places of one of a template's roots.
class RowPatterns::TemplateReader {
  public:
    TemplateReader(const RowPatterns& patterns, const CornerRows& source, std::uint32_t rings)
        : p_(patterns),
          source_(source),
          net_(source.corner.net()),
          coarse_(net_.layout(source.corner.segments())),
          fine_(net_.layout(patterns.factor_ * source.corner.segments())),
          regular_(regular_corners(net_)),
          grid_(net_, coarse_, regular_, rings),
          last_(net_.last_place(fine_)),
          zone_(zone(patterns.factor_, source.corner.segments())),
          places_(static_cast<std::size_t>(source.corner.mesh().vertex_count())) {
        const std::uint32_t n = net_.last_place(coarse_);
        for (std::uint32_t f = 0; f < net_.root_count(); ++f)
            for (std::uint32_t y = 0; y <= n; ++y)
                for (std::uint32_t x = 0; x <= (net_.side_count() == 4 ? n : n - y); ++x)
                    places_[number(net_.number_at(coarse_, f, RootLattices::Place{x, y}))].push_back({f, x, y});
    }

    std::uint32_t zone_size() const { return zone_; }
    void look_at(std::uint32_t root) {
        root_ = root;
        h_ = source_.corner.halfedge(root);
        side_ = grid_.side(h_ % net_.side_count());
        numbers_.assign(grid_.size(), -1);
        grid_.fill(net_.base().face(h_), source_.corner.numbers().data(), numbers_.data());
    }

    /// Reads the rows of place (x, y). Points are offsets from there, along the two sides of the root at the corner.
    bool rows(std::uint32_t x, std::uint32_t y, std::span<RowOf<Step>> out) const {
        const auto dx = static_cast<std::ptrdiff_t>(x / p_.factor_), dy = static_cast<std::ptrdiff_t>(y / p_.factor_);
        const auto seen = [&](std::uint32_t number) -> std::optional<Step> {
            const auto at = std::find(numbers_.begin(), numbers_.end(), static_cast<int>(number));
            if (at == numbers_.end()) return std::nullopt;
            const GhostGrid::Place p = grid_.place(at - numbers_.begin());
            const std::uint32_t sides = net_.side_count(), s = h_ % sides;
            const auto place = turned_place<GhostGrid::Place>(sides == 4, std::int64_t{net_.last_place(coarse_)},
                                                              s == 0 ? 0 : sides - s, p.x, p.y);
            return step(place.x - dx, place.y - dy);
        };
        return p_.rows_of<Step>(source_, row(x, y), seen, out);
    }
    /// Whether place (x, y) has the interior rows. A vertex that lies at two places of the grid is one point.
    bool is_regular(std::uint32_t x, std::uint32_t y) {
        const std::size_t count = p_.rows_inside();
        found_.resize(count);
        expected_.resize(count);
        const auto place = [&](std::uint32_t of) { return std::optional(first_place(of)); };
        if (!p_.rows_of<std::uint32_t>(source_, row(x, y), place, found_)) return false;
        const std::size_t kind = (y % p_.factor_ * p_.factor_ + x % p_.factor_) * count;
        const std::ptrdiff_t here =
            side_.index(static_cast<std::ptrdiff_t>(x / p_.factor_), static_cast<std::ptrdiff_t>(y / p_.factor_));
        for (std::size_t i = 0; i < count; ++i) {
            expected_[i].clear();
            for (const auto& term : p_.regular_[kind + i]) {
                const int of =
                    numbers_[static_cast<std::size_t>(here + term.at.a * side_.along + term.at.b * side_.away)];
                if (of < 0) return false;
                expected_[i].push_back({first_place(static_cast<std::uint32_t>(of)), term.weight});
            }
            sort_terms(expected_[i]);
        }
        if (count == 2) {
            make_canonical(expected_[0], expected_[1]);
            // The weights of a tangent may cancel at a corner where only two roots meet.
            if (expected_[1].empty()) return false;
        }
        for (std::size_t i = 0; i < count; ++i)
            if (!p_.same(found_[i], expected_[i])) return false;
        return true;
    }
    /// Place (a, b) as seen from a side at the corner, the root's first or last: a along half-edge h, b away from it.
    struct OnSide {
        std::uint32_t h, a, b;
    };
    OnSide on_side(bool last, std::uint32_t x, std::uint32_t y) const {
        if (!last) return {h_, x, y};
        return {std::uint32_t(net_.base().prev(h_)), net_.side_count() == 4 ? last_ - y : last_ - x - y, x};
    }
    /// Reads the rows of a place near a side. Points are offsets from there, along the side and away from it.
    bool side_rows(const OnSide& at, std::span<RowOf<Step>> out) const {
        const bool cells = net_.in_cells();
        const auto n = static_cast<int>(net_.last_place(coarse_)), along = static_cast<int>(at.a / p_.factor_);
        const auto seen = [&](std::uint32_t number) -> std::optional<Step> {
            for (const std::uint32_t g : {at.h, std::uint32_t(net_.base().twin(at.h))})
                for (const RootPlace& p : places_[number]) {
                    if (g == none || p.root != std::uint32_t(net_.base().face(g))) continue;
                    const auto s = net_.seen_from(net_.last_place(coarse_), g % net_.side_count(), {p.x, p.y});
                    const int a = static_cast<int>(s.x), b = static_cast<int>(s.y);
                    if (!cells && b == n) return std::nullopt;
                    return g == at.h ? step(a - along, b) : step(n - a - along, cells ? -b - 1 : -b);
                }
            return std::nullopt;
        };
        // At the end of a crease the rules give tangents of both sides, but a place lies on one side only.
        const bool seen_only = source_.corner.kind().crease_end;
        return p_.rows_of<Step>(source_, source_.row[net_.number(fine_, at.h, at.a, at.b)], seen, out, seen_only);
    }
    bool corner_rows(std::uint32_t x, std::uint32_t y, std::span<RowOf<RootLattices::Seen>> out) const {
        return p_.rows_of<RootLattices::Seen>(
            source_, row(x, y), [&](std::uint32_t number) { return from_corner(number); }, out);
    }
    /// Calls visit(x, y) for all places within zone_size() of the corner, the farthest first.
    template <class Visit>
    void for_each_inwards(Visit&& visit) const {
        const bool quads = net_.side_count() == 4;
        for (std::uint32_t d = zone_ + 1; d-- > 0;)
            for (std::uint32_t i = 0; i <= d; ++i) {
                visit(quads ? d : i, quads ? i : d - i);
                if (quads && i < d) visit(i, d);
            }
    }

  private:
    static Step step(std::ptrdiff_t a, std::ptrdiff_t b) {
        return {static_cast<std::int16_t>(a), static_cast<std::int16_t>(b)};
    }
    std::size_t number(std::uint32_t place) const { return static_cast<std::size_t>(source_.corner.numbers()[place]); }
    std::uint32_t first_place(std::uint32_t vertex) const {
        const RootPlace& p = places_[vertex].front();
        return net_.number_at(coarse_, p.root, RootLattices::Place{p.x, p.y});
    }
    /// A point in the coordinates of the next root counter-clockwise around the corner, from the current root on, that
    /// contains it; if there is none, of the next such root clockwise.
    std::optional<RootLattices::Seen> from_corner(std::uint32_t number) const {
        const CornerKind& kind = source_.corner.kind();
        const std::uint32_t n = net_.last_place(coarse_), roots = kind.roots();
        std::optional<RootLattices::Seen> best;
        for (const RootPlace& place : places_[number]) {
            std::uint32_t g = 0;
            while (g < roots && net_.base().face(source_.corner.halfedge(g)) != int(place.root)) ++g;
            if (g == roots) continue;
            const auto [x, y] = net_.seen_from(n, source_.corner.halfedge(g) % net_.side_count(), {place.x, place.y});
            // Points on the far sides of a root belong to other corners as well.
            if (!net_.in_cells() && (net_.side_count() == 4 ? std::max(x, y) : x + y) == n) continue;
            const int turn = kind.closed ? static_cast<int>((g + roots - root_) % roots) : static_cast<int>(g - root_);
            if (best && (best->turn >= 0 ? turn < 0 || turn > best->turn : turn < best->turn)) continue;
            best = {static_cast<std::int16_t>(turn), static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
        }
        return best;
    }
    int row(std::uint32_t x, std::uint32_t y) const { return source_.row[net_.number(fine_, h_, x, y)]; }

    const RowPatterns& p_;
    const CornerRows& source_;
    const RootLattices& net_;
    RootLayout coarse_, fine_;
    std::vector<char> regular_;
    GhostGrid grid_;
    std::uint32_t last_, zone_, root_ = 0, h_ = 0;
    GhostGrid::Side side_{};
    std::vector<std::vector<RootPlace>> places_;  ///< by vertex: its places in all roots, sides included
    std::vector<int> numbers_;                    ///< by place of the grid: its vertex; -1: none
    std::vector<RowOf<std::uint32_t>> found_, expected_;
};

/// Reads the interior rows, and finds how many rings of ghosts they need around a root.
bool RowPatterns::learn_regular(const CornerRows& source) {
    const std::uint32_t count = rows_inside(), n = source.corner.segments();
    TemplateReader reader(*this, source, std::min(k_most_rings, n));
    reader.look_at(0);
    regular_.assign(std::size_t{factor_} * factor_ * count, {});
    const std::uint32_t middle = reader.zone_size() / 2 - (factor_ - 1);
    for (std::uint32_t y = middle; y < middle + factor_; ++y)
        for (std::uint32_t x = middle; x < middle + factor_; ++x) {
            const std::span<RowOf<Step>> known(&regular_[(y % factor_ * factor_ + x % factor_) * std::size_t{count}],
                                               count);
            if (!reader.rows(x, y, known) || known.back().empty()) return false;
        }
    // Ghosts that the results of a root read: results are at places 0 to `fine`, the root's own points at 0 to `end`.
    const auto fine = static_cast<int>(net_.in_cells() ? factor_ * n - 1 : factor_ * n),
               end = static_cast<int>(net_.in_cells() ? n - 1 : n);
    const bool quads = net_.side_count() == 4;
    int rings = 0;
    for (int y = 0; y <= fine; ++y)
        for (int x = 0; x <= (quads ? fine : fine - y); ++x) {
            const auto f = static_cast<int>(factor_);
            const std::size_t kind = static_cast<std::size_t>(y % f * f + x % f) * count;
            for (std::size_t i = 0; i < count; ++i)
                for (const auto& term : regular_[kind + i]) {
                    const int a = x / f + term.at.a, b = y / f + term.at.b;
                    rings = std::max({rings, -a, -b, quads ? std::max(a, b) - end : a + b - end});
                }
        }
    rings_ = static_cast<std::uint32_t>(rings);
    kernel_ = has_kernel();
    return rings_ <= n;
}

/// Whether the interior rows are those of Catmull-Clark or Loop.
bool RowPatterns::has_kernel() const {
    if (kind_ != Kind::points || factor_ != 2 || net_.in_cells()) return false;
    using Row = RowOf<Step>;
    std::vector<Row> rows;
    if (net_.side_count() == 4) {
        const std::vector<std::pair<std::int16_t, double>> line[2] = {{{-1, 0.125}, {0, 0.75}, {1, 0.125}},
                                                                      {{0, 0.5}, {1, 0.5}}};
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 2; ++x) {
                Row& row = rows.emplace_back();
                for (const auto& [a, along] : line[x])
                    for (const auto& [b, across] : line[y]) row.push_back({{a, b}, along * across});
            }
    } else {
        const double ring = 0.0625, end = 0.375, opposite = 0.125;
        rows = {Row{{{-1, 0}, ring},
                    {{-1, 1}, ring},
                    {{0, -1}, ring},
                    {{0, 0}, 0.625},
                    {{0, 1}, ring},
                    {{1, -1}, ring},
                    {{1, 0}, ring}},
                Row{{{0, 0}, end}, {{0, 1}, opposite}, {{1, -1}, opposite}, {{1, 0}, end}},
                Row{{{-1, 1}, opposite}, {{0, 0}, end}, {{0, 1}, end}, {{1, 0}, opposite}},
                Row{{{0, 0}, opposite}, {{0, 1}, end}, {{1, 0}, end}, {{1, 1}, opposite}}};
    }
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (!same(rows[i], regular_[i])) return false;
    return true;
}

bool RowPatterns::learn(const CornerKinds& corners, std::span<const std::shared_ptr<const CornerRows>> sources) {
    if (!learn_regular(*sources.back())) return false;
    const std::uint32_t each = rows_per_point(), zone = RowPatterns::zone(factor_, sources.back()->corner.segments());
    sources = sources.first(sources.size() - 1);
    // With kernels all roots at a smooth corner have the same rows. The first one computes the vertex there.
    const auto different_roots = [&](const CornerKind& kind) {
        const bool smooth = kind.closed && kind.angle.empty() && std::ranges::none_of(kind.sharp, is_sharp);
        return kernel_ && smooth ? 1 : kind.roots();
    };
    // The depth of sharp sides is measured at the outer places of the zone, where the corner has no influence any more.
    const auto far = [&](std::uint32_t x, std::uint32_t y) { return distance(x, y) + 2 * factor_ > zone; };
    depth_ = reach_ = 0;
    std::deque<TemplateReader> readers;
    for (const auto& source : sources) readers.emplace_back(*this, *source, rings_);
    struct Special {
        std::uint32_t x, y;
    };
    std::vector<std::vector<std::vector<Special>>> special(sources.size());
    for (std::size_t k = 0; k < sources.size(); ++k) {
        const CornerKind& kind = sources[k]->corner.kind();
        special[k].resize(kind.roots());
        for (std::uint32_t i = 0; i < different_roots(kind); ++i) {
            readers[k].look_at(i);
            readers[k].for_each_inwards([&](std::uint32_t x, std::uint32_t y) {
                if (readers[k].is_regular(x, y)) return;
                special[k][i].push_back({x, y});
                if (!far(x, y)) return;
                const std::uint32_t from_first = kind.sharp_before(i) ? y : zone,
                                    from_last = kind.sharp_after(i) ? x : zone;
                depth_ = std::max(depth_, std::min(from_first, from_last) + 1);
            });
        }
    }
    if (2 * depth_ > zone) return false;
    // Corner rows are needed for all special places that no sharp side's pattern describes.
    std::vector<std::vector<SidePattern>> sides(sources.size());
    std::vector<RowOf<Step>> found(each);
    bool any_wedge = false;
    for (std::size_t k = 0; k < sources.size(); ++k) {
        const CornerKind& kind = sources[k]->corner.kind();
        sides[k].resize(kind.roots());
        for (std::uint32_t i = 0; i < different_roots(kind); ++i) {
            readers[k].look_at(i);
            for (const Special& s : special[k][i]) {
                const bool along_first = kind.sharp_before(i) && s.y < depth_,
                           along_last = kind.sharp_after(i) && s.x < depth_;
                if (!along_first && !along_last) reach_ = std::max(reach_, distance(s.x, s.y) + 1);
            }
            for (const bool last : {false, true}) {
                if (!(last ? kind.sharp_after(i) : kind.sharp_before(i))) continue;
                any_wedge = any_wedge || (kind.sharp_before(i) && kind.sharp_after(i));
                SidePattern pattern(std::size_t{depth_} * factor_ * each);
                std::vector<char> known(std::size_t{depth_} * factor_, 0);
                bool fits = true;
                readers[k].for_each_inwards([&](std::uint32_t x, std::uint32_t y) {
                    if ((last ? x : y) >= depth_ || !fits) return;
                    const TemplateReader::OnSide at = readers[k].on_side(last, x, y);
                    const std::size_t place = at.b * factor_ + at.a % factor_;
                    const std::span<RowOf<Step>> rows = std::span(pattern).subspan(place * each, each);
                    if (known[place] == 0) {
                        fits = readers[k].side_rows(at, rows);
                        known[place] = 1;
                        return;
                    }
                    bool equal = readers[k].side_rows(at, found);
                    for (std::size_t r = 0; r < each; ++r) equal = equal && same(rows[r], found[r]);
                    if (!equal) reach_ = std::max(reach_, distance(x, y) + 1);
                });
                if (!fits) return false;
                if (!last) sides[k][i] = std::move(pattern);
            }
        }
    }
    // A place near two sharp sides is near the corner between them, and has corner rows.
    if (any_wedge && depth_ > 0) reach_ = std::max(reach_, net_.side_count() == 4 ? depth_ : 2 * depth_ - 1);
    if (reach_ + 2 * factor_ > zone + 1) return false;

    std::vector<std::vector<std::uint32_t>> side_number(sources.size()), corner_number(sources.size());
    side_patterns_.clear();
    corner_patterns_.clear();
    farthest_ = 0;
    for (std::size_t k = 0; k < sources.size(); ++k) {
        const CornerKind& kind = sources[k]->corner.kind();
        for (std::uint32_t i = 0; i < different_roots(kind); ++i) {
            readers[k].look_at(i);
            side_number[k].push_back(none);
            if (!sides[k][i].empty()) {
                side_number[k].back() = static_cast<std::uint32_t>(side_patterns_.size());
                for (const RowOf<Step>& row : sides[k][i])
                    for (const auto& term : row)
                        rings_ = std::max(rings_, static_cast<std::uint32_t>(std::max<int>(0, -term.at.b)));
                side_patterns_.push_back(std::move(sides[k][i]));
            }
            CornerPattern pattern;
            for (const Special& s : special[k][i]) {
                if (distance(s.x, s.y) >= reach_) continue;
                CornerPlace place{s.x, s.y, std::vector<RowOf<RootLattices::Seen>>(each)};
                if (!readers[k].corner_rows(s.x, s.y, place.rows)) return false;
                for (const RowOf<RootLattices::Seen>& row : place.rows)
                    for (const auto& term : row)
                        farthest_ = std::max(
                            farthest_, static_cast<std::int16_t>(distance(static_cast<std::uint32_t>(term.at.a),
                                                                          static_cast<std::uint32_t>(term.at.b))));
                pattern.push_back(std::move(place));
            }
            corner_number[k].push_back(none);
            if (pattern.empty()) continue;
            corner_number[k].back() = static_cast<std::uint32_t>(corner_patterns_.size());
            corner_patterns_.push_back(std::move(pattern));
        }
        side_number[k].resize(kind.roots(), side_number[k].front());
        corner_number[k].resize(kind.roots(), corner_number[k].front());
    }
    const std::size_t halfedges = corners.kind.size();
    side_pattern_.resize(halfedges);
    corner_pattern_.resize(halfedges);
    for (std::size_t h = 0; h < halfedges; ++h) {
        side_pattern_[h] = side_number[corners.kind[h]][corners.root[h]];
        corner_pattern_[h] = corner_number[corners.kind[h]][corners.root[h]];
    }
    return true;
}

bool RowPatterns::fits(const RootLayout& coarse) const {
    const std::uint32_t n = coarse.segments(), last = net_.last_place(net_.layout(factor_ * n));
    return n >= rings_ && net_.last_place(coarse) >= static_cast<std::uint32_t>(farthest_) &&
           last + 1 >= 2 * std::max(reach_, depth_);
}

}  // namespace tetrakis::detail
