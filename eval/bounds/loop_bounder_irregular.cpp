#include "box_spline_error.hpp"
#include "box_spline_lattice.hpp"
#include "loop_bounder.hpp"
#include "loop_star_bound.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

// Pieces of cells that are no regular patch: stars around extraordinary vertices, and cells with boundaries or creases.

namespace tetrakis {

using detail::Bary;
using detail::BoxSplineHessian;
using detail::corner_of;
using detail::is_corner;
using detail::LoopCell;
using detail::middle;
using detail::next3;
using detail::prev3;
using detail::squared;

namespace {

/// Samples of a star, those first that are likely to be far off.
constexpr std::array<std::size_t, detail::LoopStarBound::k_samples> k_sample_order{10, 2, 4,  0, 1, 5,
                                                                                   8,  9, 11, 6, 7, 3};

bool is_whole(const std::array<Bary, 3>& at) { return is_corner(at[0]) && is_corner(at[1]) && is_corner(at[2]); }

}  // namespace

/// S lies in the hull of the cell's points, and T is no further off than any of its own points. For edges of the leaf
/// that has to be a point of theirs: a corner that all those at the piece meet at stands for them. Where there is none,
/// S - L lies in the hull of the differences.
double LoopBounder::hull_error(const LoopCell& cell, const Points& point) const {
    assert(cell.kind == LoopCell::Kind::star || cell.kind == LoopCell::Kind::generic);
    std::array<double, 3> far{};  // squared, from L at each corner
    const std::array<Vec3d, 3> l{linear(point[0]), linear(point[1]), linear(point[2])};
    const auto look = [&](const Vec3d& p) {
        for (std::size_t i = 0; i < 3; ++i) far[i] = std::max(far[i], squared(p - l[i]));
    };
    if (cell.kind == LoopCell::Kind::star) {
        for (int i = 0; i < detail::loop_star_size(cell.star->valence()); ++i) look(cell.star->points()[i]);
    } else {
        for (const detail::LoopRing& ring : cell.node->rings().corner) {
            look(ring.centre);
            for (const detail::LoopRing::Spoke& spoke : ring.spokes) look(spoke.point);
        }
    }
    double error = std::max({far[0], far[1], far[2]});
    for (int i = 0; i < 3; ++i)
        if (!on_one_side(point[next3(i)], point[prev3(i)])) error = std::min(error, far[i]);
    return std::sqrt(error);
}

void LoopBounder::bound_quarter(const LoopCell& cell, int quarter, const Piece& piece, int depth) {
    if (rejected_) return;
    LoopCell child;
    patches_.child(cell, quarter, child);
    Piece part = piece;
    for (Bary& b : part.at) b = detail::turned(detail::in_quarter(b, quarter), child.turn);
    if (child.kind != LoopCell::Kind::regular) {
        bound_irregular(child, part, depth - 1);
        return;
    }
    const BoxSplineHessian hessian(child.net);
    if (!is_whole(part.at)) {
        bound_regular(hessian, part.at, part.point, k_unknown, std::min(depth - 1, k_regular_refinement));
        return;
    }
    Points point;  // in the order of the patch's corners
    for (std::size_t i = 0; i < 3; ++i) point[static_cast<std::size_t>(corner_of(part.at[i]))] = part.point[i];
    bound_red(hessian, point, k_unknown, std::min(depth - 1, k_regular_refinement));
}

/// A whole star cell, from the table of its valence where that is enough.
void LoopBounder::bound_star(const detail::LoopStarChain& star, const Piece& piece, int depth) {
    using detail::LoopStarBound;
    LoopCell cell;
    cell.kind = LoopCell::Kind::star;
    cell.star = &star;
    const LoopStarBound* table = LoopStarBound::of(star.valence());
    if (table == nullptr) {
        bound_quarters(cell, piece, depth);
        return;
    }
    Points corner;
    for (std::size_t i = 0; i < 3; ++i) corner[static_cast<std::size_t>(corner_of(piece.at[i]))] = piece.point[i];
    const double m = LoopStarBound::largest_difference(star.valence(), star.points());
    const double ends = largest_error(corner);
    if (settle(ends + table->whole * m + pad_)) return;
    auto deviation = table->deviations(star.points());
    const double around = table->around * m + pad_, inner = table->inner * m + pad_;
    const auto sample = [&](std::size_t s) {
        const auto& at = LoopStarBound::k_sample_at[s];
        const double w0 = 0.25 * at[0], w1 = 0.25 * at[1], w2 = 0.25 * at[2];
        return Point{w0 * corner[0].b1 + w1 * corner[1].b1 + w2 * corner[2].b1,
                     w0 * corner[0].b2 + w1 * corner[1].b2 + w2 * corner[2].b2, deviation[s], 0};
    };
    std::array<double, LoopStarBound::k_samples> error;
    const double room = std::max(0.0, decide_at_ - around), room_inside = std::min(room, decide_at_ - inner);
    for (const std::size_t s : k_sample_order) {
        if (ends > 0) {
            const auto& at = LoopStarBound::k_sample_at[s];
            deviation[s] += (0.25 * at[0]) * corner[0].deviation + (0.25 * at[1]) * corner[1].deviation +
                            (0.25 * at[2]) * corner[2].deviation;
        }
        error[s] = std::sqrt(squared(deviation[s]));
        if (error[s] <= (s < 2 ? room_inside : room)) continue;
        Point p = sample(s);
        attain(p);
        if (rejected_) return;
        error[s] = p.error;
    }
    std::array<double, 4> upper{corner[0].error, corner[1].error, corner[2].error, 0};
    for (std::size_t k = 0; k < 4; ++k) {
        for (const std::size_t s : LoopStarBound::k_in_quarter[k]) upper[k] = std::max(upper[k], error[s]);
        upper[k] += around;
    }
    upper[0] = std::max(upper[0], std::max({corner[0].error, error[0], error[1]}) + inner);
    if (settle(std::max({upper[0], upper[1], upper[2], upper[3]}))) return;
    Points middles;
    for (std::size_t k = 0; k < 3; ++k) {
        middles[k] = sample(LoopStarBound::k_middles[k]);
        middles[k].error = error[LoopStarBound::k_middles[k]];
    }
    std::array<bool, 4> settled;
    for (std::size_t k = 0; k < 4; ++k) settled[k] = accept(upper[k]);
    bound_quarters(cell, piece, depth, &middles, settled);
}

/// A part of a star that its table's samples bound. Whether it needs no further look.
bool LoopBounder::bound_star_part(const detail::LoopStarChain& star, const Piece& piece) {
    const detail::LoopStarBound* table = detail::LoopStarBound::of(star.valence());
    if (table == nullptr) return false;
    const auto& p = piece.point;
    const auto part = table->part(star.points(), piece.at, {p[0].deviation, p[1].deviation, p[2].deviation});
    const double around_rest = part.around + pad_, inner_rest = part.inner + pad_;
    double around = 0, inner = 0;
    for (int i = 0; i < part.count; ++i) {
        const auto& q = part.points[static_cast<std::size_t>(i)];
        Point point = combine(p, q.at);
        point.deviation = q.deviation;
        if (q.attained)
            attain_where_needed(point, q.near_centre ? std::max(around_rest, inner_rest) : around_rest);
        else if (!small(point, q.near_centre ? std::max(around_rest, inner_rest) : around_rest))
            point.error = error_of(point);
        if (rejected_) return true;
        around = std::max(around, point.error);
        if (q.near_centre) inner = std::max(inner, point.error);
    }
    return settle(std::max(around + around_rest, inner + inner_rest));
}

void LoopBounder::bound_irregular(const LoopCell& cell, const Piece& piece, int depth) {
    if (rejected_) return;
    if (!may_split(depth)) {
        upper_ = std::max(upper_, hull_error(cell, piece.point) + pad_);
        return;
    }
    int corners = 0;
    for (const Bary& b : piece.at) corners += is_corner(b) ? 1 : 0;
    if (cell.kind == LoopCell::Kind::star && corners == 3) {
        bound_star(*cell.star, piece, depth);
        return;
    }
    if (cell.kind == LoopCell::Kind::star && bound_star_part(*cell.star, piece)) return;
    if (cell.kind == LoopCell::Kind::generic && settle(hull_error(cell, piece.point) + pad_)) return;
    if (corners == 3)
        bound_quarters(cell, piece, depth);
    else
        bound_green(cell, piece, corners, depth);
}

void LoopBounder::bound_quarters(const LoopCell& cell, const Piece& piece, int depth, const Points* middles,
                                 const std::array<bool, 4>& settled) {
    Piece p;  // in the order of the cell's corners
    for (int i = 0; i < 3; ++i) {
        const int k = corner_of(piece.at[i]);
        p.at[k] = piece.at[i], p.point[k] = piece.point[i];
    }
    Piece m;  // [k]: middle of edge k
    for (int k = 0; k < 3; ++k) m.at[k] = middle(p.at[k], p.at[next3(k)]);
    if (middles != nullptr) {
        m.point = *middles;
    } else {
        LoopCell centre;
        patches_.child(cell, 3, centre);
        for (int k = 0; k < 3; ++k) {
            // Corner i of the centre is the middle of the edge opposite corner i.
            const Vec3d s = centre.kind == LoopCell::Kind::regular ? detail::box_spline_corner(centre.net, prev3(k))
                                                                   : patches_.position(cell, m.at[k]);
            m.point[k] = surface_halfway(p.point[k], p.point[next3(k)], s);
        }
    }
    for (int k = 2; k >= -1; --k) {
        const int quarter = k < 0 ? 0 : k == 0 ? 3 : k;  // the irregular one of a star last
        if (settled[static_cast<std::size_t>(quarter)]) continue;
        Piece part;
        for (int i = 0; i < 3; ++i) {
            const bool own = i == quarter;
            const int edge = quarter == 3 ? next3(i) : i == next3(quarter) ? quarter : prev3(quarter);
            part.at[i] = own ? p.at[i] : m.at[edge];
            part.point[i] = own ? p.point[i] : m.point[edge];
        }
        bound_quarter(cell, quarter, part, depth);
    }
}

void LoopBounder::bound_green(const LoopCell& cell, const Piece& piece, int corners, int depth) {
    // Green triangles. Corner k of the cell; a second corner j or the middle of the edge from k to j; the middle of the
    // edge from j to the third corner. They fall into half the quarter at k, half the centre and, for a half, the
    // quarter at j.
    const auto find = [&](const auto& wanted) {
        int found = -1;
        for (int i = 0; i < 3; ++i)
            if (wanted(piece.at[i])) found = i;
        return found;
    };
    int ik, ij, im;  // positions in the piece
    if (corners == 2) {
        im = find([](const Bary& b) { return !is_corner(b); });
        // The corner that is not an end of the middle's edge.
        ik = find([&](const Bary& b) { return is_corner(b) && piece.at[im][corner_of(b)] == 0; });
        ij = 3 - im - ik;
    } else {
        ik = find([](const Bary& b) { return is_corner(b); });
        const int k = corner_of(piece.at[ik]);
        ij = find([&](const Bary& b) { return b[k] == 0.5; });
        im = 3 - ik - ij;
    }
    assert(ik >= 0 && ij >= 0 && im >= 0 && ik != ij);
    const int k = corner_of(piece.at[ik]);
    const auto put_middle = [&](int i, int j, Piece& out, int o) {
        out.at[o] = middle(piece.at[i], piece.at[j]);
        out.point[o] = surface_halfway(piece.point[i], piece.point[j], patches_.position(cell, out.at[o]));
    };
    const auto copy = [](const Piece& from, int i, Piece& to, int j) {
        to.at[j] = from.at[i], to.point[j] = from.point[i];
    };
    // The middle of the edge k j, and the point x of the line from k to the other middle that is on the centre's side.
    Piece extra;
    if (corners == 2)
        put_middle(ik, ij, extra, 0);
    else
        copy(piece, ij, extra, 0);
    put_middle(ik, im, extra, 1);
    Piece part;
    copy(extra, 0, part, 0);
    copy(piece, im, part, 1);
    copy(extra, 1, part, 2);
    bound_quarter(cell, 3, part, depth);
    copy(piece, ik, part, 1);
    bound_quarter(cell, k, part, depth);
    if (corners == 2) {
        copy(piece, ij, part, 1);
        copy(piece, im, part, 2);
        bound_quarter(cell, corner_of(piece.at[ij]), part, depth);
    }
}

}  // namespace tetrakis
