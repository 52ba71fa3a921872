#include "sqrt3_net.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../schemes/rules/sqrt3.hpp"
#include "sqrt3_points.hpp"
#include "sqrt3_rules.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace tetrakis::detail {

Sqrt3Net::Sqrt3Net(const Sqrt3Levels& levels)
    : mesh_(&levels.lattice().mesh()), levels_(&levels), tagged_(levels.lattice().has_tagged_vertices()) {
    const std::size_t count = levels.vertices.size();
    points_ = reinterpret_cast<Vec3d*>(memory_[0].reserve(3 * count));
    next_points_ = reinterpret_cast<Vec3d*>(memory_[1].reserve(3 * count));
    for (auto* flags : {&has_, &next_has_}) resize_large(*flags, count);
    resize_large(leaving_, count);
    std::copy(mesh_->positions().begin(), mesh_->positions().end(), points_);
    std::fill_n(has_.begin(), mesh_->vertex_count(), std::uint8_t{1});
    const auto& twin = levels.levels[0].twin;
    has_cuts_ = std::find(twin.begin(), twin.end(), Sqrt3Level::none) != twin.end();
}

/// Makes points of the next level, and limits; what a thread needs for itself.
class Sqrt3Net::Worker {
  public:
    Worker(Sqrt3Net& net, const Limits& limits) : net_(net), levels_(*net.levels_), limits_(limits) {}

    /// Asks for what move() of a vertex will look at: first where that is, later, `at_once`, for itself.
    void prefetch(std::uint32_t vertex, bool at_once) const {
        const std::uint32_t face = new_face(vertex);
        if (face == Sqrt3Level::none) {
            const std::uint32_t leaving = net_.leaving_[vertex];
            if (at_once || leaving == Sqrt3Level::none) return;
            if (net_.all_raised_ && net_.level_ > 0) {
                __builtin_prefetch(&above().twin[leaving / 3]);
                return;
            }
            __builtin_prefetch(&here().twin[leaving]);
            __builtin_prefetch(&here().vertex[leaving]);
            return;
        }
        for (std::uint32_t h = 3 * face; h < 3 * face + 3; ++h) {
            const std::uint32_t t = above().twin[h];
            if (net_.is_whole()) {
                if (at_once) __builtin_prefetch(&point(net_.first_new_ + t / 3));
                continue;
            }
            if (!Sqrt3Level::there(t)) continue;
            const std::uint32_t& apex = above().apex[t / 3];
            if (!at_once)
                __builtin_prefetch(&apex);
            else if (Sqrt3Level::there(apex))
                __builtin_prefetch(&point(apex));
        }
    }
    /// Moves a vertex to the next level, and writes its limit.
    void move(std::uint32_t vertex);
    /// Makes the points over a face.
    void add_apex(std::uint32_t face);

  private:
    const Sqrt3Level& here() const { return net_.here(); }
    const Sqrt3Level& above() const { return levels_.levels[static_cast<std::size_t>(net_.level_ - 1)]; }
    bool has(std::uint32_t vertex) const { return net_.has_[vertex] != 0; }
    const Vec3d& point(std::uint32_t vertex) const { return net_.points_[vertex]; }
    void put(std::uint32_t vertex, const Vec3d& at) {
        net_.next_points_[vertex] = at;
        net_.next_has_[vertex] = 1;
    }
    /// The face that the last step has put a vertex into, or a guess; none where it did not.
    std::uint32_t new_face(std::uint32_t vertex) const {
        if (net_.level_ == 0 || vertex < net_.first_new_) return Sqrt3Level::none;
        // A cut face has more than one point; where no face is left out, faces have the lattice's numbers.
        const bool by_key = net_.has_cuts_ && net_.level_ % 2 == 0 && net_.all_raised_ &&
                            levels_.vertices[vertex].kind == Sqrt3Vertex::Kind::centre;
        const std::uint32_t face =
            by_key ? static_cast<std::uint32_t>(levels_.vertices[vertex].key) : vertex - net_.first_new_;
        return face < above().face_count() ? face : Sqrt3Level::none;
    }
    bool find_new(std::uint32_t vertex);
    bool gather_old(std::uint32_t vertex);
    void move_new(std::uint32_t vertex, std::uint32_t to);
    bool gather(std::uint32_t leaving);
    bool gather_cut(std::uint32_t leaving);
    void put_limit(std::uint32_t leaving, std::uint32_t to);
    bool beside_cut(std::uint32_t leaving) const;
    bool has_limit(std::uint32_t vertex, std::uint32_t leaving) const;

