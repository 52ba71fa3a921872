#include "regular_limit.hpp"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace tetrakis::detail {

RuleMesh RegularLimit::lattice_mesh(FanLattice lattice, int rings) {
    const int n = 2 * rings + 1;
    RuleMesh::Builder faces;
    for (int y = 0; y + 1 < n; ++y)
        for (int x = 0; x + 1 < n; ++x) {
            const int v = y * n + x;
            if (lattice == FanLattice::triangles) {
                faces.face({v, v + 1, v + n});
                faces.face({v + 1, v + n + 1, v + n});
            } else {
                faces.face({v, v + 1, v + n + 1, v + n});
            }
        }
    return RuleMesh(n * n, std::move(faces));
}

RegularLimit::RegularLimit(FanLattice lattice, int rings, const StencilRow& limit, std::span<const StencilRow> tangents)
    : valence_(lattice == FanLattice::triangles ? 6 : 4), size_(lattice == FanLattice::triangles ? 3 : 4) {
    const RuleMesh mesh = lattice_mesh(lattice, rings);
    // The rim is not regular.
    const int most = rings - 1;
    radius_ = most;
    look_at(mesh);
    if (!walk(mesh, middle(rings), most)) throw std::logic_error("a lattice that is not regular");
    struct Offset {
        int x = 0, y = 0;
        bool walked = false;
    };
    std::vector<Offset> offset(mesh.vertex_count());
    for (int y = -most; y <= most; ++y)
        for (int x = -most; x <= most; ++x)
            if (inside(x, y, most)) offset[around_[place(x, y)]] = {x, y, true};
    const auto reach = [&](const StencilRow& row) {
        int farthest = 0;
        for (const auto& [v, weight] : row.terms) {
            if (!offset[v].walked) throw std::logic_error("a mask that reaches the rim");
            const auto [x, y, walked] = offset[v];
            const int hexagonal = size_ == 3 ? std::abs(x + y) : 0;
            farthest = std::max({farthest, std::abs(x), std::abs(y), hexagonal});
        }
        return farthest;
    };
    int radius = reach(limit);
    for (const StencilRow& row : tangents) radius = std::max(radius, reach(row));
    radius_ = std::max(radius, 1);
    side_ = 2 * radius_ + 1;
    const auto terms = [&](const StencilRow& row) {
        Terms result;
        for (const auto& [v, weight] : row.terms) result.push_back({place(offset[v].x, offset[v].y), weight});
        return result;
    };
    limit_ = terms(limit);
    if (tangents.size() == 2) {
        tangent1_ = terms(tangents[0]);
        tangent2_ = terms(tangents[1]);
    }
    around_.assign(static_cast<std::size_t>(side_) * side_, RuleMesh::none);
}

std::size_t RegularLimit::place(int x, int y) const {
    return static_cast<std::size_t>(y + radius_) * (2 * radius_ + 1) + static_cast<std::size_t>(x + radius_);
}

bool RegularLimit::inside(int x, int y, int radius) const { return size_ == 4 || std::abs(x + y) <= radius; }

void RegularLimit::look_at(const RuleMesh& mesh) {
    // Counts of faces; what is sharp or beside another kind of face never comes to the right one.
    constexpr unsigned char k_other = 0x80;
    regular_.assign(mesh.vertex_count(), 0);
    for (int f = 0; f < mesh.face_count(); ++f) {
        const std::span<const int> corners = mesh.corners(f);
        const bool right_size = static_cast<int>(corners.size()) == size_;
        const int begin = mesh.face_begin(f);
        for (std::size_t i = 0; i < corners.size(); ++i) {
            unsigned char& at = regular_[corners[i]];
            at = right_size && at < k_other ? static_cast<unsigned char>(at + 1) : k_other;
            if (!mesh.sharp(begin + static_cast<int>(i))) continue;
            at = k_other;
            regular_[corners[(i + 1) % corners.size()]] = k_other;
        }
    }
    for (int v = 0; v < mesh.vertex_count(); ++v)
        regular_[v] = regular_[v] == valence_ && !is_sharp(mesh.vertex_sharpness(v)) ? 1 : 0;
}

bool RegularLimit::walk(const RuleMesh& mesh, int v, int radius) {
    around_.resize(static_cast<std::size_t>(2 * radius_ + 1) * (2 * radius_ + 1));
    const int half = valence_ / 2 - 1;
    const auto clockwise = [&](int h, int times) {
        for (int i = 0; i < times; ++i) h = mesh.next(mesh.twin(h));
        return h;
    };
    const auto straight = [&](int h) { return clockwise(mesh.next(h), half); };
    const auto left = [&](int h) { return mesh.twin(mesh.prev(h)); };
    // From (x, y), where h leaves by a step of dy along the second axis.
    const auto column = [&](int x, int h, int dy) {
        for (int y = dy; std::abs(y) <= radius && inside(x, y, radius); y += dy) {
            const int w = mesh.target(h);
            if (regular_[w] == 0) return false;
            around_[place(x, y)] = w;
            h = straight(h);
        }
        return true;
    };
    if (regular_[v] == 0) return false;
    const int ahead = mesh.first(v);
    const int behind = clockwise(ahead, valence_ / 2);
    for (const int dx : {1, -1}) {
        int h = dx > 0 ? ahead : behind;
        for (int x = 0; std::abs(x) <= radius; x += dx) {
            around_[place(x, 0)] = mesh.origin(h);
            // The second axis comes next counter-clockwise after the first.
            const int forward = dx > 0 ? h : clockwise(h, valence_ / 2);
            if ((x != 0 || dx > 0) && (!column(x, left(forward), 1) || !column(x, clockwise(forward, half), -1)))
                return false;
            if (std::abs(x) == radius) break;
            if (regular_[mesh.target(h)] == 0) return false;
            h = straight(h);
        }
    }
    return true;
}

bool RegularLimit::found(const RuleMesh& mesh, int v) { return walk(mesh, v, radius_); }

StencilRow RegularLimit::row(const Terms& terms) const {
    StencilRow result;
    for (const Term& t : terms) result.add(around_[t.place], t.weight);
    return result;
}

std::optional<std::pair<StencilRow, StencilRow>> RegularLimit::tangents() const {
    if (tangent1_.empty()) return std::nullopt;
    return std::pair(row(tangent1_), row(tangent2_));
}

}  // namespace tetrakis::detail
