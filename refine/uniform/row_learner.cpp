#include "row_learner.hpp"

#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// Segments of a template root's side, in the order of attempts: a larger template if the masks are too wide. The first
/// is enough for the scheme's own rules (measured: all schemes, with boundaries, creases and darts).
std::span<const std::uint32_t> template_segments(const RootLattices& net, const SchemeInfo& scheme,
                                                 const RuleOptions& rules, bool limits) {
    static constexpr std::uint32_t k_cells[] = {4, 8, 16, 32}, k_faces[] = {3, 4, 5, 6, 8, 16, 32};
    const int rings = rule_rings(scheme, rules);
    // In faces, limits of one ring need 3 segments, and so do its steps then; else steps of one ring need 4, of two 5
    // (triangles) or 6 (quads), limits 6.
    if (net.in_cells()) return std::span(k_cells).subspan(rings > (limits ? 1 : 2) ? 1 : 0);
    if (scheme.one_ring_limits && (limits || rings == 1)) return k_faces;
    return std::span(k_faces).subspan(limits ? 3 : rings == 1 ? 1 : net.side_count() - 1);
}

/// Cache of the rows of corner templates, for the schemes of the table. Any thread may use it.
class KnownCorners {
  public:
    /// All that the rows of a corner depend on: scheme; options by rule_choices(); number of sides of a root; whether
    /// points are cells; kind of corner; segments of the template; whether the rows are those of limits.
    using Key = std::tuple<const SchemeInfo*, std::string, std::uint32_t, bool, CornerKind, std::uint32_t, bool>;
    using Rows = std::shared_ptr<const CornerRows>;

    /// Null: the cache does not have the rows.
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

std::uint32_t factor_of(const SchemeInfo& scheme) { return scheme.refinement == Refinement::sqrt3 ? 3 : 2; }

bool too_large(const RowSource& source, std::uint32_t segments, std::uint32_t factor) {
    // Rows, mesh and places of the finer level (measured: 50 kB for Catmull-Clark, 5 roots of 12 x 12 cells).
    constexpr double k_bytes_per_cell = 100;
    double roots = 0;
    // A template in cells also has the roots beside the corner's.
    for (const CornerKind& kind : source.corners.kinds)
        roots += source.net.in_cells() ? 3 * kind.roots() + 12 : kind.roots();
    const double side = static_cast<double>(factor) * segments;
    return source.max_memory_bytes != 0 &&
           roots * side * side * k_bytes_per_cell > static_cast<double>(source.max_memory_bytes);
}

/// Null if the faces of the finer level do not form lattices.
KnownCorners::Rows step_rows(const RowSource& source, const CornerKind& kind, std::uint32_t segments) {
    CornerTemplate corner(kind, source.net, segments, source.scheme, source.rules);
    if (corner.numbers().empty()) return nullptr;
    RuleStep step = source.scheme.step(corner.mesh(), source.rules);
    std::optional<std::vector<int>> row = corner.finer_numbers(step, factor_of(source.scheme));
    if (!row) return nullptr;
    RuleLimits rows;
    rows.positions = std::move(step.stencils);
    return std::make_shared<CornerRows>(std::move(corner), std::move(*row), std::move(rows));
}

KnownCorners::Rows limit_rows(const RowSource& source, const CornerKind& kind, std::uint32_t segments,
                              LimitSearch& search) {
    CornerTemplate corner(kind, source.net, segments, source.scheme, source.rules);
    if (corner.numbers().empty()) return nullptr;
    const RootLattices& net = corner.net();
    const RootLayout at = net.layout(segments);
    std::vector<int> vertices, row(net.place_count(at), -1);
    const std::uint32_t zone = RowPatterns::zone(1, segments);
    for (std::uint32_t i = 0; i < kind.roots(); ++i)
        for (std::uint32_t y = 0; y <= zone; ++y)
            for (std::uint32_t x = 0; x <= (net.side_count() == 4 ? zone : zone - y); ++x) {
                const std::uint32_t place = net.number(at, corner.halfedge(i), x, y);
                if (row[place] >= 0) continue;
                row[place] = static_cast<int>(vertices.size());
                vertices.push_back(corner.numbers()[place]);
            }
    RuleLimits limits = rule_limits(search, corner.mesh(), vertices);
    return std::make_shared<CornerRows>(std::move(corner), std::move(row), std::move(limits));
}

/// @param limits  finds limit rows; null: the rows of a step are wanted
/// @param learn   called with the rows of all kinds and last of a regular corner; false: templates are too small
template <class Learn>
bool learn_from_templates(RowSource& source, LimitSearch* limits, const Learn& learn) {
    static KnownCorners known;
    // The address of a scheme that is not in the table may later belong to another scheme.
    const bool keeps = find_scheme(source.scheme.name) == &source.scheme;
    const std::string rules = rule_choices(source.rules);
    CornerKind regular;
    regular.sharp.assign(source.net.side_count() == 4 ? 4 : 6, 0.0f);
    const std::vector<CornerKind>& kinds = source.corners.kinds;
    for (const std::uint32_t n : template_segments(source.net, source.scheme, source.rules, limits != nullptr)) {
        if (too_large(source, n, limits != nullptr ? 1 : factor_of(source.scheme))) return false;
        std::vector<KnownCorners::Rows> all(kinds.size() + 1);
        const auto take = [&](std::uint32_t i) {
            const CornerKind& kind = i < kinds.size() ? kinds[i] : regular;
            const KnownCorners::Key key(&source.scheme, rules, source.net.side_count(), source.net.in_cells(), kind, n,
                                        limits != nullptr);
            if (keeps) all[i] = known.find(key);
            if (all[i]) return;
            all[i] = limits != nullptr ? limit_rows(source, kind, n, *limits) : step_rows(source, kind, n);
            if (keeps && all[i]) known.add(key, all[i]);
        };
        if (limits != nullptr)
            for (std::uint32_t i = 0; i < all.size(); ++i) take(i);
        else
            for_each_index(static_cast<std::uint32_t>(all.size()), take, 1);
        if (std::find(all.begin(), all.end(), nullptr) != all.end()) return false;
        if (learn(all)) return true;
    }
    return false;
}

void set_template_rules(RuleOptions& rules) {
    rules.runner = nullptr;
    // The outer end of a template is not a boundary of the mesh, so it must not recede.
    rules.averaging_boundary = AveragingBoundary::replicate;
}

}  // namespace

double learning_cost(const CornerKinds& corners, const RootLattices& net, const SchemeInfo& scheme,
                     const RuleOptions& rules, int factor) {
    // The rules make the points, from which rows are read (measured: sqrt3, modified-butterfly, kobbelt on suzanne).
    constexpr double k_per_point = 1.7;
    double roots = 0;
    for (const CornerKind& kind : corners.kinds) roots += kind.roots();
    const double side = factor * static_cast<double>(template_segments(net, scheme, rules, false)[0]);
    return k_per_point * roots * side * side / (net.side_count() == 4 ? 1 : 2);
}

bool learn_step(RowSource source, RowPatterns& patterns) {
    set_template_rules(source.rules);
    return learn_from_templates(source, nullptr, [&](const auto& all) { return patterns.learn(source.corners, all); });
}

bool learn_limits(RowSource source, RowPatterns* points, RowPatterns* normals) {
    set_template_rules(source.rules);
    LimitSearch search(source.scheme, source.rules);
    return learn_from_templates(source, &search, [&](const auto& all) {
        return (points == nullptr || points->learn(source.corners, all)) &&
               (normals == nullptr || normals->learn(source.corners, all));
    });
}

}  // namespace tetrakis::detail
