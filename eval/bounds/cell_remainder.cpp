#include "cell_remainder.hpp"

#include "../../schemes/rules/averaging.hpp"
#include "../../schemes/rules/modified_butterfly.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Rules of edges look two rings around a cell; those of others, as Kobbelt's virtual points, up to one more; a step of
/// averaging is by half a ring.
int rings_of(const SchemeInfo& scheme, const RuleOptions& options) {
    if (scheme.step == averaging_step) return options.averaging_steps / 2 + 1;
    return scheme.step == modified_butterfly_step || scheme.step == butterfly_step ? 2 : 3;
}

}  // namespace

CellRemainder::CellRemainder(const SchemeInfo& scheme, const RuleOptions& options)
    : corners_(scheme.family == MeshFamily::triangles ? 3 : 4),
      rings_(rings_of(scheme, options)),
      table_(scheme, options, corners_, rings_) {
    const SurroundingsKey key = fan_surroundings(lattice(), {.faces = corners_ == 3 ? 6 : 4}, rings_);
    regular_ = table_.find(key);
    if (regular_ != nullptr) regular_walk_ = walk_to(key, regular_->point);
}

std::optional<CellRemainder::Total> CellRemainder::total(const FanShape& shape) const {
    const CellNorms* const found = table_.find(fan_surroundings(lattice(), shape, rings_));
    if (found == nullptr) return std::nullopt;
    Total total{0, false};
    for (const double w : found->weight) total.sum += w;
    for (const CellAnchor& a : found->anchor) total.linear = total.linear || a[0] != 1;
    return total;
}

CellRemainder::Walk CellRemainder::walk_to(const SurroundingsKey& key, std::span<const int> points) const {
    const RuleMesh mesh = surroundings_mesh(key);
    Walk all;
    std::vector<int> entry{0};
    std::vector<char> entered(mesh.face_count(), 0);
    std::vector<Walk::Point> where(mesh.vertex_count(), {-1, 0});
    entered[0] = 1;
    all.faces.push_back({-1, 0});
    for (std::size_t i = 0; i < entry.size(); ++i) {
        int h = entry[i];
        for (int turns = 0; turns < corners_; ++turns, h = mesh.next(h)) {
            Walk::Point& p = where[mesh.origin(h)];
            if (p.face < 0) p = {static_cast<int>(i), turns};
            const int t = mesh.twin(h);
            if (t == RuleMesh::none || std::exchange(entered[mesh.face(t)], 1)) continue;
            entry.push_back(t);
            all.faces.push_back({static_cast<int>(i), turns});
        }
    }
    // Only the faces on the way to a point.
    std::vector<char> needed(all.faces.size(), 0);
    needed[0] = 1;
    for (const int i : points)
        for (int f = where[i].face; f > 0; f = all.faces[f].from) needed[f] = 1;
    Walk walk;
    std::vector<int> number(all.faces.size(), -1);
    for (std::size_t f = 0; f < all.faces.size(); ++f) {
        if (!needed[f]) continue;
        number[f] = static_cast<int>(walk.faces.size());
        walk.faces.push_back({f == 0 ? -1 : number[all.faces[f].from], all.faces[f].turns});
    }
    for (const int i : points) walk.points.push_back({number[where[i].face], where[i].turns});
    return walk;
}

CellRemainder::Level::Level(const CellRemainder& remainder, const RuleMesh& mesh, std::span<const Vec3d> points,
                            MeshPartFinder& parts)
    : remainder_(remainder), mesh_(mesh), points_(points), parts_(parts), irregular_(mesh.vertex_count(), 0) {
    find_irregular();
}

void CellRemainder::Level::find_irregular() {
    const CellRemainder& remainder = remainder_;
    const RuleMesh& mesh = mesh_;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        irregular_[v] = mesh.first(v) == RuleMesh::none || mesh.rule(v) != VertexRule::smooth ||
                        mesh.vertex_sharpness(v) > 0 || !is_regular_vertex(mesh, v, remainder.corners());
    for (int f = 0; f < mesh.face_count(); ++f) {
        bool other = mesh.face_size(f) != remainder.corners();
        for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + mesh.face_size(f); ++h)
            other = other || mesh.sharpness(h) > 0;
        if (other)
            for (const int v : mesh.corners(f)) irregular_[v] = 1;
    }
    std::vector<std::uint8_t> wider;
    for (int ring = 1; ring < remainder.rings(); ++ring) {
        wider = irregular_;
        for (int f = 0; f < mesh.face_count(); ++f) {
            const std::span<const int> corners = mesh.corners(f);
            if (std::any_of(corners.begin(), corners.end(), [&](int v) { return irregular_[v] != 0; }))
                for (const int v : corners) wider[v] = 1;
        }
        irregular_.swap(wider);
    }
}

double CellRemainder::Level::sum(const CellNorms& norms, int halfedge, std::span<const int> points) const {
    std::array<Vec3d, 4> corner{};
    int h = halfedge;
    for (int k = 0; k < remainder_.corners(); ++k, h = mesh_.next(h)) corner[k] = points_[mesh_.origin(h)];
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const CellAnchor& a = norms.anchor[i];
        const Vec3d expected = a[0] * corner[0] + a[1] * corner[1] + a[2] * corner[2] + a[3] * corner[3];
        sum += norms.weight[i] * glm::length(points_[points[i]] - expected);
    }
    return sum;
}

double CellRemainder::Level::operator()(int halfedge) {
    const std::span<const int> corners = mesh_.corners(mesh_.face(halfedge));
    const CellNorms* const regular = remainder_.regular_;
    if (regular != nullptr && std::none_of(corners.begin(), corners.end(), [&](int v) { return irregular_[v] != 0; })) {
        const Walk& walk = remainder_.regular_walk_;
        entry_.resize(walk.faces.size());
        found_.resize(walk.points.size());
        const auto turned = [&](int h, int turns) {
            for (int i = 0; i < turns; ++i) h = mesh_.next(h);
            return h;
        };
        entry_[0] = halfedge;
        for (std::size_t f = 1; f < entry_.size(); ++f)
            entry_[f] = mesh_.twin(turned(entry_[walk.faces[f].from], walk.faces[f].turns));
        for (std::size_t i = 0; i < found_.size(); ++i)
            found_[i] = mesh_.origin(turned(entry_[walk.points[i].face], walk.points[i].turns));
        return sum(*regular, halfedge, found_);
    }
    const std::optional<CellSurroundings> around = cell_surroundings(mesh_, halfedge, remainder_.rings(), parts_);
    if (!around) return std::numeric_limits<double>::infinity();
    const CellNorms* const norms = remainder_.table_.find(around->key);
    if (norms == nullptr) return std::numeric_limits<double>::infinity();
    found_.clear();
    for (const int i : norms->point) found_.push_back(around->vertices[i]);
    return sum(*norms, halfedge, found_);
}

}  // namespace tetrakis::detail
