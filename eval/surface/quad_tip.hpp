#pragma once

#include "quad_star.hpp"

#include <vector>

namespace tetrakis::detail {

/// The characteristic map of Catmull-Clark at a smooth interior vertex of some valence >= 3 (Reif 1995): the planar
/// surface that one step scales by lambda. It is one-to-one (Peters, Reif 1998), so that a cell stays between the rays
/// that its sides lie on. Computed once per valence.
struct QuadCharacteristic {
    double lambda = 0;
    double reach = 0;             ///< a, b <= reach over the cell, its points written as a d0 + b d1; a, b >= 0
    std::vector<Vec2d> at;        ///< of the star's points, as (a, b)
    std::vector<Vec2d> tangents;  ///< weights of the ring's points that give d0 and d1

    /// Null for valence 2, whose sides lie on one line, and above 64.
    static const QuadCharacteristic* of(int valence);
};

/// First-order part of the surface around the corner of a star: the corner's limit + a d0 + b d1, where (a, b) follows
/// the characteristic map. The sides x and y of the cell become the rays along d0 and d1, its diagonal that along
/// d0 + d1. The surface of the cell is off by `rest` at most: what the points are off is refined by the same rules,
/// whose weights are not negative and sum to one.
struct QuadTip {
    const QuadCharacteristic* map = nullptr;
    Vec3d d0{0}, d1{0};
    double rest = 0;

    explicit operator bool() const { return map != nullptr; }
    static QuadTip of(const QuadStar& star);
    /// That of the star at the same corner one level further down.
    QuadTip child(const QuadStar& star) const;

  private:
    void find_rest(const QuadStar& star);
};

}  // namespace tetrakis::detail
