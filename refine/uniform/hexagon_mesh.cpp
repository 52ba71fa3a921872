#include "hexagon_mesh.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetrakis::detail {

namespace {

/// The polygon of the next level that a half-edge has a side of: the hexagon of a smooth edge,
///   { u, V + next(t), V + t, v, V + next(h), V + h }   for the edge's halves h from u to v, and t,
/// or its own pentagon along a sharp one, { u, middle, v, V + next(h), V + h }, where V + h is the corner that the face
/// of h gets at its origin.
enum Side : std::uint32_t { first_of_hexagon, second_of_hexagon, of_pentagon };
constexpr std::uint32_t k_side_bits = 2;

constexpr std::uint32_t packed(std::uint32_t begin, Side side) { return begin << k_side_bits | side; }
constexpr std::uint32_t side_of(std::uint32_t polygon) { return polygon & ((1u << k_side_bits) - 1); }
/// Where a corner of the polygon is, by the side of the half-edge that it is seen from.
constexpr std::uint32_t place(std::uint32_t polygon, const std::uint32_t (&by_side)[3]) {
    return (polygon >> k_side_bits) + by_side[side_of(polygon)];
}
constexpr std::uint32_t k_at_origin[3] = {0, 3, 0}, k_at_target[3] = {3, 0, 2}, k_corner_ahead[3] = {4, 1, 3},
                        k_corner[3] = {5, 2, 4}, k_middle[3] = {0, 0, 1};

std::vector<HexagonMesh::Sharp> children(std::span<const HexagonMesh::Sharp> vertices) {
    std::vector<HexagonMesh::Sharp> finer;
    for (const auto& [v, sharpness] : vertices)
        if (const float s = child_sharpness(sharpness); is_sharp(s)) finer.push_back({v, s});
    return finer;
}

}  // namespace

HexagonMesh::HexagonMesh(const RuleMesh& mesh, std::vector<std::uint32_t> control_face)
    : vertex_count_(static_cast<std::uint32_t>(mesh.vertex_count())), control_face_(std::move(control_face)) {
    Turns turns;
    for (int f = 0; f < mesh.face_count(); ++f) {
        face_begin_.push_back(static_cast<std::uint32_t>(mesh.face_begin(f) + mesh.face_size(f)));
        turns[static_cast<std::uint32_t>(mesh.face_size(f))];
    }
    for (const std::uint32_t size : {k_pentagon_size, k_hexagon_size}) turns[size];
    for (auto& [size, turn] : turns)
        for (std::uint32_t i = 0; i < size; ++i) {
            const double angle = 2 * std::numbers::pi * i / size;
            turn.emplace_back(std::cos(angle), std::sin(angle));
        }
    turns_ = std::make_shared<const Turns>(std::move(turns));
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        const int t = mesh.twin(h);
        origin_.push_back(static_cast<std::uint32_t>(mesh.origin(h)));
        twin_.push_back(t == RuleMesh::none ? none : static_cast<std::uint32_t>(t));
        if (mesh.sharp(h) && (t == RuleMesh::none || h < t))
            sharp_edges_.push_back({static_cast<std::uint32_t>(h), mesh.sharpness(h)});
    }
    leaving_begin_.push_back(0);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) != RuleMesh::none)
            for (const int h : mesh.ring(v).halfedge) leaving_.push_back(static_cast<std::uint32_t>(h));
        leaving_begin_.push_back(static_cast<std::uint32_t>(leaving_.size()));
        if (const float s = mesh.vertex_sharpness(v); is_sharp(s))
            sharp_vertices_.push_back({static_cast<std::uint32_t>(v), s});
    }
    find_tagged();
}

std::uint32_t HexagonMesh::face(std::uint32_t h) const {
    return static_cast<std::uint32_t>(std::upper_bound(face_begin_.begin(), face_begin_.end(), h) -
                                      face_begin_.begin() - 1);
}

