#include "rule_mesh.hpp"

#include "corner_angles.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

[[noreturn]] void refuse(const char* what, int element) {
    throw std::invalid_argument(std::string(what) + " " + std::to_string(element));
}

}  // namespace

RuleMesh::RuleMesh(int vertex_count, Builder faces, std::vector<float> vertex_sharpness)
    : face_begin_(std::move(faces.face_begin_)),
      origin_(std::move(faces.origin_)),
      sharpness_(std::move(faces.sharpness_)),
      vertex_sharpness_(std::move(vertex_sharpness)),
      corner_angle_(std::move(faces.corner_angle_)) {
    const int halfedges = static_cast<int>(origin_.size());
    if (!vertex_sharpness_.empty() && static_cast<int>(vertex_sharpness_.size()) != vertex_count)
        throw std::invalid_argument("there must be one sharpness per vertex");
    face_.resize(halfedges);
    for (int f = 0; f < face_count(); ++f) {
        if (face_size(f) < 3) refuse("fewer than three corners in face", f);
        std::fill(face_.begin() + face_begin_[f], face_.begin() + face_begin_[f + 1], f);
    }
    for (const int v : origin_)
        if (v < 0 || v >= vertex_count) refuse("a face uses a vertex that does not exist:", v);

    const bool known = !faces.twin_.empty();
    if (known)
        twin_ = std::move(faces.twin_);
    else
        match_twins(std::move(faces.tag_));
    edge_.assign(halfedges, none);
    edge_halfedge_.reserve((halfedges + std::count(twin_.begin(), twin_.end(), none)) / 2);
    for (int h = 0; h < halfedges; ++h) {
        const int t = twin_[h];
        sharpness_[h] = t == none ? std::numeric_limits<float>::infinity() : std::max(sharpness_[h], sharpness_[t]);
        if (edge_[h] != none) continue;
        edge_[h] = edge_count();
        if (t != none) edge_[t] = edge_[h];
        edge_halfedge_.push_back(h);
    }
    first_.assign(vertex_count, none);
    for (int h = 0; h < halfedges; ++h) {
        int& first = first_[origin_[h]];
        if (first == none || twin_[h] == none) first = h;
    }
    if (!known) check_fans();
    take_corner_angles();
}

void RuleMesh::match_twins(std::vector<int> tags) {
    const int halfedges = halfedge_count();
    tags.resize(halfedges, 0);
    const int vertex_count = origin_.empty() ? 0 : 1 + *std::max_element(origin_.begin(), origin_.end());
    // Half-edges by their lower vertex: the few of one vertex are matched with each other.
    std::vector<int> begin(vertex_count + 1, 0), at_lower(halfedges);
    const auto lower = [&](int h) { return std::min(origin(h), target(h)); };
    const auto upper = [&](int h) { return std::max(origin(h), target(h)); };
    for (int h = 0; h < halfedges; ++h) ++begin[lower(h) + 1];
    for (int v = 0; v < vertex_count; ++v) begin[v + 1] += begin[v];
    std::vector<int> end(begin.begin(), begin.end() - 1);
    for (int h = 0; h < halfedges; ++h) at_lower[end[lower(h)]++] = h;
    const auto edge = [&](int h) { return std::pair(upper(h), tags[h]); };
    twin_.assign(halfedges, none);
    for (int v = 0; v < vertex_count; ++v) {
        // Those of one edge come one after another.
        std::sort(at_lower.begin() + begin[v], at_lower.begin() + begin[v + 1],
                  [&](int a, int b) { return std::pair(edge(a), a) < std::pair(edge(b), b); });
        for (int i = begin[v]; i + 1 < begin[v + 1]; ++i) {
            const int h = at_lower[i], other = at_lower[i + 1];
            if (edge(h) != edge(other)) continue;
            if (twin_[h] != none) refuse("more than two faces at the edge of half-edge", h);
            if (origin_[h] == origin_[other]) refuse("two faces of opposite sense at half-edge", h);
            twin_[h] = other;
            twin_[other] = h;
        }
    }
}

void RuleMesh::check_fans() const {
    std::vector<int> leaving(vertex_count(), 0);
    for (const int v : origin_) ++leaving[v];
    for (int v = 0; v < vertex_count(); ++v) {
        int met = 0;
        for_each_leaving(v, [&](int) { ++met; });
        if (met != leaving[v]) refuse("faces that share nothing but the vertex", v);
    }
}

void RuleMesh::take_corner_angles() {
    if (!has_corner_angles()) return;
    if (corner_angle_.size() != origin_.size())
        throw std::invalid_argument("there must be one corner angle per half-edge");
    for (int h = 0; h < halfedge_count(); ++h)
        if (corner_angle_[h] != 0 && !detail::is_corner_angle(corner_angle_[h]))
            refuse("a corner angle that is not in (0, 2 pi) or is pi, of half-edge", h);
    if (std::all_of(corner_angle_.begin(), corner_angle_.end(), [](double a) { return a == 0; })) corner_angle_ = {};
}

bool RuleMesh::all_faces_have(int corners) const {
    for (int f = 0; f < face_count(); ++f)
        if (face_size(f) != corners) return false;
    return true;
}

int RuleMesh::Ring::position(int vertex) const {
    return static_cast<int>(std::find(neighbour.begin(), neighbour.end(), vertex) - neighbour.begin());
}

RuleMesh::Ring RuleMesh::from(int start, bool stops_at_sharp_edges) const {
    Ring ring;
    for (int h = start; h != none;) {
        ring.halfedge.push_back(h);
        ring.neighbour.push_back(target(h));
        ring.sharpness.push_back(sharpness_[h]);
        const int into = prev(h);
        h = twin_[into];
        if (h == start) break;
        if (h != none && !(stops_at_sharp_edges && sharp(into))) continue;
        ring.closed = false;
        ring.neighbour.push_back(origin_[into]);
        ring.sharpness.push_back(sharpness_[into]);
        break;
    }
    return ring;
}

RuleMesh::Ring RuleMesh::ring(int v) const { return from(first_[v], false); }

RuleMesh::Ring RuleMesh::sector(int h) const {
    // Back, clockwise, to the sharp edge where the sector starts.
    int start = h;
    while (!sharp(start)) {
        start = next(twin_[start]);
        if (start == h) return ring(origin_[h]);
    }
    return from(start, true);
}

VertexRule RuleMesh::rule(int v) const { return vertex_rule(ring(v).sharpness, vertex_sharpness(v)); }

ShortList<int, 8> RuleMesh::sharp_neighbours(int v) const {
    const Ring r = ring(v);
    ShortList<int, 8> result;
    for (int i = 0; i < r.edges(); ++i)
        if (is_sharp(r.sharpness[i])) result.push_back(r.neighbour[i]);
    return result;
}

}  // namespace tetrakis
