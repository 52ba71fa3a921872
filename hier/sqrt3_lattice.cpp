#include "tetrakis/hier/sqrt3_lattice.hpp"

namespace tetrakis {

namespace {

// Twins kept per level: enough for the surroundings of what is worked on.
constexpr std::size_t k_most_twins = 1u << 16;

}  // namespace

Sqrt3Lattice::Sqrt3Lattice(const ControlMesh& mesh) : mesh_(&mesh) {
    for (std::uint32_t e = 0; e < mesh.edge_count() && closed_; ++e) closed_ = !mesh.is_boundary(EdgeId(e));
}

int Sqrt3Lattice::max_level(const ControlMesh& mesh) {
    std::uint64_t count = 3 * std::uint64_t{mesh.halfedge_count()};
    int level = 0;
    for (; count < none / 9; count *= 3) ++level;
    return level;
}

std::uint64_t Sqrt3Lattice::cut_side(int level, std::uint64_t f) {
    // Only the first half-edge of a face can be on the boundary after the step that keeps boundary edges.
    return cuts_boundary(level) && twin(level, 3 * f) == none ? 3 * f : none;
}

std::uint64_t Sqrt3Lattice::twin(int level, std::uint64_t h) {
    if (level == 0) {
        const HalfedgeId t = mesh_->twin(HalfedgeId(static_cast<std::uint32_t>(h)));
        return t.valid() ? t.value : none;
    }
    // Without boundary each level asks the one above for a single twin, which is cheaper than to look it up.
    if (closed_) return find_twin(level, h);
    if (twins_.size() <= static_cast<std::size_t>(level)) twins_.resize(static_cast<std::size_t>(level) + 1);
    const auto& known = twins_[static_cast<std::size_t>(level)];
    if (const auto at = known.find(h); at != known.end()) return at->second;
    const std::uint64_t found = find_twin(level, h);
    auto& twins = twins_[static_cast<std::size_t>(level)];
    if (twins.size() > k_most_twins) twins.clear();
    twins.emplace(h, found);
    return found;
}

std::uint64_t Sqrt3Lattice::find_twin(int level, std::uint64_t x) {
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3, t = twin(above, h);
    if (!cuts_boundary(above)) {
        if (j == 0) return t == none ? none : 3 * next(t) + 2;
        if (j == 1) return t == none ? 3 * next(h) + 2 : 3 * t + 1;
        const std::uint64_t side = twin(above, prev(h));
        return side == none ? 3 * prev(h) + 1 : 3 * side;
    }
    // A cut edge s, from a to b in the triangle (a, b, o): the first point stands over o -> a, the second over b -> o.
    const std::uint64_t s = cut_side(above, face(h));
    if (h == s) {
        if (j == 0) return none;
        return j == 1 ? 3 * twin(above, next(s)) : 3 * prev(s) + 2;
    }
    if (j == 1) return 3 * t + 1;
    if (j == 0) {
        const std::uint64_t beyond = cut_side(above, face(t));
        if (beyond == none) return 3 * next(t) + 2;
        return next(t) == beyond ? none : 3 * beyond + 1;
    }
    if (s == none) return 3 * twin(above, prev(h));
    return prev(h) == s ? none : 3 * s + 2;
}

Sqrt3Vertex Sqrt3Lattice::apex(int level, std::uint64_t h) {
    const auto birth = static_cast<std::uint8_t>(level + 1);
    const std::uint64_t s = cut_side(level, face(h));
    if (s == none) return {face(h), birth, Sqrt3Vertex::Kind::centre};
    return {s, birth, next(s) == h ? Sqrt3Vertex::Kind::second : Sqrt3Vertex::Kind::first};
}

Sqrt3Vertex Sqrt3Lattice::origin(int level, std::uint64_t x) {
    if (level == 0)
        return {mesh_->origin(HalfedgeId(static_cast<std::uint32_t>(x))).value, 0, Sqrt3Vertex::Kind::control};
    if (const std::uint64_t old = before(level, x); old != none) return origin(level - 1, old);
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3;
    if (cut_side(above, face(h)) == h)
        return {h, static_cast<std::uint8_t>(level), j == 0 ? Sqrt3Vertex::Kind::first : Sqrt3Vertex::Kind::second};
    return j == 2 ? apex(above, h) : apex(above, twin(above, h));
}

std::uint64_t Sqrt3Lattice::before(int level, std::uint64_t x) {
    const int above = level - 1;
    const std::uint64_t h = x / 3, j = x % 3;
    if (cut_side(above, face(h)) == h) return j == 2 ? prev(h) : none;
    if (j == 0) return h;
    return j == 1 && !cuts_boundary(above) && twin(above, h) == none ? next(h) : none;
}

std::uint64_t Sqrt3Lattice::after(int level, std::uint64_t h) {
    return cut_side(level, face(h)) == h ? 3 * twin(level, prev(h)) : 3 * h;
}

}  // namespace tetrakis
