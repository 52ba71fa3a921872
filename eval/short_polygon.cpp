#include "tetrakis/eval/short_polygon.hpp"

namespace tetrakis::detail {

namespace {

/// The side of a line where sign * (coordinate - bound) is not negative.
ShortPolygon beyond(const ShortPolygon& polygon, glm::length_t axis, double bound, double sign) {
    ShortPolygon kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double here = sign * (p[axis] - bound), next = sign * (q[axis] - bound);
        if (here >= 0) kept.add(p);
        if ((here > 0 && next < 0) || (here < 0 && next > 0)) {
            Vec2d cut = p + here / (here - next) * (q - p);
            cut[axis] = bound;
            kept.add(cut);
        }
    }
    return kept;
}

}  // namespace

ShortPolygon ShortPolygon::within(const Vec2d& low, const Vec2d& high) const {
    ShortPolygon kept = *this;
    for (glm::length_t axis = 0; axis < 2; ++axis)
        kept = beyond(beyond(kept, axis, low[axis], 1), axis, high[axis], -1);
    return kept;
}

double ShortPolygon::area() const {
    double twice = 0;
    for (std::size_t i = 0; i < size_; ++i) {
        const Vec2d &p = corner_[i], &q = corner_[(i + 1) % size_];
        twice += p.x * q.y - p.y * q.x;
    }
    return 0.5 * twice;
}

ShortSegment ShortSegment::within(const Vec2d& low, const Vec2d& high) const {
    double first = 0, last = 1;
    const Vec2d along = to - from;
    for (glm::length_t axis = 0; axis < 2; ++axis) {
        const double to_low = low[axis] - from[axis], to_high = high[axis] - from[axis];
        if (along[axis] == 0) {
            if (to_low > 0 || to_high < 0) return {};
            continue;
        }
        const double enters = (along[axis] > 0 ? to_low : to_high) / along[axis];
        const double leaves = (along[axis] > 0 ? to_high : to_low) / along[axis];
        first = std::max(first, enters);
        last = std::min(last, leaves);
    }
    if (!(first < last)) return {};
    return {from + first * along, from + last * along};
}

}  // namespace tetrakis::detail
