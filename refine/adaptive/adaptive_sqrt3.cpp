#include "adaptive_sqrt3.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../points/sqrt3_points.hpp"
#include "../points/sqrt3_rules.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
constexpr std::uint32_t k_face_block = 1u << 12;
constexpr std::uint32_t k_point_block = 256;  // of Sqrt3Points

/// Evaluators for as many threads as ask for one at a time; they keep what they have found.
class PointsPool {
  public:
    explicit PointsPool(const Sqrt3Lattice& lattice) : lattice_(lattice) {}

    /// Calls visit(points, i) for i < count, in parallel.
    template <class Visit>
    void for_each(std::size_t count, const Visit& visit) {
        for_each_block(static_cast<std::uint32_t>(count), k_point_block, [&](std::uint32_t begin, std::uint32_t end) {
            std::unique_ptr<Sqrt3Points> points = take();
            for (std::uint32_t i = begin; i < end; ++i) visit(*points, i);
            const std::scoped_lock lock(mutex_);
            idle_.push_back(std::move(points));
        });
    }

  private:
    std::unique_ptr<Sqrt3Points> take() {
        const std::scoped_lock lock(mutex_);
        if (idle_.empty()) return std::make_unique<Sqrt3Points>(lattice_);
        std::unique_ptr<Sqrt3Points> points = std::move(idle_.back());
        idle_.pop_back();
        return points;
    }

    const Sqrt3Lattice& lattice_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Sqrt3Points>> idle_;
};

/// Makes a mesh: its triangles, then the points of its vertices, level by level.
class MeshMaker {
  public:
    MeshMaker(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options)
        : forest_(forest), mesh_(forest.mesh()), options_(options), pool_(forest.lattice()) {
        check_memory();
        find_corners();
        add_leaves();
    }

    Sqrt3Mesh make() {
        for (auto* points : {&points_[0], &points_[1]}) detail::resize_large(*points, forest_.point_slots());
        for (auto* at : {&at_[0], &at_[1]}) at->assign(forest_.point_slots(), k_no_level);
        detail::resize_large(leaving_, forest_.point_slots());
        found_.assign(out_.points.size(), 0);
        std::copy(mesh_.positions().begin(), mesh_.positions().end(), points_[0].begin());
        std::fill_n(at_[0].begin(), mesh_.vertex_count(), std::uint8_t{0});
        for (level_ = 0; level_ < static_cast<int>(levels_.size()); ++level_) {
            options_.context.report("vertices", static_cast<double>(level_) / static_cast<double>(levels_.size()));
            find_leaving();
            add_missing();
            for_each_block(static_cast<std::uint32_t>(faces().size()), k_face_block,
                           [&](std::uint32_t begin, std::uint32_t end) { step(begin, end); });
        }
        add_rest();
        return std::move(out_);
    }

  private:
    static constexpr std::uint8_t k_no_level = 0xFF;
    static constexpr std::uint8_t k_position = 1, k_normal = 2;  // of a vertex that has been found

    void check_memory() const {
        const std::uint64_t bytes =
            forest_.leaf_slots() * (sizeof(std::array<std::uint32_t, 3>) + sizeof(std::uint32_t)) +
            forest_.point_slots() * (2 * sizeof(Vec3d) + 2 + 2 * sizeof(std::uint32_t));
        const std::uint64_t most = options_.context.max_memory_bytes;
        if (most == 0 || bytes <= most) return;
        throw Error(ErrorCode::memory_limit, "the levels of the mesh's " + std::to_string(forest_.leaf_count()) +
                                                 " triangles take " + std::to_string(bytes) +
                                                 " bytes, more than the limit of " + std::to_string(most) +
                                                 "; coarsen first, or raise the limit");
    }

