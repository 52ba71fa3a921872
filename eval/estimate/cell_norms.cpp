#include "cell_norms.hpp"

#include "../../schemes/core/scheme_table.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

namespace tetrakis::detail {

namespace {

// The iteration: it ends where nothing changes by more than this, and has failed where weights grow or creep.
constexpr double k_settled = 1e-10, k_most_weight = 1e3;
constexpr int k_most_rounds = 400;
// Added to each equation, so that the solution has room for what the iteration, which approaches it from below, leaves:
// a hundred times its last change.
constexpr double k_room = 1e-8;

/// Rules of edges look two rings around a cell; those of others, as Kobbelt's virtual points, up to one more; a step of
/// averaging is by half a ring.
int rings_of(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.has_chosen_steps()) return options.averaging_steps / 2 + 1;
    return std::max(2, rule_rings(scheme, options) + (scheme.choice_rings > 0 ? 1 : 0));
}

/// The equations between the weights of some kinds of surroundings, and others that are known.
class NormEquations {
  public:
    using Known = std::map<SurroundingsKey, std::unique_ptr<const CellNorms>>;

    /// @param known  has the weights of all kinds that the equations ask for and do not determine
    NormEquations(std::map<SurroundingsKey, std::optional<CellEquations>> kinds, const Known& known);

    /// The weights, or nullptr, of each kind.
    Known solve();

  private:
    struct Child {
        /// Per point of the child that has a weight: how far it is from where the child's corners would have it, as a
        /// combination of the same of the parent's active points, by their numbers among these; sizes of weights.
        std::vector<SparseRow> offsets;
        const std::vector<double>* weight = nullptr;  ///< of the child's points
    };
    struct Kind {
        CellEquations equations;
        std::vector<double> weight;   ///< of the active points
        std::vector<double> below;    ///< the largest sums of their weights in children whose weights are known
        std::vector<Child> children;  ///< the others
        bool none = false;            ///< there are no weights
    };
    /// The points of a child that matter.
    struct Points {
        std::vector<int> point;
        std::vector<CellAnchor> anchor;
        const std::vector<double>* weight = nullptr;
    };

    std::optional<Points> points_of(const SurroundingsKey& key) const;
    template <class Visit>
    bool for_each_offset(const Kind& kind, const CellDescent::Child& child, const Points& points, Visit&& visit) const;
    bool activate(Kind& kind);
    void find_offsets(Kind& kind);
    static SparseRow sizes(const CellEquations& equations, const SparseRow& row, const std::vector<int>& place);
    static void add(const SparseRow& sizes, double factor, std::span<double> sum);
    std::vector<double> right_side(const Kind& kind) const;
    double improve(Kind& kind) const;
    bool holds(const Kind& kind) const;
    void spread_none();
    Known norms() const;

