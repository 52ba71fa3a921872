#include "sqrt3_forest.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "sqrt3_levels.hpp"

#include <algorithm>
#include <cstddef>

namespace tetrakis {

Sqrt3Forest::Sqrt3Forest(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept)
    : mesh_(&mesh), lattice_(mesh, kept), max_level_(Sqrt3Lattice::max_level(mesh)) {
    if (!mesh.all_triangles())
        throw Error(ErrorCode::unsupported,
                    "adaptive sqrt3 refinement takes no other faces than triangles; triangulate the mesh",
                    mesh.data().source);
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) roots_ += mesh.is_hole(FaceId(f)) ? 0 : 1;
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
    const bool numbered = face.level <= max_level_ && face.face < count;
    if (!numbered || lattice_.is_hole(face.level, face.face))
        throw Error(ErrorCode::invalid_input, "there is no face " + std::to_string(face.face) + " at level " +
                                                  std::to_string(face.level) + " of sqrt3 refinement" +
                                                  (numbered ? ": it lies in a hole" : ""));
}

bool Sqrt3Forest::is_split(const Sqrt3Face& face) const { return is_split(face.level, face.face); }

bool Sqrt3Forest::is_there(const Sqrt3Face& face) const {
    require_face(face);
    Sqrt3Lattice lattice = lattice_;
    return is_there(lattice, face.level, face.face);
}

void Sqrt3Forest::refuse_depth() const {
    throw Error(ErrorCode::unsupported,
                "level " + std::to_string(max_level_) + " is the deepest that has numbers; its faces cannot be split");
}

std::vector<Sqrt3Face> Sqrt3Forest::needed(const Sqrt3Face& face) const {
    require_face(face);
    if (face.level >= max_level_) refuse_depth();
    if (is_split(face)) return {};
    Sqrt3Lattice lattice = lattice_;
    std::vector<Sqrt3Face> wanted{face};
    add_needed(lattice, wanted);
    return wanted;
}

std::size_t Sqrt3Forest::refine(const Sqrt3Face& face) { return split_all(needed(face)); }

// Adds to a face what has to be split with it or before it, the finest first.
void Sqrt3Forest::add_needed(Sqrt3Lattice& lattice, std::vector<Sqrt3Face>& wanted) const {
    for (std::size_t begin = 0; begin < wanted.size();) {
        const std::uint8_t level = wanted[begin].level;
        // Those of one level come one after another.
        const auto need = [&](int at, std::uint64_t face) {
            const Sqrt3Face f{static_cast<std::uint8_t>(at), face};
            if (is_split(at, face)) return;
            for (std::size_t k = wanted.size(); k-- > 0 && wanted[k].level == f.level;)
                if (wanted[k] == f) return;
            wanted.push_back(f);
        };
        std::size_t end = wanted.size();
        for (std::size_t i = begin; i < end; ++i)
            if (const std::uint64_t partner = lattice.partner(level, wanted[i].face); partner != Sqrt3Lattice::none)
                need(level, partner);
        end = wanted.size();
        for (std::size_t i = begin; i < end && level > 0; ++i) {
            const std::uint64_t h = wanted[i].face, t = lattice.twin(level - 1, h);
            need(level - 1, Sqrt3Lattice::face(h));
            if (t != Sqrt3Lattice::none) need(level - 1, Sqrt3Lattice::face(t));
        }
        begin = end;
    }
}

// Faces that are split already do not count; all or nothing.
std::size_t Sqrt3Forest::split_all(std::span<const Sqrt3Face> faces) {
    const std::size_t levels = split_.size();
    std::size_t deepest = 0, done = 0, count = 0;
    for (const Sqrt3Face& f : faces) deepest = std::max<std::size_t>(deepest, f.level + std::size_t{1});
    detail::PoolVector<std::uint8_t> fresh(faces.size(), 0);
    if (levels < deepest) split_.resize(deepest);
    try {
        for (; done < faces.size(); ++done) count += fresh[done] = split_[faces[done].level].insert(faces[done].face);
    } catch (...) {
        while (done-- > 0)
            if (fresh[done] != 0) split_[faces[done].level].erase(faces[done].face);
        split_.resize(levels);
        throw;
    }
    return count;
}

std::size_t Sqrt3Forest::refine_where(const std::function<bool(const Sqrt3Leaf&)>& wanted) {
    detail::PoolVector<Sqrt3Face> faces;
    std::vector<Sqrt3Face> needed;
    Sqrt3Lattice lattice = lattice_;
    const Sqrt3Levels levels(lattice_, split_, 0);
    levels.for_each_leaf([&](int level, std::uint32_t face, bool half, FaceId control_face) {
        const Sqrt3Leaf leaf = levels.leaf(level, face, half, control_face);
        if (!wanted(leaf)) return;
        if (level >= max_level_) refuse_depth();
        const Sqrt3Level& at = levels.levels[static_cast<std::size_t>(level)];
        if (!half && (level % 2 == 0 || at.line(3 * face) == nullptr)) {
            faces.push_back({leaf.level, leaf.face});  // it is there, and has no partner: what it needs has been split
            return;
        }
        needed.assign(1, {leaf.level, half ? Sqrt3Lattice::face(lattice.twin(level, leaf.face)) : leaf.face});
        add_needed(lattice, needed);
        faces.insert(faces.end(), needed.begin(), needed.end());
    });
    return split_all(faces);
}

