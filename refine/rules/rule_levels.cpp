#include "rule_levels.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/most_frequent.hpp"
#include "../../hier/base/parallel.hpp"
#include "rule_refiner.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

StencilTable smoothing_stencils(const RuleMesh& mesh) {
    StencilTable table;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const VertexRule rule = mesh.first(v) == RuleMesh::none ? VertexRule::corner : mesh.rule(v);
        if (rule == VertexRule::corner) {
            table.push({{v, 1}});
            continue;
        }
        const auto around = rule == VertexRule::crease ? mesh.sharp_neighbours(v) : mesh.ring(v).neighbour;
        StencilRow row{{v, 0.5}};
        for (const int e : around) row.add(e, 0.5 / static_cast<double>(around.size()));
        table.push(std::move(row));
    }
    return table;
}

}  // namespace

void apply(const StencilTable& table, const double* in, int width, double* out) {
    for_each_index(static_cast<std::uint32_t>(table.row_count()), [&](std::uint32_t r) {
        const auto points = table.points(static_cast<int>(r));
        const auto weights = table.weights(static_cast<int>(r));
        double* to = out + std::size_t{r} * width;
        std::fill_n(to, width, 0.0);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double* from = in + static_cast<std::size_t>(points[i]) * width;
            for (int k = 0; k < width; ++k) to[k] += weights[i] * from[k];
        }
    });
}

RuleLevels::RuleLevels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules, int smoothing)
    : scheme_(scheme), rules_(rules), source_(mesh.data().source), last_(rule_mesh(mesh, scheme, rules)) {
    rules_.runner = &runner_;
    faces_.control_face.resize(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) faces_.control_face[f] = static_cast<int>(f);
    for (int i = 0; i < smoothing; ++i) steps_.push_back(smoothing_stencils(last_));
}

std::vector<int> RuleLevels::advance() {
    RuleStep step;
    try {
        step = scheme_.step(last_, rules_);
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::invalid_input, e.what(), source_);
    }
    if (splits_vertices(scheme_, rules_)) {
        faces_.follow(last_, step);
    } else {
        for (int& face : step.parent_face) face = faces_.control_face[face];
        faces_.control_face = std::move(step.parent_face);
    }
    steps_.push_back(std::move(step.stencils));
    last_ = std::move(step.mesh);
    ++level_;
    return std::move(step.child_halfedge);
}

std::vector<std::uint32_t> RuleLevels::control_face_of_corners() const {
    std::vector<std::uint32_t> of(static_cast<std::size_t>(last_.halfedge_count()));
    for (int h = 0; h < last_.halfedge_count(); ++h)
        of[h] = static_cast<std::uint32_t>(faces_.point_face.empty() ? faces_.control_face[last_.face(h)]
                                                                     : faces_.point_face[h]);
    return of;
}

/// The points of a dual scheme lie in faces, its faces anywhere.
void CornerFaces::follow(const RuleMesh& level, const RuleStep& step) {
    const RuleMesh& finer = step.mesh;
    std::vector<int> corners, next;
    // The corner that a point is the child of, at its origin; those on boundaries and creases are none's.
    std::vector<int> corner_of(static_cast<std::size_t>(finer.vertex_count()), RuleMesh::none);
    for (std::size_t h = 0; h < step.child_halfedge.size(); ++h)
        if (const int child = step.child_halfedge[h]; child != RuleMesh::none)
            corner_of[finer.origin(child)] = static_cast<int>(h);
    const auto follow = [&](const std::vector<int>& parent) {
        std::vector<int> of(static_cast<std::size_t>(finer.halfedge_count()));
        for (int f = 0; f < finer.face_count(); ++f) {
            corners.clear();
            for (const int v : finer.corners(f))
                corners.push_back(corner_of[v] != RuleMesh::none ? parent[corner_of[v]] : RuleMesh::none);
            if (std::all_of(corners.begin(), corners.end(), [](int c) { return c == RuleMesh::none; }))
                corners[0] = control_face[step.parent_face[f]];
            // Points on boundaries and creases belong to what is beside them on this side, corners of these to the
            // first face of their sector: they are left over after the first round.
            for (bool first_round = true; std::count(corners.begin(), corners.end(), RuleMesh::none) != 0;
                 first_round = false) {
                next = corners;
                const std::size_t size = corners.size();
                for (std::size_t i = 0; i < size; ++i) {
                    if (corners[i] != RuleMesh::none) continue;
                    const int before = corners[(i + size - 1) % size], after = corners[(i + 1) % size];
                    const int preferred = first_round ? before : after;
                    next[i] = preferred != RuleMesh::none ? preferred : first_round ? after : before;
                }
                corners.swap(next);
            }
            std::copy(corners.begin(), corners.end(), of.begin() + finer.face_begin(f));
        }
        return of;
    };
    const bool first = corner_face.empty();
    if (first) {
        corner_face.resize(static_cast<std::size_t>(level.halfedge_count()));
        for (int h = 0; h < level.halfedge_count(); ++h) corner_face[h] = control_face[level.face(h)];
    }
    std::vector<int> of_points = follow(first ? corner_face : point_face);
    corner_face = follow(corner_face);
    // Where a crease ends, its last point lies on both sides; it belongs to the left one, as in vertex_roots().
    for (int h = 0; h < static_cast<int>(step.child_crease.size()); ++h) {
        const int along = step.child_crease[h];
        if (along == RuleMesh::none || level.on_boundary(level.origin(h)) ||
            level.sharp_neighbours(level.origin(h)).size() != 1)
            continue;
        for (const int around : finer.ring(finer.origin(along)).halfedge) of_points[around] = of_points[along];
    }
    point_face = std::move(of_points);
    control_face.resize(static_cast<std::size_t>(finer.face_count()));
    for (int f = 0; f < finer.face_count(); ++f) {
        corners.assign(point_face.begin() + finer.face_begin(f),
                       point_face.begin() + finer.face_begin(f) + finer.face_size(f));
        control_face[f] = most_frequent(corners);
    }
}

std::vector<double> RuleLevels::net(std::span<const double> control, int width) const {
    std::vector<double> values(static_cast<std::size_t>(last_.vertex_count()) * static_cast<std::size_t>(width));
    net(control, width, values);
    return values;
}

void RuleLevels::net(std::span<const double> control, int width, std::span<double> out) const {
    if (steps_.empty()) std::copy(control.begin(), control.end(), out.begin());
    std::vector<double> coarser, finer;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
        const bool last = i + 1 == steps_.size();
        if (!last) finer.resize(static_cast<std::size_t>(steps_[i].row_count()) * static_cast<std::size_t>(width));
        apply(steps_[i], i == 0 ? control.data() : coarser.data(), width, last ? out.data() : finer.data());
        coarser.swap(finer);
    }
}

}  // namespace tetrakis::detail