    std::map<SurroundingsKey, Kind> kinds_;
    const Known& known_;
};

NormEquations::NormEquations(std::map<SurroundingsKey, std::optional<CellEquations>> kinds, const Known& known)
    : known_(known) {
    for (auto& [key, equations] : kinds) {
        Kind& kind = kinds_[key];
        kind.none = !equations;
        if (equations) kind.equations = std::move(*equations);
    }
}

std::optional<NormEquations::Points> NormEquations::points_of(const SurroundingsKey& key) const {
    if (const auto at = kinds_.find(key); at != kinds_.end()) {
        const Kind& kind = at->second;
        if (kind.none) return std::nullopt;
        Points points{kind.equations.active, {}, &kind.weight};
        for (const int i : points.point) points.anchor.push_back(kind.equations.anchor[i]);
        return points;
    }
    const CellNorms* const norms = known_.at(key).get();
    if (norms == nullptr) return std::nullopt;
    return Points{norms->point, norms->anchor, &norms->weight};
}

/// Visits how far the child's points are from where its corners would have them, as combinations of the parent's
/// points. False where that is not 0 when those are where the parent's corners would have them.
template <class Visit>
bool NormEquations::for_each_offset(const Kind& kind, const CellDescent::Child& child, const Points& points,
                                    Visit&& visit) const {
    const CellEquations& equations = kind.equations;
    SparseSum sum(equations.points);
    for (std::size_t j = 0; j < points.point.size(); ++j) {
        sum.add(equations.below.rows[child.vertices[points.point[j]]], 1);
        for (int k = 0; k < 4; ++k)
            if (const double a = points.anchor[j][k]; a != 0) sum.add(equations.below.rows[child.vertices[k]], -a);
        const SparseRow offset = sum.take();
        if (!equations.annihilates(offset)) return false;
        visit(offset);
    }
    return true;
}

/// A point that matters to a small cell does to the large one. Returns whether anything was not known before.
bool NormEquations::activate(Kind& kind) {
    CellEquations& equations = kind.equations;
    const std::size_t before = equations.active.size();
    std::vector<char> active(equations.points, 0);
    for (const int i : equations.active) active[i] = 1;
    const auto activate_point = [&](int i) {
        if (!std::exchange(active[i], 1)) equations.active.push_back(i);
    };
    for (const CellDescent::Child& child : equations.next.children) {
        const std::optional<Points> points = points_of(child.key);
        kind.none = kind.none || !points;
        if (kind.none) return true;
        for (const int j : points->point)
            for (const auto& [i, weight] : equations.next.rows[child.vertices[j]]) activate_point(i);
    }
    for (const CellDescent::Child& child : equations.below.children) {
        const std::optional<Points> points = points_of(child.key);
        kind.none = kind.none || !points;
        if (kind.none) return true;
        const bool known = for_each_offset(kind, child, *points, [&](const SparseRow& offset) {
            for (const auto& [i, weight] : offset)
                if (std::abs(weight) > k_no_weight) activate_point(i);
        });
        if (known) continue;
        // Inside the cell the rules reproduce more than around it.
        kind.none = equations.anchor == equations.constant();
        equations.anchor = equations.constant();
        return true;
    }
    return equations.active.size() > before;
}

SparseRow NormEquations::sizes(const CellEquations& equations, const SparseRow& row, const std::vector<int>& place) {
    SparseRow result;
    for (const auto& [i, weight] : row)
        if (place[i] >= 0 && equations.is_free(i) && std::abs(weight) > k_no_weight)
            result.emplace_back(place[i], std::abs(weight));
    return result;
}

void NormEquations::add(const SparseRow& sizes, double factor, std::span<double> sum) {
    for (const auto& [a, size] : sizes) sum[a] += factor * size;
}

void NormEquations::find_offsets(Kind& kind) {
    const CellEquations& equations = kind.equations;
    std::vector<int> place(equations.points, -1);
    for (std::size_t a = 0; a < equations.active.size(); ++a) {
        place[equations.active[a]] = static_cast<int>(a);
        kind.weight.push_back(equations.direct[equations.active[a]]);
    }
    kind.below.assign(equations.active.size(), 0.0);
    for (const CellDescent::Child& child : equations.below.children) {
        const Points points = *points_of(child.key);
        if (!kinds_.contains(child.key)) {
            std::vector<double> sum(equations.active.size(), 0.0);
            auto weight = points.weight->begin();
            for_each_offset(kind, child, points,
                            [&](const SparseRow& offset) { add(sizes(equations, offset, place), *weight++, sum); });
            for (std::size_t a = 0; a < sum.size(); ++a) kind.below[a] = std::max(kind.below[a], sum[a]);
            continue;
        }
        Child& terms = kind.children.emplace_back();
        terms.weight = points.weight;
        for_each_offset(kind, child, points,
                        [&](const SparseRow& offset) { terms.offsets.push_back(sizes(equations, offset, place)); });
    }
}

/// What the weights of a kind have to reach at least, by those that its children have now.
std::vector<double> NormEquations::right_side(const Kind& kind) const {
    std::vector<double> result = kind.below, sum(kind.weight.size());
    for (const Child& child : kind.children) {
        std::fill(sum.begin(), sum.end(), 0.0);
        for (std::size_t j = 0; j < child.offsets.size(); ++j) add(child.offsets[j], (*child.weight)[j], sum);
        for (std::size_t a = 0; a < sum.size(); ++a) result[a] = std::max(result[a], sum[a]);
    }
    for (std::size_t a = 0; a < result.size(); ++a) result[a] += kind.equations.direct[kind.equations.active[a]];
    return result;
}

/// Returns the largest change.
double NormEquations::improve(Kind& kind) const {
    std::vector<double> now = right_side(kind);
    double change = 0;
    for (std::size_t a = 0; a < now.size(); ++a) {
        now[a] += k_room;
        change = std::max(change, now[a] - kind.weight[a]);
        kind.none = kind.none || now[a] > k_most_weight;
    }
    kind.weight = std::move(now);
    return change;
}

/// Whether the weights reach what they have to. The equations grow with the weights, so where all kinds' do, none is
/// below the solution.
bool NormEquations::holds(const Kind& kind) const {
    const std::vector<double> least = right_side(kind);
    return std::equal(least.begin(), least.end(), kind.weight.begin(), std::less_equal<>());
}

/// What is made of something without weights has none.
void NormEquations::spread_none() {
    for (bool again = true; again;) {
        again = false;
        for (auto& [key, kind] : kinds_)
            if (!kind.none)
                for (const CellDescent* down : {&kind.equations.below, &kind.equations.next})
                    for (const CellDescent::Child& child : down->children)
                        if (const auto at = kinds_.find(child.key); at != kinds_.end() && at->second.none)
                            kind.none = again = true;
    }
}

NormEquations::Known NormEquations::solve() {
    for (bool again = true; again;) {
        again = false;
        for (auto& [key, kind] : kinds_)
            if (!kind.none && activate(kind)) again = true;
    }
    for (auto& [key, kind] : kinds_)
        if (!kind.none) find_offsets(kind);
    double change = std::numeric_limits<double>::infinity();
    for (int round = 0; round < k_most_rounds && change > k_settled; ++round) {
        change = 0;
        for (auto& [key, kind] : kinds_)
            if (!kind.none) change = std::max(change, improve(kind));
    }
    const auto failed = [&](const auto& entry) { return !entry.second.none && !holds(entry.second); };
    if (change > k_settled || std::any_of(kinds_.begin(), kinds_.end(), failed))
        for (auto& [key, kind] : kinds_) kind.none = true;
    spread_none();
    return norms();
}

NormEquations::Known NormEquations::norms() const {
    std::map<SurroundingsKey, std::unique_ptr<CellNorms>> made;
    for (const auto& [key, kind] : kinds_) {
        std::unique_ptr<CellNorms>& norms = made[key];
        if (kind.none) continue;
        norms = std::make_unique<CellNorms>();
        norms->point = kind.equations.active;
        norms->weight = kind.weight;
        for (std::size_t a = 0; a < kind.weight.size(); ++a) {
            const int i = norms->point[a];
            if (!kind.equations.is_free(i)) norms->weight[a] = 0;
            norms->anchor.push_back(kind.equations.anchor[i]);
        }
    }
    for (const auto& [key, kind] : kinds_) {
        if (kind.none) continue;
        CellNorms& norms = *made.at(key);
        std::vector<int> place(kind.equations.points, -1);
        for (std::size_t a = 0; a < norms.point.size(); ++a) place[norms.point[a]] = static_cast<int>(a);
        for (std::size_t k = 0; k < norms.children.size(); ++k) {
            const CellDescent::Child& from = kind.equations.next.children[k];
            CellNorms::Child& child = norms.children[k];
            const auto own = made.find(from.key);
            child.norms = own != made.end() ? own->second.get() : known_.at(from.key).get();
            for (const int j : child.norms->point) {
                StencilRow row;
                for (const auto& [i, weight] : kind.equations.next.rows[from.vertices[j]]) row.add(place[i], weight);
                child.rows.push(std::move(row));
            }
        }
    }
    Known result;
    for (auto& [key, norms] : made) result.emplace(key, std::move(norms));
    return result;
}

// The level where hardly any cell is near more than one extraordinary point, so that many have the same surroundings.
constexpr int k_irregular_from = 2;

}  // namespace