void HexagonMesh::find_tagged() {
    struct End {
        std::uint32_t vertex, other;
        float sharpness;
    };
    std::vector<End> ends;
    for (const auto& [h, sharpness] : sharp_edges_) {
        const std::uint32_t u = origin_[h], v = origin_[next(h)];
        ends.push_back({u, v, sharpness});
        ends.push_back({v, u, sharpness});
    }
    std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
        return a.vertex != b.vertex ? a.vertex < b.vertex : a.other < b.other;
    });
    std::vector<float> sharpness;
    auto tag = sharp_vertices_.begin();
    for (auto end = ends.begin(); end != ends.end() || tag != sharp_vertices_.end();) {
        const std::uint32_t v =
            std::min(end != ends.end() ? end->vertex : none, tag != sharp_vertices_.end() ? tag->number : none);
        sharpness.clear();
        Tagged of{v, VertexRule::smooth, false, {none, none}};
        for (; end != ends.end() && end->vertex == v; ++end) {
            if (sharpness.size() < std::size(of.ends)) of.ends[sharpness.size()] = end->other;
            sharpness.push_back(end->sharpness);
        }
        const bool has_tag = tag != sharp_vertices_.end() && tag->number == v;
        const float own = has_tag ? tag++->sharpness : 0;
        of.rule = vertex_rule(sharpness, own);
        of.semi_sharp = is_semi_sharp(own) || std::any_of(sharpness.begin(), sharpness.end(), is_semi_sharp);
        tagged_.push_back(of);
    }
}

/// Adds their faces to the old ones, in the order of the half-edges. Returns each half-edge's.
std::vector<std::uint32_t> HexagonMesh::add_polygons(HexagonMesh& fine) const {
    const std::uint32_t count = halfedge_count();
    constexpr std::uint32_t k_second = none - 1;  // of a sharp edge
    std::vector<std::uint32_t> polygon(count, none);
    const std::size_t faces = face_count() + count / 2 + sharp_edges_.size() + 1;
    reserve_large(fine.face_begin_, faces + 1);
    reserve_large(fine.control_face_, faces);
    fine.face_begin_ = face_begin_;
    fine.control_face_ = control_face_;
    std::uint32_t begin = count;
    auto sharp = sharp_edges_.begin();
    for (std::uint32_t f = 0; f < face_count(); ++f)
        for (std::uint32_t h = face_begin_[f]; h < face_begin_[f + 1]; ++h) {
            const bool first = sharp != sharp_edges_.end() && sharp->number == h;
            if (first) {
                if (twin_[h] != none) polygon[twin_[h]] = k_second;
                ++sharp;
            } else if (polygon[h] != none && polygon[h] != k_second) {
                continue;
            }
            if (first || polygon[h] == k_second) {
                polygon[h] = packed(begin, of_pentagon);
                begin += k_pentagon_size;
            } else {
                polygon[h] = packed(begin, first_of_hexagon);
                polygon[twin_[h]] = packed(begin, second_of_hexagon);
                begin += k_hexagon_size;
            }
            fine.face_begin_.push_back(begin);
            fine.control_face_.push_back(control_face_[f]);
        }
    return polygon;
}

