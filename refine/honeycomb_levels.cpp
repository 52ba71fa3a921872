#include "tetrakis/refine/honeycomb_levels.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/huge_buffer.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/face_normals.hpp"
#include "tetrakis/refine/honeycomb_limit.hpp"
#include "tetrakis/refine/limit_search.hpp"
#include "tetrakis/refine/mesh_part.hpp"
#include "tetrakis/refine/rule_limit.hpp"
#include "tetrakis/refine/uniform_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_hexagon = 6;

/// @throws Error  unsupported, memory_limit
void check_size(const ControlMesh& mesh, int levels, const RepeatedRows::Demand& demand, const RunContext& context) {
    std::uint64_t vertices = mesh.vertex_count(), faces = mesh.face_count(), corners = mesh.halfedge_count(), above = 0,
                  sharp = 0, boundary = 0;
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e)
        if (is_sharp(mesh.sharpness(EdgeId(e)))) {
            ++sharp;
            boundary += mesh.is_boundary(EdgeId(e)) ? 1 : 0;
        }
    constexpr std::uint64_t k_most = std::uint64_t{1} << 30;
    for (int level = 1; level <= levels; ++level) {
        const std::uint64_t pentagons = 2 * sharp - boundary, hexagons = (corners - pentagons) / 2;
        above = corners;
        vertices += corners + sharp;
        faces += hexagons + pentagons;
        corners += k_hexagon * hexagons + (k_hexagon - 1) * pentagons;
        sharp *= 2;
        boundary *= 2;
        if (corners >= k_most)
            throw Error(
                ErrorCode::unsupported,
                fmt::format("{} levels of honeycomb refinement give more elements than can be counted; level {} "
                            "has {} face corners, and the limit is {}",
                            levels, level, corners, k_most),
                mesh.data().source);
    }
    // Connectivity, fans and points of the level above, of that above it, and so on; with limits, of the last one.
    constexpr std::uint64_t k_per_corner = 20, k_per_face = 2 * sizeof(std::uint32_t);
    const bool limits = demand.limit || demand.normals;
    const std::uint64_t kept = (limits ? corners : 0) + above + above / 3;
    const std::uint64_t bytes =
        vertices * demand.point_bytes + faces * (demand.face_bytes + (limits ? k_per_face : 0)) +
        corners * demand.corner_bytes + kept * k_per_corner + (above + above / 3) / 3 * sizeof(Vec3d);
    check_memory(mesh, levels, {vertices, faces, corners, bytes}, context);
}

/// A level as the rules see one (RuleMesh).
class RuleView {
  public:
    RuleView(const HexagonMesh& mesh, const std::vector<std::uint32_t>& face_of) : mesh_(mesh), face_of_(face_of) {
        if (mesh.sharp_vertices().empty()) return;
        vertex_sharpness_.resize(mesh.vertex_count(), 0.0f);
        for (const auto& [v, s] : mesh.sharp_vertices()) vertex_sharpness_[v] = s;
    }
    int vertex_count() const { return static_cast<int>(mesh_.vertex_count()); }
    int face_count() const { return static_cast<int>(mesh_.face_count()); }
    int face_begin(int f) const { return static_cast<int>(mesh_.face_begin(number(f))); }
    int face_size(int f) const { return static_cast<int>(mesh_.face_size(number(f))); }
    std::span<const std::uint32_t> corners(int f) const {
        return std::span(mesh_.origins()).subspan(mesh_.face_begin(number(f)), mesh_.face_size(number(f)));
    }
    int origin(int h) const { return static_cast<int>(mesh_.origin(number(h))); }
    int twin(int h) const { return static_cast<int>(mesh_.twin(number(h))); }  // none is -1
    int face(int h) const { return static_cast<int>(face_of_[number(h)]); }
    int prev(int h) const {
        const int begin = face_begin(face(h));
        return h > begin ? h - 1 : begin + face_size(face(h)) - 1;
    }
    int first(int v) const {
        const auto leaving = mesh_.leaving(number(v));
        return leaving.empty() ? RuleMesh::none : static_cast<int>(leaving[0]);
    }
    float sharpness(int h) const {
        const auto edges = mesh_.sharp_edges();
        const int t = twin(h);
        const std::uint32_t first = number(t == RuleMesh::none ? h : std::min(h, t));
        const auto at = std::lower_bound(edges.begin(), edges.end(), first,
                                         [](const HexagonMesh::Sharp& a, std::uint32_t b) { return a.number < b; });
        return at != edges.end() && at->number == first ? at->sharpness : 0.0f;
    }
    const std::vector<float>& vertex_sharpness() const { return vertex_sharpness_; }
    float vertex_sharpness(int v) const { return vertex_sharpness_[number(v)]; }
    bool has_corner_angles() const { return false; }
    double corner_angle(int) const { return 0; }

