#include "tetrakis/schemes/factored_dual.hpp"
#include "tetrakis/hier/error.hpp"
#include "tetrakis/refine/factored_steps.hpp"
#include "tetrakis/refine/rule_refinement.hpp"
#include "tetrakis/schemes/doo_sabin.hpp"
#include "tetrakis/schemes/vertex_split.hpp"

#include <cassert>
#include <limits>
#include <stdexcept>

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

/// The dual schemes. The scheme's own mesh is mesh_; the 4-8 mesh has its vertices, a centre in each of its faces and,
/// after the first half-step, a midpoint on each edge.
class FactoredDual final : public FactoredSteps {
  public:
    FactoredDual(const ControlMesh& control, FactoredScheme scheme) : mesh_(as_rules(control)), mask_(mask_of(scheme)) {
        positions_.assign(control.positions().begin(), control.positions().end());
        vertex_.resize(mesh_.vertex_count());
        for (std::size_t v = 0; v < vertex_.size(); ++v) vertex_[v] = static_cast<std::uint32_t>(v);
        centre_.resize(mesh_.face_count());
        for (std::uint32_t& c : centre_) c = add({});
        rest_centres(nullptr);
        set_states();
    }

    void half_step(FactoredTrace* trace) override {
        // Two half-steps make four half-edges of one (more at creases), each with its point, triangle and stencil row.
        constexpr std::uint64_t k_per_halfedge = 240;
        const auto halfedges = static_cast<std::uint64_t>(mesh_.halfedge_count());
        check_memory(k_per_halfedge * halfedges * (midpoint_.empty() ? 1 : 4));
        if (midpoint_.empty())
            insert_midpoints(trace);
        else
            insert_corners(trace);
        set_states();
    }

    FactoredVertex state(std::uint32_t v) const override { return state_[v]; }

    std::vector<std::array<std::uint32_t, 3>> triangles() const override {
        std::vector<std::array<std::uint32_t, 3>> result;
        for (int h = 0; h < mesh_.halfedge_count(); ++h) {
            const std::uint32_t u = vertex_[mesh_.origin(h)], w = vertex_[mesh_.target(h)];
            const std::uint32_t c = centre_[mesh_.face(h)];
            const int t = mesh_.twin(h);
            if (!midpoint_.empty()) {
                const std::uint32_t s = midpoint_[mesh_.edge(h)];
                result.push_back({u, s, c});
                result.push_back({s, w, c});
            } else if (whole_ || t == RuleMesh::none || mesh_.sharp(h)) {
                result.push_back({u, w, c});
            } else {
                // The block across the edge is still cut from centre to centre.
                result.push_back({u, centre_[mesh_.face(t)], c});
            }
        }
        return result;
    }

    PolygonMesh mesh() const override {
        PolygonMesh result;
        result.positions = positions_;
        result.face_offsets.push_back(0);
        for (const auto& t : triangles()) add_face(result, t);
        drop_unused_vertices(result);
        return result;
    }

    PolygonMesh active_mesh() const override {
        PolygonMesh result;
        result.positions = positions_;
        result.face_offsets.push_back(0);
        for (int f = 0; f < mesh_.face_count(); ++f) {
            std::vector<std::uint32_t> corners;
            for (const int v : mesh_.corners(f)) corners.push_back(vertex_[v]);
            add_face(result, corners);
        }
        drop_unused_vertices(result);
        return result;
    }

  private:
    /// What a rule sees: all reads of rules pass here.
    class Reader {
      public:
        Reader(const std::vector<Vec3d>& points, FactoredTrace* trace, std::size_t computed)
            : points_(points), trace_(trace), computed_(static_cast<std::uint32_t>(computed)) {}
        const Vec3d& operator()(std::uint32_t v) const {
            if (trace_ != nullptr) trace_->reads.emplace_back(computed_, v);
            return points_[v];
        }

      private:
        const std::vector<Vec3d>& points_;
        FactoredTrace* trace_;
        std::uint32_t computed_;
    };

    static RuleMesh as_rules(const ControlMesh& control) {
        if (control.halfedge_count() > k_most_halfedges) refuse();
        return rule_mesh(control);
    }
    [[noreturn]] static void refuse() {
        throw Error(ErrorCode::unsupported, "so many half-steps have more elements than 31 bits can count");
    }

    std::uint32_t add(const Vec3d& p) {
        positions_.push_back(p);
        return static_cast<std::uint32_t>(positions_.size() - 1);
    }
    template <class Corners>
    static void add_face(PolygonMesh& mesh, const Corners& corners) {
        mesh.face_vertices.insert(mesh.face_vertices.end(), corners.begin(), corners.end());
        mesh.face_offsets.push_back(static_cast<std::uint32_t>(mesh.face_vertices.size()));
    }

    // First half-step.
    void insert_midpoints(FactoredTrace* trace) {
        positions_.reserve(positions_.size() + static_cast<std::size_t>(mesh_.edge_count()));
        midpoint_.resize(mesh_.edge_count());
        for (int e = 0; e < mesh_.edge_count(); ++e) {
            const int h = mesh_.edge_halfedge(e);
            const Reader read(positions_, trace, positions_.size());
            midpoint_[e] = add(0.5 * (read(vertex_[mesh_.origin(h)]) + read(vertex_[mesh_.target(h)])));
        }
    }

