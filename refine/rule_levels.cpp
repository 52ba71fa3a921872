#include "tetrakis/refine/rule_levels.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/rule_refiner.hpp"

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
    : scheme_(scheme), rules_(rules), source_(mesh.data().source), last_(rule_mesh(mesh)) {
    rules_.runner = &runner_;
    control_face_.resize(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) control_face_[f] = static_cast<int>(f);
    for (int i = 0; i < smoothing; ++i) steps_.push_back(smoothing_stencils(last_));
}

std::vector<int> RuleLevels::advance() {
    RuleStep step;
    try {
        step = scheme_.step(last_, rules_);
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::invalid_input, e.what(), source_);
    }
    for (int& face : step.parent_face) face = control_face_[face];
    control_face_ = std::move(step.parent_face);
    steps_.push_back(std::move(step.stencils));
    last_ = std::move(step.mesh);
    ++level_;
    return std::move(step.child_halfedge);
}

std::vector<double> RuleLevels::net(std::span<const double> control, int width) const {
    std::vector<double> values(control.begin(), control.end());
    for (const StencilTable& step : steps_) {
        std::vector<double> finer(static_cast<std::size_t>(step.row_count()) * static_cast<std::size_t>(width));
        apply(step, values.data(), width, finer.data());
        values = std::move(finer);
    }
    return values;
}

}  // namespace tetrakis::detail
