#include "quad_tip.hpp"

#include <algorithm>
#include <memory>
#include <mutex>
#include <numbers>
#include <span>

namespace tetrakis::detail {

namespace {

constexpr int k_most_valence = 64;

/// Steps after which the other modes of the same rotation are gone: they shrink by less than 0.7 of lambda.
constexpr int k_steps = 120;

/// Bezier points of one coordinate pair of a net, along both directions: they hold the patch.
template <class Visit>
void for_each_bezier_point(const Net16& net, Visit&& visit) {
    constexpr double w[4][4] = {{1.0 / 6, 4.0 / 6, 1.0 / 6, 0},
                                {0, 2.0 / 3, 1.0 / 3, 0},
                                {0, 1.0 / 3, 2.0 / 3, 0},
                                {0, 1.0 / 6, 4.0 / 6, 1.0 / 6}};
    for (const auto& wy : w)
        for (const auto& wx : w) visit(combine(net, {wx[0], wx[1], wx[2], wx[3]}, {wy[0], wy[1], wy[2], wy[3]}));
}

std::unique_ptr<QuadCharacteristic> make(int n) {
    const auto angle = [n](double i) { return 2 * std::numbers::pi * i / n; };
    QuadStar star;
    star.valence = n;
    star.points.resize(QuadStar::point_count(n));
    star.points[0] = Vec3d(0);
    for (int i = 0; i < n; ++i) {
        const Vec3d e(std::cos(angle(i)), std::sin(angle(i)), 0),
            next(std::cos(angle(i + 1)), std::sin(angle(i + 1)), 0);
        star.points[static_cast<std::size_t>(1 + 2 * i)] = e;
        star.points[static_cast<std::size_t>(2 + 2 * i)] = e + next;
    }
    for (int i = 0; i < 7; ++i) star.points[static_cast<std::size_t>(2 * n + 1 + i)] = star.face(0);
    auto map = std::make_unique<QuadCharacteristic>();
    std::array<Net16, 3> regular;
    for (int step = 0; step < k_steps; ++step) {
        QuadStar finer;
        subdivide(star, finer, regular);
        map->lambda = finer.edge(0).x;  // e_0 has length 1
        const Vec3d centre = finer.points[0];
        for (Vec3d& p : std::span(finer.points.data(), finer.points.size())) p = (p - centre) / map->lambda;
        star = std::move(finer);
    }
    // The cell's corners (1, 0) and (0, 1) are corners of the regular quarters.
    QuadStar finer;
    subdivide(star, finer, regular);
    const Vec3d d0 = regular_position(regular[0], {}, 1, 0), d1 = regular_position(regular[2], {}, 0, 1);
    const double det = d0.x * d1.y - d0.y * d1.x;
    const auto oblique = [&](const Vec3d& p) { return Vec2d(p.x * d1.y - p.y * d1.x, d0.x * p.y - d0.y * p.x) / det; };
    for (const Vec3d& p : star.points) map->at.push_back(oblique(p));
    // The three quarters are a ring of the cell whose smaller copies fill the rest.
    constexpr double k_margin = 1e-9;
    for (const Net16& net : regular)
        for_each_bezier_point(net, [&](const Vec3d& p) {
            const Vec2d q = oblique(p);
            map->reach = std::max({map->reach, q.x, q.y});
        });
    map->reach += k_margin;
    // Tangents: MASKS, Catmull-Clark at an interior vertex; scaled so that the map's own are its own.
    const double c = std::cos(angle(1)), edge_weight = 1 + c + std::cos(angle(0.5)) * std::sqrt(2 * (9 + c));
    std::vector<Vec2d> weight(2 * static_cast<std::size_t>(n) + 1, Vec2d(0));
    for (int i = 0; i < n; ++i) {
        const Vec2d e(std::cos(angle(i)), std::sin(angle(i))), next(std::cos(angle(i + 1)), std::sin(angle(i + 1)));
        weight[static_cast<std::size_t>(1 + 2 * i)] = edge_weight * e;
        weight[static_cast<std::size_t>(2 + 2 * i)] = e + next;
    }
    double scale = 0;
    for (std::size_t i = 0; i < weight.size(); ++i) scale += weight[i].x * star.points[i].x;
    // S(p) = t1 p.x + t2 p.y with t = weights / scale, so d0 = t1 d0.x + t2 d0.y.
    for (const Vec2d& w : weight)
        map->tangents.push_back(Vec2d(w.x * d0.x + w.y * d0.y, w.x * d1.x + w.y * d1.y) / scale);
    return map;
}

}  // namespace

const QuadCharacteristic* QuadCharacteristic::of(int valence) {
    if (valence < 3 || valence > k_most_valence) return nullptr;
    struct Entry {
        std::once_flag once;
        std::unique_ptr<QuadCharacteristic> map;
    };
    static std::array<Entry, k_most_valence + 1> entries;
    Entry& entry = entries[static_cast<std::size_t>(valence)];
    std::call_once(entry.once, [&] { entry.map = make(valence); });
    return entry.map.get();
}

void QuadTip::find_rest(const QuadStar& star) {
    double most = 0;
    for (std::size_t i = 0; i < star.points.size(); ++i) {
        const Vec3d r = star.points[i] - star.limit - (map->at[i].x * d0 + map->at[i].y * d1);
        most = std::max(most, glm::dot(r, r));
    }
    rest = std::sqrt(most);
}

QuadTip QuadTip::of(const QuadStar& star) {
    QuadTip tip;
    tip.map = QuadCharacteristic::of(star.valence);
    if (!tip.map) return tip;
    for (std::size_t i = 0; i < tip.map->tangents.size(); ++i) {
        tip.d0 += tip.map->tangents[i].x * star.points[i];
        tip.d1 += tip.map->tangents[i].y * star.points[i];
    }
    tip.find_rest(star);
    return tip;
}

QuadTip QuadTip::child(const QuadStar& star) const {
    QuadTip tip;
    tip.map = map;
    if (!map) return tip;
    tip.d0 = map->lambda * d0, tip.d1 = map->lambda * d1;
    tip.find_rest(star);
    return tip;
}

}  // namespace tetrakis::detail
