#include "uniform_tags.hpp"

#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <array>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

float half_beside(float sharpness, float neighbour) {
    return child_sharpness_chaikin(sharpness, std::array{sharpness, neighbour});
}

}  // namespace

UniformTags::UniformTags(const MeshLevel& base, CreaseMethod method, int levels) : base_(&base), method_(method) {
    if (!base.has_tags()) {
        steps_.emplace_back();
        return;
    }
    for (std::uint32_t v = 0; v < base.vertex_count; ++v)
        if (base.tagged[v] != 0) vertices_.push_back(v);
    vertex_sharpness_ = base.vertex_sharpness;
    ends_.resize(2 * std::size_t{base.edge_count});
    for (std::uint32_t e = 0; e < base.edge_count; ++e) {
        const float s = base.edge_sharpness[e];
        if (!is_sharp(s)) continue;
        sharp_edges_.push_back(e);
        ends_[2 * e] = ends_[2 * e + 1] = s;
        if (method == CreaseMethod::chaikin && is_semi_sharp(s)) pieces_[e] = {s};
    }
    for (int k = 0; k < levels; ++k) {
        const bool semi = !pieces_.empty() ||
                          std::any_of(sharp_edges_.begin(), sharp_edges_.end(),
                                      [&](std::uint32_t e) {
                                          return is_semi_sharp(ends_[2 * e]) || is_semi_sharp(ends_[2 * e + 1]);
                                      }) ||
                          std::any_of(vertices_.begin(), vertices_.end(),
                                      [&](std::uint32_t v) { return is_semi_sharp(vertex_sharpness_[v]); });
        advance();
        // What is left is sharp for ever: this step repeats itself.
        if (!semi) break;
    }
    segments_ = 1u << levels;
    if (steps_.empty()) steps_.emplace_back();
}

void UniformTags::gather(std::uint32_t v, const std::vector<float>& ends, std::vector<float>& around) const {
    around.clear();
    const std::uint32_t start = base_->vertex_halfedge[v];
    std::uint32_t h = start;
    do {
        around.push_back(ends[base_->edge_side[h]]);
        const std::uint32_t before = base_->prev(h);
        h = base_->twin[before];
        if (h == none) around.push_back(ends[base_->edge_side[before] ^ 1u]);
    } while (h != start && h != none);
}

void UniformTags::advance() {
    TagStep step;
    const std::uint32_t edges = base_->edge_count;
    std::vector<float> finer(ends_.size()), around, child;
    step.crease.assign(edges, 0.0f);
    for (const std::uint32_t e : sharp_edges_) {
        finer[2 * e] = child_sharpness(ends_[2 * e]);
        finer[2 * e + 1] = child_sharpness(ends_[2 * e + 1]);
    }
    if (!pieces_.empty()) {
        // The two ends see all sharp edges of their vertex.
        for (const std::uint32_t v : vertices_) {
            const std::uint32_t start = base_->vertex_halfedge[v];
            if (start == none) continue;
            gather(v, ends_, around);
            std::uint32_t h = start;
            do {
                const std::uint32_t before = base_->prev(h);
                const std::uint32_t side = base_->edge_side[h];
                finer[side] = child_sharpness_chaikin(ends_[side], around);
                h = base_->twin[before];
                if (h == none) {
                    const std::uint32_t last = base_->edge_side[before] ^ 1u;
                    finer[last] = child_sharpness_chaikin(ends_[last], around);
                }
            } while (h != start && h != none);
        }
    }
    for (const std::uint32_t e : sharp_edges_)
        step.crease[e] = static_cast<float>(edge_crease_weight(ends_[2 * e], finer[2 * e], finer[2 * e + 1]));
    for (auto& [e, pieces] : pieces_) {
        std::vector<float> halves(2 * pieces.size()), weights(2 * pieces.size() - 1);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            halves[2 * i] = i == 0 ? finer[2 * e] : half_beside(pieces[i], pieces[i - 1]);
            halves[2 * i + 1] = i + 1 == pieces.size() ? finer[2 * e + 1] : half_beside(pieces[i], pieces[i + 1]);
            weights[2 * i] = static_cast<float>(edge_crease_weight(pieces[i], halves[2 * i], halves[2 * i + 1]));
            if (i == 0) continue;
            const std::array around_vertex{pieces[i], 0.0f, pieces[i - 1], 0.0f};
            const std::array finer_around{halves[2 * i], 0.0f, halves[2 * i - 1], 0.0f};
            weights[2 * i - 1] =
                static_cast<float>(vertex_blend(around_vertex, 0.0f, finer_around, 0.0f).crease.weight);
        }
        step.varying.emplace(e, std::move(weights));
        pieces = std::move(halves);
    }
    std::erase_if(pieces_,
                  [](const auto& entry) { return std::none_of(entry.second.begin(), entry.second.end(), is_sharp); });

    std::vector<float> finer_vertex(vertex_sharpness_.size());
    for (const std::uint32_t v : vertices_) finer_vertex[v] = child_sharpness(vertex_sharpness_[v]);
    step.blend.resize(vertices_.size());
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
        const std::uint32_t v = vertices_[i];
        if (base_->vertex_halfedge[v] == none) {
            step.blend[i] = {.smooth = 0, .corner = 1};
            continue;
        }
        gather(v, ends_, around);
        gather(v, finer, child);
        step.blend[i] = vertex_blend(around, vertex_sharpness_[v], child, finer_vertex[v]);
    }
    ends_ = std::move(finer);
    vertex_sharpness_ = std::move(finer_vertex);
    segments_ *= 2;
    steps_.push_back(std::move(step));
}

float UniformTags::piece(std::uint32_t e, std::uint32_t i) const {
    const auto found = pieces_.find(e);
    return found != pieces_.end() ? found->second[i] : ends_[2 * e];
}

float UniformTags::half(std::uint32_t e, std::uint32_t i, std::uint32_t j) const {
    const float s = piece(e, i);
    if (method_ == CreaseMethod::uniform || !is_semi_sharp(s)) return child_sharpness(s);
    if (j == i && i > 0) return half_beside(s, piece(e, i - 1));
    if (j > i && j < segments_) return half_beside(s, piece(e, j));
    const std::uint32_t h = base_->edge_halfedge[e];
    std::vector<float> around;
    gather(base_->origin[j == 0 ? h : base_->next(h)], ends_, around);
    return child_sharpness_chaikin(s, around);
}

}  // namespace tetrakis::detail