    // The faces of each level in the order of their numbers, and the corners of all slots.
    void find_corners() {
        detail::resize_large(corner_, forest_.leaf_slots());
        levels_.emplace_back();
        for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) {
            for (std::uint32_t k = 0; k < 3; ++k) corner_[f][k] = mesh_.origin(HalfedgeId(3 * f + k)).value;
            if (forest_.is_face(f)) levels_[0].push_back(f);
        }
        for (;;) {
            detail::PoolVector<std::uint32_t> finer;
            bool any = false;
            for (const std::uint32_t f : levels_.back())
                for (std::uint32_t h = 3 * f; forest_.is_split(f) && h < 3 * f + 3; ++h) {
                    const std::uint32_t child = forest_.child_over(h);
                    if (forest_.is_face(child)) finer.push_back(child);
                    any = true;
                }
            if (!any) return;
            const auto& above = levels_.back();
            for_each_index(static_cast<std::uint32_t>(above.size()), [&](std::uint32_t i) {
                for (std::uint32_t h = 3 * above[i]; forest_.is_split(above[i]) && h < 3 * above[i] + 3; ++h)
                    corner_[forest_.child_over(h)] = corners_over(h);
            });
            levels_.push_back(std::move(finer));
        }
    }
    std::uint32_t origin(std::uint32_t h) const { return corner_[h / 3][h % 3]; }
    std::array<std::uint32_t, 3> corners_over(std::uint32_t h) const {
        const LeafId child(forest_.child_over(h));
        const std::uint32_t twin = forest_.twin(h);
        if (forest_.is_half(child)) return {origin(h), origin(Sqrt3Forest::next(h)), forest_.apex(h)};
        if (twin < Sqrt3Forest::k_no_halfedge) return {origin(h), forest_.apex(twin), forest_.apex(h)};
        const auto points = forest_.points(child);
        return {points[0].value, points[1].value, points[2].value};
    }

    void add_leaves() {
        const std::size_t count = forest_.leaf_count();
        number_.assign(forest_.point_slots(), k_none);
        // Of a closed surface: half as many vertices as triangles, and two more on a sphere; of others some more.
        const std::size_t vertices = count / 2 + count / 64 + 2;
        detail::reserve_large(out_.points, vertices);
        detail::reserve_large(place_, vertices);
        const ControlMeshData& data = mesh_.data();
        PolygonMesh& mesh = out_.mesh;
        detail::resize_large(mesh.face_vertices, 3 * count);
        detail::resize_large(mesh.face_offsets, count + 1);
        for (std::size_t f = 0; f <= count; ++f) mesh.face_offsets[f] = static_cast<std::uint32_t>(3 * f);
        std::uint32_t* to = mesh.face_vertices.data();
        forest_.for_each_leaf([&](LeafId leaf, FaceId control_face) {
            const std::uint32_t first = 3 * leaf.value;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t point = corner_[leaf.value][k];
                std::uint32_t& v = number_[point];
                if (v == k_none) {
                    v = static_cast<std::uint32_t>(out_.points.size());
                    out_.points.emplace_back(point);
                    place_.push_back(first + k);
                } else if (!options_.limit && level_of(first) > level_of(place_[v])) {
                    place_[v] = first + k;
                }
                *to++ = v;
            }
            if (!data.face_material.empty()) mesh.face_material.push_back(data.face_material[control_face.value]);
            if (!data.face_group.empty()) mesh.face_group.push_back(data.face_group[control_face.value]);
        });
        mesh.materials = data.materials;
        mesh.groups = data.groups;
        detail::resize_large(mesh.positions, out_.points.size());
        if (options_.normals) detail::resize_large(mesh.normals, out_.points.size());
    }
    int level_of(std::uint32_t h) const { return forest_.level(LeafId(h / 3)); }

    const detail::PoolVector<std::uint32_t>& faces() const { return levels_[static_cast<std::size_t>(level_)]; }
    bool is_last() const { return level_ + 1 == static_cast<int>(levels_.size()); }
    bool has_point(std::uint32_t point) const { return at_[level_ % 2][point] == level_; }
    const Vec3d& point(std::uint32_t point) const { return points_[level_ % 2][point]; }
    void put(std::uint32_t point, int level, const Vec3d& position) {
        points_[level % 2][point] = position;
        at_[level % 2][point] = static_cast<std::uint8_t>(level);
    }

    // The first half-edge of the level's faces that leaves a point.
    void find_leaving() {
        for (std::size_t i = faces().size(); i-- > 0;)
            for (std::uint32_t h = 3 * faces()[i] + 3; h-- > 3 * faces()[i];) leaving_[origin(h)] = h;
    }
    // Points that the level before could not make.
    void add_missing() {
        std::vector<std::uint32_t> missing;
        for (const std::uint32_t f : faces())
            for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h)
                if (leaving_[origin(h)] == h && !has_point(origin(h))) missing.push_back(h);
        pool_.for_each(missing.size(), [&](Sqrt3Points& points, std::uint32_t i) {
            const std::uint32_t h = missing[i];
            put(origin(h), level_, points.position(level_, 3 * forest_.triangle(LeafId(h / 3)).face + h % 3));
        });
    }
    // The next level's points, and limits, of some faces.
    void step(std::uint32_t begin, std::uint32_t end) {
        detail::Sqrt3Rules rules;
        detail::Sqrt3Ring ring;
        for (std::uint32_t i = begin; i < end; ++i) {
            const std::uint32_t f = faces()[i];
            for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h)
                if (leaving_[origin(h)] == h) step(h, rules, ring);
            if (!forest_.is_split(f) || forest_.is_cut(f)) continue;
            put(forest_.apex(3 * f), level_ + 1,
                detail::Sqrt3Rules::centre({point(corner_[f][0]), point(corner_[f][1]), point(corner_[f][2])}));
        }
    }
    // The same of the point that a half-edge leaves.
    void step(std::uint32_t leaving, detail::Sqrt3Rules& rules, detail::Sqrt3Ring& ring) {
        const std::uint32_t v = origin(leaving), to = number_[v];
        if (to != k_none && !options_.limit && level_of(place_[to]) == level_) put_position(to, point(v));
        // Limits are those of the first level, to which the level before has not moved the point.
        const bool is_new = level_ == 0 || at_[(level_ + 1) % 2][v] != level_ - 1;
        const bool limit = to != k_none && (options_.limit || options_.normals) && is_new;
        if ((!limit && is_last()) || !gather(leaving, ring)) return;
        if (!is_last()) put(v, level_ + 1, rules.moved(ring, level_ % 2 != 0));
        if (!limit) return;
        if (options_.normals)
            put_limit(to, rules.limit(ring));
        else
            put_position(to, rules.limit_position(ring));
    }
    void put_position(std::uint32_t vertex, const Vec3d& position) {
        out_.mesh.positions[vertex] = position;
        found_[vertex] |= k_position;
    }
    void put_limit(std::uint32_t vertex, const LimitPoint& limit) {
        if (options_.limit) put_position(vertex, limit.position);
        if (!options_.normals) return;
        out_.mesh.normals[vertex] = limit.normal;
        found_[vertex] |= k_normal;
    }
    // The ring of a smooth vertex whose faces are all there, as Sqrt3Points has it; false: it is not as plain as that,
    // or an edge at it or opposite to it is not flipped.
    bool gather(std::uint32_t leaving, detail::Sqrt3Ring& ring) const {
        const std::uint32_t v = origin(leaving);
        if (v < mesh_.vertex_count() && mesh_.sharpness(VertexId(v)) > 0) return false;
        ring.point = point(v);
        ring.around.clear();
        for (std::uint32_t h = leaving;;) {
            const std::uint32_t w = origin(Sqrt3Forest::next(h));
            if (forest_.is_cut(h / 3) || !has_point(w)) return false;
            ring.around.push_back(point(w));
            h = forest_.twin(Sqrt3Forest::prev(h));
            if (h >= Sqrt3Forest::k_no_halfedge || !forest_.is_face(h / 3)) return false;
            if (h == leaving) return true;
        }
    }

    // What the levels did not give.
    void add_rest() {
        const std::uint8_t all = k_position | (options_.normals ? k_normal : 0);
        std::vector<std::uint32_t> rest;
        for (std::uint32_t v = 0; v < found_.size(); ++v)
            if (found_[v] != all) rest.push_back(v);
        pool_.for_each(rest.size(), [&](Sqrt3Points& points, std::uint32_t i) {
            const std::uint32_t v = rest[i];
            const Sqrt3Leaf leaf = forest_.triangle(LeafId(place_[v] / 3)).leaf();
            int level = leaf.vertex_level(place_[v] % 3);
            std::uint64_t leaving = leaf.leaving(place_[v] % 3);
            if (options_.limit || options_.normals) put_limit(v, points.limit(level, leaving));
            if (options_.limit) return;
            if (level < level_of(place_[v])) leaving = points.lattice().after(level++, leaving);
            put_position(v, points.position(level, leaving));
        });
    }

    const Sqrt3Forest& forest_;
    const ControlMesh& mesh_;
    const Sqrt3MeshOptions& options_;
    PointsPool pool_;
    Sqrt3Mesh out_;
    detail::RawPoolVector<std::array<std::uint32_t, 3>> corner_;  // per slot: points
    std::vector<detail::PoolVector<std::uint32_t>> levels_;       // their faces
    detail::RawPoolVector<std::uint32_t> number_;                 // per point: of the mesh's vertex
    std::vector<std::uint32_t> place_;  // per vertex of the mesh: a corner, 3 slot + k, of a leaf of the finest level
    int level_ = 0;
    detail::RawPoolVector<std::uint32_t> leaving_;  // per point
    // Of this level and the next one, by whether it is even; per point, and the level that it is of.
    detail::RawPoolVector<Vec3d> points_[2];
    detail::PoolVector<std::uint8_t> at_[2];
    detail::PoolVector<std::uint8_t> found_;  // per vertex of the mesh
};

}  // namespace

void require_sqrt3_limits(const ControlMesh& mesh) {
    for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
        const VertexId v(i);
        const HalfedgeId leaving = mesh.vertex_halfedge(v);
        if (!leaving.valid() || mesh.is_boundary(v) || mesh.face_valence(v) != 2 || mesh.sharpness(v) > 0) continue;
        const float one = mesh.sharpness(mesh.edge(leaving)), other = mesh.sharpness(mesh.edge(mesh.prev(leaving)));
        if (std::min(one, other) > 0 || std::max(one, other) < k_sharpness_infinity) continue;
        throw Error(
            ErrorCode::unsupported,
            "sqrt3 has no limit at vertex " + std::to_string(i) +
                ", where a crease ends between two triangles; tag the vertex as a corner, or leave out the limit",
            mesh.data().source);
    }
}

Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options) {
    if (options.limit || options.normals) require_sqrt3_limits(forest.mesh());
    return with_threads(options.context, [&] { return MeshMaker(forest, options).make(); });
}

}  // namespace tetrakis
