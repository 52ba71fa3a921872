#include "mesh_part.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Calls visit(half-edge) for the half-edges that leave v, counter-clockwise. Returns whether they close.
template <class Visit>
bool for_each_leaving(const RuleMesh& mesh, int v, Visit&& visit) {
    const int first = mesh.first(v);
    for (int h = first; h != RuleMesh::none;) {
        visit(h);
        h = mesh.twin(mesh.prev(h));
        if (h == first) return true;
    }
    return false;
}

}  // namespace

int MeshPart::halfedge(const RuleMesh& whole, int h) const {
    const int f = whole.face(h);
    const auto at = std::lower_bound(face.begin(), face.end(), f);
    if (at == face.end() || *at != f) return RuleMesh::none;
    return mesh.face_begin(static_cast<int>(at - face.begin())) + (h - whole.face_begin(f));
}

MeshPart MeshPartFinder::find(const RuleMesh& mesh, std::span<const int> seeds, int rings) {
    const std::size_t vertices = static_cast<std::size_t>(mesh.vertex_count()),
                      faces = static_cast<std::size_t>(mesh.face_count());
    if (vertex_seen_.size() < vertices) {
        vertex_seen_.resize(vertices, 0);
        number_.resize(vertices);
    }
    if (face_kept_.size() < faces) {
        face_kept_.resize(faces, 0);
        face_begin_.resize(faces);
    }
    if (++stamp_ == 0) {
        std::fill(vertex_seen_.begin(), vertex_seen_.end(), 0u);
        std::fill(face_kept_.begin(), face_kept_.end(), 0u);
        stamp_ = 1;
    }
    MeshPart part;
    std::vector<int> front, next;
    const auto see = [&](int v) {
        if (vertex_seen_[v] == stamp_) return;
        vertex_seen_[v] = stamp_;
        part.vertex.push_back(v);
        next.push_back(v);
    };
    const auto keep = [&](int f) {
        if (face_kept_[f] == stamp_) return;
        face_kept_[f] = stamp_;
        part.face.push_back(f);
        for (const int v : mesh.corners(f)) see(v);
    };
    for (const int v : seeds) see(v);
    for (int ring = 0; ring < rings; ++ring) {
        front = std::exchange(next, {});
        for (const int v : front) for_each_leaving(mesh, v, [&](int h) { keep(mesh.face(h)); });
    }
    for (bool again = true; again;) {
        again = false;
        for (std::size_t i = 0; i < part.vertex.size(); ++i) {
            const int v = part.vertex[i];
            int fans = 0;
            bool before = false, first = false, any = false;
            const bool closed = for_each_leaving(mesh, v, [&](int h) {
                const bool here = face_kept_[mesh.face(h)] == stamp_;
                if (!any) first = here;
                fans += here && !before ? 1 : 0;
                before = here;
                any = true;
            });
            if (closed && first && before && fans > 1) --fans;
            if (fans < 2) continue;
            for_each_leaving(mesh, v, [&](int h) { keep(mesh.face(h)); });
            again = true;
        }
    }
    std::sort(part.face.begin(), part.face.end());
    std::sort(part.vertex.begin(), part.vertex.end());
    // Seeds without faces have no place in the part.
    std::erase_if(part.vertex, [&](int v) { return mesh.first(v) == RuleMesh::none; });
    for (std::size_t i = 0; i < part.vertex.size(); ++i) number_[part.vertex[i]] = static_cast<int>(i);
    int corners = 0;
    for (const int f : part.face) {
        face_begin_[f] = corners;
        corners += mesh.face_size(f);
    }
    RuleMesh::Builder builder;
    builder.reserve(part.face.size(), static_cast<std::size_t>(corners));
    std::vector<int> twins;
    twins.reserve(static_cast<std::size_t>(corners));
    std::vector<double> angles;
    for (const int f : part.face) {
        const int begin = mesh.face_begin(f);
        for (int h = begin; h < begin + mesh.face_size(f); ++h) {
            builder.corner(number_[mesh.origin(h)], mesh.sharpness(h));
            if (mesh.has_corner_angles()) angles.push_back(mesh.corner_angle(h));
            const int t = mesh.twin(h), beyond = t == RuleMesh::none ? 0 : mesh.face(t);
            const bool inside = t != RuleMesh::none && face_kept_[beyond] == stamp_;
            twins.push_back(inside ? face_begin_[beyond] + (t - mesh.face_begin(beyond)) : RuleMesh::none);
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