    Sqrt3Net& net_;
    const Sqrt3Levels& levels_;
    const Limits& limits_;
    Sqrt3Rules rules_;
    std::optional<Sqrt3Points> points_alone_;  // for limits beside darts
    const RingMask vertex_mask_ = Sqrt3::vertex_mask(6), limit_mask_ = Sqrt3::limit_mask(6);
    std::array<const Vec3d*, 6> new_ring_{};
    Sqrt3Ring ring_;
    std::vector<std::uint32_t> around_;  // the vertices around, where an edge is sharp
};

// The ring of a vertex that the last step has put into a face, as gather() has it, from that face and those around:
// without going around it from face to face. False where it is not as plain as that.
bool Sqrt3Net::Worker::find_new(std::uint32_t vertex) {
    const std::uint32_t face = new_face(vertex);
    if (face == Sqrt3Level::none) return false;
    const Sqrt3Level& level = above();
    std::array<std::uint32_t, 3> beyond;
    std::array<std::uint32_t, 6> around;
    if (net_.is_whole()) {
        for (std::uint32_t j = 0; j < 3; ++j) {
            beyond[j] = level.twin[3 * face + j];
            around[2 * j] = level.vertex[3 * face + j];
            around[2 * j + 1] = net_.first_new_ + beyond[j] / 3;
        }
    } else {
        const bool cuts = net_.level_ % 2 == 0;
        const auto is_raised = [&](std::uint32_t f) { return net_.all_raised_ || Sqrt3Level::there(level.child[f]); };
        if (level.apex[face] != vertex || !is_raised(face)) return false;
        for (std::uint32_t j = 0; j < 3; ++j) {
            const std::uint32_t t = beyond[j] = level.twin[3 * face + j];
            if (!Sqrt3Level::there(t) || !is_raised(t / 3)) return false;
            if (cuts && level.twin[t / 3 * 3] == Sqrt3Level::none) return false;
            around[2 * j] = level.vertex[3 * face + j];
            around[2 * j + 1] = level.apex[t / 3];
        }
        const auto is_there = [&](std::uint32_t w) { return Sqrt3Level::there(w) && has(w); };
        if (!net_.all_raised_ && !(has(vertex) && std::all_of(around.begin(), around.end(), is_there))) return false;
    }
    // The face before those over its sides is the first of them, or one beyond; each has the vertex for its last
    // corner.
    std::size_t first = 0, least = 3 * std::size_t{face};
    for (std::size_t j = 0; j < 3; ++j)
        if (beyond[j] < least) {
            least = beyond[j];
            first = 2 * j + 1;
        }
    for (std::size_t i = 0; i < 6; ++i) new_ring_[i] = &point(around[first + i < 6 ? first + i : first + i - 6]);
    return true;
}

// The ring of a vertex that has come before the last step, as gather() has it, where all edges were flipped: the points
// in the faces that the level before has around it. False where it is not as plain as that.
bool Sqrt3Net::Worker::gather_old(std::uint32_t vertex) {
    const bool tagged = net_.tagged_ && vertex < net_.mesh_->vertex_count();
    if (net_.level_ == 0 || !net_.all_raised_ || net_.may_be_flipped() || tagged) return false;
    // The first half-edge that left it there: the face over half-edge h has the number h, and starts with 3 h, where
    // none of those around is cut.
    const Sqrt3Level& level = above();
    const bool cuts = net_.has_cuts_ && net_.level_ % 2 == 0;
    const std::uint32_t leaving = net_.leaving_[vertex] / 3;
    if (net_.has_cuts_ && (level.vertex[leaving] != vertex || level.twin[leaving] == Sqrt3Level::none)) return false;
    ring_.point = point(vertex);
    ring_.closed = true;
    ring_.sharp.clear();
    ring_.vertex_sharpness = 0;
    ring_.around.assign(1, point(level.apex[level.twin[leaving] / 3]));
    for (std::uint32_t h = leaving;;) {
        const std::uint32_t next = level.twin[Sqrt3Level::prev(h)];
        if (next == Sqrt3Level::none || (cuts && level.twin[h / 3 * 3] == Sqrt3Level::none)) return false;
        if (next == leaving) return true;
        ring_.around.push_back(point(level.apex[h / 3]));
        h = next;
    }
}

