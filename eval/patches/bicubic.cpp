#include "bicubic.hpp"

#include "../../schemes/core/sharpness.hpp"

namespace tetrakis::detail {

void child_net(const Net16& net, SideCrease crease, int qx, int qy, Net16& out, SideCrease& out_crease) {
    if (!crease) {
        out_crease = {};
        child_net(net, qx, qy, out);
        return;
    }
    const bool across_y = crease.across_y(), far = crease.far();
    const double weight = std::min(1.0, static_cast<double>(crease.sharpness));
    const int along = across_y ? 1 : 4, across = across_y ? 4 : 1;
    const int q_along = across_y ? qx : qy, q_across = across_y ? qy : qx;
    // The smooth quarter, and the crease's own row blended with the curve along it.
    child_net(net, qx, qy, out);
    const int from = (far ? 2 : 1) * across, to = (far ? 3 - q_across : 1 - q_across) * across;
    for (int k = 0; k < 3; ++k) {
        double curve[4];
        half_curve(net.c[k] + from, along, q_along != 0, curve, 1);
        for (int i = 0; i < 4; ++i) {
            double& point = out.c[k][to + i * along];
            point = weight * curve[i] + (1 - weight) * point;
        }
    }
    const bool touches = (q_across != 0) == far;
    const float next = child_sharpness(crease.sharpness);
    out_crease = touches && next > 0 ? SideCrease{crease.side, next} : SideCrease{};
}

int crease_strips(const Net16& net, SideCrease crease, std::array<CreaseStrip, 3>& strips) {
    const bool across_y = crease.across_y(), far = crease.far();
    const int along = across_y ? 1 : 4, across = across_y ? 4 : 1;
    const CreasePieces pieces = CreasePieces::make(crease.sharpness);
    for (int s = 0; s < pieces.count; ++s) {
        CreaseStrip& strip = strips[static_cast<std::size_t>(s)];
        strip.begin = pieces.begin[s], strip.end = pieces.end[s];
        strip.origin = pieces.whole(s) ? 0 : strip.begin;
        strip.span = pieces.whole(s) ? 1 : strip.end - strip.begin;
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 4; ++i) {
                const double* p = net.c[k] + i * along;
                for (int j = 0; j < 4; ++j) {
                    const Weights4& w = pieces.control[s][j];
                    const auto at = [&](int c) { return p[across * (far ? 3 - c : c)]; };
                    strip.net.c[k][i * along + across * (far ? 3 - j : j)] =
                        (w[0] * at(0) + w[1] * at(1)) + (w[2] * at(2) + w[3] * at(3));
                }
            }
    }
    return pieces.count;
}

const CreasePieces& crease_pieces(float sharpness) {
    // Most models have creases of one sharpness, or of a few.
    thread_local float known = 0;
    thread_local CreasePieces pieces = CreasePieces::make(known);
    if (sharpness != known) {
        pieces = CreasePieces::make(sharpness);
        known = sharpness;
    }
    return pieces;
}

void regular_basis(SideCrease crease, double x, double y, Weights4 (&wx)[3], Weights4 (&wy)[3]) {
    wx[0] = cubic_basis(x), wx[1] = cubic_basis_d1(x), wx[2] = cubic_basis_d2(x);
    wy[0] = cubic_basis(y), wy[1] = cubic_basis_d1(y), wy[2] = cubic_basis_d2(y);
    if (!crease) return;
    const bool across_y = crease.across_y(), far = crease.far();
    Weights4(&w)[3] = across_y ? wy : wx;
    const double t = across_y ? y : x;
    for (int d = 0; d < 3; ++d) {
        w[d] = crease_basis(crease_pieces(crease.sharpness), far ? 1 - t : t, d);
        if (far) std::reverse(w[d].begin(), w[d].end());
    }
    if (!far) return;
    for (double& d : w[1]) d = -d;
}

}  // namespace tetrakis::detail
