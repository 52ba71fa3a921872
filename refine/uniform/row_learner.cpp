#include "row_learner.hpp"

#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Segments of the templates' roots, one after the other: as long as masks are too wide for them.
std::span<const std::uint32_t> template_segments(const SchemeInfo& scheme, const RuleOptions& rules) {
    static constexpr std::uint32_t k_segments[] = {4, 6, 9, 14, 20};
    return std::span(k_segments).subspan(rule_rings(scheme, rules) == 1 ? 0 : 1);
}

/// All that a corner's rows depend on.
auto key_of(const SchemeInfo& scheme, const RuleOptions& rules, const RootLattices& net, const CornerKind& kind,
            std::uint32_t segments, bool limits) {
    const auto& [beside, loop, hoppe, beta, gamma, reflect, w, tuning, steps, boundary, angle, measured, chaikin,
                 runner] = rules;
    return std::tuple(&scheme, net.side_count(), net.in_cells(), kind, segments, limits, beside, loop, hoppe, beta,
                      gamma, reflect, w, tuning, steps, boundary, angle, measured, chaikin, runner);
}

/// What the rules have said, of the schemes of the table. Any thread may ask.
class KnownCorners {
  public:
    using Key = std::invoke_result_t<decltype(key_of), const SchemeInfo&, const RuleOptions&, const RootLattices&,
                                     const CornerKind&, std::uint32_t, bool>;
    using Rows = std::shared_ptr<const CornerRows>;

    /// Null: not known.
    Rows find(const Key& key) {
        const std::lock_guard lock(mutex_);
        const auto at = rows_.find(key);
        return at == rows_.end() ? nullptr : at->second;
    }
    void add(const Key& key, const Rows& rows) {
        constexpr std::size_t k_most = std::size_t{1} << 20;  // some 100 MB
        const std::size_t terms = rows->rows.positions.begins().back() + 2 * rows->rows.tangent1.begins().back();
        const std::lock_guard lock(mutex_);
        if (terms_ + terms > k_most) {
            rows_.clear();
            terms_ = 0;
        }
        if (rows_.try_emplace(key, rows).second) terms_ += terms;
    }

  private:
    std::mutex mutex_;
    std::map<Key, Rows> rows_;
    std::size_t terms_ = 0;
};

}  // namespace

RowLearner::RowLearner(const RootLattices& net, const CornerKinds& corners, const SchemeInfo& scheme,
                       const RuleOptions& rules, std::uint64_t max_memory_bytes)
    : net_(net),
      corners_(corners),
      scheme_(scheme),
      rules_(rules),
      max_memory_bytes_(max_memory_bytes),
      factor_(scheme.refinement == Refinement::sqrt3 ? 3 : 2) {
    rules_.runner = nullptr;
    // No template is all there is of a surface: its end is none of the mesh's.
    rules_.averaging_boundary = AveragingBoundary::replicate;
}

bool RowLearner::too_large(std::uint32_t segments, std::uint32_t factor) const {
    // A finer level's rows, mesh and places (measured: Catmull-Clark's 50 kB for templates of 5 roots, 12 segments).
    constexpr double k_bytes_per_cell = 100;
    double roots = 0;
    for (const CornerKind& kind : corners_.kinds) roots += kind.roots();
    const double side = static_cast<double>(factor) * segments;
    return max_memory_bytes_ != 0 && roots * side * side * k_bytes_per_cell > static_cast<double>(max_memory_bytes_);
}

double RowLearner::cost(const CornerKinds& corners, const RootLattices& net, const SchemeInfo& scheme,
                        const RuleOptions& rules, int factor) {
    // Their points are made by the rules, and read (measured: modified-butterfly, doo-sabin, kobbelt on suzanne).
    constexpr double k_per_point = 3;
    double roots = 0;
    for (const CornerKind& kind : corners.kinds) roots += kind.roots();
    const double side = factor * static_cast<double>(template_segments(scheme, rules)[0]);
    return k_per_point * roots * side * side / (net.side_count() == 4 ? 1 : 2);
}

