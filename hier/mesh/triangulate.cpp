#include "triangulate.hpp"

#include "corner_tags.hpp"
#include "mesh_links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>
#include <unordered_set>
#include <vector>

namespace tetrakis {

namespace {

// Corners times reflex corners of a face up to which ears are tested for holding a reflex corner. Beyond it (a concave
// face of ten thousand corners) the order of the ears alone decides.
constexpr std::uint64_t k_reflex_budget = 100'000'000;

struct Ear {
    bool bad;             ///< backward, holding a reflex corner, or leaving a backward triangle
    double length2;       ///< of its diagonal, squared and rounded()
    std::uint32_t at;     ///< place of its tip in the polygon
    std::uint32_t round;  ///< of that place when the ear was looked at
    friend bool operator>(const Ear& a, const Ear& b) {
        return std::tie(a.bad, a.length2, a.at, a.round) > std::tie(b.bad, b.length2, b.at, b.round);
    }
};

/// To 12 bits: diagonals that are alike but for rounding tie, so that equal faces are cut alike.
double rounded(double x) {
    constexpr double k_steps = 4096;
    int exponent = 0;
    const double fraction = std::frexp(x, &exponent);
    return std::ldexp(std::round(k_steps * fraction) / k_steps, exponent);
}

class Triangulator {
  public:
    explicit Triangulator(const ControlMesh& mesh) : mesh_(mesh), in_(mesh.data()), out_(in_) {
        uses_ = detail::sorted_edge_uses(in_.face_offsets, in_.face_vertices, mesh.vertex_count());
    }

    ControlMeshData run() {
        out_.face_offsets.assign(1, 0);
        out_.face_vertices.clear();
        out_.face_uvs.clear();
        out_.face_normals.clear();
        out_.face_material.clear();
        out_.face_group.clear();
        out_.face_lines.clear();
        out_.holes.clear();
        out_.hole_lines.clear();
        std::vector<std::uint32_t> first(std::size_t{mesh_.face_count()} + 1);
        for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) {
            first[f] = triangle_count();
            face_ = f;
            cut_face();
        }
        first[mesh_.face_count()] = triangle_count();
        for (std::size_t i = 0; i < in_.holes.size(); ++i)
            for (std::uint32_t t = first[in_.holes[i]]; t < first[in_.holes[i] + 1]; ++t) {
                out_.holes.push_back(t);
                if (!in_.hole_lines.empty()) out_.hole_lines.push_back(in_.hole_lines[i]);
            }
        for (auto& tag : out_.corner_angles) tag.face = triangle_at(tag.vertex, first[tag.face]);
        keep_sharp_corners();
        out_.warnings.push_back(fmt::format("cut {} of {} faces into triangles", cut_count_, mesh_.face_count()));
        if (centre_count_ != 0)
            out_.warnings.push_back(
                fmt::format("{} of them got a new vertex in the middle, where no diagonal was free", centre_count_));
        return std::move(out_);
    }

  private:
    std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(out_.face_offsets.size() - 1); }
    std::uint32_t vertex(std::uint32_t place) const { return in_.face_vertices[first_ + place]; }
    const Vec3d& point(std::uint32_t place) const { return in_.positions[vertex(place)]; }

    // The first from `t` on that touches the vertex; diagonals are smooth, so its sector is that of the others.
    std::uint32_t triangle_at(std::uint32_t vertex, std::uint32_t t) const {
        while (detail::face_corner(out_, t, vertex) == HalfedgeId::none) ++t;
        return t;
    }

