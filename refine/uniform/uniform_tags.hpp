#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "mesh_level.hpp"

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

/// What tags do in one step of structured refinement: everything sharp lies on the sides of the roots.
struct TagStep {
    std::vector<float> crease;       ///< per base edge: weight of the crease rule, all along it; empty: no tags
    std::vector<VertexBlend> blend;  ///< of the base level's tagged vertices, in the order of UniformTags::vertices()
    /// Edges whose pieces differ (Chaikin): the weight at each inner vertex of the next level, 2 N - 1 of them.
    std::unordered_map<std::uint32_t, std::vector<float>> varying;
};

/// The tags of a base level followed level by level, without points: once per mesh.
class UniformTags {
  public:
    UniformTags() = default;
    /// @param base    outlives this
    /// @param levels  steps below the base level
    UniformTags(const MeshLevel& base, CreaseMethod method, int levels);

    /// Tagged vertices of the base level, ascending.
    std::span<const std::uint32_t> vertices() const { return vertices_; }
    /// The step from level k below the base to level k + 1.
    const TagStep& step(int k) const {
        return steps_[static_cast<std::size_t>(k) < steps_.size() ? static_cast<std::size_t>(k) : steps_.size() - 1];
    }

    /// Whether anything is sharp; if not, what follows is not to be asked.
    bool any() const { return !ends_.empty(); }
    // Of the last level, for limits: sharpness of the piece of h at its start, at its end, of piece i of edge e, of a
    // base vertex.
    float at_origin(std::uint32_t h) const { return ends_[base_->edge_side[h]]; }
    float at_target(std::uint32_t h) const { return ends_[base_->edge_side[h] ^ 1u]; }
    float piece(std::uint32_t e, std::uint32_t i) const;
    bool is_smooth(std::uint32_t e) const {
        return !is_sharp(ends_[2 * e]) && !is_sharp(ends_[2 * e + 1]) && !pieces_.contains(e);
    }
    float vertex(std::uint32_t v) const { return vertex_sharpness_[v]; }
    /// What the half of piece i at the edge's vertex j (i or i + 1) gets one level further down.
    float half(std::uint32_t e, std::uint32_t i, std::uint32_t j) const;

  private:
    void advance();
    VertexBlend corner_blend(std::uint32_t v, const std::vector<float>& finer_ends) const;
    /// Sharpness around a base vertex, counter-clockwise from its first half-edge.
    void gather(std::uint32_t v, const std::vector<float>& ends, std::vector<float>& around) const;

    const MeshLevel* base_ = nullptr;
    CreaseMethod method_ = CreaseMethod::uniform;
    std::vector<std::uint32_t> vertices_;
    std::vector<std::uint32_t> sharp_edges_;  ///< of the base level
    std::vector<TagStep> steps_;
    // The level reached. Ends: [2 e + side], the piece at the edge's start and end; both for an edge whose pieces are
    // alike. Pieces: of semi-sharp edges under Chaikin creasing.
    std::vector<float> ends_, vertex_sharpness_;
    std::unordered_map<std::uint32_t, std::vector<float>> pieces_;
    std::uint32_t segments_ = 1;
};

}  // namespace tetrakis::detail
