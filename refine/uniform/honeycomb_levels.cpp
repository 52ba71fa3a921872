#include "honeycomb_levels.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/ring_mask.hpp"
#include "../rules/limit_search.hpp"
#include "../rules/mesh_part.hpp"
#include "../rules/rule_limit.hpp"
#include "uniform_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

/// Elements of a level, and what of it is sharp.
struct Counts {
    std::uint64_t vertices, faces, corners, sharp_edges, boundary_edges;

    explicit Counts(const RuleMesh& mesh)
        : vertices(static_cast<std::uint64_t>(mesh.vertex_count())),
          faces(static_cast<std::uint64_t>(mesh.face_count())),
          corners(static_cast<std::uint64_t>(mesh.halfedge_count())),
          sharp_edges(0),
          boundary_edges(0) {
        for (int e = 0; e < mesh.edge_count(); ++e) {
            const int h = mesh.edge_halfedge(e);
            sharp_edges += mesh.sharp(h) ? 1 : 0;
            boundary_edges += mesh.twin(h) == RuleMesh::none ? 1 : 0;
        }
    }
    /// Of the next level, where nothing becomes smooth: at most.
    void refine() {
        const std::uint64_t pentagons = 2 * sharp_edges - boundary_edges, hexagons = (corners - pentagons) / 2;
        vertices += corners + sharp_edges;
        faces += hexagons + pentagons;
        corners += k_hexagon_size * hexagons + (k_hexagon_size - 1) * pentagons;
        sharp_edges *= 2;
        boundary_edges *= 2;
    }
};

/// @param charts  of the texture coordinates; null: there are none
/// @throws Error  unsupported, memory_limit
void check_size(const ControlMesh& mesh, const RuleMesh& start, const RuleMesh* charts, int levels,
                const RepeatedRows::Demand& demand, const RunContext& context) {
    Counts counts(start), above = counts, of_charts(charts != nullptr ? *charts : RuleMesh());
    constexpr std::uint64_t k_most = std::uint64_t{1} << 30;
    for (int level = 1; level <= levels; ++level) {
        above = counts;
        counts.refine();
        of_charts.refine();
        if (const std::uint64_t most = std::max(counts.corners, of_charts.corners); most >= k_most)
            throw Error(
                ErrorCode::unsupported,
                fmt::format(
                    "{} levels of honeycomb refinement give more elements than its 32-bit numbers can count; level {} "
                    "has {} face corners{}, and the limit is {}",
                    levels, level, most, most > counts.corners ? " in its charts" : "", k_most),
                mesh.data().source);
    }
    // Connectivity and fans of the level above, of that above it, and so on, with its points; with limits and charts,
    // of the last one; of the charts points as well, and what corners are there.
    constexpr std::uint64_t k_per_corner = 5 * sizeof(std::uint32_t);
    const bool limits = demand.limit || demand.normals;
    const auto with_those_above = [](std::uint64_t size) { return size + size / 3; };
    std::uint64_t bytes = counts.vertices * demand.point_bytes + counts.faces * demand.face_bytes +
                          counts.corners * demand.corner_bytes + with_those_above(above.corners) * k_per_corner +
                          with_those_above(above.vertices) * sizeof(Vec3d);
    if (limits || charts != nullptr) bytes += counts.corners * k_per_corner;
    if (charts != nullptr)
        bytes += with_those_above(of_charts.corners) * k_per_corner +
                 with_those_above(of_charts.vertices) * sizeof(Vec3d) +
                 with_those_above(counts.corners) * 2 * sizeof(std::uint32_t) + of_charts.vertices * sizeof(Vec2d);
    check_memory(mesh, levels, {counts.vertices, counts.faces, counts.corners, bytes}, context);
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

/// Tagged vertices whose limits the rules find: those that are sharp for some levels, and ends of creases.
std::vector<int> by_rules(const HexagonMesh& mesh) {
    std::vector<int> vertices;
    for (const HexagonMesh::Tagged& tagged : mesh.tagged())
        if (!mesh.leaving(tagged.vertex).empty() &&
            (tagged.semi_sharp || (tagged.rule != VertexRule::corner && tagged.rule != VertexRule::crease)))
            vertices.push_back(static_cast<int>(tagged.vertex));
    return vertices;
}

}  // namespace

