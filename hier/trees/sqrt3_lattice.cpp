#include "sqrt3_lattice.hpp"

#include <algorithm>
#include <span>

namespace tetrakis {

namespace {

/// Moves points from the plane of a face to the plane of the adjacent face in which `middle` lies, if it lies outside.
void move_to_face(const ControlMesh& mesh, FaceId& face, Sqrt3Point middle, std::span<Sqrt3Point> points) {
    for (std::uint32_t side = 0; side < 3; ++side) {
        if (middle[(side + 2) % 3] >= 0) continue;
        const HalfedgeId h(3 * face.value + side);
        for (Sqrt3Point& p : points) p.weight = across(mesh, h, p.weight);
        face = mesh.face(mesh.twin(h));
        return;
    }
}

}  // namespace

Site sqrt3_site(const ControlMesh& mesh, FaceId face, Sqrt3Point p, int lattice) {
    move_to_face(mesh, face, p, {&p, 1});
    for (; lattice > 0 && p[1] % 3 == 0 && p[2] % 3 == 0; --lattice) p = p / 3;
    return canonical_triangle_site(mesh, face, p.weight, lattice);
}

// Centres of faces of even levels are the points of the next lattice whose coordinates are equal modulo 3.
int sqrt3_first_level(const Site& site) {
    return 2 * site.level - (site.level > 0 && site.at.x % 3 == site.at.y % 3 ? 1 : 0);
}

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
}

int Sqrt3Lattice::max_level(const ControlMesh& mesh) {
    std::uint64_t count = 3 * std::uint64_t{mesh.halfedge_count()};
    int level = 0;
    for (; count < none / 9; count *= 3) ++level;
    return level;
}

std::uint64_t Sqrt3Lattice::cut_side(int level, std::uint64_t f) {
    // After a step that flips the other edges, only a face's first half-edge can be on an edge that is not flipped.
    return cuts(level) && twin(level, 3 * f) == none ? 3 * f : none;
}

std::uint64_t Sqrt3Lattice::twin(int level, std::uint64_t h) {
    if (level == 0) {
        const HalfedgeId at(static_cast<std::uint32_t>(h)), t = mesh_->twin(at);
        return t.valid() && !(lines_ && line(0, h).is_cut()) ? t.value : none;
    }
    return twins(level, face(h)).of[h % 3];
}

// find_twin() only needs twins of the level above in the parent face, or in a face beside it that is cut. With twins
// stored per face, their number does not multiply from level to level.
const Sqrt3Lattice::Twins& Sqrt3Lattice::twins(int level, std::uint64_t f) {
    constexpr std::uint64_t k_golden = 0x9E37'79B9'7F4A'7C15ull;
    static_assert(k_kept_twins == 1u << 5);
    const auto end = static_cast<std::size_t>(level) * k_kept_twins;
    if (twins_.size() < end) twins_.resize(end);
    const std::size_t at = end - 1 - static_cast<std::size_t>(f * k_golden >> 59);
    if (twins_[at].face == f) return twins_[at];
    Twins found{f, {}};
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
    // A cut edge s from a to b of triangle (a, b, o): its first point stands over o -> a, its second one over b -> o.
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
    // The thirds of a cut edge s from a to b of triangle (a, b, o) belong to the triangles across o -> a, over s, and
    // across b -> o, in this order. Seen from the other side, their order is reversed.
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

std::uint64_t Sqrt3Lattice::partner(int level, std::uint64_t f) {
    if (!lines_ || !cuts(level)) return none;
    const std::uint64_t h = beyond(level, 3 * f);
    return h == none || is_hole(level, face(h)) ? none : face(h);
}

bool Sqrt3Lattice::is_line(const Sqrt3Cell& cell, std::size_t side, int level) const {
    for (std::uint32_t s = 0; s < 3; ++s) {
        const std::size_t away = (s + 2) % 3;
        if (cell.corner[side][away] != 0 || cell.corner[(side + 1) % 3][away] != 0) continue;
        const HalfedgeId h(3 * cell.root.value + s);
        const EdgeId e = mesh_->edge(h);
        return !mesh_->twin(h).valid() || is_kept(e) || mesh_->sharpness(e) > static_cast<float>(level / 2);
    }
    return false;
}

Sqrt3Point Sqrt3Lattice::apex(const Sqrt3Cell& cell, std::size_t side) {
    const auto& [a, b, c] = cell.corner;
    if (cell.level % 2 == 0) return a + b + c;
    if (!cell.cut) return (a + b + c) / 3;
    return side == 1 ? (a + 2 * b) / 3 : (2 * a + b) / 3;
}

// Two steps cut the edges of a face in three and the face in nine, whether edges are flipped or not.
Sqrt3Cell Sqrt3Lattice::child(const Sqrt3Cell& cell, std::size_t side) const {
    Sqrt3Cell child{cell.root, static_cast<std::uint8_t>(cell.level + 1), false, {}};
    if (cell.level % 2 == 0) {
        const Sqrt3Point &a = cell.corner[side], &b = cell.corner[(side + 1) % 3], &c = cell.corner[(side + 2) % 3];
        child.cut = is_line(cell, side, cell.level);
        child.corner = {3 * a, child.cut ? 3 * b : 2 * a + 2 * b - c, a + b + c};
        return child;
    }
    const auto& [a, other, centre] = cell.corner;
    const Sqrt3Point b = cell.cut ? other : other + centre - a, third = (b - a) / 3, first = a + third,
                     second = b - third;
    if (side == 2)
        child.corner = {centre, centre - third, first};
    else if (cell.cut)
        child.corner = side == 0 ? std::array{first, second, centre} : std::array{b, centre + third, second};
    else
        child.corner = side == 0 ? std::array{a, other - third, first} : std::array{other, second, first};
    return in_root(child);
}

Sqrt3Cell Sqrt3Lattice::in_root(Sqrt3Cell cell) const {
    move_to_face(*mesh_, cell.root, cell.corner[0] + cell.corner[1] + cell.corner[2], cell.corner);
    return cell;
}

Sqrt3Cell Sqrt3Lattice::cell(int level, std::uint64_t face) const {
    if (level == 0) return cell(FaceId(static_cast<std::uint32_t>(face)));
    return child(cell(level - 1, face / 3), static_cast<std::size_t>(face % 3));
}

Sqrt3Cell Sqrt3Lattice::half(const Sqrt3Cell& whole, std::size_t side) const {
    const std::int64_t scale = whole.level % 2 == 0 ? 3 : 1;
    return in_root({whole.root,
                    static_cast<std::uint8_t>(whole.level + 1),
                    false,
                    {scale * whole.corner[side], scale * whole.corner[(side + 1) % 3], apex(whole, side)}});
}

Sqrt3Cell Sqrt3Lattice::cell(const Sqrt3Triangle& t) const {
    return t.half ? half(cell(t.level - 1, t.face / 3), t.face % 3) : cell(t.level, t.face);
}

}  // namespace tetrakis
