#include "triangulate.hpp"

#include "corner_tags.hpp"
#include "face_cutter.hpp"
#include "mesh_links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <unordered_set>
#include <vector>

namespace tetrakis {

namespace {

class Triangulator {
  public:
    explicit Triangulator(const ControlMeshData& mesh)
        : in_(mesh),
          out_(in_),
          uses_(detail::sorted_edge_uses(in_.face_offsets, in_.face_vertices,
                                         static_cast<std::uint32_t>(in_.positions.size()))) {}

    /// @param mesh  what the data are of; null: they need not be a surface, and have no tags
    ControlMeshData run(const ControlMesh* mesh) {
        out_.face_offsets.assign(1, 0);
        out_.face_vertices.clear();
        out_.face_uvs.clear();
        out_.face_normals.clear();
        out_.face_material.clear();
        out_.face_group.clear();
        out_.face_lines.clear();
        out_.holes.clear();
        out_.hole_lines.clear();
        const auto face_count = static_cast<std::uint32_t>(in_.face_offsets.size() - 1);
        std::vector<std::uint32_t> first(std::size_t{face_count} + 1);
        for (face_ = 0; face_ < face_count; ++face_) {
            first[face_] = triangle_count();
            cut_face();
        }
        first[face_count] = triangle_count();
        if (mesh == nullptr) return std::move(out_);
        // Of a face that is dropped at the boundary not all triangles might be dropped by themselves.
        for (std::uint32_t f = 0; f < face_count; ++f)
            if (mesh->is_hole(FaceId(f)))
                for (std::uint32_t t = first[f]; t < first[f + std::size_t{1}]; ++t) out_.holes.push_back(t);
        for (auto& tag : out_.corner_angles) tag.face = triangle_at(tag.vertex, first[tag.face]);
        keep_sharp_corners(*mesh);
        out_.warnings.push_back(fmt::format("cut {} of {} faces into triangles", cut_count_, face_count));
        if (centre_count_ != 0)
            out_.warnings.push_back(
                fmt::format("{} of them got a new vertex in the middle, where no diagonal was free", centre_count_));
        return std::move(out_);
    }

  private:
    std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(out_.face_offsets.size() - 1); }
    std::uint32_t vertex(std::uint32_t place) const { return in_.face_vertices[first_ + place]; }

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

    bool is_free(std::uint32_t a, std::uint32_t b) const {
        return !detail::find_edge(uses_, vertex(a), vertex(b)) && !diagonals_.contains(edge(a, b));
    }
    std::uint64_t edge(std::uint32_t a, std::uint32_t b) const {
        const std::uint64_t low = std::min(vertex(a), vertex(b)), high = std::max(vertex(a), vertex(b));
        return low << 32 | high;
    }

    void cut_face() {
        first_ = in_.face_offsets[face_];
        const std::uint32_t size = in_.face_offsets[face_ + 1] - first_;
        if (size == 3) return add_triangle(0, 1, 2);
        ++cut_count_;
        points_.clear();
        for (std::uint32_t i = 0; i < size; ++i) points_.push_back(in_.positions[vertex(i)]);
        const std::span<const std::uint32_t> left = cutter_.cut(
            points_, [&](std::uint32_t a, std::uint32_t b) { return is_free(a, b); },
            [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
                add_triangle(a, tip, b);
                diagonals_.insert(edge(a, b));
            });
        if (!left.empty()) add_fan(left);
    }

    void add_fan(std::span<const std::uint32_t> places) {
        ++centre_count_;
        Vec3d centre(0.0), normal(0.0);
        Vec2d uv(0.0);
        for (const std::uint32_t place : places) {
            const std::uint32_t h = first_ + place;
            centre += in_.positions[vertex(place)];
            if (!in_.face_uvs.empty()) uv += in_.uvs[in_.face_uvs[h]];
            if (!in_.face_normals.empty()) normal += in_.normals[in_.face_normals[h]];
        }
        const double share = 1.0 / static_cast<double>(places.size());
        const auto v = static_cast<std::uint32_t>(out_.positions.size());
        out_.positions.push_back(centre * share);
        if (!in_.vertex_lines.empty()) out_.vertex_lines.push_back(in_.face_lines.empty() ? 0 : in_.face_lines[face_]);
        if (!in_.face_uvs.empty()) {
            out_.uvs.push_back(uv * share);
            if (!in_.uv_lines.empty()) out_.uv_lines.push_back(0);
        }
        if (!in_.face_normals.empty()) out_.normals.push_back(normal * share);
        for (std::size_t i = 0; i < places.size(); ++i) {
            begin_triangle();
            add_corner(places[i]);
            add_corner(places[(i + 1) % places.size()]);
            out_.face_vertices.push_back(v);
            if (!in_.face_uvs.empty()) out_.face_uvs.push_back(static_cast<std::uint32_t>(out_.uvs.size() - 1));
            if (!in_.face_normals.empty())
                out_.face_normals.push_back(static_cast<std::uint32_t>(out_.normals.size() - 1));
        }
    }

    // A boundary corner of one face may have several triangles now and would lose its sharpness.
    void keep_sharp_corners(const ControlMesh& mesh) {
        if (in_.boundary_rule != BoundaryRule::edge_and_corner) return;
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            if (mesh.is_boundary(VertexId(v)) && mesh.face_valence(VertexId(v)) == 1 &&
                mesh.face_size(mesh.face(mesh.vertex_halfedge(VertexId(v)))) > 3)
                out_.corners.push_back({v, k_sharpness_infinity});
    }

    const ControlMeshData& in_;
    ControlMeshData out_;
    std::vector<detail::EdgeUse> uses_;
    std::unordered_set<std::uint64_t> diagonals_;
    std::uint64_t cut_count_ = 0, centre_count_ = 0;

    // The face being cut; its places are corners counted from its first one.
    std::uint32_t face_ = 0, first_ = 0;
    detail::FaceCutter cutter_;
    std::vector<Vec3d> points_;
};

}  // namespace

ControlMesh triangulate(const ControlMesh& mesh, const RunContext& context) {
    if (mesh.all_triangles()) return mesh;
    return ControlMesh::build(Triangulator(mesh.data()).run(&mesh), context);
}

ControlMeshData detail::cut_faces(const ControlMeshData& mesh) { return Triangulator(mesh).run(nullptr); }

}  // namespace tetrakis