HoneycombLevels::HoneycombLevels(const ControlMesh& mesh, std::unique_ptr<RuleLevels> start, const SchemeInfo& scheme,
                                 int levels, const RuleOptions& rules, const RepeatedRows::Demand& demand,
                                 const RunContext& context)
    : start_(std::move(start)), limit_(demand.limit) {
    if (mesh.has_uvs()) charts_ = extend_over_seams(mesh, start_->last(), scheme, rules);
    check_size(mesh, start_->last(), charts_ ? &charts_->mesh : nullptr, levels, demand, context);
    std::vector<std::uint32_t> control(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) control[f] = f;
    levels_.reserve(static_cast<std::size_t>(levels) + 1);
    levels_.emplace_back(start_->last(), std::move(control));
    // What has no limit has none on any level: old vertices keep their numbers.
    if (limit_) try {
            RuleLimitFinder(scheme, rules).find(start_->last(), by_rules(levels_.back()));
        } catch (const std::invalid_argument& e) {
            throw Error(ErrorCode::unsupported, e.what(), mesh.data().source);
        }
    const bool fans = demand.limit || demand.normals;
    const HexagonMesh::Use last = fans || charts_ ? HexagonMesh::Use::limits : HexagonMesh::Use::faces;
    for (int level = 1; level <= levels; ++level) {
        context.report("levels", static_cast<double>(level - 1) / levels);
        levels_.push_back(levels_.back().finer(level < levels ? HexagonMesh::Use::levels : last));
    }
    if (fans) fans_.emplace(levels_.back());
    if (limit_) find_limits(scheme, rules);
}

RootNet::Faces HoneycombLevels::faces() {
    HexagonMesh& last = levels_.back();
    if (fans_) return {last.face_begins(), last.origins(), last.control_faces()};
    return last.take_faces();
}

void HoneycombLevels::find_limits(const SchemeInfo& scheme, const RuleOptions& rules) {
    const HexagonMesh& mesh = levels_.back();
    std::vector<char> seen;  // by number of edges
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const std::size_t valence = mesh.leaving(v).size();
        if (seen.size() <= valence) seen.resize(valence + 1, 0);
        if (valence == 0 || seen[valence] != 0 || fans_->is_tagged(v)) continue;
        fans_->need_weights(valence);
        seen[valence] = 1;
    }
    by_rules_ = by_rules(mesh);
    if (by_rules_.empty()) return;
    MeshPartFinder finder;
    const MeshPart part = finder.find(RuleView(mesh, fans_->face_of()), by_rules_, rule_limit_rings(scheme, rules));
    std::vector<int> vertices;
    for (const int v : by_rules_)
        vertices.push_back(
            static_cast<int>(std::lower_bound(part.vertex.begin(), part.vertex.end(), v) - part.vertex.begin()));
    const RuleLimits limits = RuleLimitFinder(scheme, rules).find(part.mesh, vertices);
    for (int row = 0; row < limits.positions.row_count(); ++row) {
        StencilRow from = limits.positions.row(row);
        for (auto& term : from.terms) term.first = part.vertex[static_cast<std::size_t>(term.first)];
        rows_.push(std::move(from));
    }
}

void HoneycombLevels::write_limits(const Vec3d* net, std::span<Vec3d> points) const {
    const HexagonMesh& mesh = levels_.back();
    for_each_index(mesh.vertex_count(), [&](std::uint32_t v) {
        if (fans_->is_tagged(v) || mesh.leaving(v).empty()) {
            points[v] = net[v];
            return;
        }
        const std::optional<Vec3d> plain = fans_->limit(v, net);
        points[v] = plain ? *plain : fans_->limit_below(v, net);
    });
    for (const HexagonMesh::Tagged& tagged : mesh.tagged())
        if (tagged.rule == VertexRule::crease)
            points[tagged.vertex] = k_crease_limit_mask.vertex * net[tagged.vertex] +
                                    k_crease_limit_mask.neighbour * (net[tagged.ends[0]] + net[tagged.ends[1]]);
    for (std::size_t i = 0; i < by_rules_.size(); ++i) {
        const auto from = rows_.points(static_cast<int>(i));
        const auto weights = rows_.weights(static_cast<int>(i));
        Vec3d sum(0);
        for (std::size_t k = 0; k < from.size(); ++k) sum += weights[k] * net[from[k]];
        points[static_cast<std::size_t>(by_rules_[i])] = sum;
    }
}

void HoneycombLevels::refine(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals,
                             const RunContext& context) const {
    const std::vector<double> first = start_->net({&control.data()->x, 3 * control.size()}, 3);
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
    if (limit_) write_limits(now, points);
    if (!normals.empty()) for_each_index(point_count(), [&](std::uint32_t v) { normals[v] = fans_->normal(v, now); });
}

}  // namespace tetrakis::detail
