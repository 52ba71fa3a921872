#include "followed_uvs.hpp"

#include "../rules/rule_refiner.hpp"
#include "uv_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Interpolates UVs by the stencils of a step.
std::vector<Vec2d> next_uvs(const StencilTable& stencils, const std::vector<Vec2d>& uvs) {
    std::vector<Vec2d> finer(static_cast<std::size_t>(stencils.row_count()));
    apply(stencils, uvs.data(), finer.data());
    return finer;
}

/// The mesh and its charts on the same level, and the partners of its half-edges in the charts.
class SideBySide {
  public:
    SideBySide(RuleMesh surface, SeamExtension charts, std::vector<int> partner, const SchemeInfo& scheme,
               const RuleOptions& rules)
        : surface_(std::move(surface)),
          charts_(std::move(charts)),
          scheme_(scheme),
          rules_(rules),
          partner_(std::move(partner)) {
        home_.resize(surface_.halfedge_count());
        for (int h = 0; h < surface_.halfedge_count(); ++h) home_[h] = surface_.face(h);
    }

    /// @param linear  refine the charts linearly; for triangle schemes
    void refine(bool linear) {
        // If all edges and vertices are sharp, each rule of a triangle scheme is linear.
        if (linear) charts_.mesh = charts_.mesh.with_tags([](float) { return k_sharpness_infinity; }, {});
        RuleStep step = scheme_.step(surface_, rules_), chart_step = scheme_.step(charts_.mesh, rules_);
        charts_.uvs = next_uvs(chart_step.stencils, charts_.uvs);
        const auto halfedges = static_cast<std::size_t>(step.mesh.halfedge_count());
        const std::vector<int> old_partner = std::exchange(partner_, std::vector<int>(halfedges, RuleMesh::none)),
                               old_home = std::exchange(home_, std::vector<int>(halfedges, RuleMesh::none)),
                               old_corner = std::exchange(corner_, std::vector<int>(halfedges, 0));
        const bool first = old_corner.empty();
        std::vector<char> child(step.mesh.vertex_count(), 0);
        std::vector<int> queue;
        const auto set = [&](int h, int partner, int home, int corner) {
            if (partner == RuleMesh::none || partner_[h] != RuleMesh::none) return;
            partner_[h] = partner;
            home_[h] = home;
            corner_[h] = corner;
            queue.push_back(h);
        };
        for (int h = 0; h < surface_.halfedge_count(); ++h) {
            const int a = step.child_halfedge[h];
            if (a == RuleMesh::none || old_partner[h] == RuleMesh::none) continue;
            child[step.mesh.origin(a)] = 1;
            set(a, chart_step.child_halfedge[old_partner[h]], old_home[h], first ? 0 : old_corner[h]);
        }
        const RuleMesh &fine = step.mesh, &chart = chart_step.mesh;
        const auto twin = [](const RuleMesh& mesh, int h) { return h == RuleMesh::none ? h : mesh.twin(h); };
        // sqrt3 cuts every triangle in nine, also at seams: no triangle lies across one.
        for (std::size_t i = 0; i < queue.size() && scheme_.refinement == Refinement::sqrt3; ++i) {
            const int h = queue[i], p = partner_[h];
            set(fine.next(h), chart.next(p), home_[h], corner_[h]);
            if (const int t = fine.twin(h); t != RuleMesh::none) set(t, chart.twin(p), home_[h], corner_[h]);
        }
        // Around the children of corners, which lie on one side of every seam; then along faces to the other points. A
        // point at the end of a seam or crease is reached from the left.
        for (std::size_t i = 0; i < queue.size(); ++i) {
            const int h = queue[i], p = partner_[h];
            if (const int left = twin(fine, fine.prev(h)); left != RuleMesh::none)
                set(left, twin(chart, chart.prev(p)), home_[h], corner_[h]);
            if (const int t = twin(fine, h), q = twin(chart, p); t != RuleMesh::none && q != RuleMesh::none)
                set(fine.next(t), chart.next(q), home_[h], corner_[h]);
        }
        const auto behind = [&](int h) {
            if (const int b = fine.prev(h); child[fine.origin(b)] == 0)
                set(b, chart.prev(partner_[h]), home_[h], corner_[h]);
        };
        const auto ahead = [&](int h) {
            if (const int n = fine.next(h); child[fine.origin(n)] == 0)
                set(n, chart.next(partner_[h]), home_[h], corner_[h]);
        };
        const std::size_t children = queue.size();
        for (std::size_t i = 0; i < children; ++i) behind(queue[i]);
        for (std::size_t i = 0; i < children; ++i) ahead(queue[i]);
        for (std::size_t i = children; i < queue.size(); ++i) behind(queue[i]);
        for (std::size_t i = children; i < queue.size(); ++i) ahead(queue[i]);
        // Honeycomb's old vertices and corners of faces do not meet themselves.
        if (first && scheme_.refinement != Refinement::honeycomb) std::iota(corner_.begin(), corner_.end(), 0);
        surface_ = std::move(step.mesh);
        charts_.mesh = std::move(chart_step.mesh);
    }

