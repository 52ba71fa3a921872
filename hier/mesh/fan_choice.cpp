#include "fan_choice.hpp"

#include "../base/error.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_none = VertexId::none;

/// Which vertices are already joined: by an edge of the mesh, or by a diagonal that was taken.
class Joins {
  public:
    explicit Joins(const ControlMesh& mesh) : mesh_(mesh), head_(mesh.vertex_count(), k_none) {}

    bool joined(VertexId a, VertexId b) const {
        const auto [low, other] = ordered(a, b);
        const HalfedgeId first = mesh_.vertex_halfedge(low);
        HalfedgeId h = first;
        do {
            if (mesh_.target(h) == other || mesh_.origin(mesh_.prev(h)) == other) return true;
            h = mesh_.ccw_outgoing(h);
        } while (h.valid() && h != first);
        for (std::uint32_t i = head_[low.value]; i != k_none; i = entries_[i].next)
            if (entries_[i].other == other) return true;
        return false;
    }
    void add(VertexId a, VertexId b) {
        const auto [low, other] = ordered(a, b);
        entries_.push_back({other, head_[low.value]});
        head_[low.value] = static_cast<std::uint32_t>(entries_.size() - 1);
    }

  private:
    // Kept at, and looked up from, the end with fewer faces: a hub's list would grow with its valence.
    std::pair<VertexId, VertexId> ordered(VertexId a, VertexId b) const {
        const auto key = [&](VertexId v) { return std::pair(mesh_.face_valence(v), v); };
        return key(a) < key(b) ? std::pair(a, b) : std::pair(b, a);
    }

    struct Entry {
        VertexId other;
        std::uint32_t next;
    };
    const ControlMesh& mesh_;
    std::vector<std::uint32_t> head_;
    std::vector<Entry> entries_;
};

/// Cuts ears off one face after the other.
class EarCutter {
  public:
    EarCutter(const ControlMesh& mesh, std::span<const Vec3d> positions)
        : mesh_(mesh), positions_(positions), joins_(mesh) {}

    /// Appends the n - 2 triangles of a face, n > 3, or nothing.
    bool cut(FaceId f, std::vector<std::array<std::uint8_t, 3>>& triangles) {
        load(f);
        const std::size_t first = triangles.size();
        taken_.clear();
        while (corners_.size() > 3) {
            const std::size_t ear = best_ear();
            if (ear == corners_.size()) {
                triangles.resize(first);
                return false;
            }
            const auto [before, at, after] = around(ear);
            triangles.push_back({before, at, after});
            taken_.emplace_back(vertex(before), vertex(after));
            corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(ear));
        }
        if (!(area(corners_[0], corners_[1], corners_[2]) > 0)) {
            triangles.resize(first);
            return false;
        }
        triangles.push_back({corners_[0], corners_[1], corners_[2]});
        for (const auto& [a, b] : taken_) joins_.add(a, b);
        return true;
    }

  private:
    void load(FaceId f) {
        first_ = mesh_.face_halfedge(f);
        corners_.resize(mesh_.face_size(f));
        normal_ = Vec3d(0);
        for (std::size_t i = 0; i < corners_.size(); ++i) corners_[i] = static_cast<std::uint8_t>(i);
        // Newell: twice the area vector, taken from the first corner against cancellation.
        const Vec3d origin = point(0);
        for (std::size_t i = 1; i + 1 < corners_.size(); ++i)
            normal_ += glm::cross(point(corners_[i]) - origin, point(corners_[i + 1]) - origin);
    }

    VertexId vertex(std::uint8_t corner) const { return mesh_.origin(HalfedgeId(first_.value + corner)); }
    const Vec3d& point(std::uint8_t corner) const { return positions_[vertex(corner).value]; }
    /// Positive for a counter-clockwise triangle, seen against the face's normal.
    double area(std::uint8_t a, std::uint8_t b, std::uint8_t c) const {
        return glm::dot(glm::cross(point(b) - point(a), point(c) - point(a)), normal_);
    }
    std::array<std::uint8_t, 3> around(std::size_t i) const {
        const std::size_t n = corners_.size();
        return {corners_[(i + n - 1) % n], corners_[i], corners_[(i + 1) % n]};
    }

    /// A triangle that turns the right way, with no other corner in it, at a diagonal that is free.
    bool is_ear(std::size_t i) const {
        const auto [before, at, after] = around(i);
        if (!(area(before, at, after) > 0)) return false;
        for (std::uint8_t c : corners_) {
            if (c == before || c == at || c == after) continue;
            if (area(before, at, c) >= 0 && area(at, after, c) >= 0 && area(after, before, c) >= 0) return false;
        }
        return !joins_.joined(vertex(before), vertex(after));
    }

    std::size_t best_ear() const {
        std::size_t best = corners_.size();
        double best_length = 0;
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            const auto [before, at, after] = around(i);
            const Vec3d d = point(after) - point(before);
            const double length = glm::dot(d, d);
            if (best != corners_.size() && !(length < best_length)) continue;
            if (!is_ear(i)) continue;
            best = i;
            best_length = length;
        }
        return best;
    }

    const ControlMesh& mesh_;
    std::span<const Vec3d> positions_;
    Joins joins_;
    HalfedgeId first_;
    Vec3d normal_{0};
    std::vector<std::uint8_t> corners_;  // those not cut off yet
    std::vector<std::pair<VertexId, VertexId>> taken_;
};

/// Two triangles with the same three vertices close up to a pillow: one of them has to keep its centre.
bool repeats_accepted_triangle(const ControlMesh& mesh, FaceId f, const FanChoice& fans) {
    const HalfedgeId h = mesh.face_halfedge(f), t = mesh.twin(h);
    if (!t.valid()) return false;
    const FaceId g = mesh.face(t);
    return mesh.face_size(g) == 3 && fans.accepted[g.value] != 0 &&
           mesh.origin(mesh.prev(t)) == mesh.origin(mesh.prev(h));
}

void require_size(std::size_t size, std::uint32_t wanted, const char* what) {
    if (size != wanted)
        throw Error(ErrorCode::invalid_input,
                    "fans need " + std::to_string(wanted) + " " + what + ", got " + std::to_string(size));
}

}  // namespace

FanChoice choose_fans(const ControlMesh& mesh, std::span<const Vec3d> positions, std::span<const std::uint8_t> wanted) {
    require_size(positions.size(), mesh.vertex_count(), "positions");
    require_size(wanted.size(), mesh.face_count(), "flags");
    FanChoice fans;
    fans.accepted.assign(mesh.face_count(), 0);
    fans.offsets.reserve(mesh.face_count() + 1);
    fans.offsets.push_back(0);
    EarCutter cutter(mesh, positions);
    for (std::uint32_t i = 0; i < mesh.face_count(); ++i) {
        const FaceId f(i);
        const std::uint32_t n = mesh.face_size(f);
        if (wanted[i] != 0 && !mesh.is_hole(f) && n <= k_max_fan_corners) {
            if (n > 3) {
                fans.accepted[i] = cutter.cut(f, fans.triangles);
            } else if (!repeats_accepted_triangle(mesh, f, fans)) {
                fans.accepted[i] = 1;
                fans.triangles.push_back({0, 1, 2});
            }
        }
        fans.offsets.push_back(static_cast<std::uint32_t>(fans.triangles.size()));
    }
    return fans;
}

}  // namespace tetrakis
