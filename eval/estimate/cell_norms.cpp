#include "cell_norms.hpp"

#include "../../schemes/core/scheme_table.hpp"
#include "../../schemes/parts/sector_fan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

// Number of levels for which a weight is computed directly; below them it is a sum of other weights.
constexpr int k_levels = 3;
// Weights and sums below this are rounding errors.
constexpr double k_no_weight = 1e-11;
// The iteration ends once no weight changes by more than k_settled; it fails if weights exceed k_most_weight.
constexpr double k_settled = 1e-10, k_most_weight = 1e3;
constexpr int k_most_rounds = 400;
// Added to each equation. The iteration approaches the solution from below; this room, a hundred times the last change,
// makes up for the rest.
constexpr double k_room = 1e-8;
// From this level on, hardly any cell is near two extraordinary points, so that many cells share their surroundings.
constexpr int k_irregular_from = 2;

/// Rings of faces on which the norms depend: two for edge rules, up to one more for other rules, such as Kobbelt's
/// virtual points. A step of averaging takes half a ring.
int rings_of(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.has_chosen_steps()) return options.averaging_steps / 2 + 1;
    return std::max(2, rule_rings(scheme, options) + (scheme.choice_rings > 0 ? 1 : 0));
}

/// Functions that the rules may reproduce, the best first. Expected points extend a cell's corners by this function.
enum class Extension { bilinear, affine, constant };

CellAnchor anchor_at(const Vec2d& p, Extension extension, int corners) {
    if (extension == Extension::constant) return {1, 0, 0, 0};
    if (corners == 4 && extension == Extension::affine) return {1 - p.x - p.y, p.x, 0, p.y};
    return corner_weights(p, corners);
}

/// A cell some levels below the first one, with its points as combinations of the first one's points.
struct CellBelow {
    const CellNorms& norms;
    StencilTable rows;
    std::array<Vec2d, 4> corner;  ///< in the first cell, whose sides have length 1
};

template <class Take>
void for_each_below(const CellBelow& cell, int levels, int corners, const Take& take) {
    if (levels == 0) return take(cell);
    for (int c = 0; c < 4; ++c) {
        const CellNorms::Child& child = cell.norms.children[c];
        CellBelow below{*child.norms, cell.rows.then(child.rows), {}};
        const auto& at = cell.corner;
        for (int k = 0; k < corners; ++k)
            below.corner[k] = 0.5 * (c < corners ? at[k] + at[c] : at[(k + 1) % corners] + at[(k + 2) % corners]);
        for_each_below(below, levels - 1, corners, take);
    }
}

/// The vector from a point's expected position to the point, as a combination of points.
StencilRow offset(const StencilTable& rows, int point, const CellAnchor& anchor) {
    StencilRow row = rows.row(point);
    for (int k = 0; k < 4; ++k)
        if (anchor[k] != 0) rows.add_row(k, -anchor[k], row);
    row.gather();
    return row;
}

/// Whether a combination of points is 0 if all points are at their expected positions.
bool annihilates(const StencilRow& row, std::span<const CellAnchor> anchor) {
    CellAnchor sum{};
    double size = 1;
    for (const auto& [i, weight] : row.terms) {
        size += std::abs(weight);
        for (int k = 0; k < 4; ++k) sum[k] += weight * anchor[i][k];
    }
    return std::ranges::all_of(sum, [&](double s) { return std::abs(s) < k_no_weight * size; });
}

}  // namespace

/// Depth-first search over kinds of surroundings. Strongly connected components (Tarjan 1972) are solved together,
/// after all components that they depend on. So the weights of a kind do not depend on earlier requests.
class CellNormTable::Search {
  public:
    explicit Search(const CellNormTable& table) : table_(table), corners_(table.corners_) {}