std::size_t Sqrt3Forest::refine(std::span<const Sqrt3Face> faces) {
    std::vector<Sqrt3Face> all, wanted;
    Sqrt3Lattice lattice = lattice_;
    for (const Sqrt3Face& face : faces) {
        require_face(face);
        if (face.level >= max_level_) refuse_depth();
        wanted.assign(1, face);
        add_needed(lattice, wanted);
        all.insert(all.end(), wanted.begin(), wanted.end());
    }
    return split_all(all);
}

std::size_t Sqrt3Forest::refine_closed(std::span<const Sqrt3Face> faces) {
    for (const Sqrt3Face& face : faces)
        if (face.level >= max_level_) refuse_depth();
    return split_all(faces);
}

std::size_t Sqrt3Forest::refine(const Sqrt3Leaf& leaf) { return split_all(needed(leaf)); }

std::vector<Sqrt3Face> Sqrt3Forest::needed(const Sqrt3Leaf& leaf) const {
    if (!leaf.half) return needed(Sqrt3Face{leaf.level, leaf.face});
    Sqrt3Lattice lattice = lattice_;
    require_face({static_cast<std::uint8_t>(leaf.level + 1), leaf.face});
    const std::uint64_t twin = lattice.twin(leaf.level, leaf.face);
    if (twin == Sqrt3Lattice::none || !is_split(leaf.level, Sqrt3Lattice::face(leaf.face)))
        throw Error(ErrorCode::invalid_input,
                    "there is no half triangle over half-edge " + std::to_string(leaf.face) + " any more");
    return needed(Sqrt3Face{leaf.level, Sqrt3Lattice::face(twin)});
}

bool Sqrt3Forest::has_split_children(Sqrt3Lattice& lattice, const Sqrt3Face& face) const {
    // Faces that come from it lie across its half-edges, each in two numbers, one for either face of the edge.
    for (std::uint64_t h = 3 * face.face; h < 3 * face.face + 3; ++h) {
        if (is_split(face.level + 1, h)) return true;
        const std::uint64_t twin = lattice.twin(face.level, h);
        if (twin != Sqrt3Lattice::none && is_split(face.level + 1, twin)) return true;
    }
    return false;
}

bool Sqrt3Forest::can_coarsen(const Sqrt3Face& face) const {
    if (!is_split(face)) return false;
    Sqrt3Lattice lattice = lattice_;
    if (has_split_children(lattice, face)) return false;
    const std::uint64_t partner = lattice.partner(face.level, face.face);
    return partner == Sqrt3Lattice::none || !has_split_children(lattice, {face.level, partner});
}

void Sqrt3Forest::coarsen(std::span<const Sqrt3Face> faces) {
    for (const Sqrt3Face& face : faces)
        if (!can_coarsen(face))
            throw Error(ErrorCode::invalid_input, "face " + std::to_string(face.face) + " of level " +
                                                      std::to_string(face.level) +
                                                      " is not split, or a face that comes from it is");
    std::vector<Sqrt3Face> partners;
    if (lattice_.has_lines()) {
        Sqrt3Lattice lattice = lattice_;
        for (const Sqrt3Face& face : faces)
            if (const std::uint64_t partner = lattice.partner(face.level, face.face); partner != Sqrt3Lattice::none)
                partners.push_back({face.level, partner});
    }
    for (const Sqrt3Face& face : faces) split_[face.level].erase(face.face);
    for (const Sqrt3Face& face : partners) split_[face.level].erase(face.face);
    while (!split_.empty() && split_.back().empty()) split_.pop_back();
}

std::vector<Sqrt3Leaf> Sqrt3Forest::leaves() const {
    const Sqrt3Levels levels(lattice_, split_, 0);
    std::vector<Sqrt3Leaf> result;
    detail::reserve_large(result, leaf_count());
    levels.for_each_leaf([&](int level, std::uint32_t face, bool half, FaceId control_face) {
        result.push_back(levels.leaf(level, face, half, control_face));
    });
    return result;
}

std::vector<Sqrt3Face> Sqrt3Forest::split_faces() const {
    std::vector<Sqrt3Face> faces;
    for (std::size_t level = 0; level < split_.size(); ++level)
        for (const std::uint64_t f : split_[level].sorted()) faces.push_back({static_cast<std::uint8_t>(level), f});
    return faces;
}

std::optional<std::string> Sqrt3Forest::check() const {
    Sqrt3Lattice lattice = lattice_;
    for (const Sqrt3Face& face : split_faces()) {
        const auto fault = [&](const char* what) {
            return "face " + std::to_string(face.face) + " of level " + std::to_string(face.level) + " is split but " +
                   what;
        };
        if (!is_there(lattice, face.level, face.face)) return fault("not there: a face that it comes from is whole");
        const std::uint64_t partner = lattice.partner(face.level, face.face);
        if (partner != Sqrt3Lattice::none && !is_split(face.level, partner))
            return fault("its partner is not, so the edge between them is cut on one side");
    }
    return std::nullopt;
}

std::uint64_t Sqrt3Forest::memory_bytes() const {
    std::uint64_t bytes = split_.capacity() * sizeof(split_[0]);
    for (const NumberSet& level : split_) bytes += level.memory_bytes();
    return bytes;
}

}  // namespace tetrakis