/// Kinds of surroundings depth first (Tarjan 1972): those that are made of one another are solved together, after all
/// others that they are made of. So the weights of a kind do not depend on what was asked for before.
class CellNormTable::Search {
  public:
    explicit Search(const CellNormTable& table) : table_(table) {}

    /// Returns the number of the first kind that this one, or what it is made of, leads back to.
    int visit(const SurroundingsKey& key) {
        const auto of = kinds_.try_emplace(key).first;  // stays where it is
        Kind& kind = of->second;
        const int number = kind.number = static_cast<int>(kinds_.size());
        stack_.push_back(key);
        kind.equations = cell_equations(table_.scheme_, table_.options_, key, table_.corners_, table_.rings_);
        int lowest = number;
        if (kind.equations)
            for (const CellDescent* down : {&kind.equations->below, &kind.equations->next})
                for (const CellDescent::Child& child : down->children) {
                    if (table_.known_.contains(child.key)) continue;
                    const auto met = kinds_.find(child.key);
                    lowest = std::min(lowest, met == kinds_.end() ? visit(child.key) : met->second.number);
                }
        if (lowest == number) solve(key);
        return lowest;
    }

  private:
    struct Kind {
        int number = 0;
        std::optional<CellEquations> equations;
    };

    void solve(const SurroundingsKey& first) {
        std::map<SurroundingsKey, std::optional<CellEquations>> equations;
        for (bool last = false; !last;) {
            last = stack_.back() == first;
            equations.emplace(stack_.back(), std::move(kinds_.at(stack_.back()).equations));
            stack_.pop_back();
        }
        NormEquations::Known solved = NormEquations(std::move(equations), table_.known_).solve();
        const std::unique_lock lock(table_.reading_);
        table_.known_.merge(std::move(solved));
    }