    /// Returns the least number of an unfinished kind that this one depends on, itself included (Tarjan's low-link).
    int visit(const SurroundingsKey& key) {
        const auto of = kinds_.try_emplace(key).first;  // iterators of a map stay valid
        Kind& kind = of->second;
        const int number = kind.number = static_cast<int>(kinds_.size());
        stack_.push_back(of);
        kind.step = cell_step(table_.scheme_, table_.options_, key, corners_, table_.rings_);
        int lowest = number;
        if (kind.step)
            for (const CellSurroundings& child : kind.step->children) {
                if (table_.known_.contains(child.key)) continue;
                const auto met = kinds_.find(child.key);
                lowest = std::min(lowest, met == kinds_.end() ? visit(child.key) : met->second.number);
            }
        if (lowest == number) {
            const auto first = std::ranges::find(stack_, of);
            finish({first, stack_.end()});
            stack_.erase(first, stack_.end());
        }
        return lowest;
    }

  private:
    /// A small cell, with the absolute weights of its points' offsets from their expected positions.
    struct Offsets {
        const CellNorms* norms;
        StencilTable sizes;
    };
    struct Kind {
        int number = 0;
        std::optional<CellStep> step;
        std::unique_ptr<CellNorms> norms = std::make_unique<CellNorms>();
        std::vector<int> place;  ///< by point around the cell: its number in norms->point, or -1
        Extension extension = Extension::bilinear;
        std::vector<double> direct;  ///< by point: largest |basis function less the corner's hat function|
        std::vector<Offsets> below;
    };
    using Kinds = std::map<SurroundingsKey, Kind>;

    void finish(std::vector<Kinds::iterator> component) {
        std::ranges::sort(component, {}, [](Kinds::iterator of) -> const SurroundingsKey& { return of->first; });
        std::vector<Kind*> kinds;
        for (const Kinds::iterator of : component) kinds.push_back(&of->second);
        const bool solved = link(kinds) && find_extensions(kinds) && find_weights(kinds);
        for (const Kinds::iterator of : component) {
            table_.known_.emplace(of->first, solved ? std::move(of->second.norms) : nullptr);
            of->second.below = {};  // frees most of the search's memory
        }
    }

    /// Links kinds to their children, and finds the points used: the corners, and all points in the rows of the
    /// children's used points. Returns false if a child has no norms; then these kinds have none.
    bool link(std::span<Kind* const> kinds) const {
        for (Kind* const kind : kinds) {
            if (!kind->step) return false;
            for (std::size_t c = 0; c < 4; ++c) {
                const SurroundingsKey& key = kind->step->children[c].key;
                const auto known = table_.known_.find(key);
                const CellNorms* const child =
                    known != table_.known_.end() ? known->second.get() : kinds_.at(key).norms.get();
                if (child == nullptr) return false;
                kind->norms->children[c].norms = child;
            }
            kind->place.assign(kind->step->at.size(), -1);
            for (int k = 0; k < corners_; ++k) add_point(*kind, k);
        }
        for (bool again = true; again;) {
            again = false;
            for (Kind* const kind : kinds)
                for (std::size_t c = 0; c < 4; ++c) {
                    const std::vector<int>& points = kind->norms->children[c].norms->point;
                    for (std::size_t j = 0; j < points.size(); ++j)  // may grow: `points` may be the kind's own
                        for (const int i : kind->step->rows.points(kind->step->children[c].vertices[points[j]]))
                            again = add_point(*kind, i) || again;
                }
        }
        for (Kind* const kind : kinds)
            for (std::size_t c = 0; c < 4; ++c) {
                CellNorms::Child& child = kind->norms->children[c];
                for (const int j : child.norms->point) {
                    StencilRow row = kind->step->rows.row(kind->step->children[c].vertices[j]);
                    for (auto& [point, weight] : row.terms) point = kind->place[point];
                    child.rows.push(std::move(row));
                }
            }
        return true;
    }
    static bool add_point(Kind& kind, int i) {
        if (kind.place[i] >= 0) return false;
        kind.place[i] = static_cast<int>(kind.norms->point.size());
        kind.norms->point.push_back(i);
        return true;
    }

