#include "row_learner.hpp"

#include "../../hier/base/parallel.hpp"

#include <optional>
#include <span>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Segments of the templates' roots, one after the other: as long as masks are too wide for them.
std::span<const std::uint32_t> template_segments(const SchemeInfo& scheme, const RuleOptions& rules) {
    static constexpr std::uint32_t k_segments[] = {4, 6, 9, 14, 20};
    return std::span(k_segments).subspan(rule_rings(scheme, rules) == 1 ? 0 : 1);
}

}  // namespace

RowLearner::RowLearner(const RootLattices& net, const CornerKinds& corners, const SchemeInfo& scheme,
                       const RuleOptions& rules, std::uint64_t max_memory_bytes)
    : net_(net), corners_(corners), scheme_(scheme), rules_(rules), max_memory_bytes_(max_memory_bytes) {
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

const std::vector<std::unique_ptr<CornerTemplate>>& RowLearner::templates(std::uint32_t segments) {
    if (segments_ == segments) return templates_;
    segments_ = segments;
    const auto count = static_cast<std::uint32_t>(corners_.kinds.size());
    templates_.clear();
    templates_.resize(count + std::size_t{1});
    CornerKind regular;
    regular.sharp.assign(net_.side_count() == 4 ? 4 : 6, 0.0f);
    for_each_index(
        count + 1,
        [&](std::uint32_t i) {
            templates_[i] = std::make_unique<CornerTemplate>(i < count ? corners_.kinds[i] : regular, net_.side_count(),
                                                             net_.in_cells(), segments);
        },
        1);
    return templates_;
}

bool RowLearner::learn_step(RowPatterns& patterns) {
    for (const std::uint32_t n : template_segments(scheme_, rules_)) {
        if (too_large(n, patterns.factor())) return false;
        const auto& templates = this->templates(n);
        std::vector<std::optional<CornerTemplate::Step>> steps(templates.size());
        for_each_index(
            static_cast<std::uint32_t>(templates.size()),
            [&](std::uint32_t i) { steps[i] = templates[i]->step(scheme_, rules_, patterns.factor()); }, 1);
        std::vector<RowPatterns::KnownRows> sources;
        for (std::size_t i = 0; i < templates.size(); ++i) {
            if (!steps[i]) return false;
            sources.push_back({*templates[i], std::move(steps[i]->row), steps[i]->rows});
        }
        if (patterns.learn(corners_, sources.back(), std::span(sources).first(sources.size() - 1))) return true;
    }
    return false;
}

bool RowLearner::learn_limits(RowPatterns* points, RowPatterns* normals) {
    RuleLimitFinder finder(scheme_, rules_);
    for (const std::uint32_t n : template_segments(scheme_, rules_)) {
        if (too_large(n, 1)) return false;
        const auto& templates = this->templates(n);
        std::vector<RuleLimits> limits(templates.size());
        std::vector<std::vector<int>> rows;
        for (std::size_t i = 0; i < templates.size(); ++i) {
            const RootLattices& net = templates[i]->net();
            const RootLayout at = net.layout(n);
            std::vector<int> vertices;
            std::vector<int>& row = rows.emplace_back(net.place_count(at), -1);
            const std::uint32_t zone = RowPatterns::zone(1, n);
            for (std::uint32_t f = 0; f < net.base().face_count; ++f)
                for (std::uint32_t y = 0; y <= zone; ++y)
                    for (std::uint32_t x = 0; x <= (net.side_count() == 4 ? zone : zone - y); ++x) {
                        const std::uint32_t place = net.number_at(at, f, RootLattices::Place{x, y});
                        if (row[place] >= 0) continue;
                        row[place] = static_cast<int>(vertices.size());
                        vertices.push_back(static_cast<int>(templates[i]->first_place(place)));
                    }
            limits[i] = finder.find(templates[i]->mesh(), vertices);
        }
        const auto learn = [&](RowPatterns& patterns, bool tangents) {
            std::vector<RowPatterns::KnownRows> sources;
            for (std::size_t i = 0; i < templates.size(); ++i) {
                if (tangents)
                    sources.push_back(
                        {*templates[i], rows[i], limits[i].tangent1, &limits[i].tangent2, limits[i].begin});
                else
                    sources.push_back({*templates[i], rows[i], limits[i].positions});
            }
            return patterns.learn(corners_, sources.back(), std::span(sources).first(sources.size() - 1));
        };
        if ((points == nullptr || learn(*points, false)) && (normals == nullptr || learn(*normals, true))) return true;
    }
    return false;
}

}  // namespace tetrakis::detail
