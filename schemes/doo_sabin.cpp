#include "tetrakis/schemes/doo_sabin.hpp"

#include "tetrakis/schemes/vertex_split.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

using std::numbers::pi;

std::vector<double> DooSabin::weights(int k) {
    std::vector<double> w(k);
    for (int i = 0; i < k; ++i) w[i] = (3 + 2 * std::cos(2 * pi * i / k)) / (4 * k);
    w[0] = 0.25 + 5.0 / (4 * k);
    return w;
}

std::vector<double> DooSabin::weights_catmull_clark(int k) {
    std::vector<double> w(k, 1.0 / (4 * k));
    w[0] += 0.5;
    w[1] += 0.125;
    w[k - 1] += 0.125;
    return w;
}

std::vector<double> Midedge::weights(int k) {
    std::vector<double> w(k, 1.0 / k);
    for (int i = 0; i < k; ++i)
        for (int j = 1; 2 * j < k; ++j) w[i] += 2 * std::ldexp(std::cos(2 * pi * i * j / k), -j) / k;
    return w;
}

std::vector<double> Midedge::weights_simplest(int k) {
    std::vector<double> w(k, 0.0);
    w[0] += 0.5;
    w[1] += 0.25;
    w[k - 1] += 0.25;
    return w;
}

namespace {

using Weights = std::vector<double> (*)(int);

RuleStep dual_step(const RuleMesh& mesh, const RuleOptions& options, Weights weights) {
    std::vector<std::vector<double>> of_size;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int k = mesh.face_size(f);
        if (static_cast<int>(of_size.size()) <= k) of_size.resize(k + 1);
        if (of_size[k].empty()) of_size[k] = weights(k);
    }
    return detail::split_vertices(
        mesh, options.runner,
        [&](int h) {
            const int k = mesh.face_size(mesh.face(h));
            StencilRow row;
            for (int i = 0, at = h; i < k; ++i, at = mesh.next(at)) row.add(mesh.origin(at), of_size[k][i]);
            return row;
        },
        [&](int h, int near) {
            const int far = mesh.origin(h) == near ? mesh.target(h) : mesh.origin(h);
            return StencilRow{{near, DooSabin::crease_near}, {far, DooSabin::crease_far}};
        },
        [](int v) {
            return StencilRow{{v, 1}};
        });
}

ClosedMasks closed_masks(const FanShape& shape, double lambda) {
    ClosedMasks masks;
    if (shape.corner) {
        masks.limit = {{{}, 1}};
        return masks;
    }
    if (shape.boundary) {
        masks.lambda1 = 0.5;
        masks.lambda2 = 0.25;
        masks.limit = {{{0, 0, 0}, 0.5}, {{1, 0, 0}, 0.5}};
        masks.tangent1 = {{{0, 0, 0}, 1}, {{1, 0, 0}, -1}};
        masks.tangent2 = {{{0, 0, 0}, -1}, {{1, 0, 0}, -1}, {{0, 0, 1}, 1}, {{1, 0, 1}, 1}};
        return masks;
    }
    masks.lambda1 = masks.lambda2 = lambda;
    const int k = shape.faces;
    for (int i = 0; i < k; ++i) {
        masks.limit.emplace_back(FanLabel{i, 0, 0}, 1.0 / k);
        masks.tangent1.emplace_back(FanLabel{i, 0, 0}, std::cos(2 * pi * i / k));
        masks.tangent2.emplace_back(FanLabel{i, 0, 0}, std::sin(2 * pi * i / k));
    }
    return masks;
}

}  // namespace

RuleStep doo_sabin_step(const RuleMesh& mesh, const RuleOptions& options) {
    return dual_step(mesh, options, DooSabin::weights);
}
RuleStep doo_sabin_catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options) {
    return dual_step(mesh, options, DooSabin::weights_catmull_clark);
}
RuleStep midedge_step(const RuleMesh& mesh, const RuleOptions& options) {
    return dual_step(mesh, options, Midedge::weights);
}
RuleStep midedge_simplest_step(const RuleMesh& mesh, const RuleOptions& options) {
    return dual_step(mesh, options, Midedge::weights_simplest);
}

ClosedMasks doo_sabin_closed_masks(const FanShape& shape, const RuleOptions&) { return closed_masks(shape, 0.5); }
ClosedMasks doo_sabin_catmull_clark_closed_masks(const FanShape& shape, const RuleOptions&) {
    return closed_masks(shape, 0.5 + std::cos(2 * pi / shape.faces) / 4);
}
ClosedMasks midedge_closed_masks(const FanShape& shape, const RuleOptions&) { return closed_masks(shape, 0.5); }
ClosedMasks midedge_simplest_closed_masks(const FanShape& shape, const RuleOptions&) {
    return closed_masks(shape, (1 + std::cos(2 * pi / shape.faces)) / 2);
}

}  // namespace tetrakis