// The ring of the vertex that a half-edge leaves, the first one that does; false where part of it is missing.
bool Sqrt3Net::Worker::gather(std::uint32_t leaving) {
    const Sqrt3Level& level = here();
    const std::uint32_t v = level.vertex[leaving];
    if (!has(v)) return false;
    ring_.point = point(v);
    ring_.closed = true;
    ring_.around.clear();
    ring_.sharp.clear();
    ring_.vertex_sharpness =
        net_.tagged_ ? Sqrt3Rules::vertex_sharpness(*net_.mesh_, levels_.vertices[v], net_.level_) : 0.0f;
    const bool kept = net_.may_be_flipped();
    for (std::uint32_t h = leaving;;) {
        if (kept && h % 3 == 2 && level.twin[h - 2] == Sqrt3Level::none) return gather_cut(leaving);
        const std::uint32_t w = level.vertex[Sqrt3Level::next(h)];
        if (!Sqrt3Level::there(w) || !has(w)) return false;
        ring_.around.push_back(point(w));
        h = level.twin[Sqrt3Level::prev(h)];
        if (h == leaving) break;
        if (h == Sqrt3Level::outside) return false;
        if (h == Sqrt3Level::none) return gather_cut(leaving);
    }
    return true;
}

// Whether kept edges are not as the rules see them: where smooth, they see them flipped.
bool Sqrt3Net::may_be_flipped() const { return level_ % 2 != 0 && levels_->lattice().has_kept(); }

// Whether an edge that the next step cuts is a kept one that is smooth.
bool Sqrt3Net::is_smooth_cut(std::uint32_t h) const {
    const Sqrt3Line* line = here().twin[h] == Sqrt3Level::none ? here().line(h) : nullptr;
    return line != nullptr && !(line->sharpness > 0);
}

// The same where some of the edges are not flipped, as Sqrt3Points::fan() has it.
bool Sqrt3Net::Worker::gather_cut(std::uint32_t leaving) {
    const Sqrt3Level& level = here();
    const bool kept = net_.may_be_flipped();
    const auto across = [&](std::uint32_t h) {
        if (level.twin[h] != Sqrt3Level::none) return level.twin[h];
        const Sqrt3Line* line = level.line(h);
        return line != nullptr ? line->beyond : Sqrt3Level::none;
    };
    // Clockwise to the boundary, or all around.
    std::uint32_t start = leaving;
    for (;;) {
        const std::uint32_t t = across(start);
        if (t == Sqrt3Level::outside) return false;
        ring_.closed = t != Sqrt3Level::none;
        if (!ring_.closed) break;
        start = Sqrt3Level::next(t);
        if (start == leaving) break;
    }
    ring_.around.clear();
    around_.clear();
    const auto add = [&](std::uint32_t to) {
        const std::uint32_t w = level.vertex[to];
        if (!Sqrt3Level::there(w) || !has(w)) return false;
        ring_.around.push_back(point(w));
        around_.push_back(w);
        return true;
    };
    const auto add_edge = [&](std::uint32_t edge, std::uint32_t to) {
        if (level.twin[edge] == Sqrt3Level::none) {
            const Sqrt3Line* line = level.line(edge);
            const float sharpness = line != nullptr ? line->sharpness : k_sharpness_infinity;
            if (sharpness > 0)
                ring_.sharp.emplace_back(ring_.around.size(), sharpness);
            else if (kept)
                return true;
        }
        return add(to);
    };
    for (std::uint32_t h = start;;) {
        if (!add_edge(h, Sqrt3Level::next(h))) return false;
        if (const std::uint32_t side = h / 3 * 3; kept && h % 3 == 2 && net_.is_smooth_cut(side)) {
            const std::uint32_t beyond = level.line(side)->beyond;
            if (beyond == Sqrt3Level::outside || !add(Sqrt3Level::prev(beyond))) return false;
        }
        const std::uint32_t behind = Sqrt3Level::prev(h);
        h = across(behind);
        if (h == Sqrt3Level::outside) return false;
        if (h == Sqrt3Level::none && !add_edge(behind, behind)) return false;
        if (h == Sqrt3Level::none || h == start) break;
    }
    return true;
}

