#include "tetrakis/hier/sqrt3_forest.hpp"

#include "tetrakis/hier/error.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis {

Sqrt3Forest::Sqrt3Forest(const ControlMesh& mesh) : mesh_(&mesh), max_level_(Sqrt3Lattice::max_level(mesh)) {
    const auto refuse = [&](const std::string& what) {
        throw Error(ErrorCode::unsupported, "adaptive sqrt3 refinement takes no " + what, mesh.data().source);
    };
    if (!mesh.all_triangles()) refuse("other faces than triangles; triangulate the mesh");
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (mesh.is_hole(FaceId(f))) refuse("holes, and face " + std::to_string(f) + " is one");
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e)
        if (!mesh.is_boundary(EdgeId(e)) && mesh.sharpness(EdgeId(e)) > 0)
            refuse("creases inside the mesh, and that of half-edge " +
                   std::to_string(mesh.edge_halfedge(EdgeId(e)).value) + " is one");
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const float sharpness = mesh.sharpness(VertexId(v));
        if (sharpness > 0 && (!mesh.is_boundary(VertexId(v)) || sharpness != k_sharpness_infinity))
            refuse("tagged vertices but corners of the boundary, and vertex " + std::to_string(v) + " is tagged");
    }
}

std::size_t Sqrt3Forest::split_count() const {
    std::size_t count = 0;
    for (const auto& level : split_) count += level.size();
    return count;
}

bool Sqrt3Forest::is_there(Sqrt3Lattice& lattice, int level, std::uint64_t face) const {
    if (level == 0) return true;
    // The face `face` lies across the half-edge of that number.
    if (!is_split(level - 1, Sqrt3Lattice::face(face))) return false;
    const std::uint64_t twin = lattice.twin(level - 1, face);
    return twin == Sqrt3Lattice::none || is_split(level - 1, Sqrt3Lattice::face(twin));
}

void Sqrt3Forest::require_face(const Sqrt3Face& face) const {
    std::uint64_t count = mesh_->face_count();
    for (int k = 0; k < std::min<int>(face.level, max_level_); ++k) count *= 3;
    if (face.level > max_level_ || face.face >= count)
        throw Error(ErrorCode::invalid_input, "there is no face " + std::to_string(face.face) + " at level " +
                                                  std::to_string(face.level) + " of sqrt3 refinement");
}

bool Sqrt3Forest::is_split(const Sqrt3Face& face) const { return is_split(face.level, face.face); }

bool Sqrt3Forest::is_there(const Sqrt3Face& face) const {
    require_face(face);
    Sqrt3Lattice lattice(*mesh_);
    return is_there(lattice, face.level, face.face);
}

std::size_t Sqrt3Forest::refine(const Sqrt3Face& face) {
    require_face(face);
    if (face.level >= max_level_)
        throw Error(ErrorCode::unsupported, "level " + std::to_string(max_level_) +
                                                " is the deepest that has numbers; its faces cannot be split");
    if (is_split(face)) return 0;
    // What has to be split, the finest first.
    Sqrt3Lattice lattice(*mesh_);
    std::vector<std::unordered_set<std::uint64_t>> wanted(face.level + std::size_t{1});
    wanted[face.level].insert(face.face);
    for (int level = face.level; level > 0; --level)
        for (const std::uint64_t f : wanted[static_cast<std::size_t>(level)]) {
            auto& above = wanted[static_cast<std::size_t>(level) - 1];
            const auto need = [&](std::uint64_t parent) {
                if (!is_split(level - 1, parent)) above.insert(parent);
            };
            need(Sqrt3Lattice::face(f));
            if (const std::uint64_t t = lattice.twin(level - 1, f); t != Sqrt3Lattice::none)
                need(Sqrt3Lattice::face(t));
        }
    std::size_t count = 0;
    const std::size_t levels = split_.size();
    std::vector<std::pair<std::size_t, std::uint64_t>> done;
    try {
        for (const auto& level : wanted) count += level.size();
        done.reserve(count);
        if (levels < wanted.size()) split_.resize(wanted.size());
        for (std::size_t level = 0; level < wanted.size(); ++level)
            for (const std::uint64_t f : wanted[level]) {
                split_[level].insert(f);
                done.emplace_back(level, f);
            }
    } catch (...) {
        for (const auto& [level, f] : done) split_[level].erase(f);
        split_.resize(levels);
        throw;
    }
    return count;
}

