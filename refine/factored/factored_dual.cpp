#include "../../schemes/parts/vertex_split.hpp"
#include "../../schemes/rules/dual_schemes.hpp"
#include "factored_faces.hpp"

#include <cassert>

namespace tetrakis::detail {

namespace {

using Mask = FactoredCornerMask (*)(int);

Mask mask_of(FactoredScheme scheme) {
    switch (scheme) {
        case FactoredScheme::doo_sabin_catmull_clark:
            return factored_doo_sabin_catmull_clark;
        case FactoredScheme::midedge:
            return factored_midedge;
        case FactoredScheme::midedge_simplest:
            return factored_midedge_simplest;
        default:
            return factored_doo_sabin;
    }
}

/// The dual schemes.
class FactoredDual final : public FactoredFaces {
  public:
    FactoredDual(const ControlMesh& control, FactoredScheme scheme) : FactoredFaces(control), mask_(mask_of(scheme)) {
        put_centres();
        set_states();
    }

  private:
    void make_half_step() override {
        if (done_ == 0)
            insert_midpoints();
        else
            insert_corners();
        done_ = 1 - done_;
        set_states();
    }

    Room room(int done) const override {
        constexpr std::uint64_t k_growth_at_creases = 6;
        return done == 1 ? Room{k_growth_at_creases, k_per_finer} : Room{1, k_per_halfedge};
    }

    // Second half-step.
    void insert_corners() {
        check_halfedge_count(positions_.size(), 1, k_next);  // old points are kept
        const auto first = static_cast<std::uint32_t>(positions_.size());
        const auto row = [&](const Vec3d& p) {
            add(p);
            return StencilRow{};
        };
        const RuleStep step = split_vertices(
            mesh_, nullptr, [&](int h) { return row(corner(h)); },
            [&](int h, int near) {
                // 3/4 of the near end and 1/4 of the far one.
                return row(0.5 * (positions_[vertex_[near]] + positions_[midpoint_[mesh_.edge(h)]]));
            },
            [&](int v) { return row(positions_[vertex_[v]]); });
        std::vector<std::uint32_t> centres = next_centres(step.mesh);
        mesh_ = step.mesh;
        centre_ = std::move(centres);
        midpoint_.clear();
        vertex_.resize(mesh_.vertex_count());
        for (std::size_t v = 0; v < vertex_.size(); ++v) vertex_[v] = first + static_cast<std::uint32_t>(v);
        whole_ = false;
        rest_centres();
    }

    /// The new point at the origin of h, by way of its face's centre.
    Vec3d corner(int h) {
        const int f = mesh_.face(h), k = mesh_.face_size(f);
        if (static_cast<int>(masks_.size()) <= k) masks_.resize(k + 1);
        FactoredCornerMask& mask = masks_[k];
        if (mask.midpoint.empty()) mask = mask_(k);
        Vec3d point(0);
        if (mask.corner != 0) point += mask.corner * positions_[vertex_[mesh_.origin(h)]];
        if (mask.centre != 0) point += mask.centre * positions_[centre_[f]];
        for (int i = 0, at = h; i < k; ++i, at = mesh_.next(at))
            if (mask.midpoint[i] != 0) point += mask.midpoint[i] * positions_[midpoint_[mesh_.edge(at)]];
        return point;
    }

    /// Centres of the next mesh's faces, in the order of split_vertices(): old centres, midpoints, old vertices. The
    /// second side of a crease has its own centre, and so has each further sector of a vertex.
    std::vector<std::uint32_t> next_centres(const RuleMesh& next) {
        std::vector<std::uint32_t> result;
        const auto use = [&](std::uint32_t old, bool again) { result.push_back(again ? add(positions_[old]) : old); };
        for_each_split_face(
            mesh_, [&](int f) { use(centre_[f], false); },
            [&](int h) {
                const int e = mesh_.edge(h);
                use(midpoint_[e], mesh_.sharp(h) && mesh_.edge_halfedge(e) != h);
            },
            [&](int v, int sector) { use(vertex_[v], sector > 0); });
        assert(static_cast<int>(result.size()) == next.face_count());
        static_cast<void>(next);
        return result;
    }

    Mask mask_;
    std::vector<FactoredCornerMask> masks_;  ///< by number of corners
};

}  // namespace

std::unique_ptr<FactoredFaces> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme) {
    return std::make_unique<FactoredDual>(mesh, scheme);
}

}  // namespace tetrakis::detail