bool Sqrt3Net::Worker::beside_cut(std::uint32_t leaving) const {
    if (!net_.has_cuts_) return false;
    const Sqrt3Level& level = here();
    std::uint32_t h = leaving;
    do {
        if (level.twin[h / 3 * 3] == Sqrt3Level::none && !net_.is_smooth_cut(h / 3 * 3)) return true;
        h = level.twin[Sqrt3Level::prev(h)];
    } while (h != leaving);
    return false;
}

// At its first level, or where that comes before a cut beside it, at the level after (Sqrt3Points::limit()). Of a ring
// that has been gathered.
bool Sqrt3Net::Worker::has_limit(std::uint32_t vertex, std::uint32_t leaving) const {
    const int birth = levels_.vertices[vertex].birth;
    if (birth == net_.level_) return net_.level_ % 2 == 0 || !beside_cut(leaving);
    return birth + 1 == net_.level_ && net_.level_ % 2 == 0;
}

void Sqrt3Net::Worker::put_limit(std::uint32_t leaving, std::uint32_t to) {
    limits_.found[to] = 1;
    // What a crease goes to may be a dart (Sqrt3Points::limit()).
    const bool alone =
        !here().lines.empty() && std::any_of(ring_.sharp.begin(), ring_.sharp.end(), [&](const auto& edge) {
            return levels_.vertices[around_[edge.first]].kind == Sqrt3Vertex::Kind::control;
        });
    if (alone) {
        if (!points_alone_) points_alone_.emplace(levels_.lattice());
        const Sqrt3Level& level = here();
        const LimitPoint point = points_alone_->limit(net_.level_, 3 * level.number[leaving / 3] + leaving % 3);
        limits_.positions[to] = point.position;
        if (!limits_.normals.empty()) limits_.normals[to] = point.normal;
    } else if (limits_.normals.empty()) {
        limits_.positions[to] = rules_.limit_position(ring_);
    } else {
        const LimitPoint point = rules_.limit(ring_);
        limits_.positions[to] = point.position;
        limits_.normals[to] = point.normal;
    }
}

void Sqrt3Net::Worker::add_apex(std::uint32_t face) {
    const Sqrt3Level& level = here();
    const std::uint32_t v = level.apex[face];
    if (v == Sqrt3Level::outside) return;
    std::array<Vec3d, 3> corner;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t w = level.vertex[3 * face + k];
        if (!net_.all_raised_ && (!Sqrt3Level::there(w) || !has(w))) return;
        corner[k] = point(w);
    }
    if (net_.is_whole() || levels_.vertices[v].kind == Sqrt3Vertex::Kind::centre) {
        put(v, Sqrt3Rules::centre(corner));
        return;
    }
    if (net_.is_smooth_cut(3 * face)) {
        const std::uint32_t beyond = level.line(3 * face)->beyond;
        const std::uint32_t w = Sqrt3Level::there(beyond) ? level.vertex[Sqrt3Level::prev(beyond)] : beyond;
        if (!Sqrt3Level::there(w) || !has(w)) return;
        for (std::uint32_t k = 0; k < 2; ++k) {
            const std::uint32_t to = k == 0 ? v : levels_.beside(v);
            put(to, Sqrt3Rules::beside_smooth(corner[k], corner[2], point(w)));
        }
        return;
    }
    for (std::uint32_t k = 0; k < 2; ++k) {
        if (!gather(3 * face + k)) continue;
        const Vec3d* beyond = nullptr;
        if (ring_.rule() == VertexRule::crease) {
            const std::size_t other = around_[ring_.sharp[0].first] == level.vertex[3 * face + 1 - k] ? 1 : 0;
            beyond = &ring_.around[ring_.sharp[other].first];
        }
        const std::uint32_t to = k == 0 ? v : levels_.beside(v);
        put(to, Sqrt3Rules::beside(corner[k], corner[1 - k], beyond));
    }
}

void Sqrt3Net::Worker::move(std::uint32_t vertex) {
    const bool last = net_.at_last();
    const std::uint32_t to = limits_.number.empty() ? no_number : limits_.number[vertex];
    const bool asked = to != no_number && limits_.found[to] == 0;
    if (last && !asked) return;
    if (!net_.may_be_flipped() && find_new(vertex)) {
        // Its limit is there at once: no edge around is one that the next step cuts.
        return move_new(vertex, asked ? to : no_number);
    }
    const std::uint32_t leaving = net_.leaving_[vertex];
    if (leaving == Sqrt3Level::none) return;
    if (!gather_old(vertex) && !gather(leaving)) return;
    if (asked && has_limit(vertex, leaving)) put_limit(leaving, to);
    if (!last) put(vertex, rules_.moved(ring_, net_.level_ % 2 != 0));
}

