#pragma once

#include "sharpness.hpp"
#include "short_list.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis {

/// A polygon mesh as the rules of a scheme see it: connectivity and sharpness without positions. Faces are
/// counter-clockwise; half-edges are numbered face by face. Boundary edges are infinitely sharp.
///
/// Small and plain: for the general path of every scheme, and for the neighbourhoods of spectral analysis.
class RuleMesh {
  public:
    static constexpr int none = -1;

    /// Collects faces corner by corner, with the sharpness of the edge that leaves each corner.
    class Builder {
      public:
        /// @param tag  of the edge: half-edges with the same ends are one edge only if their tags are equal
        void corner(int vertex, float sharpness = 0, int tag = 0) {
            origin_.push_back(vertex);
            sharpness_.push_back(sharpness);
            if (tag == 0) return;
            tag_.resize(origin_.size(), 0);
            tag_.back() = tag;
        }
        void end_face() { face_begin_.push_back(static_cast<int>(origin_.size())); }
        /// A whole face.
        void face(std::span<const int> corners, int tag = 0) {
            for (const int v : corners) corner(v, 0, tag);
            end_face();
        }
        void face(std::initializer_list<int> corners, int tag = 0) {
            face(std::span(corners.begin(), corners.size()), tag);
        }
        void reserve(std::size_t faces, std::size_t corners) {
            face_begin_.reserve(faces + 1);
            origin_.reserve(corners);
            sharpness_.reserve(corners);
        }
        int halfedge_count() const { return static_cast<int>(origin_.size()); }
        /// Sets the twin of each half-edge, `none` on a boundary. The constructor then searches no twins, and checks
        /// neither twins nor fans.
        void set_twins(std::vector<int> twins) { twin_ = std::move(twins); }
        /// One value of RuleMesh::corner_angle() per half-edge; empty: no corner has an angle.
        void set_corner_angles(std::vector<double> angles) { corner_angle_ = std::move(angles); }

      private:
        friend class RuleMesh;
        std::vector<int> face_begin_{0}, origin_;
        std::vector<float> sharpness_;
        std::vector<int> twin_, tag_;  ///< tags of the first half-edges; missing ones are 0
        std::vector<double> corner_angle_;
    };

    RuleMesh() = default;
    /// An edge's sharpness is the larger one of its two half-edges.
    /// @param vertex_sharpness  per vertex; empty: none is sharp
    /// @throws std::invalid_argument  a face has fewer than three corners or a vertex that does not exist, an edge has
    ///                                more than two faces or two that disagree on its direction, faces touch in a
    ///                                vertex alone, a corner angle is not 0 or in (0, 2 pi) or is pi
    RuleMesh(int vertex_count, Builder faces, std::vector<float> vertex_sharpness = {});

    int vertex_count() const { return static_cast<int>(first_.size()); }
    int face_count() const { return static_cast<int>(face_begin_.size()) - 1; }
    int halfedge_count() const { return static_cast<int>(origin_.size()); }
    int edge_count() const { return static_cast<int>(edge_halfedge_.size()); }

    int face_begin(int f) const { return face_begin_[f]; }
    int face_size(int f) const { return face_begin_[f + 1] - face_begin_[f]; }
    /// The corners of a face, from its first half-edge on.
    std::span<const int> corners(int f) const { return {origin_.data() + face_begin_[f], std::size_t(face_size(f))}; }
    bool all_faces_have(int corners) const;

    int origin(int h) const { return origin_[h]; }
    int target(int h) const { return origin_[next(h)]; }
    int face(int h) const { return face_[h]; }
    int next(int h) const { return h + 1 < face_begin_[face_[h] + 1] ? h + 1 : face_begin_[face_[h]]; }
    int prev(int h) const { return h > face_begin_[face_[h]] ? h - 1 : face_begin_[face_[h] + 1] - 1; }
    int twin(int h) const { return twin_[h]; }
    int edge(int h) const { return edge_[h]; }
    int edge_halfedge(int e) const { return edge_halfedge_[e]; }          ///< the first of its half-edges
    bool leads(int h) const { return twin_[h] == none || h < twin_[h]; }  ///< whether h is its edge's first half-edge

    float sharpness(int h) const { return sharpness_[h]; }
    bool sharp(int h) const { return is_sharp(sharpness_[h]); }
    float vertex_sharpness(int v) const { return vertex_sharpness_.empty() ? 0.0f : vertex_sharpness_[v]; }
    const std::vector<float>& vertex_sharpness() const { return vertex_sharpness_; }
    /// The same faces with other tags.
    /// @param change         change(sharpness) is the new sharpness of an edge or vertex; infinity must stay
    /// @param corner_angles  as Builder takes them
    template <class Change>
    RuleMesh with_tags(const Change& change, std::vector<double> corner_angles) const {
        RuleMesh result = *this;
        result.vertex_sharpness_.resize(first_.size(), 0.0f);
        for (auto* tags : {&result.sharpness_, &result.vertex_sharpness_})
            for (float& sharpness : *tags) sharpness = change(sharpness);
        result.corner_angle_ = std::move(corner_angles);
        result.take_corner_angles();
        return result;
    }
    /// The own interior angle of the sector at origin(h) that contains face(h), equal for all its half-edges; 0: none.
    /// Rules use it where the vertex is a corner.
    double corner_angle(int h) const { return corner_angle_.empty() ? 0 : corner_angle_[h]; }
    bool has_corner_angles() const { return !corner_angle_.empty(); }

    /// A half-edge that leaves v: at a boundary the first one counter-clockwise. `none` for an isolated vertex.
    int first(int v) const { return first_[v]; }
    bool on_boundary(int v) const { return first_[v] == none || twin_[first_[v]] == none; }
    /// Calls visit(half-edge) for those that leave v, counter-clockwise. Returns whether the ring is closed.
    template <class Visit>
    bool for_each_leaving(int v, const Visit& visit) const {
        for (int h = first_[v]; h != none;) {
            visit(h);
            h = twin_[prev(h)];
            if (h == first_[v]) return true;
        }
        return false;
    }

    /// The faces and edges around a vertex, counter-clockwise.
    struct Ring {
        ShortList<int, 8> neighbour;    ///< K if closed, K + 1 if not
        ShortList<int, 8> halfedge;     ///< leaves the vertex, one per face: from it to neighbour i, face i on its left
        ShortList<float, 8> sharpness;  ///< of each edge
        bool closed = true;

        int faces() const { return static_cast<int>(halfedge.size()); }
        int edges() const { return static_cast<int>(neighbour.size()); }
        int wrap(int i) const { return (i % edges() + edges()) % edges(); }
        int at(int i) const { return neighbour[wrap(i)]; }
        int position(int vertex) const;  ///< of a neighbour
    };
    Ring ring(int v) const;
    /// The faces between the two sharp edges that enclose the smooth edge of `h` at its origin: closed if the vertex
    /// has fewer than two sharp edges (a dart's ring is whole, but starts at its sharp edge).
    Ring sector(int h) const;
    VertexRule rule(int v) const;
    /// Neighbours of v along its sharp edges.
    ShortList<int, 8> sharp_neighbours(int v) const;

  private:
    Ring from(int start, bool stops_at_sharp_edges) const;
    void match_twins(std::vector<int> tags);
    void check_fans() const;
    void take_corner_angles();

    std::vector<int> face_begin_{0}, origin_, face_, twin_, edge_, edge_halfedge_, first_;
    std::vector<float> sharpness_, vertex_sharpness_;
    std::vector<double> corner_angle_;
};

}  // namespace tetrakis
