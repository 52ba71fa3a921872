#include "star_lessons.hpp"

#include "../../hier/base/parallel.hpp"

#include <optional>
#include <span>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Of the stars' roots, one after the other: as long as masks are too wide for them.
std::span<const std::uint32_t> star_segments(const SchemeInfo& scheme, const RuleOptions& rules) {
    static constexpr std::uint32_t k_segments[] = {4, 6, 9, 14, 20};
    return std::span(k_segments).subspan(rule_rings(scheme, rules) == 1 ? 0 : 1);
}

}  // namespace

StarLessons::StarLessons(const RootNet& net, const CornerKinds& corners, const SchemeInfo& scheme,
                         const RuleOptions& rules, std::uint64_t max_memory_bytes)
    : net_(net), corners_(corners), scheme_(scheme), rules_(rules), max_memory_bytes_(max_memory_bytes) {
    rules_.runner = nullptr;
    // No star is all there is of a surface: its end is none of the mesh's.
    rules_.averaging_boundary = AveragingBoundary::replicate;
}

bool StarLessons::too_large(std::uint32_t segments, std::uint32_t factor) const {
    // A finer level's rows, mesh and places (measured: Catmull-Clark's 50 kB for stars of 5 roots, 12 segments).
    constexpr double k_bytes_per_cell = 100;
    double roots = 0;
    for (const StarKind& kind : corners_.kinds) roots += kind.roots();
    const double side = static_cast<double>(factor) * segments;
    return max_memory_bytes_ != 0 && roots * side * side * k_bytes_per_cell > static_cast<double>(max_memory_bytes_);
}

double StarLessons::cost(const CornerKinds& corners, const RootNet& net, const SchemeInfo& scheme,
                         const RuleOptions& rules, int factor) {
    // Their points are made by the rules, and read (measured: modified-butterfly, doo-sabin, kobbelt on suzanne).
    constexpr double k_per_point = 3;
    double roots = 0;
    for (const StarKind& kind : corners.kinds) roots += kind.roots();
    const double side = factor * static_cast<double>(star_segments(scheme, rules)[0]);
    return k_per_point * roots * side * side / (net.side_count() == 4 ? 1 : 2);
}

const std::vector<std::unique_ptr<RowStar>>& StarLessons::stars(std::uint32_t segments) {
    if (segments_ == segments) return stars_;
    segments_ = segments;
    const auto count = static_cast<std::uint32_t>(corners_.kinds.size());
    stars_.clear();
    stars_.resize(count + std::size_t{1});
    StarKind regular;
    regular.sharp.assign(net_.side_count() == 4 ? 4 : 6, 0.0f);
    for_each_index(
        count + 1,
        [&](std::uint32_t i) {
            stars_[i] = std::make_unique<RowStar>(i < count ? corners_.kinds[i] : regular, net_.side_count(),
                                                  net_.in_cells(), segments);
        },
        1);
    return stars_;
}

bool StarLessons::teach_step(RowPatterns& patterns) {
    for (const std::uint32_t n : star_segments(scheme_, rules_)) {
        if (too_large(n, patterns.factor())) return false;
        const auto& stars = this->stars(n);
        std::vector<std::optional<RowStar::Step>> steps(stars.size());
        for_each_index(
            static_cast<std::uint32_t>(stars.size()),
            [&](std::uint32_t i) { steps[i] = stars[i]->step(scheme_, rules_, patterns.factor()); }, 1);
        std::vector<RowPatterns::Lesson> lessons;
        for (std::size_t i = 0; i < stars.size(); ++i) {
            if (!steps[i]) return false;
            lessons.push_back({*stars[i], std::move(steps[i]->row), steps[i]->rows});
        }
        if (patterns.learn(corners_, lessons.back(), std::span(lessons).first(lessons.size() - 1))) return true;
    }
    return false;
}

bool StarLessons::teach_limits(RowPatterns* points, RowPatterns* normals) {
    RuleLimitFinder finder(scheme_, rules_);
    for (const std::uint32_t n : star_segments(scheme_, rules_)) {
        if (too_large(n, 1)) return false;
        const auto& stars = this->stars(n);
        std::vector<RuleLimits> limits(stars.size());
        std::vector<std::vector<int>> rows;
        for (std::size_t i = 0; i < stars.size(); ++i) {
            const RootNet& net = stars[i]->net();
            const RootLayout at = net.layout(n);
            std::vector<int> vertices;
            std::vector<int>& row = rows.emplace_back(net.place_count(at), -1);
            const std::uint32_t zone = RowPatterns::zone(1, n);
            for (std::uint32_t f = 0; f < net.base().face_count; ++f)
                for (std::uint32_t y = 0; y <= zone; ++y)
                    for (std::uint32_t x = 0; x <= (net.side_count() == 4 ? zone : zone - y); ++x) {
                        const std::uint32_t place = net.number_at(at, f, RootNet::Place{x, y});
                        if (row[place] >= 0) continue;
                        row[place] = static_cast<int>(vertices.size());
                        vertices.push_back(static_cast<int>(stars[i]->first_place(place)));
                    }
            limits[i] = finder.find(stars[i]->mesh(), vertices);
        }
        const auto learn = [&](RowPatterns& patterns, bool tangents) {
            std::vector<RowPatterns::Lesson> lessons;
            for (std::size_t i = 0; i < stars.size(); ++i) {
                if (tangents)
                    lessons.push_back({*stars[i], rows[i], limits[i].tangent1, &limits[i].tangent2, limits[i].begin});
                else
                    lessons.push_back({*stars[i], rows[i], limits[i].positions});
            }
            return patterns.learn(corners_, lessons.back(), std::span(lessons).first(lessons.size() - 1));
        };
        if ((points == nullptr || learn(*points, false)) && (normals == nullptr || learn(*normals, true))) return true;
    }
    return false;
}

}  // namespace tetrakis::detail
