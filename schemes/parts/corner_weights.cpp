#include "corner_weights.hpp"

#include "face_split.hpp"
#include "vertex_split.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis::detail {

using std::numbers::pi;

FaceWeights::FaceWeights(const RuleMesh& mesh, CornerWeights weights) : mesh_(mesh) {
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int k = mesh.face_size(f);
        if (static_cast<int>(of_size_.size()) <= k) of_size_.resize(k + 1);
        if (of_size_[k].empty()) of_size_[k] = weights(k);
    }
}

RuleStep corner_weights_step(const RuleMesh& mesh, const RuleOptions& options, CornerWeights weights) {
    const FaceWeights faces(mesh, weights);
    return split_vertices(
        mesh, options.runner,
        [&](int h) {
            StencilRow row;
            faces.add_corner(h, 1, row);
            return row;
        },
        [&](int h, int near) {
            const int far = mesh.origin(h) == near ? mesh.target(h) : mesh.origin(h);
            return StencilRow{{near, ChaikinWeights::near_end}, {far, ChaikinWeights::far_end}};
        },
        vertex_itself);
}

ClosedMasks corner_weights_closed_masks(const FanShape& shape, const RuleOptions&) {
    if (shape.corner) return corner_closed_masks(1, false);
    if (shape.boundary)
        return {.limit = {{{0, 0, 0}, 0.5}, {{1, 0, 0}, 0.5}},
                .tangent1 = {{{0, 0, 0}, 1}, {{1, 0, 0}, -1}},
                .tangent2 = {{{0, 0, 0}, -1}, {{1, 0, 0}, -1}, {{0, 0, 1}, 1}, {{1, 0, 1}, 1}}};
    ClosedMasks masks;
    const int k = shape.faces;
    for (int i = 0; i < k; ++i) {
        masks.limit.emplace_back(FanLabel{i, 0, 0}, 1.0 / k);
        masks.tangent1.emplace_back(FanLabel{i, 0, 0}, std::cos(2 * pi * i / k));
        masks.tangent2.emplace_back(FanLabel{i, 0, 0}, std::sin(2 * pi * i / k));
    }
    return masks;
}

}  // namespace tetrakis::detail