std::size_t Sqrt3Forest::refine(const Sqrt3Leaf& leaf) {
    if (!leaf.half) return refine(Sqrt3Face{leaf.level, leaf.face});
    Sqrt3Lattice lattice(*mesh_);
    require_face({static_cast<std::uint8_t>(leaf.level + 1), leaf.face});
    const std::uint64_t twin = lattice.twin(leaf.level, leaf.face);
    if (twin == Sqrt3Lattice::none || !is_split(leaf.level, Sqrt3Lattice::face(leaf.face)))
        throw Error(ErrorCode::invalid_input,
                    "there is no half triangle over half-edge " + std::to_string(leaf.face) + " any more");
    return refine(Sqrt3Face{leaf.level, Sqrt3Lattice::face(twin)});
}

bool Sqrt3Forest::can_coarsen(const Sqrt3Face& face) const {
    if (!is_split(face)) return false;
    // Faces that come from it lie across its half-edges, each in two numbers, one for either face of the edge.
    Sqrt3Lattice lattice(*mesh_);
    for (std::uint64_t h = 3 * face.face; h < 3 * face.face + 3; ++h) {
        if (is_split(face.level + 1, h)) return false;
        const std::uint64_t twin = lattice.twin(face.level, h);
        if (twin != Sqrt3Lattice::none && is_split(face.level + 1, twin)) return false;
    }
    return true;
}

void Sqrt3Forest::coarsen(const Sqrt3Face& face) {
    if (!can_coarsen(face))
        throw Error(ErrorCode::invalid_input, "face " + std::to_string(face.face) + " of level " +
                                                  std::to_string(face.level) +
                                                  " is not split, or a face that comes from it is");
    split_[face.level].erase(face.face);
    while (!split_.empty() && split_.back().empty()) split_.pop_back();
}

std::vector<Sqrt3Leaf> Sqrt3Forest::leaves() const {
    std::vector<Sqrt3Leaf> result;
    Sqrt3Lattice lattice(*mesh_);
    std::vector<std::pair<int, std::uint64_t>> open;
    for (std::uint32_t root = 0; root < mesh_->face_count(); ++root) {
        open.emplace_back(0, root);
        while (!open.empty()) {
            const auto [level, face] = open.back();
            open.pop_back();
            Sqrt3Leaf leaf;
            leaf.level = static_cast<std::uint8_t>(level);
            leaf.control_face = FaceId(root);
            if (!is_split(level, face)) {
                leaf.face = face;
                for (std::size_t k = 0; k < 3; ++k) {
                    leaf.leaving[k] = 3 * face + k;
                    leaf.vertex[k] = lattice.origin(level, leaf.leaving[k]);
                    leaf.vertex_level[k] = leaf.level;
                }
                result.push_back(leaf);
                continue;
            }
            for (std::uint64_t h = 3 * face + 3; h-- > 3 * face;) {
                const std::uint64_t twin = lattice.twin(level, h);
                if (twin == Sqrt3Lattice::none || is_split(level, Sqrt3Lattice::face(twin))) {
                    open.emplace_back(level + 1, h);
                    continue;
                }
                leaf.half = true;
                leaf.face = h;
                leaf.leaving = {h, Sqrt3Lattice::next(h), 3 * h + 2};
                leaf.vertex = {lattice.origin(level, h), lattice.origin(level, leaf.leaving[1]),
                               lattice.apex(level, h)};
                leaf.vertex_level = {leaf.level, leaf.level, static_cast<std::uint8_t>(level + 1)};
                result.push_back(leaf);
            }
        }
    }
    return result;
}

std::vector<Sqrt3Face> Sqrt3Forest::split_faces() const {
    std::vector<Sqrt3Face> faces;
    for (std::size_t level = 0; level < split_.size(); ++level)
        for (const std::uint64_t f : split_[level]) faces.push_back({static_cast<std::uint8_t>(level), f});
    std::sort(faces.begin(), faces.end());
    return faces;
}

std::optional<std::string> Sqrt3Forest::check() const {
    Sqrt3Lattice lattice(*mesh_);
    for (const Sqrt3Face& face : split_faces())
        if (!is_there(lattice, face.level, face.face))
            return "face " + std::to_string(face.face) + " of level " + std::to_string(face.level) +
                   " is split but not there: a face that it comes from is whole";
    return std::nullopt;
}

std::uint64_t Sqrt3Forest::memory_bytes() const {
    std::uint64_t bytes = split_.capacity() * sizeof(split_[0]);
    // A node per face (number, link, rounded up by the allocator) and a pointer per bucket.
    constexpr std::uint64_t k_node = 32;
    for (const auto& level : split_) bytes += level.size() * k_node + level.bucket_count() * sizeof(void*);
    return bytes;
}

}  // namespace tetrakis