HexagonMesh HexagonMesh::finer(Use use) const {
    HexagonMesh fine;
    fine.turns_ = turns_;
    const std::uint32_t old = vertex_count_;
    fine.vertex_count_ = old + halfedge_count() + static_cast<std::uint32_t>(sharp_edges_.size());
    const std::vector<std::uint32_t> polygon = add_polygons(fine);
    const bool twins = use != Use::faces;
    resize_large(fine.origin_, fine.face_begin_.back());
    if (twins) resize_large(fine.twin_, fine.origin_.size());
    std::uint32_t *const origin = fine.origin_.data(), *const twin = fine.twin_.data();
    const auto glue = [&](std::uint32_t a, std::uint32_t b) {
        twin[a] = b;
        twin[b] = a;
    };
    for_each_index(face_count(), [&](std::uint32_t f) {
        const std::uint32_t begin = face_begin_[f], end = face_begin_[f + 1];
        std::uint32_t before = polygon[end - 1];
        for (std::uint32_t h = begin; h < end; ++h) {
            const std::uint32_t next = h + 1 < end ? h + 1 : begin, of = polygon[h];
            origin[h] = old + h;
            origin[place(of, k_at_origin)] = origin_[h];
            origin[place(of, k_corner_ahead)] = old + next;
            origin[place(of, k_corner)] = old + h;
            if (side_of(of) == of_pentagon) origin[place(of, k_at_target)] = origin_[next];
            if (!twins) continue;
            glue(h, place(of, k_corner_ahead));
            glue(place(of, k_corner), place(before, k_at_target));
            before = of;
        }
    });
    std::uint32_t middle = old + halfedge_count();
    for (const auto& [h, sharpness] : sharp_edges_) {
        const std::uint32_t t = twin_[h], here = place(polygon[h], k_at_origin);
        origin[here + 1] = middle;
        if (t != none) origin[place(polygon[t], k_middle)] = middle;
        ++middle;
        if (!twins) continue;
        if (t != none) {
            const std::uint32_t there = place(polygon[t], k_at_origin);
            glue(here, there + 1);
            glue(here + 1, there);
        } else {
            twin[here] = twin[here + 1] = none;
        }
        if (const float s = child_sharpness(sharpness); is_sharp(s))
            for (const std::uint32_t half : {here, here + 1}) fine.sharp_edges_.push_back({half, s});
    }
    fine.sharp_vertices_ = children(sharp_vertices_);
    if (!twins) return fine;
    set_leaving(polygon, fine);
    fine.find_tagged();
    return fine;
}

void HexagonMesh::set_leaving(std::span<const std::uint32_t> polygon, HexagonMesh& fine) const {
    const std::uint32_t old = vertex_count_, corners = halfedge_count();
    const auto is_sharp_edge = [&](std::uint32_t h) { return side_of(polygon[h]) == of_pentagon; };
    std::vector<std::uint32_t>& begin = fine.leaving_begin_;
    resize_large(begin, fine.vertex_count_ + std::size_t{1});
    // A sharp edge has a polygon on either side.
    begin[0] = 0;
    auto tag = tagged_.begin();
    for (std::uint32_t v = 0; v < old; ++v) {
        std::uint32_t count = leaving_begin_[v + 1] - leaving_begin_[v];
        if (tag != tagged_.end() && tag->vertex == v) {
            for (const std::uint32_t h : leaving(v)) count += is_sharp_edge(prev(h)) ? 1 : 0;
            ++tag;
        }
        begin[v + 1] = begin[v] + count;
    }
    constexpr std::uint32_t k_edges = 3;
    const std::uint32_t first = begin[old];
    for_each_index(corners, [&](std::uint32_t h) { begin[old + h + 1] = first + k_edges * (h + 1); });
    std::uint32_t v = old + corners;
    for (const Sharp& edge : sharp_edges_) {
        begin[v + 1] = begin[v] + (twin_[edge.number] == none ? 1 : 2);
        ++v;
    }
    resize_large(fine.leaving_, begin.back());
    std::uint32_t* const leaving_fine = fine.leaving_.data();
    const auto start_at_first = [&](std::uint32_t of) {
        const auto from = fine.leaving_.begin() + begin[of], to = fine.leaving_.begin() + begin[of + 1];
        if (from != to && fine.twin_[*from] != none) std::rotate(from, std::min_element(from, to), to);
    };
    for_each_index(old, [&](std::uint32_t of) {
        std::uint32_t* to = leaving_fine + begin[of];
        const auto around = leaving(of);
        const bool plain = begin[of + 1] - begin[of] == around.size();
        for (const std::uint32_t h : around) {
            *to++ = place(polygon[h], k_at_origin);
            if (plain) continue;
            if (const std::uint32_t into = prev(h); is_sharp_edge(into)) *to++ = place(polygon[into], k_at_target);
        }
        start_at_first(of);
    });
    for_each_index(face_count(), [&](std::uint32_t f) {
        std::uint32_t before = polygon[face_begin_[f + 1] - 1];
        for (std::uint32_t h = face_begin_[f]; h < face_begin_[f + 1]; ++h) {
            std::uint32_t* const to = leaving_fine + first + k_edges * h;
            to[0] = h;
            to[1] = place(before, k_corner_ahead);
            to[2] = place(polygon[h], k_corner);
            before = polygon[h];
        }
    });
    v = old + corners;
    for (const Sharp& edge : sharp_edges_) {
        leaving_fine[begin[v]] = place(polygon[edge.number], k_middle);
        if (const std::uint32_t t = twin_[edge.number]; t != none)
            leaving_fine[begin[v] + 1] = place(polygon[t], k_middle);
        start_at_first(v++);
    }
}

