#include "mesh_part.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis::detail {

int MeshPart::halfedge(const RuleMesh& whole, int h) const {
    const int f = whole.face(h);
    const auto at = std::lower_bound(face.begin(), face.end(), f);
    if (at == face.end() || *at != f) return RuleMesh::none;
    return mesh.face_begin(static_cast<int>(at - face.begin())) + (h - whole.face_begin(f));
}

void MeshPartFinder::look(const RuleMesh& mesh, std::span<const int> seeds, int rings) {
    const std::size_t vertices = static_cast<std::size_t>(mesh.vertex_count()),
                      faces = static_cast<std::size_t>(mesh.face_count());
    if (vertex_seen_.size() < vertices) {
        vertex_seen_.resize(vertices, 0);
        vertex_place_.resize(vertices);
    }
    if (face_kept_.size() < faces) {
        face_kept_.resize(faces, 0);
        face_place_.resize(faces);
    }
    if (++stamp_ == 0) {
        std::fill(vertex_seen_.begin(), vertex_seen_.end(), 0u);
        std::fill(face_kept_.begin(), face_kept_.end(), 0u);
        stamp_ = 1;
    }
    faces_.clear();
    vertices_.clear();
    const auto see = [&](int v) {
        if (std::exchange(vertex_seen_[v], stamp_) == stamp_) return;
        vertex_place_[v] = static_cast<int>(vertices_.size());
        vertices_.push_back(v);
    };
    const auto keep = [&](int f) {
        if (std::exchange(face_kept_[f], stamp_) == stamp_) return;
        face_place_[f] = static_cast<int>(faces_.size());
        faces_.push_back(f);
        for (const int v : mesh.corners(f)) see(v);
    };
    const auto keep_around = [&](int v) { mesh.for_each_leaving(v, [&](int h) { keep(mesh.face(h)); }); };
    for (const int v : seeds)
        if (mesh.first(v) != RuleMesh::none) see(v);
    std::size_t inside = 0;  // the number of first vertices all of whose faces are found
    for (int ring = 0; ring < rings; ++ring)
        for (const std::size_t end = vertices_.size(); inside < end; ++inside) keep_around(vertices_[inside]);
    for (bool again = true; again;) {
        again = false;
        for (std::size_t i = inside; i < vertices_.size(); ++i) {
            int fans = 0;
            bool before = false, first = false, any = false;
            const bool closed = mesh.for_each_leaving(vertices_[i], [&](int h) {
                const bool here = has_face(mesh.face(h));
                if (!any) first = here;
                fans += here && !before ? 1 : 0;
                before = here;
                any = true;
            });
            if (closed && first && before && fans > 1) --fans;
            if (fans < 2) continue;
            keep_around(vertices_[i]);
            again = true;
        }
    }
}

MeshPart MeshPartFinder::find(const RuleMesh& mesh, std::span<const int> seeds, int rings) {
    look(mesh, seeds, rings);
    MeshPart part;
    part.face = faces_;
    part.vertex = vertices_;
    std::sort(part.face.begin(), part.face.end());
    std::sort(part.vertex.begin(), part.vertex.end());
    for (std::size_t i = 0; i < part.vertex.size(); ++i) vertex_place_[part.vertex[i]] = static_cast<int>(i);
    std::vector<int> face_begin;
    int corners = 0;
    for (std::size_t i = 0; i < part.face.size(); ++i) {
        face_place_[part.face[i]] = static_cast<int>(i);
        face_begin.push_back(corners);
        corners += mesh.face_size(part.face[i]);
    }
    RuleMesh::Builder builder;
    builder.reserve(part.face.size(), static_cast<std::size_t>(corners));
    std::vector<int> twins;
    twins.reserve(static_cast<std::size_t>(corners));
    std::vector<double> angles;
    for (const int f : part.face) {
        const int begin = mesh.face_begin(f);
        for (int h = begin; h < begin + mesh.face_size(f); ++h) {
            builder.corner(vertex_place_[mesh.origin(h)], mesh.sharpness(h));
            if (mesh.has_corner_angles()) angles.push_back(mesh.corner_angle(h));
            const int t = mesh.twin(h), beyond = t == RuleMesh::none ? 0 : mesh.face(t);
            const bool inside = t != RuleMesh::none && has_face(beyond);
            twins.push_back(inside ? face_begin[face_place_[beyond]] + (t - mesh.face_begin(beyond)) : RuleMesh::none);
        }
        builder.end_face();
    }
    builder.set_twins(std::move(twins));
    builder.set_corner_angles(std::move(angles));
    std::vector<float> sharpness;
    if (!mesh.vertex_sharpness().empty())
        for (const int v : part.vertex) sharpness.push_back(mesh.vertex_sharpness(v));
    part.mesh = RuleMesh(static_cast<int>(part.vertex.size()), std::move(builder), std::move(sharpness));
    return part;
}

}  // namespace tetrakis::detail
