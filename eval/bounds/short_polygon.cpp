#include "short_polygon.hpp"

#include <algorithm>

namespace tetrakis::detail {

namespace {

double cross_product(const Vec2d& a, const Vec2d& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

ShortPolygon ShortPolygon::around(std::vector<Vec2d> points) {
    // Andrew's monotone chain, the lower side, then the upper one.
    std::sort(points.begin(), points.end(),
              [](const Vec2d& a, const Vec2d& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3) return ShortPolygon(points);
    std::vector<Vec2d> chain;
    const auto take = [&](const Vec2d& p, std::size_t least) {
        while (chain.size() >= least + 2 &&
               cross_product(chain.back() - chain[chain.size() - 2], p - chain.back()) <= 0)
            chain.pop_back();
        chain.push_back(p);
    };
    for (const Vec2d& p : points) take(p, 0);
    const std::size_t lower = chain.size() - 1;
    for (std::size_t i = points.size() - 1; i-- > 0;) take(points[i], lower);
    chain.pop_back();
    return ShortPolygon(chain);
}

ShortPolygon ShortPolygon::beyond(const Vec2d& normal, double least) const {
    ShortPolygon kept;
    for (std::size_t i = 0; i < size_; ++i) {
        const Vec2d &p = corner_[i], &q = corner_[(i + 1) % size_];
        const double here = glm::dot(normal, p) - least, next = glm::dot(normal, q) - least;
        if (here >= 0) kept.add(p);
        if (size_ == 2 && i == 1) break;  // a segment has one side
        if ((here > 0 && next < 0) || (here < 0 && next > 0)) kept.add(p + here / (here - next) * (q - p));
    }
    return kept;
}

ShortPolygon ShortPolygon::within(const Vec2d& low, const Vec2d& high) const {
    return beyond({1, 0}, low.x).beyond({-1, 0}, -high.x).beyond({0, 1}, low.y).beyond({0, -1}, -high.y);
}

double ShortPolygon::area() const {
    double twice = 0;
    for (std::size_t i = 0; i < size_; ++i) twice += cross_product(corner_[i], corner_[(i + 1) % size_]);
    return 0.5 * twice;
}

bool ShortPolygon::is_nothing_beside(const Vec2d& size) const {
    constexpr double k_no_share = 1e-12;
    if (size_ == 2) return !(glm::length(corner_[1] - corner_[0]) > k_no_share * glm::length(size));
    return !(area() > k_no_share * size.x * size.y);
}

}  // namespace tetrakis::detail