// move() of a vertex that find_new() has found.
// @param to  where its limit goes, if that is asked for
void Sqrt3Net::Worker::move_new(std::uint32_t vertex, std::uint32_t to) {
    const Vec3d& at = point(vertex);
    Vec3d around(0);
    for (const Vec3d* q : new_ring_) around += *q;
    if (!net_.at_last()) put(vertex, Sqrt3Rules::masked(vertex_mask_, at, around));
    if (to == no_number) return;
    limits_.found[to] = 1;
    limits_.positions[to] = Sqrt3Rules::masked(limit_mask_, at, around);
    if (limits_.normals.empty()) return;
    ring_.point = at;
    ring_.closed = true;
    ring_.sharp.clear();
    ring_.vertex_sharpness = 0;
    ring_.around.resize(6);
    for (std::size_t i = 0; i < 6; ++i) ring_.around[i] = *new_ring_[i];
    limits_.normals[to] = rules_.limit(ring_).normal;
}

// The vertices come in the order of their levels.
std::uint32_t Sqrt3Net::born_at(int level) const {
    const auto& vertices = levels_->vertices;
    const auto end = std::partition_point(vertices.begin(), vertices.end(),
                                          [&](const Sqrt3Vertex& v) { return static_cast<int>(v.birth) <= level; });
    return static_cast<std::uint32_t>(end - vertices.begin());
}

// By vertices, not by half-edges: which of those are the first ones cannot be foretold.
void Sqrt3Net::find_leaving() {
    const Sqrt3Level& level = here();
    std::fill_n(leaving_.begin(), born_at(level_), Sqrt3Level::none);
    for (auto h = static_cast<std::uint32_t>(level.vertex.size()); h-- > 0;)
        if (const std::uint32_t v = level.vertex[h]; Sqrt3Level::there(v)) leaving_[v] = h;
}

void Sqrt3Net::step(const Limits& limits) {
    constexpr std::uint32_t k_ahead = 8;         // vertices whose rings are asked for ahead of time
    constexpr std::uint32_t k_block = 1u << 13;  // vertices or faces; each block has masks of its own
    std::fill_n(next_has_.begin(), born_at(level_ + 1), std::uint8_t{0});
    first_new_ = level_ == 0 ? 0 : born_at(level_ - 1);
    // On the last level the older ones have had their limits, unless some edges are cut, or rings not whole.
    const bool new_alone = is_whole() && at_last() && level_ > 0;
    if (!new_alone) find_leaving();
    const std::uint32_t first = new_alone ? first_new_ : 0;
    for_each_block(born_at(level_) - first, k_block, [&](std::uint32_t block_begin, std::uint32_t block_end) {
        const std::uint32_t begin = first + block_begin, end = first + block_end;
        Worker worker(*this, limits);
        for (std::uint32_t v = begin; v < end; ++v) {
            if (v + 2 * k_ahead < end) worker.prefetch(v + 2 * k_ahead, false);
            if (v + k_ahead < end) worker.prefetch(v + k_ahead, true);
            worker.move(v);
        }
    });
    if (at_last()) return;
    const Sqrt3Level& level = here();
    const bool cuts = level_ % 2 != 0;
    const auto is_cut = [&](std::uint32_t f) { return cuts && level.twin[3 * f] == Sqrt3Level::none; };
    for_each_block(level.face_count(), k_block, [&](std::uint32_t begin, std::uint32_t end) {
        Worker worker(*this, limits);
        for (std::uint32_t f = begin; f < end; ++f)
            if (!is_cut(f)) worker.add_apex(f);
    });
    // The faces on both sides of a cut edge write the same points: not at the same time.
    Worker worker(*this, limits);
    for (std::uint32_t f = 0; cuts && f < level.face_count(); ++f)
        if (is_cut(f)) worker.add_apex(f);
    std::swap(points_, next_points_);
    std::swap(has_, next_has_);
    // Children are numbered one after the other.
    all_raised_ = all_raised_ && !level.child.empty() && level.child.back() == 3 * (level.face_count() - 1);
    ++level_;
}

}  // namespace tetrakis::detail
