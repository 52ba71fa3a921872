#include "tetrakis/refine/honeycomb_levels.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/huge_buffer.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/limit_search.hpp"
#include "tetrakis/refine/mesh_part.hpp"
#include "tetrakis/refine/rule_limit.hpp"
#include "tetrakis/refine/uniform_cost.hpp"
#include "tetrakis/schemes/ring_mask.hpp"

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
    // And of the charts, with what corners are there.
    const std::uint64_t charts = mesh.has_uvs() ? 2 * corners : 0;
    const std::uint64_t kept = (limits ? corners : 0) + charts + above + above / 3;
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
    std::vector<std::uint32_t> control(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) control[f] = f;
    all->levels_.reserve(static_cast<std::size_t>(levels) + 1);
    all->levels_.emplace_back(start->last(), std::move(control));
    const HexagonMesh::Use last =
        demand.limit || demand.normals || mesh.has_uvs() ? HexagonMesh::Use::limits : HexagonMesh::Use::faces;
    for (int level = 1; level <= levels; ++level) {
        context.report("refine", static_cast<double>(level - 1) / levels);
        all->levels_.push_back(all->levels_.back().finer(level < levels ? HexagonMesh::Use::levels : last));
    }
    if (demand.limit || demand.normals) {
        all->fans_.emplace(all->levels_.back());
        try {
            if (all->limit_) all->find_limits(scheme, rules);
        } catch (const std::invalid_argument&) {
            return nullptr;
        }
    }
    all->start_ = std::move(start);
    return all;
}

RootNet::Faces HoneycombLevels::faces() {
    HexagonMesh& last = levels_.back();
    if (fans_) return {last.face_begins(), last.origins(), last.control_faces()};
    return last.take_faces();
}

/// @throws std::invalid_argument  there is none for one of them
void HoneycombLevels::find_limits(const SchemeInfo& scheme, const RuleOptions& rules) {
    const HexagonMesh& mesh = levels_.back();
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.leaving(v).empty() || fans_->is_tagged(v)) continue;
        if (fans_->is_plain(v))
            fans_->need_weights(mesh.leaving(v).size());
        else
            beside_.push_back(v);
    }
    for (const HexagonMesh::Tagged& tagged : mesh.tagged())
        if (tagged.semi_sharp || (tagged.rule != VertexRule::corner && tagged.rule != VertexRule::crease))
            by_rules_.push_back(static_cast<int>(tagged.vertex));
    MeshPartFinder finder;
    const RuleView view(mesh, fans_->face_of());
    const auto find = [&](std::span<const int> vertices, int rings, std::vector<int>& in_part) {
        MeshPart part = finder.find(view, vertices, rings);
        for (const int v : vertices)
            in_part.push_back(
                static_cast<int>(std::lower_bound(part.vertex.begin(), part.vertex.end(), v) - part.vertex.begin()));
        return part;
    };
    if (!by_rules_.empty()) {
        std::vector<int> vertices;
        const MeshPart part = find(by_rules_, rule_limit_rings(scheme, rules), vertices);
        const RuleLimits limits = RuleLimitFinder(scheme, rules).find(part.mesh, vertices);
        for (int row = 0; row < limits.positions.row_count(); ++row) {
            StencilRow from = limits.positions.row(row);
            for (auto& term : from.terms) term.first = part.vertex[static_cast<std::size_t>(term.first)];
            rows_.push(std::move(from));
        }
    }
    if (beside_.empty()) return;
    // After the first step a vertex has the hexagons of its edges around it, after the second those beyond as well. Its
    // fan there comes from the faces that its neighbours have here.
    constexpr int k_rings = 2;
    MeshPart part = find(std::vector<int>(beside_.begin(), beside_.end()), k_rings, in_part_);
    const auto faces = static_cast<std::size_t>(part.mesh.face_count());
    parts_.reserve(3);
    parts_.emplace_back(part.mesh, std::vector<std::uint32_t>(faces, 0));
    parts_.push_back(parts_.back().finer(HexagonMesh::Use::levels));
    parts_.push_back(parts_.back().finer(HexagonMesh::Use::limits));
    of_part_ = std::move(part.vertex);
    part_fans_.emplace(parts_.back());
    for (const int v : in_part_) part_fans_->need_weights(parts_.back().leaving(static_cast<std::uint32_t>(v)).size());
}

void HoneycombLevels::write_limits(const Vec3d* net, std::span<Vec3d> points) const {
    const HexagonMesh& mesh = levels_.back();
    for_each_index(mesh.vertex_count(), [&](std::uint32_t v) { points[v] = fans_->limit(v, net).value_or(net[v]); });
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
    if (beside_.empty()) return;
    std::vector<Vec3d> part(of_part_.size()), finer(parts_[1].vertex_count()), finest(parts_[2].vertex_count());
    for (std::size_t i = 0; i < part.size(); ++i) part[i] = net[of_part_[i]];
    parts_[0].refine(part.data(), finer.data());
    parts_[1].refine(finer.data(), finest.data());
    for_each_index(static_cast<std::uint32_t>(beside_.size()), [&](std::uint32_t i) {
        points[beside_[i]] = *part_fans_->limit(static_cast<std::uint32_t>(in_part_[i]), finest.data());
    });
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
