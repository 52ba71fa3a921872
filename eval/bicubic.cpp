#include "tetrakis/eval/bicubic.hpp"

#include "tetrakis/schemes/sharpness.hpp"

namespace tetrakis::detail {

namespace {
/// The half of four points across a crease at p_0 (index 1): as half_curve(), but the crease's own row blends.
void half_crease(const double* p, int stride, double weight, bool upper, double* q) {
    half_curve(p, stride, upper, q, stride);
    const double smooth = 0.125 * (p[0] + p[2 * stride]) + 0.75 * p[stride];
    q[upper ? 0 : stride] = weight * p[stride] + (1 - weight) * smooth;
}
}  // namespace

void child_net(const Net16& net, SideCrease crease, int qx, int qy, Net16& out, SideCrease& out_crease) {
    if (!crease) {
        out_crease = {};
        child_net(net, qx, qy, out);
        return;
    }
    const bool across_y = crease.side == 0 || crease.side == 2;
    const bool far = crease.side == 1 || crease.side == 2;  // the crease is at 1, not at 0
    const double weight = std::min(1.0, static_cast<double>(crease.sharpness));
    const int along = across_y ? 1 : 4, across = across_y ? 4 : 1;
    const int q_along = across_y ? qx : qy, q_across = across_y ? qy : qx;
    for (int k = 0; k < 3; ++k) {
        double half[16];
        for (int i = 0; i < 4; ++i) half_curve(net.c[k] + i * across, along, q_along != 0, half + i * across, along);
        for (int i = 0; i < 4; ++i) {
            const double* p = half + i * along;
            double* q = out.c[k] + i * along;
            if (!far) {
                half_crease(p, across, weight, q_across != 0, q);
            } else {
                // Mirrored: walk the four points from the far end.
                double r[4] = {p[3 * across], p[2 * across], p[across], p[0]}, s[4];
                half_crease(r, 1, weight, q_across == 0, s);
                for (int j = 0; j < 4; ++j) q[j * across] = s[3 - j];
            }
        }
    }
    const bool touches = (q_across != 0) == far;
    const float next = child_sharpness(crease.sharpness);
    out_crease = touches && next > 0 ? SideCrease{crease.side, next} : SideCrease{};
}

double sharpened(const Net16& net, SideCrease crease, Net16& out) {
    const bool across_y = crease.side == 0 || crease.side == 2;
    const bool far = crease.side == 1 || crease.side == 2;
    const int along = across_y ? 1 : 4, across = (across_y ? 4 : 1) * (far ? -1 : 1);
    const int beyond = far ? 3 * std::abs(across) : 0;
    out = net;
    double most = 0;
    for (int i = 0; i < 4; ++i) {
        double squared = 0;
        for (int k = 0; k < 3; ++k) {
            const double* p = net.c[k] + beyond + i * along;
            const double phantom = 2 * p[across] - p[2 * across], difference = p[0] - phantom;
            out.c[k][beyond + i * along] = phantom;
            squared += difference * difference;
        }
        most = std::max(most, squared);
    }
    return std::exp2(-std::floor(static_cast<double>(crease.sharpness))) / 6 * std::sqrt(most);
}

void regular_basis(SideCrease crease, double x, double y, Weights4 (&wx)[3], Weights4 (&wy)[3]) {
    wx[0] = cubic_basis(x), wx[1] = cubic_basis_d1(x), wx[2] = cubic_basis_d2(x);
    wy[0] = cubic_basis(y), wy[1] = cubic_basis_d1(y), wy[2] = cubic_basis_d2(y);
    if (!crease) return;
    const bool across_y = crease.side == 0 || crease.side == 2;
    const bool far = crease.side == 1 || crease.side == 2;
    Weights4(&w)[3] = across_y ? wy : wx;
    const double t = across_y ? y : x;
    crease_basis(CreasePieces::make(crease.sharpness), far ? 1 - t : t, w[0], w[1], w[2]);
    if (!far) return;
    for (Weights4& weights : w) {
        std::swap(weights[0], weights[3]);
        std::swap(weights[1], weights[2]);
    }
    for (double& d : w[1]) d = -d;
}

}  // namespace tetrakis::detail