    void begin_triangle() {
        out_.face_offsets.push_back(out_.face_offsets.back() + 3);
        if (!in_.face_material.empty()) out_.face_material.push_back(in_.face_material[face_]);
        if (!in_.face_group.empty()) out_.face_group.push_back(in_.face_group[face_]);
        if (!in_.face_lines.empty()) out_.face_lines.push_back(in_.face_lines[face_]);
    }
    void add_corner(std::uint32_t place) {
        const std::uint32_t h = first_ + place;
        out_.face_vertices.push_back(in_.face_vertices[h]);
        if (!in_.face_uvs.empty()) out_.face_uvs.push_back(in_.face_uvs[h]);
        if (!in_.face_normals.empty()) out_.face_normals.push_back(in_.face_normals[h]);
    }
    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        begin_triangle();
        for (const std::uint32_t place : {a, b, c}) add_corner(place);
    }

    // Twice the triangle's area as seen along the face's normal.
    double facing(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        return glm::dot(normal_, glm::cross(point(b) - point(a), point(c) - point(a)));
    }

    bool is_free(std::uint32_t a, std::uint32_t b) const {
        const std::uint64_t low = std::min(vertex(a), vertex(b)), high = std::max(vertex(a), vertex(b));
        return !detail::find_edge(uses_, vertex(a), vertex(b)) && !diagonals_.contains(low << 32 | high);
    }

    void cut_face() {
        first_ = in_.face_offsets[face_];
        left_ = in_.face_offsets[face_ + 1] - first_;
        if (left_ == 3) return add_triangle(0, 1, 2);
        ++cut_count_;
        prepare_polygon();
        refill();
        while (left_ > 3 && !ears_.empty()) {
            const Ear ear = ears_.top();
            ears_.pop();
            if (ear.round != round_[ear.at]) continue;
            const std::uint32_t a = prev_[ear.at], b = next_[ear.at];
            if (!is_free(a, b)) continue;
            add_triangle(a, ear.at, b);
            const std::uint64_t low = std::min(vertex(a), vertex(b)), high = std::max(vertex(a), vertex(b));
            diagonals_.insert(low << 32 | high);
            remove(ear.at);
            if (left_ == 4) {
                refill();  // whether the other triangle faces backwards matters from now on
            } else {
                offer(a);
                offer(b);
            }
        }
        if (left_ == 3)
            add_triangle(prev_[start_], start_, next_[start_]);
        else
            add_fan();
    }

    void prepare_polygon() {
        prev_.resize(left_);
        next_.resize(left_);
        round_.assign(left_, 0);
        normal_ = Vec3d(0.0);
        for (std::uint32_t i = 0; i < left_; ++i) {
            prev_[i] = i == 0 ? left_ - 1 : i - 1;
            next_[i] = i + 1 == left_ ? 0 : i + 1;
            normal_ += glm::cross(point(i) - point(0), point(next_[i]) - point(0));
        }
        start_ = 0;
        reflex_.clear();
        for (std::uint32_t i = 0; i < left_; ++i)
            if (facing(prev_[i], i, next_[i]) < 0) reflex_.push_back(i);
        test_reflex_ = std::uint64_t{left_} * reflex_.size() <= k_reflex_budget;
    }

    void remove(std::uint32_t place) {
        next_[prev_[place]] = next_[place];
        prev_[next_[place]] = prev_[place];
        ++round_[place];
        start_ = prev_[place];
        prev_[place] = next_[place] = place;  // marks it as gone
        --left_;
    }

    void refill() {
        ears_ = {};
        std::uint32_t place = start_;
        do {
            offer(place);
            place = next_[place];
        } while (place != start_);
    }

    void offer(std::uint32_t tip) {
        const std::uint32_t a = prev_[tip], b = next_[tip];
        bool bad = facing(a, tip, b) <= 0;
        if (left_ == 4) bad = bad || facing(a, b, next_[b]) <= 0;
        if (test_reflex_ && !bad) bad = holds_reflex_corner(a, tip, b);
        const Vec3d diagonal = point(b) - point(a);
        ears_.push({bad, rounded(glm::dot(diagonal, diagonal)), tip, ++round_[tip]});
    }

    bool holds_reflex_corner(std::uint32_t a, std::uint32_t tip, std::uint32_t b) const {
        return std::ranges::any_of(reflex_, [&](std::uint32_t r) {
            const bool gone = next_[r] == r;
            return !gone && r != a && r != tip && r != b && facing(a, tip, r) >= 0 && facing(tip, b, r) >= 0 &&
                   facing(b, a, r) >= 0;
        });
    }

    void add_fan() {
        ++centre_count_;
        Vec3d centre(0.0), normal(0.0);
        Vec2d uv(0.0);
        std::uint32_t place = start_;
        do {
            const std::uint32_t h = first_ + place;
            centre += point(place);
            if (!in_.face_uvs.empty()) uv += in_.uvs[in_.face_uvs[h]];
            if (!in_.face_normals.empty()) normal += in_.normals[in_.face_normals[h]];
            place = next_[place];
        } while (place != start_);
        const double share = 1.0 / left_;
        const auto v = static_cast<std::uint32_t>(out_.positions.size());
        out_.positions.push_back(centre * share);
        if (!in_.vertex_lines.empty()) out_.vertex_lines.push_back(in_.face_lines.empty() ? 0 : in_.face_lines[face_]);
        if (!in_.face_uvs.empty()) {
            out_.uvs.push_back(uv * share);
            if (!in_.uv_lines.empty()) out_.uv_lines.push_back(0);
        }
        if (!in_.face_normals.empty()) out_.normals.push_back(normal * share);
        do {
            begin_triangle();
            add_corner(place);
            add_corner(next_[place]);
            out_.face_vertices.push_back(v);
            if (!in_.face_uvs.empty()) out_.face_uvs.push_back(static_cast<std::uint32_t>(out_.uvs.size() - 1));
            if (!in_.face_normals.empty())
                out_.face_normals.push_back(static_cast<std::uint32_t>(out_.normals.size() - 1));
            place = next_[place];
        } while (place != start_);
    }

    // A boundary corner of one face may have several triangles now and would lose its sharpness.
    void keep_sharp_corners() {
        if (in_.boundary_rule != BoundaryRule::edge_and_corner) return;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (mesh_.is_boundary(VertexId(v)) && mesh_.face_valence(VertexId(v)) == 1 &&
                mesh_.face_size(mesh_.face(mesh_.vertex_halfedge(VertexId(v)))) > 3)
                out_.corners.push_back({v, k_sharpness_infinity});
    }

    const ControlMesh& mesh_;
    const ControlMeshData& in_;
    ControlMeshData out_;
    std::vector<detail::EdgeUse> uses_;
    std::unordered_set<std::uint64_t> diagonals_;
    std::uint64_t cut_count_ = 0, centre_count_ = 0;

    // The face being cut: a ring of places, i.e. corners counted from its first one.
    std::uint32_t face_ = 0, first_ = 0, left_ = 0, start_ = 0;
    Vec3d normal_{0.0};
    std::vector<std::uint32_t> prev_, next_, round_, reflex_;
    bool test_reflex_ = false;
    std::priority_queue<Ear, std::vector<Ear>, std::greater<>> ears_;
};

}  // namespace

ControlMesh triangulate(const ControlMesh& mesh, const RunContext& context) {
    if (mesh.all_triangles()) return mesh;
    return ControlMesh::build(Triangulator(mesh).run(), context);
}

}  // namespace tetrakis
