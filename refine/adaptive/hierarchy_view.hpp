#pragma once

#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../hier/trees/triangle_forest.hpp"
#include "../families/error_estimator.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <functional>
#include <span>
#include <tuple>
#include <vector>

namespace tetrakis {

/// Common part of the adapters for forests of lattice triangles.
struct LatticeView {
    using Triangle = CellTriangle;
    using Key = std::array<std::uint32_t, 8>;

    static Key key(const CellTriangle& t) {
        return {t.root.value,  t.level,       t.corner[0].x, t.corner[0].y,
                t.corner[1].x, t.corner[1].y, t.corner[2].x, t.corner[2].y};
    }
};

/// A 4-8 bisection forest, adapted to AdaptiveRefinement, with the coarsest mesh of eval/README.md: a face whose fan
/// was accepted has no centre until one of its roots is split, for its own error or to keep the mesh conforming.
class BisectionHierarchy : public LatticeView {
  public:
    explicit BisectionHierarchy(const ControlMesh& mesh)
        : forest_(mesh), fans_(mesh.face_count(), 0), fan_errors_(mesh.face_count(), 0.0) {}
    explicit BisectionHierarchy(const ControlMesh&&) = delete;

    /// Outputs a face as a fan without its centre; all roots of the face must be leaves.
    void accept_fan(FaceId face, double error) {
        active_fans_ += !fans_[face.value];
        fans_[face.value] = 1;
        fan_errors_[face.value] = error;
    }
    /// Calls visit(face, error of its fan) for the faces without a centre.
    template <class Visit>
    void for_each_fan(Visit&& visit) const {
        for (std::uint32_t f = 0; f < fans_.size(); ++f)
            if (fans_[f]) visit(FaceId(f), fan_errors_[f]);
    }
    double fan_error(FaceId face) const { return fan_errors_[face.value]; }
    const BisectionForest& forest() const { return forest_; }
    const std::vector<std::uint8_t>& fans() const { return fans_; }

    std::uint32_t slots() const { return forest_.leaf_slots(); }
    bool is_leaf(LeafId leaf) const { return forest_.is_leaf(leaf); }
    int level(LeafId leaf) const { return forest_.depth(leaf) / 2; }
    bool must_split(LeafId) const { return false; }
    Key key(LeafId leaf) const { return LatticeView::key(forest_.triangle(leaf)); }
    std::uint64_t triangle_count() const { return forest_.leaf_count() - 2 * active_fans_; }

    void initial_leaves(std::vector<LeafId>& leaves) const {
        for (std::uint32_t i = 0; i < forest_.leaf_slots(); ++i)
            if (const LeafId leaf(i); forest_.is_leaf(leaf) && !fans_[forest_.face(leaf).value]) leaves.push_back(leaf);
    }
    int triangles(LeafId leaf, std::array<CellTriangle, 3>& parts) const {
        parts[0] = forest_.triangle(leaf);
        return 1;
    }
    /// Splits the marked leaves and what must be split with them. @param fresh  receives (appended) the leaves to be
    /// estimated: new leaves, and leaves that were hidden by a fan.
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& fresh) {
        forest_.refine(marked, created_);
        fresh.insert(fresh.end(), created_.begin(), created_.end());
        for (LeafId leaf : created_) open(forest_.face(leaf), fresh);
    }
    /// Gives a face its centre back. @param fresh  receives (appended) the leaves of the face that are still roots
    void open(FaceId face, std::vector<LeafId>& fresh) {
        if (!fans_[face.value]) return;
        fans_[face.value] = 0;
        --active_fans_;
        const ControlMesh& mesh = forest_.mesh();
        const std::uint32_t h0 = mesh.face_halfedge(face).value;
        for (std::uint32_t i = 0; i < mesh.face_size(face); ++i)
            if (const LeafId leaf = forest_.root_leaf(HalfedgeId(h0 + i)); leaf.valid()) fresh.push_back(leaf);
    }

  private:
    BisectionForest forest_;
    std::vector<std::uint8_t> fans_;
    std::vector<double> fan_errors_;
    std::uint64_t active_fans_ = 0;
    std::vector<LeafId> created_;
};

/// Triangle quadtrees with red-green closure, adapted to AdaptiveRefinement.
class TriangleHierarchy : public LatticeView {
  public:
    explicit TriangleHierarchy(const ControlMesh& mesh)
        : forest_(mesh), first_count_(forest_.leaf_count()), first_points_(forest_.point_count()) {}
    explicit TriangleHierarchy(const ControlMesh&&) = delete;

    /// At an interior vertex of valence 2, both faces would have the edge between the midpoints of the vertex's two
    /// edges, and four triangles would share it. So in one face the cell across that edge is always split.
    bool must_split(LeafId leaf) const {
        const int level = forest_.level(leaf);
        if (level == 0) return false;
        const ControlMesh& mesh = forest_.mesh();
        const CellTriangle t = forest_.triangle(leaf);
        const std::int64_t n = std::int64_t{1} << level;
        HalfedgeId h = t.root;
        for (int k = 0; k < 3; ++k, h = mesh.next(h)) {
            // The cell across from the one at corner k: of all cells, its corners are the second nearest to corner k.
            std::int64_t nearness = 0;
            for (const LatticePoint& p : t.corner)
                nearness += k == 0 ? n - p.x - p.y : (k == 1 ? std::int64_t{p.x} : std::int64_t{p.y});
            if (nearness != 3 * n - 4) continue;
            const VertexId v = mesh.origin(h);
            if (mesh.face_valence(v) == 2 && !mesh.is_boundary(v) && mesh.vertex_halfedge(v) == h) return true;
        }
        return false;
    }