// Doo and Sabin's weights: a quarter of the point, three of the mean, and what turns with the corners.
void HexagonMesh::refine_face(std::span<const Vec3d> p, Vec3d* to) const {
    const std::size_t size = p.size();
    if (size == k_hexagon_size) {
        const Vec3d mean = 0.125 * ((p[0] + p[3]) + (p[1] + p[4]) + (p[2] + p[5]));
        const Vec3d d[3] = {p[0] - p[3], p[1] - p[4], p[2] - p[5]};
        constexpr double k_whole = 1.0 / 12, k_half = 1.0 / 24;
        const Vec3d turning[3] = {k_whole * d[0] + k_half * (d[1] - d[2]), k_whole * d[1] + k_half * (d[0] + d[2]),
                                  k_whole * d[2] + k_half * (d[1] - d[0])};
        for (std::size_t i = 0; i < 3; ++i) {
            to[i] = 0.25 * p[i] + (mean + turning[i]);
            to[i + 3] = 0.25 * p[i + 3] + (mean - turning[i]);
        }
        return;
    }
    const auto& turn = turns_->find(static_cast<std::uint32_t>(size))->second;
    Vec3d sum(0), cosines(0), sines(0);
    for (std::size_t i = 0; i < size; ++i) {
        sum += p[i];
        cosines += turn[i].first * p[i];
        sines += turn[i].second * p[i];
    }
    for (std::size_t i = 0; i < size; ++i)
        to[i] = 0.25 * p[i] +
                (0.75 * sum + 0.5 * (turn[i].first * cosines + turn[i].second * sines)) / static_cast<double>(size);
}

Vec3d HexagonMesh::refine_corner(std::span<const Vec3d> p, std::size_t i) const {
    const std::size_t size = p.size();
    const auto& turn = turns_->find(static_cast<std::uint32_t>(size))->second;
    Vec3d sum(0);
    for (std::size_t j = 0; j < size; ++j) sum += (0.75 + 0.5 * turn[(j + size - i) % size].first) * p[j];
    return 0.25 * p[i] + sum / static_cast<double>(size);
}

void HexagonMesh::refine(const Vec3d* points, Vec3d* finer) const {
    Vec3d* const corner = finer + vertex_count_;
    for_each_block(face_count(), k_default_grain, [&](std::uint32_t begin_face, std::uint32_t end_face) {
        std::vector<Vec3d> of_face(k_hexagon_size);
        for (std::uint32_t f = begin_face; f < end_face; ++f) {
            const std::uint32_t begin = face_begin_[f], size = face_begin_[f + 1] - begin;
            if (of_face.size() < size) of_face.resize(size);
            for (std::uint32_t i = 0; i < size; ++i) of_face[i] = points[origin_[begin + i]];
            refine_face({of_face.data(), size}, corner + begin);
        }
    });
    for_each_index(vertex_count_, [&](std::uint32_t v) {
        const auto around = leaving(v);
        Vec3d sum(0);
        for (const std::uint32_t h : around) sum += corner[h];
        finer[v] = around.empty() ? points[v] : sum / static_cast<double>(around.size());
    });
    for (const Tagged& tagged : tagged_) {
        const Vec3d& p = points[tagged.vertex];
        if (tagged.rule == VertexRule::corner) finer[tagged.vertex] = p;
        if (tagged.rule == VertexRule::crease)
            finer[tagged.vertex] = 0.75 * p + 0.125 * (points[tagged.ends[0]] + points[tagged.ends[1]]);
    }
    Vec3d* middle = corner + halfedge_count();
    for (const Sharp& edge : sharp_edges_)
        *middle++ = 0.5 * (points[origin_[edge.number]] + points[origin_[next(edge.number)]]);
}

}  // namespace tetrakis::detail