    const CellNormTable& table_;
    std::map<SurroundingsKey, Kind> kinds_;
    std::vector<SurroundingsKey> stack_;
};

double CellNorms::remainder(std::span<const Vec3d> points) const {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const CellAnchor& a = anchor[i];
        Vec3d expected = a[0] * points[0] + a[1] * points[1] + a[2] * points[2];
        if (a[3] != 0) expected += a[3] * points[3];
        sum += weight[i] * glm::length(points[i] - expected);
    }
    return sum;
}

CellNormTable::CellNormTable(const SchemeInfo& scheme, const RuleOptions& options)
    : scheme_(scheme),
      options_(options),
      corners_(scheme.family == MeshFamily::triangles ? 3 : 4),
      rings_(rings_of(scheme, options)) {}

const CellNorms* CellNormTable::find(const SurroundingsKey& key) const {
    {
        const std::shared_lock lock(reading_);
        if (const auto at = known_.find(key); at != known_.end()) return at->second.get();
    }
    const std::lock_guard writer(writing_);
    if (!known_.contains(key)) Search(*this).visit(key);
    return known_.at(key).get();
}

std::optional<CellNormTable::Total> CellNormTable::total(const FanShape& shape) const {
    const FanLattice lattice = corners_ == 3 ? FanLattice::triangles : FanLattice::quads;
    const CellNorms* const found = find(fan_surroundings(lattice, shape, rings_));
    if (found == nullptr) return std::nullopt;
    Total total{0, false};
    for (const double w : found->weight) total.sum += w;
    for (const CellAnchor& a : found->anchor) total.linear = total.linear || a[0] != 1;
    return total;
}

NormedCell CellNormTable::of_cell(const RuleMesh& mesh, int halfedge, int level, MeshPartFinder& parts) const {
    const std::span<const int> corners = mesh.corners(mesh.face(halfedge));
    parts.look(mesh, corners, rings_ - 1);
    const auto irregular =
        std::ranges::count_if(parts.vertices(), [&](int v) { return !is_regular_vertex(mesh, v, corners_); });
    if (level < 0 || irregular > (level < k_irregular_from ? 0 : 1)) return {};
    // Beside corners of some angles there are weights only as seen from the corner itself.
    for (int k = 0; k < corners_; ++k, halfedge = mesh.next(halfedge)) {
        const std::optional<CellSurroundings> around = cell_surroundings(mesh, halfedge, rings_, parts);
        if (!around) break;
        const CellNorms* const found = find(around->key);
        if (found == nullptr) continue;
        NormedCell cell{found, halfedge};
        for (const int i : found->point) cell.points.push_back(around->vertices[i]);
        return cell;
    }
    return {};
}

}  // namespace tetrakis::detail