    FollowedUvs result() {
        FollowedUvs out;
        if (std::find(partner_.begin(), partner_.end(), RuleMesh::none) != partner_.end()) return out;
        out.uvs = std::move(charts_.uvs);
        out.face_uvs.resize(surface_.halfedge_count());
        out.control_face.resize(surface_.face_count());
        for (int f = 0; f < surface_.face_count(); ++f) face(f, out);
        return out;
    }

  private:
    /// Sets the UVs of a face's corners, from one side of the seams that it crosses.
    void face(int f, FollowedUvs& out) const {
        const int begin = surface_.face_begin(f), size = surface_.face_size(f);
        const auto at = [&](int i) { return static_cast<std::size_t>(begin + i % size); };
        const auto uv = [&](int partner) { return static_cast<std::uint32_t>(charts_.mesh.origin(partner)); };
        const auto home = [&](int i) { return static_cast<std::uint32_t>(home_[at(i)]); };
        for (int i = 0; i < size; ++i) out.face_uvs[at(i)] = uv(partner_[at(i)]);
        // If a seam passes an interior vertex of two faces, both of its sides meet twice in the faces across it. Then
        // the parts in one control face come from two corners of level 1.
        const SeamRun run = longest_run(
            size, [&](int i) { return charts_.mesh.next(partner_[at(i)]) == partner_[at(i + 1)]; },
            [&](int i) { return std::pair(home(i), corner_.empty() ? 0 : corner_[at(i)]); });
        out.control_face[f] = home_of(run, size, home);
        if (run.size == size) return;
        std::vector<std::uint32_t> beyond;
        for (int p = charts_.mesh.next(partner_[at(run.first + run.size - 1)]); p != partner_[at(run.first)];
             p = charts_.mesh.next(p))
            beyond.push_back(uv(p));
        for_each_beyond(run, size, static_cast<int>(beyond.size()), [&](int i, std::size_t k, double t) {
            if (t == 0 || t == 1) {
                out.face_uvs[at(i)] = beyond[t == 0 ? k : k + 1];
            } else {
                out.face_uvs[at(i)] = static_cast<std::uint32_t>(out.uvs.size());
                out.uvs.push_back((1 - t) * out.uvs[beyond[k]] + t * out.uvs[beyond[k + 1]]);
            }
        });
    }

    RuleMesh surface_;
    SeamExtension charts_;
    const SchemeInfo& scheme_;
    const RuleOptions& rules_;
    std::vector<int> partner_;  ///< per half-edge of the surface, its partner in the charts
    std::vector<int> home_;     ///< per half-edge, the control face of its origin
    std::vector<int> corner_;   ///< dual: per half-edge, its half-edge of level 1; empty on the control mesh
};

}  // namespace

bool extends_charts(const SchemeInfo& scheme, const RuleOptions& rules) {
    const int steps = scheme.has_chosen_steps() ? rules.averaging_steps : 0;
    return steps > 0 && steps % 2 == 0 && (steps > 2 || rules.averaging_boundary == AveragingBoundary::recede);
}

FollowedUvs follow_uvs(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RuleOptions& rules) {
    const ParallelBlocks runner;
    RuleOptions with_runner = rules;
    with_runner.runner = &runner;
    RuleMesh surface = rule_mesh(mesh);
    const bool triangles = scheme.refinement == Refinement::sqrt3,
               linear = triangles && mesh.face_varying_rule() == FaceVaryingRule::linear_all;
    SeamExtension charts;
    if (triangles) {
        const ControlMesh cut = uv_mesh(mesh);
        charts.mesh = rule_mesh(cut);
        charts.uvs.assign(cut.positions().begin(), cut.positions().end());
    } else {
        charts = extend_over_seams(mesh, surface, scheme, rules);
    }
    std::vector<int> partner(static_cast<std::size_t>(surface.halfedge_count()));
    std::iota(partner.begin(), partner.end(), 0);
    try {
        SideBySide both(std::move(surface), std::move(charts), std::move(partner), scheme, with_runner);
        for (int level = 0; level < levels; ++level) both.refine(linear);
        FollowedUvs result = both.result();
        if (triangles) result.control_face.clear();  // each triangle lies in one control face
        return result;
    } catch (const std::invalid_argument&) {
        return {};  // the surface is a mesh, but receding boundaries may leave less of its charts
    }
}

}  // namespace tetrakis::detail