    /// Finds the best extension that the rules reproduce, for each kind. Returns false if there is none.
    bool find_extensions(std::span<Kind* const> kinds) const {
        for (Kind* const kind : kinds) {
            std::vector<Vec2d> at;
            for (const int i : kind->norms->point) at.push_back(kind->step->at[i]);
            const auto before = [](const Vec2d& p, const Vec2d& q) { return p.x != q.x ? p.x < q.x : p.y < q.y; };
            std::ranges::sort(at, before);
            // Around many edges the unrolled lattice overlaps itself, and its positions mean nothing.
            if (std::ranges::adjacent_find(at) != at.end()) kind->extension = Extension::constant;
            set_anchors(*kind);
        }
        for (bool again = true; again;) {
            again = false;
            for (Kind* const kind : kinds)
                while (!reproduces(*kind)) {
                    if (kind->extension == Extension::constant) return false;
                    kind->extension = kind->extension == Extension::bilinear ? Extension::affine : Extension::constant;
                    set_anchors(*kind);
                    again = true;
                }
        }
        return true;
    }
    void set_anchors(Kind& kind) const {
        kind.norms->anchor.clear();
        for (const int i : kind.norms->point)
            kind.norms->anchor.push_back(anchor_at(kind.step->at[i], kind.extension, corners_));
    }
    /// Whether points at their expected positions give points at their expected positions around the children.
    bool reproduces(const Kind& kind) const {
        bool all = true;
        for_each_below(whole(kind), 1, corners_, [&](const CellBelow& cell) {
            for (int k = 0; k < corners_ && all; ++k) all = annihilates(without_hat(cell, k), kind.norms->anchor);
            for (int j = 0; j < cell.rows.row_count() && all; ++j)
                all = annihilates(offset(cell.rows, j, cell.norms.anchor[j]), kind.norms->anchor);
        });
        return all;
    }
    CellBelow whole(const Kind& kind) const {
        CellBelow cell{*kind.norms, {}, {}};
        for (int i = 0; i < static_cast<int>(kind.norms->point.size()); ++i) cell.rows.push({{i, 1}});
        for (int k = 0; k < corners_; ++k) cell.corner[k] = cell_corner(k, corners_);
        return cell;
    }
    /// The vector from the large cell's point under a small cell's corner to this corner, as a combination of points.
    StencilRow without_hat(const CellBelow& cell, int corner) const {
        StencilRow row = cell.rows.row(corner);
        const CellAnchor hats = corner_weights(cell.corner[corner], corners_);
        for (int k = 0; k < corners_; ++k) row.add(k, -hats[k]);
        row.gather();
        return row;
    }

