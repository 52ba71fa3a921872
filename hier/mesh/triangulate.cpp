#include "triangulate.hpp"

#include "corner_tags.hpp"
#include "face_cutter.hpp"
#include "mesh_numbering.hpp"

#include <fmt/format.h>

#include <span>
#include <vector>

namespace tetrakis {

namespace {

class Triangulator {
  public:
    explicit Triangulator(const ControlMesh& mesh)
        : mesh_(mesh), in_(mesh.data()), out_(in_), cutter_(mesh, in_.positions) {}

    ControlMeshData run() {
        std::vector<std::uint32_t> first;  // first triangle of each face
        out_.holes.clear();
        out_.hole_lines.clear();
        for (face_ = 0; face_ < mesh_.face_count(); ++face_) {
            first.push_back(static_cast<std::uint32_t>(triangles_.sources.size()));
            cut_face();
            // If a face is dropped at the boundary, not all of its triangles might be dropped by themselves.
            if (mesh_.is_hole(FaceId(face_))) out_.holes.push_back(face_);
        }
        detail::replace_faces(out_, triangles_);
        for (auto& tag : out_.corner_angles) tag.face = triangle_at(tag.vertex, first[tag.face]);
        keep_sharp_corners();
        out_.warnings.push_back(fmt::format("cut {} of {} faces into triangles", cut_count_, mesh_.face_count()));
        if (centre_count_ != 0)
            out_.warnings.push_back(
                fmt::format("{} of them got a new vertex in the middle, where no diagonal was free", centre_count_));
        return std::move(out_);
    }

  private:
    // The first triangle from `t` on at the vertex. Diagonals are smooth, so all its triangles are in one sector.
    std::uint32_t triangle_at(std::uint32_t vertex, std::uint32_t t) const {
        while (detail::face_corner(out_, t, vertex) == HalfedgeId::none) ++t;
        return t;
    }

    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        triangles_.corners.insert(triangles_.corners.end(), {a, b, c});
        triangles_.end_face(face_);
    }

    void cut_face() {
        first_ = in_.face_offsets[face_];
        const std::uint32_t size = in_.face_offsets[face_ + 1] - first_;
        if (size == 3) return add_triangle(first_, first_ + 1, first_ + 2);
        ++cut_count_;
        const auto left = cutter_.cut(FaceId(face_), [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
            add_triangle(first_ + a, first_ + tip, first_ + b);
            cutter_.take(a, b);
        });
        if (!left.empty()) add_fan(left);
    }

    void add_fan(std::span<const std::uint32_t> places) {
        ++centre_count_;
        Vec3d centre(0.0), normal(0.0);
        Vec2d uv(0.0);
        for (const std::uint32_t place : places) {
            const std::uint32_t h = first_ + place;
            centre += in_.positions[in_.face_vertices[h]];
            if (!in_.face_uvs.empty()) uv += in_.uvs[in_.face_uvs[h]];
            if (!in_.face_normals.empty()) normal += in_.normals[in_.face_normals[h]];
        }
        const double share = 1.0 / static_cast<double>(places.size());
        const auto v = static_cast<std::uint32_t>(out_.positions.size());
        out_.positions.push_back(centre * share);
        if (!in_.vertex_lines.empty()) out_.vertex_lines.push_back(in_.face_lines.empty() ? 0 : in_.face_lines[face_]);
        // A corner for the centre, after the corners of the mesh.
        const auto corner = static_cast<std::uint32_t>(out_.face_vertices.size());
        out_.face_vertices.push_back(v);
        if (!in_.face_uvs.empty()) {
            out_.face_uvs.push_back(static_cast<std::uint32_t>(out_.uvs.size()));
            out_.uvs.push_back(uv * share);
            if (!in_.uv_lines.empty()) out_.uv_lines.push_back(0);
        }
        if (!in_.face_normals.empty()) {
            out_.face_normals.push_back(static_cast<std::uint32_t>(out_.normals.size()));
            out_.normals.push_back(normal * share);
        }
        for (std::size_t i = 0; i < places.size(); ++i)
            add_triangle(first_ + places[i], first_ + places[(i + 1) % places.size()], corner);
    }

    // A boundary corner of one face may have several triangles now, and would no longer be sharp.
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
    detail::NewFaces triangles_;
    std::uint64_t cut_count_ = 0, centre_count_ = 0;

    // The face being cut; its corners are counted from its first one.
    std::uint32_t face_ = 0, first_ = 0;
    detail::MeshFaceCutter cutter_;
};

}  // namespace

ControlMesh triangulate(const ControlMesh& mesh, const RunContext& context) {
    if (mesh.all_triangles()) return mesh;
    return ControlMesh::build(Triangulator(mesh).run(), context);
}

}  // namespace tetrakis
