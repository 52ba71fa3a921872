#include "sharpness.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

VertexRule vertex_rule(std::span<const float> edge_sharpness, float vertex_sharpness) {
    if (is_sharp(vertex_sharpness)) return VertexRule::corner;
    const auto count = std::count_if(edge_sharpness.begin(), edge_sharpness.end(), is_sharp);
    switch (count) {
        case 0:
            return VertexRule::smooth;
        case 1:
            return VertexRule::dart;
        case 2:
            return VertexRule::crease;
        default:
            return VertexRule::corner;
    }
}

float child_sharpness(float sharpness) {
    if (std::isinf(sharpness)) return sharpness;
    return sharpness > 1.0f ? sharpness - 1.0f : 0.0f;
}

float child_sharpness_chaikin(float sharpness, std::span<const float> edges_at_end) {
    if (!is_semi_sharp(sharpness)) return is_sharp(sharpness) ? sharpness : 0.0f;
    float sum = 0.0f;
    int count = 0;
    for (const float s : edges_at_end)
        if (is_semi_sharp(s)) {
            sum += s;
            ++count;
        }
    if (count < 2) return child_sharpness(sharpness);
    const float others = (sum - sharpness) / static_cast<float>(count - 1);
    return std::max(0.75f * sharpness + 0.25f * others - 1.0f, 0.0f);
}

namespace {

void add_rule(VertexBlend& blend, double weight, VertexRule rule, std::span<const float> edge_sharpness) {
    switch (rule) {
        case VertexRule::smooth:
        case VertexRule::dart:
            blend.smooth += weight;
            break;
        case VertexRule::corner:
            blend.corner += weight;
            break;
        case VertexRule::crease: {
            const int n = static_cast<int>(edge_sharpness.size());
            int a = 0, b = n - 1;
            while (!is_sharp(edge_sharpness[a])) ++a;
            while (!is_sharp(edge_sharpness[b])) --b;
            blend.crease = {blend.crease.weight + weight, a, b};
            break;
        }
    }
}

}  // namespace

VertexBlend vertex_blend(std::span<const float> edge_sharpness, float vertex_sharpness,
                         std::span<const float> child_edge_sharpness, float child_vertex_sharpness) {
    VertexBlend blend{.smooth = 0};
    const VertexRule parent = vertex_rule(edge_sharpness, vertex_sharpness);
    const VertexRule child = vertex_rule(child_edge_sharpness, child_vertex_sharpness);
    const bool parent_smooth = parent == VertexRule::smooth || parent == VertexRule::dart;
    if (parent_smooth || parent == child) {
        add_rule(blend, 1, parent, edge_sharpness);
        return blend;
    }
    // The mean is a float, as the peers' is: a weight that differs by 6e-8 moves points by more than the golden
    // tolerance. The sum is not: it would depend on where the ring starts.
    double sum = 0;
    int count = 0;
    if (is_sharp(vertex_sharpness) && !is_sharp(child_vertex_sharpness)) {
        sum = vertex_sharpness;
        count = 1;
    }
    for (std::size_t i = 0; i < edge_sharpness.size(); ++i)
        if (is_sharp(edge_sharpness[i]) && !is_sharp(child_edge_sharpness[i])) {
            sum += edge_sharpness[i];
            ++count;
        }
    const double w = count == 0 ? 0.0 : std::min(1.0, static_cast<double>(static_cast<float>(sum / count)));
    add_rule(blend, w, parent, edge_sharpness);
    add_rule(blend, 1 - w, child, child_edge_sharpness);
    return blend;
}

double edge_crease_weight(float sharpness, float child_a, float child_b) {
    if (!is_sharp(sharpness)) return 0;
    if (is_sharp(child_a) && is_sharp(child_b)) return 1;
    return static_cast<double>(sharpness);
}

}  // namespace tetrakis