    bool find_weights(std::span<Kind* const> kinds) const {
        for (Kind* const kind : kinds) {
            kind->direct.assign(kind->norms->point.size(), 0.0);
            kind->norms->weight = kind->direct;
        }
        for (Kind* const kind : kinds)
            for_each_below(whole(*kind), k_levels, corners_, [&](const CellBelow& cell) {
                for (int k = 0; k < corners_; ++k)
                    for (const auto& [i, weight] : without_hat(cell, k).terms)
                        kind->direct[i] = std::max(kind->direct[i], std::abs(weight));
                Offsets& offsets = kind->below.emplace_back(&cell.norms);
                for (int j = 0; j < cell.rows.row_count(); ++j) {
                    StencilRow row = offset(cell.rows, j, cell.norms.anchor[j]);
                    for (auto& [i, weight] : row.terms) weight = std::abs(weight);
                    offsets.sizes.push(std::move(row));
                }
            });
        double change = std::numeric_limits<double>::infinity();
        for (int round = 0; round < k_most_rounds && change > k_settled; ++round) {
            change = 0;
            for (Kind* const kind : kinds) {
                std::vector<double> now = least(*kind);
                for (std::size_t i = 0; i < now.size(); ++i) {
                    if (now[i] > 0) now[i] += k_room;
                    change = std::max(change, now[i] - kind->norms->weight[i]);
                    if (now[i] > k_most_weight) return false;
                }
                kind->norms->weight = std::move(now);
            }
        }
        // The equations are monotone in the weights: if all hold as inequalities, no weight is below the solution.
        return change <= k_settled && std::ranges::all_of(kinds, [&](const Kind* kind) {
                   return std::ranges::equal(least(*kind), kind->norms->weight, std::less_equal<>());
               });
    }
    /// Least values for the weights of a kind, from the present weights of the cells below it.
    static std::vector<double> least(const Kind& kind) {
        const std::vector<CellAnchor>& anchor = kind.norms->anchor;
        std::vector<double> result(anchor.size(), 0.0), sum(anchor.size());
        for (const Offsets& cell : kind.below) {
            std::ranges::fill(sum, 0.0);
            for (int j = 0; j < cell.sizes.row_count(); ++j)
                for (std::size_t t = 0; t < cell.sizes.points(j).size(); ++t)
                    sum[cell.sizes.points(j)[t]] += cell.sizes.weights(j)[t] * cell.norms->weight[j];
            for (std::size_t i = 0; i < sum.size(); ++i) result[i] = std::max(result[i], sum[i]);
        }
        // A corner is at its own expected position, so its weight does not count.
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = i < 4 && anchor[i][i] == 1 ? 0 : result[i] + kind.direct[i];
        return result;
    }

    const CellNormTable& table_;
    int corners_;
    Kinds kinds_;
    std::vector<Kinds::iterator> stack_;
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
    const std::lock_guard lock(mutex_);
    if (!known_.contains(key)) Search(*this).visit(key);
    return known_.at(key).get();
}

std::optional<CellNormTable::Total> CellNormTable::total(const FanShape& shape) const {
    // The fan is larger than the rings around the cell, so that its border does not count.
    const SectorFan fan(corners_ == 3 ? FanLattice::triangles : FanLattice::quads, shape, rings_ + 2);
    MeshPartFinder parts;
    const CellNorms* const found = find(cell_surroundings(fan.mesh, fan.start[0], rings_, parts)->key);
    if (found == nullptr) return std::nullopt;
    Total total{0, false};
    for (const double w : found->weight) total.sum += w;
    for (const CellAnchor& a : found->anchor) total.linear = total.linear || a[0] != 1;
    return total;
}

NormedCell CellNormTable::of_cell(const RuleMesh& mesh, int halfedge, int level, MeshPartFinder& parts) const {
    const int face = mesh.face(halfedge);
    const std::span<const int> corners = mesh.corners(face);
    const NormedCell none{nullptr, mesh.face_begin(face), {corners.begin(), corners.end()}};
    if (level < 0) return none;
    if (level < k_irregular_from) {
        parts.look(mesh, corners, rings_ - 1);
        const int edges = corners_ == 3 ? 6 : 4;
        const auto is_regular = [&](int v) {
            return mesh.rule(v) == VertexRule::smooth && mesh.ring(v).edges() == edges;
        };
        if (!std::ranges::all_of(parts.vertices(), is_regular)) return none;
    }
    // Beside corners with certain angles there are norms only if the corner itself is the first corner.
    for (int k = 0; k < corners_; ++k, halfedge = mesh.next(halfedge)) {
        const std::optional<CellSurroundings> around = cell_surroundings(mesh, halfedge, rings_, parts);
        if (!around) break;
        const CellNorms* const found = find(around->key);
        if (found == nullptr) continue;
        NormedCell cell{found, halfedge};
        for (const int i : found->point) cell.points.push_back(around->vertices[i]);
        return cell;
    }
    return none;
}

}  // namespace tetrakis::detail