    const TriangleForest& forest() const { return forest_; }

    std::uint32_t slots() const { return forest_.leaf_slots(); }
    bool is_leaf(LeafId leaf) const { return forest_.is_leaf(leaf); }
    int level(LeafId leaf) const { return forest_.level(leaf); }
    Key key(LeafId leaf) const { return LatticeView::key(forest_.triangle(leaf)); }
    /// Triangles of the conforming mesh, green ones included. By Euler's formula, with a constant characteristic, each
    /// new point adds two triangles, or one if it is on the boundary.
    std::uint64_t triangle_count() const {
        return first_count_ + 2 * (std::uint64_t{forest_.point_count()} - first_points_) - boundary_points_;
    }

    void initial_leaves(std::vector<LeafId>& leaves) const { leaves = forest_.ordered_leaves(); }
    int triangles(LeafId leaf, std::array<CellTriangle, 3>& parts) const {
        const GreenTriangles green = forest_.green_triangles(leaf);
        assert(green.count <= 3);
        std::copy_n(green.cell.begin(), 3, parts.begin());
        return green.count;
    }
    /// Splits the marked leaves and what must be split with them. A leaf whose neighbours are then all split is split,
    /// too: its output triangles do not change, but then each has its own error.
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& fresh) {
        split(marked, fresh);
        surrounded_.clear();
        for (LeafId leaf : change_.reshaped) {
            const auto hanging = forest_.hanging_points(leaf);
            if (hanging[0].valid() && hanging[1].valid() && hanging[2].valid())
                surrounded_.push_back(leaf);
            else
                fresh.push_back(leaf);
        }
        if (surrounded_.empty()) return;
        // No leaf beside them is left that this split could reshape.
        split(surrounded_, fresh);
        assert(change_.reshaped.empty());
    }
    void open(FaceId, std::vector<LeafId>&) {}
    double fan_error(FaceId) const { return 0; }
    template <class Visit>
    void for_each_fan(Visit&&) const {}

  private:
    void split(std::span<const LeafId> marked, std::vector<LeafId>& fresh) {
        const std::uint32_t points = forest_.point_slots();
        forest_.refine(marked, change_);
        for (std::uint32_t p = points; p < forest_.point_slots(); ++p)
            boundary_points_ += at_end(forest_.point_site(PointId(p)));
        fresh.insert(fresh.end(), change_.created.begin(), change_.created.end());
    }
    /// Whether a point is on a control edge that has a face on one side only (holes are no faces).
    bool at_end(const Site& site) const {
        const ControlMesh& mesh = forest_.mesh();
        const auto [x, y] = site.at;
        if (x != 0 && y != 0 && x + y != 1u << site.level) return false;
        const HalfedgeId h = y == 0 ? site.root : x == 0 ? mesh.prev(site.root) : mesh.next(site.root);
        return !mesh.twin(h).valid() || mesh.is_hole(mesh.face(h)) != mesh.is_hole(mesh.face(mesh.twin(h)));
    }

    TriangleForest forest_;
    std::uint64_t first_count_, first_points_, boundary_points_ = 0;
    ForestChange change_;
    std::vector<LeafId> surrounded_;
};

/// Triangles of the sqrt(3) scheme, adapted to AdaptiveRefinement. A level is a simple step; splitting a half triangle
/// splits the triangle across its edge.
class Sqrt3Hierarchy {
  public:
    using Triangle = Sqrt3Triangle;
    using Key = std::tuple<std::uint64_t, std::uint8_t, bool>;

    Sqrt3Hierarchy(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept) : forest_(mesh, kept) {}

    const Sqrt3Forest& forest() const { return forest_; }

    std::uint32_t slots() const { return forest_.leaf_slots(); }
    bool is_leaf(LeafId leaf) const { return forest_.is_leaf(leaf); }
    int level(LeafId leaf) const { return forest_.level(leaf) - (forest_.is_half(leaf) ? 1 : 0); }
    bool must_split(LeafId) const { return false; }
    Key key(LeafId leaf) const {
        const Sqrt3Triangle t = forest_.triangle(leaf);
        return {t.face, t.level, t.half};
    }
    std::uint64_t triangle_count() const { return forest_.leaf_count(); }
    void initial_leaves(std::vector<LeafId>& leaves) const { leaves = forest_.ordered_leaves(); }
    int triangles(LeafId leaf, std::array<Sqrt3Triangle, 3>& parts) const {
        parts[0] = forest_.triangle(leaf);
        return 1;
    }
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& fresh) {
        forest_.refine(marked, change_);
        fresh.insert(fresh.end(), change_.created.begin(), change_.created.end());
    }
    void open(FaceId, std::vector<LeafId>&) {}
    template <class Visit>
    void for_each_fan(Visit&&) const {}

  private:
    Sqrt3Forest forest_;
    ForestChange change_;
};

}  // namespace tetrakis