  private:
    static std::uint32_t number(int i) { return static_cast<std::uint32_t>(i); }
    const HexagonMesh& mesh_;
    const std::vector<std::uint32_t>& face_of_;
    std::vector<float> vertex_sharpness_;
};
static_assert(static_cast<int>(HexagonMesh::none) == RuleMesh::none);

}  // namespace

std::unique_ptr<HoneycombLevels> HoneycombLevels::make(const ControlMesh& mesh, std::unique_ptr<RuleLevels>& start,
                                                       const SchemeInfo& scheme, int levels, const RuleOptions& rules,
                                                       const RepeatedRows::Demand& demand, const RunContext& context) {
    check_size(mesh, levels, demand, context);
    std::unique_ptr<HoneycombLevels> all(new HoneycombLevels);
    all->limit_ = demand.limit;
    all->normals_ = demand.normals;
    std::vector<std::uint32_t> control(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) control[f] = f;
    all->levels_.reserve(static_cast<std::size_t>(levels) + 1);
    all->levels_.emplace_back(start->last(), std::move(control));
    const HexagonMesh::Use last = demand.limit || demand.normals ? HexagonMesh::Use::limits : HexagonMesh::Use::faces;
    for (int level = 1; level <= levels; ++level) {
        context.report("refine", static_cast<double>(level - 1) / levels);
        all->levels_.push_back(all->levels_.back().finer(level < levels ? HexagonMesh::Use::levels : last));
    }
    if (last == HexagonMesh::Use::limits) {
        try {
            all->find_limits(scheme, rules);
        } catch (const std::invalid_argument&) {
            return nullptr;
        }
    }
    all->start_ = std::move(start);
    return all;
}

RepeatedRows::Faces HoneycombLevels::faces() {
    HexagonMesh& last = levels_.back();
    if (limit_ || normals_) return {last.face_begins(), last.origins(), last.control_faces()};
    return last.take_faces();
}

/// The vertices that a limit depends on, in the order of honeycomb_fan(). False where the mesh is another one there.
template <class Visit>
bool HoneycombLevels::walk_fan(std::uint32_t v, Visit&& visit) const {
    const HexagonMesh& mesh = levels_.back();
    if (tagged_[v] != 0) return false;
    visit(v);
    constexpr std::uint32_t k_edges = 3;
    const auto is_hexagon = [&](std::uint32_t f) { return mesh.face_size(f) == k_hexagon; };
    for (const std::uint32_t h : mesh.leaving(v)) {
        const std::uint32_t f = face_of_[h], begin = mesh.face_begin(f);
        if (!is_hexagon(f)) return false;
        const auto ahead = [](std::uint32_t first, std::uint32_t at, std::uint32_t steps) {
            return first + (at - first + steps) % k_hexagon;
        };
        const std::uint32_t next = ahead(begin, h, 1), e = mesh.origin(next);
        if (tagged_[e] != 0 || mesh.leaving(e).size() != k_edges) return false;
        const std::uint32_t across = mesh.twin(next), beyond = face_of_[across], first = mesh.face_begin(beyond);
        if (!is_hexagon(beyond)) return false;
        visit(e);
        for (std::uint32_t k = 2; k < 5; ++k) visit(mesh.origin(ahead(begin, h, k)));
        for (std::uint32_t k = 3; k < k_hexagon; ++k) visit(mesh.origin(ahead(first, across, k)));
    }
    return true;
}

