#include "edge_sharpness.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <array>

namespace tetrakis::detail {

namespace {

// k steps of child_sharpness() at once: subtracting one is exact below 2^24.
float after(float sharpness, int levels) {
    if (!is_semi_sharp(sharpness)) return sharpness;
    const auto fallen = static_cast<float>(levels);
    return sharpness > fallen ? sharpness - fallen : 0.0f;
}

float beside(float sharpness, float neighbour) {
    return child_sharpness_chaikin(sharpness, std::array{sharpness, neighbour});
}

}  // namespace

EdgeSharpness::EdgeSharpness(const ControlMesh& mesh) : mesh_(&mesh) {
    if (mesh.crease_method() != CreaseMethod::chaikin) return;
    std::vector<float> ends(2 * std::size_t{mesh.edge_count()});
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) ends[2 * e] = ends[2 * e + 1] = mesh.sharpness(EdgeId(e));
    if (std::none_of(ends.begin(), ends.end(), is_semi_sharp)) return;
    chaikin_ = true;
    const auto slot = [&](HalfedgeId h, bool at_target) {
        const EdgeId e = mesh.edge(h);
        return 2 * e.value + static_cast<std::uint32_t>((mesh.edge_halfedge(e) != h) != at_target);
    };
    ends_.push_back(ends);
    while (std::any_of(ends.begin(), ends.end(), is_semi_sharp)) {
        std::vector<float> finer(ends.size());
        for_each_block(mesh.vertex_count(), k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
            std::vector<std::uint32_t> slots;
            std::vector<float> around;
            for (std::uint32_t v = begin; v < end; ++v) {
                slots.clear();
                around.clear();
                const HalfedgeId start = mesh.vertex_halfedge(VertexId(v));
                if (!start.valid()) continue;
                HalfedgeId h = start;
                do {
                    slots.push_back(slot(h, false));
                    const HalfedgeId before = mesh.prev(h);
                    h = mesh.ccw_outgoing(h);
                    if (!h.valid()) slots.push_back(slot(before, true));
                } while (h.valid() && h != start);
                for (const std::uint32_t s : slots) around.push_back(ends[s]);
                for (const std::uint32_t s : slots) finer[s] = child_sharpness_chaikin(ends[s], around);
            }
        });
        ends = finer;
        ends_.push_back(std::move(finer));
    }
}

float EdgeSharpness::vertex(VertexId v, int level) const { return after(mesh_->sharpness(v), level); }

float EdgeSharpness::at_origin(HalfedgeId h, int level) const {
    const EdgeId e = mesh_->edge(h);
    const float s = mesh_->sharpness(e);
    if (!chaikin_ || !is_semi_sharp(s)) return after(s, level);
    const auto last = static_cast<int>(ends_.size()) - 1;
    return ends_[std::min(level, last)][2 * e.value + (mesh_->edge_halfedge(e) == h ? 0 : 1)];
}

float EdgeSharpness::piece(HalfedgeId h, int level, std::uint64_t i) const {
    const EdgeId e = mesh_->edge(h);
    const float s = mesh_->sharpness(e);
    if (!chaikin_ || !is_semi_sharp(s)) return after(s, level);
    return chaikin_piece(e, level, mesh_->edge_halfedge(e) == h ? i : (std::uint64_t{1} << level) - 1 - i);
}

float EdgeSharpness::chaikin_piece(EdgeId e, int level, std::uint64_t i) const {
    // No finite sharpness outlives the table of ends: what falls is at most the largest around, less one a level.
    if (level >= static_cast<int>(ends_.size())) return 0.0f;
    float left = 0, self = mesh_->sharpness(e), right = 0;  // neighbours on the edge, where there are any
    for (int l = 0; l < level && is_sharp(self); ++l) {
        const std::uint64_t at = i >> (level - l), last = (std::uint64_t{1} << l) - 1;
        const float first_half = at == 0 ? ends_[l + 1][2 * e.value] : beside(self, left);
        const float second_half = at == last ? ends_[l + 1][2 * e.value + 1] : beside(self, right);
        if ((i >> (level - l - 1) & 1) == 0) {
            left = at == 0 ? 0.0f : beside(left, self);
            self = first_half;
            right = second_half;
        } else {
            right = at == last ? 0.0f : beside(right, self);
            self = second_half;
            left = first_half;
        }
    }
    return self;
}

}  // namespace tetrakis::detail