    // Second half-step.
    void insert_corners(FactoredTrace* trace) {
        // A step makes four half-edges of one, and up to six at creases; positions are kept.
        constexpr std::uint32_t k_growth = 6;
        if (static_cast<std::uint32_t>(mesh_.halfedge_count()) > k_most_halfedges / k_growth ||
            positions_.size() > k_most_halfedges)
            refuse();
        const auto first = static_cast<std::uint32_t>(positions_.size());
        const auto row = [&](const Vec3d& p) {
            add(p);
            return StencilRow{};
        };
        const RuleStep step = split_vertices(
            mesh_, nullptr, [&](int h) { return row(corner(h, trace)); },
            [&](int h, int near) {
                const Reader read(positions_, trace, positions_.size());
                // 3/4 and 1/4 of the ends.
                return row(0.5 * (read(vertex_[near]) + read(midpoint_[mesh_.edge(h)])));
            },
            [&](int v) {
                const Reader read(positions_, trace, positions_.size());
                return row(read(vertex_[v]));
            });
        std::vector<std::uint32_t> centres = next_centres(step.mesh);
        mesh_ = step.mesh;
        centre_ = std::move(centres);
        midpoint_.clear();
        vertex_.resize(mesh_.vertex_count());
        for (std::size_t v = 0; v < vertex_.size(); ++v) vertex_[v] = first + static_cast<std::uint32_t>(v);
        whole_ = false;
        rest_centres(trace);
    }

    /// The new point at the origin of h, through the centre of its face.
    Vec3d corner(int h, FactoredTrace* trace) {
        const int f = mesh_.face(h), k = mesh_.face_size(f);
        if (static_cast<int>(masks_.size()) <= k) masks_.resize(k + 1);
        FactoredCornerMask& mask = masks_[k];
        if (mask.midpoint.empty()) mask = mask_(k);
        const Reader read(positions_, trace, positions_.size());
        Vec3d point(0);
        if (mask.corner != 0) point += mask.corner * read(vertex_[mesh_.origin(h)]);
        if (mask.centre != 0) point += mask.centre * read(centre_[f]);
        for (int i = 0, at = h; i < k; ++i, at = mesh_.next(at))
            if (mask.midpoint[i] != 0) point += mask.midpoint[i] * read(midpoint_[mesh_.edge(at)]);
        return point;
    }

    /// Centres of the next mesh's faces, in the order of split_vertices(): old centres, midpoints, old vertices. A
    /// crease's second side gets a centre of its own, and so do a vertex' further sectors.
    std::vector<std::uint32_t> next_centres(const RuleMesh& next) {
        std::vector<std::uint32_t> result = centre_;
        const auto use = [&](std::uint32_t old, bool again) { result.push_back(again ? add(positions_[old]) : old); };
        for (int h = 0; h < mesh_.halfedge_count(); ++h) {
            const std::uint32_t s = midpoint_[mesh_.edge(h)];
            if (mesh_.sharp(h))
                use(s, mesh_.edge_halfedge(mesh_.edge(h)) != h);
            else if (h < mesh_.twin(h))
                use(s, false);
        }
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            if (mesh_.first(v) == RuleMesh::none) continue;
            const int sharp = static_cast<int>(mesh_.sharp_neighbours(v).size());
            if (sharp == 0 && mesh_.ring(v).faces() < 3) continue;
            const int sectors = sharp < 2 ? 1 : mesh_.on_boundary(v) ? sharp - 1 : sharp;
            for (int i = 0; i < sectors; ++i) use(vertex_[v], i > 0);
        }
        assert(static_cast<int>(result.size()) == next.face_count());
        static_cast<void>(next);
        return result;
    }

    /// Centres rest at the mean of the corners around them.
    void rest_centres(FactoredTrace* trace) {
        for (int f = 0; f < mesh_.face_count(); ++f) {
            const Reader read(positions_, trace, centre_[f]);
            Vec3d sum(0);
            for (const int v : mesh_.corners(f)) sum += read(vertex_[v]);
            positions_[centre_[f]] = sum / static_cast<double>(mesh_.face_size(f));
        }
    }

    void set_states() {
        state_.assign(positions_.size(), FactoredVertex::unused);
        for (int v = 0; v < mesh_.vertex_count(); ++v)
            if (mesh_.first(v) != RuleMesh::none) state_[vertex_[v]] = FactoredVertex::active;
        for (const std::uint32_t c : centre_) state_[c] = FactoredVertex::inactive;
        for (const std::uint32_t s : midpoint_) state_[s] = FactoredVertex::active;
    }

    static constexpr std::uint32_t k_most_halfedges = std::numeric_limits<int>::max();

    RuleMesh mesh_;
    Mask mask_;
    std::vector<FactoredCornerMask> masks_;       ///< by number of corners
    std::vector<std::uint32_t> vertex_, centre_;  ///< numbers of the mesh's vertices and of its faces' centres
    std::vector<std::uint32_t> midpoint_;         ///< of edges; empty but between the two half-steps
    std::vector<FactoredVertex> state_;
    bool whole_ = true;  ///< the mesh's edges are edges of the 4-8 mesh: not after the second half-step
};

}  // namespace

std::unique_ptr<FactoredSteps> make_factored_dual(const ControlMesh& mesh, FactoredScheme scheme) {
    return std::make_unique<FactoredDual>(mesh, scheme);
}

}  // namespace tetrakis::detail
