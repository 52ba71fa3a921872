#include "sqrt3_lattice.hpp"

#include <algorithm>

namespace tetrakis {

Sqrt3Lattice::Sqrt3Lattice(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept) : mesh_(&mesh) {
    for (std::uint32_t f = 0; f < mesh.face_count() && !holes_; ++f) holes_ = mesh.is_hole(FaceId(f));
    const auto ends_hole = [&](EdgeId e) {
        const HalfedgeId h = mesh.edge_halfedge(e);
        return holes_ && mesh.is_hole(mesh.face(h)) != mesh.is_hole(mesh.face(mesh.twin(h)));
    };
    std::vector<std::uint8_t> keep;
    for (std::uint32_t i = 0; i < mesh.edge_count(); ++i) {
        const EdgeId e(i);
        if (mesh.is_boundary(e)) {
            smooth_ = false;
            continue;
        }
        const bool is_kept = ends_hole(e) || (kept && kept(e));
        if (is_kept) {
            keep.resize(mesh.edge_count(), 0);
            keep[i] = 1;
        }
        if (is_kept || mesh.sharpness(e) > 0) smooth_ = !(lines_ = true);
    }
    if (!keep.empty()) kept_ = std::make_shared<const std::vector<std::uint8_t>>(std::move(keep));
    for (std::uint32_t v = 0; v < mesh.vertex_count() && !tagged_; ++v) tagged_ = mesh.sharpness(VertexId(v)) > 0;
}

int Sqrt3Lattice::max_level(const ControlMesh& mesh) {
    std::uint64_t count = 3 * std::uint64_t{mesh.halfedge_count()};
    int level = 0;
    for (; count < none / 9; count *= 3) ++level;
    return level;
}

std::uint64_t Sqrt3Lattice::memory_bytes() const { return twins_.capacity() * sizeof(Twins); }

std::uint64_t Sqrt3Lattice::cut_side(int level, std::uint64_t f) {
    // Only the first half-edge of a face can be one that is not flipped after the step that flips the others.
    return cuts(level) && twin(level, 3 * f) == none ? 3 * f : none;
}

std::uint64_t Sqrt3Lattice::twin(int level, std::uint64_t h) {
    if (level == 0) {
        const HalfedgeId at(static_cast<std::uint32_t>(h)), t = mesh_->twin(at);
        return t.valid() && !(lines_ && line(0, h).is_cut()) ? t.value : none;
    }
    return twins(level, face(h)).of[h % 3];
}

// All twins of the level above that it takes are of the face there, or of one beside it that is cut: with them kept by
// faces, levels do not multiply.
const Sqrt3Lattice::Twins& Sqrt3Lattice::twins(int level, std::uint64_t f) {
    constexpr std::uint64_t k_golden = 0x9E37'79B9'7F4A'7C15ull;
    static_assert(k_kept_twins == 1u << 5);
    const auto end = static_cast<std::size_t>(level) * k_kept_twins;
    if (twins_.size() < end) twins_.resize(end);
    const std::size_t at = end - 1 - static_cast<std::size_t>(f * k_golden >> 59);
    if (twins_[at].face == f) return twins_[at];
    Twins found{f, {}};
    if (smooth_) {
        const std::uint64_t t = twin(level - 1, f), side = twin(level - 1, prev(f));
        found.of = {3 * next(t) + 2, 3 * t + 1, 3 * side};
        return twins_[at] = found;
    }
    for (std::uint64_t j = 0; j < 3; ++j) {
        found.of[j] = find_twin(level, 3 * f + j);
        if (found.of[j] != none || level % 2 != 0) continue;
        if (const Line ended = line(level, 3 * f + j); ended.beyond != none && !ended.is_cut())
            found.of[j] = ended.beyond;
    }
    return twins_[at] = found;
}

std::uint64_t Sqrt3Lattice::find_twin(int level, std::uint64_t x) {
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3;
    if (!cuts(above)) {
        const std::uint64_t t = twin(above, j == 2 ? prev(h) : h);
        if (j == 0) return t == none ? none : 3 * next(t) + 2;
        if (j == 1) return t == none ? 3 * next(h) + 2 : 3 * t + 1;
        return t == none ? 3 * prev(h) + 1 : 3 * t;
    }
    // A cut edge s, from a to b in the triangle (a, b, o): the first point stands over o -> a, the second over b -> o.
    const std::uint64_t s = cut_side(above, face(h));
    if (h == s) {
        if (j == 0) return none;
        return j == 1 ? 3 * twin(above, next(s)) : 3 * prev(s) + 2;
    }
    if (j == 2) {
        if (s == none) return 3 * twin(above, prev(h));
        return prev(h) == s ? none : 3 * s + 2;
    }
    const std::uint64_t t = twin(above, h);
    if (j == 1) return 3 * t + 1;
    const std::uint64_t beyond = cut_side(above, face(t));
    if (beyond == none) return 3 * next(t) + 2;
    return next(t) == beyond ? none : 3 * beyond + 1;
}

Sqrt3Lattice::Line Sqrt3Lattice::line(int level, std::uint64_t x) {
    if (!lines_) return {};
    if (level == 0) {
        const HalfedgeId at(static_cast<std::uint32_t>(x)), t = mesh_->twin(at);
        const EdgeId edge = mesh_->edge(at);
        const Line line{t.value, mesh_->sharpness(edge), is_kept(edge)};
        return t.valid() && line.is_cut() ? line : Line{};
    }
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3;
    if (j == 1) return {};
    if (!cuts(above)) {
        const Line same = j == 0 ? line(above, h) : Line{};
        return same.is_cut() ? Line{3 * same.beyond, same.sharpness, same.kept} : Line{};
    }
    // Of the thirds of a cut edge s, from a to b in the triangle (a, b, o), the triangle across o -> a has the first,
    // that of s the second, that of b -> o the third; seen from the other side they are the third, second and first.
    const auto third = [&](std::uint64_t s, auto&& other) {
        const Line cut = line(above, s);
        return cut.is_cut() ? Line{other(cut.beyond), std::max(cut.sharpness - 1, 0.0f), cut.kept} : Line{};
    };
    const std::uint64_t s = cut_side(above, face(h));
    if (j == 2) {
        if (s == none || prev(h) != s) return {};
        return third(s, [&](std::uint64_t beyond) { return 3 * twin(above, prev(beyond)); });
    }
    if (h == s) return third(s, [](std::uint64_t beyond) { return 3 * beyond; });
    const std::uint64_t t = twin(above, h), across = cut_side(above, face(t));
    if (across == none || next(t) != across) return {};
    return third(across, [](std::uint64_t beyond) { return 3 * next(beyond) + 2; });
}

float Sqrt3Lattice::sharpness(int level, std::uint64_t h) {
    if (twin(level, h) != none) return 0;
    const Line on = line(level, h);
    return on.beyond == none ? k_sharpness_infinity : on.sharpness;
}

std::uint64_t Sqrt3Lattice::partner(int level, std::uint64_t f) {
    if (!lines_ || !cuts(level)) return none;
    const std::uint64_t h = beyond(level, 3 * f);
    return h == none || is_hole(level, face(h)) ? none : face(h);
}

Sqrt3Vertex Sqrt3Lattice::on_edge(int level, std::uint64_t h, Sqrt3Vertex::Kind kind) {
    using Kind = Sqrt3Vertex::Kind;
    const auto birth = static_cast<std::uint8_t>(level + 1);
    const std::uint64_t other = beyond(level, h);
    if (other == none || owns_cut(level, face(h), face(other))) return {h, birth, kind};
    return {other, birth, kind == Kind::first ? Kind::second : Kind::first};
}

Sqrt3Vertex Sqrt3Lattice::apex(int level, std::uint64_t h) {
    const std::uint64_t s = cut_side(level, face(h));
    if (s == none) return {face(h), static_cast<std::uint8_t>(level + 1), Sqrt3Vertex::Kind::centre};
    return on_edge(level, s, next(s) == h ? Sqrt3Vertex::Kind::second : Sqrt3Vertex::Kind::first);
}

Sqrt3Vertex Sqrt3Lattice::origin(int level, std::uint64_t x) {
    if (level == 0)
        return {mesh_->origin(HalfedgeId(static_cast<std::uint32_t>(x))).value, 0, Sqrt3Vertex::Kind::control};
    if (const std::uint64_t old = before(level, x); old != none) return origin(level - 1, old);
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3;
    if (cut_side(above, face(h)) == h)
        return on_edge(above, h, j == 0 ? Sqrt3Vertex::Kind::first : Sqrt3Vertex::Kind::second);
    return j == 2 ? apex(above, h) : apex(above, twin(above, h));
}

std::uint64_t Sqrt3Lattice::before(int level, std::uint64_t x) {
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3;
    if (cut_side(above, face(h)) == h) return j == 2 ? prev(h) : none;
    if (j == 0) return h;
    return j == 1 && !cuts(above) && twin(above, h) == none ? next(h) : none;
}

std::uint64_t Sqrt3Lattice::after(int level, std::uint64_t h) {
    return cut_side(level, face(h)) == h ? 3 * twin(level, prev(h)) : 3 * h;
}

}  // namespace tetrakis