std::shared_ptr<const CornerRows> RowLearner::step_rows(const CornerKind& kind, std::uint32_t segments) const {
    CornerTemplate corner(kind, net_.side_count(), net_.in_cells(), segments);
    std::optional<CornerTemplate::Step> step = corner.step(scheme_, rules_, factor_);
    if (!step) return nullptr;
    RuleLimits rows;
    rows.positions = std::move(step->rows);
    return std::make_shared<CornerRows>(std::move(corner), std::move(step->row), std::move(rows));
}

std::shared_ptr<const CornerRows> RowLearner::limit_rows(const CornerKind& kind, std::uint32_t segments) {
    CornerTemplate corner(kind, net_.side_count(), net_.in_cells(), segments);
    const RootLattices& net = corner.net();
    const RootLayout at = net.layout(segments);
    std::vector<int> vertices, row(net.place_count(at), -1);
    const std::uint32_t zone = RowPatterns::zone(1, segments);
    for (std::uint32_t f = 0; f < net.base().face_count; ++f)
        for (std::uint32_t y = 0; y <= zone; ++y)
            for (std::uint32_t x = 0; x <= (net.side_count() == 4 ? zone : zone - y); ++x) {
                const std::uint32_t place = net.number_at(at, f, RootLattices::Place{x, y});
                if (row[place] >= 0) continue;
                row[place] = static_cast<int>(vertices.size());
                vertices.push_back(static_cast<int>(corner.first_place(place)));
            }
    if (!search_) search_.emplace(scheme_, rules_);
    RuleLimits limits = rule_limits(*search_, corner.mesh(), vertices);
    return std::make_shared<CornerRows>(std::move(corner), std::move(row), std::move(limits));
}

RowLearner::Sources RowLearner::rows(std::uint32_t segments, bool limits) {
    static KnownCorners known;
    const bool keeps = find_scheme(scheme_.name) == &scheme_;  // others may be gone, and their addresses used again
    CornerKind regular;
    regular.sharp.assign(net_.side_count() == 4 ? 4 : 6, 0.0f);
    const std::vector<CornerKind>& kinds = corners_.kinds;
    Sources all(kinds.size() + 1);
    const auto take = [&](std::uint32_t i) {
        const CornerKind& kind = i < kinds.size() ? kinds[i] : regular;
        const KnownCorners::Key key = key_of(scheme_, rules_, net_, kind, segments, limits);
        if (keeps) all[i] = known.find(key);
        if (all[i]) return;
        all[i] = limits ? limit_rows(kind, segments) : step_rows(kind, segments);
        if (keeps && all[i]) known.add(key, all[i]);
    };
    if (limits)
        for (std::uint32_t i = 0; i < all.size(); ++i) take(i);
    else
        for_each_index(static_cast<std::uint32_t>(all.size()), take, 1);
    return all;
}

/// @param learn  (rows of the kinds): false where the templates are too small
template <class Learn>
bool RowLearner::learn_from_templates(bool limits, const Learn& learn) {
    for (const std::uint32_t n : template_segments(scheme_, rules_)) {
        if (too_large(n, limits ? 1 : factor_)) return false;
        const Sources sources = rows(n, limits);
        if (std::find(sources.begin(), sources.end(), nullptr) != sources.end()) return false;
        if (learn(sources)) return true;
    }
    return false;
}

bool RowLearner::learn_step(RowPatterns& patterns) {
    return learn_from_templates(false, [&](const Sources& all) { return patterns.learn(corners_, all); });
}

bool RowLearner::learn_limits(RowPatterns* points, RowPatterns* normals) {
    return learn_from_templates(true, [&](const Sources& all) {
        return (points == nullptr || points->learn(corners_, all)) &&
               (normals == nullptr || normals->learn(corners_, all));
    });
}

}  // namespace tetrakis::detail