void HoneycombLevels::find_limits(const SchemeInfo& scheme, const RuleOptions& rules) {
    const HexagonMesh& mesh = levels_.back();
    face_of_.resize(mesh.halfedge_count());
    for_each_index(mesh.face_count(),
                   [&](std::uint32_t f) { std::fill_n(face_of_.begin() + mesh.face_begin(f), mesh.face_size(f), f); });
    tagged_.assign(mesh.vertex_count(), 0);
    for (const HexagonMesh::Tagged& tagged : mesh.tagged()) tagged_[tagged.vertex] = 1;
    if (!limit_) return;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const std::size_t valence = mesh.leaving(v).size();
        if (valence == 0) continue;
        if (valence < 2 || !walk_fan(v, [](std::uint32_t) {})) {
            irregular_.push_back(static_cast<int>(v));
            continue;
        }
        if (weights_.size() <= valence) weights_.resize(valence + 1);
        if (weights_[valence].empty()) weights_[valence] = honeycomb_limit_weights(static_cast<int>(valence));
    }
    MeshPartFinder parts;
    const MeshPart part = parts.find(RuleView(mesh, face_of_), irregular_, rule_limit_rings(scheme, rules));
    std::vector<int> vertices;
    for (const int v : irregular_)
        vertices.push_back(
            static_cast<int>(std::lower_bound(part.vertex.begin(), part.vertex.end(), v) - part.vertex.begin()));
    const RuleLimits limits = RuleLimitFinder(scheme, rules).find(part.mesh, vertices);
    for (int row = 0; row < limits.positions.row_count(); ++row) {
        StencilRow from = limits.positions.row(row);
        for (auto& term : from.terms) term.first = part.vertex[static_cast<std::size_t>(term.first)];
        rows_.push(std::move(from));
    }
}

Vec3d HoneycombLevels::limit_of(std::uint32_t v, const Vec3d* net) const {
    const std::size_t valence = levels_.back().leaving(v).size();
    if (valence == 0) return net[v];
    const double* weight = valence < weights_.size() ? weights_[valence].data() : nullptr;
    Vec3d sum(0);
    if (weight != nullptr && walk_fan(v, [&](std::uint32_t w) { sum += *weight++ * net[w]; })) return sum;
    const auto at = std::lower_bound(irregular_.begin(), irregular_.end(), static_cast<int>(v)) - irregular_.begin();
    const auto points = rows_.points(static_cast<int>(at));
    const auto weights = rows_.weights(static_cast<int>(at));
    sum = Vec3d(0);
    for (std::size_t i = 0; i < points.size(); ++i) sum += weights[i] * net[points[i]];
    return sum;
}

/// The scheme has no tangents.
Vec3d HoneycombLevels::normal_of(std::uint32_t v, const Vec3d* net) const {
    const HexagonMesh& mesh = levels_.back();
    FaceNormals normals;
    std::vector<Vec3d> points;
    for (const std::uint32_t h : mesh.leaving(v)) {
        const std::uint32_t begin = mesh.face_begin(face_of_[h]), end = begin + mesh.face_size(face_of_[h]);
        points.clear();
        for (std::uint32_t c = begin; c < end; ++c) points.push_back(net[mesh.origin(c)]);
        normals.add(points, h - begin);
    }
    return normals.normal();
}

void HoneycombLevels::refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                             const RunContext& context) const {
    std::vector<double> first = start_->net({&control.data()->x, 3 * control.size()}, 3);
    HugeBuffer<double> buffers[2];
    const Vec3d* now = reinterpret_cast<const Vec3d*>(first.data());
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        context.report("refine", static_cast<double>(level) / static_cast<double>(levels_.size()));
        const bool last = level + 1 == levels_.size();
        Vec3d* const finer =
            last && !limit_
                ? points.data()
                : reinterpret_cast<Vec3d*>(buffers[level & 1].reserve(3 * std::size_t{levels_[level].vertex_count()}));
        levels_[level - 1].refine(now, finer);
        now = finer;
    }
    const std::uint32_t count = point_count();
    if (limit_) for_each_index(count, [&](std::uint32_t v) { points[v] = limit_of(v, now); });
    if (!normals.empty()) for_each_index(count, [&](std::uint32_t v) { normals[v] = normal_of(v, now); });
}

}  // namespace tetrakis::detail
