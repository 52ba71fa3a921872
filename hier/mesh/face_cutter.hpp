#pragma once

#include "control_mesh.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <tuple>
#include <unordered_set>
#include <vector>

namespace tetrakis::detail {

/// Cuts faces into triangles, one face after the other, by the rule of triangulate(): ears, the shortest diagonal
/// first. Cost: O(n log n) for n corners; for concave faces, times their reflex corners.
class FaceCutter {
  public:
    /// Corners are named by their indices in `points`, which has at least three.
    /// @param is_free   is_free(a, b): whether a diagonal may join corners a and b
    /// @param triangle  triangle(a, tip, b) is called for each triangle, counter-clockwise as the face; a-b is a
    ///                  diagonal, except in the last triangle
    /// @return  the corners, in order, of the polygon that remains if no diagonal is free; else none. Valid until the
    ///          next call
    template <class IsFree, class Triangle>
    std::span<const std::uint32_t> cut(std::span<const Vec3d> points, const IsFree& is_free, const Triangle& triangle) {
        if (points.size() == 3) {
            triangle(0, 1, 2);
            return {};
        }
        begin(points);
        while (left_ > 3 && !ears_.empty()) {
            std::pop_heap(ears_.begin(), ears_.end(), std::greater<>());
            const Ear ear = ears_.back();
            ears_.pop_back();
            if (ear.round != round_[ear.at]) continue;
            const std::uint32_t a = prev_[ear.at], b = next_[ear.at];
            if (!is_free(a, b)) continue;
            triangle(a, ear.at, b);
            remove(ear.at);
        }
        if (left_ > 3) return rest();
        triangle(prev_[start_], start_, next_[start_]);
        return {};
    }

    /// For a triangle of the last face that was cut and has more than three corners: positive if it faces as the face
    /// does. The value is twice its area along the face's normal, times the length of the normal.
    double facing(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;

  private:
    struct Ear {
        bool bad;             ///< faces backward, contains a reflex corner, or leaves a backward triangle
        double length2;       ///< squared length of its diagonal, rounded
        std::uint32_t at;     ///< its tip
        std::uint32_t round;  ///< round_ of the tip when the ear was tested
        friend bool operator>(const Ear& a, const Ear& b) {
            return std::tie(a.bad, a.length2, a.at, a.round) > std::tie(b.bad, b.length2, b.at, b.round);
        }
    };

    void begin(std::span<const Vec3d> points);
    void remove(std::uint32_t place);
    void offer_all();
    void offer(std::uint32_t tip);
    bool holds_reflex_corner(std::uint32_t a, std::uint32_t tip, std::uint32_t b) const;
    std::span<const std::uint32_t> rest();

    std::span<const Vec3d> points_;
    std::uint32_t left_ = 0, start_ = 0;  ///< number of corners that are left, and one of them
    Vec3d normal_{0.0};
    std::vector<std::uint32_t> prev_, next_, round_, reflex_, rest_;
    bool test_reflex_ = false;
    std::vector<Ear> ears_;  ///< a heap; ears of earlier rounds are outdated
};

/// Cuts faces of a mesh. No diagonal joins two vertices that an edge or an earlier diagonal joins already.
class MeshFaceCutter : private FaceCutter {
  public:
    /// Keeps references.
    /// @param positions  positions of the mesh's vertices
    MeshFaceCutter(const ControlMesh& mesh, std::span<const Vec3d> positions) : mesh_(mesh), positions_(positions) {}

    /// As FaceCutter::cut(); corners are counted from the face's first one.
    template <class Triangle>
    std::span<const std::uint32_t> cut(FaceId face, const Triangle& triangle) {
        first_ = mesh_.face_halfedge(face);
        points_.clear();
        for (std::uint32_t i = 0; i < mesh_.face_size(face); ++i) points_.push_back(positions_[vertex(i).value]);
        const auto is_free = [&](std::uint32_t a, std::uint32_t b) { return !joined(vertex(a), vertex(b)); };
        return FaceCutter::cut(points_, is_free, triangle);
    }
    using FaceCutter::facing;
    /// Records the diagonal between two corners of the last face as taken.
    void take(std::uint32_t a, std::uint32_t b) { known_.insert(key(vertex(a), vertex(b))); }

  private:
    static std::uint64_t key(VertexId a, VertexId b) {
        return std::uint64_t{std::min(a, b).value} << 32 | std::max(a, b).value;
    }
    VertexId vertex(std::uint32_t place) const { return mesh_.origin(HalfedgeId(first_.value + place)); }
    bool joined(VertexId a, VertexId b);

    const ControlMesh& mesh_;
    std::span<const Vec3d> positions_;
    HalfedgeId first_;  ///< first corner of the face that was cut last
    std::vector<Vec3d> points_;
    std::unordered_set<std::uint64_t>
        known_;  ///< taken diagonals and edges found so far; each edge is searched around a vertex once
};

}  // namespace tetrakis::detail
