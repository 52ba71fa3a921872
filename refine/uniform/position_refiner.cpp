#include "position_refiner.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "refine.hpp"
#include "refined_points.hpp"

#include <string>

namespace tetrakis {

namespace {

void check_length(const char* what, std::size_t length, std::size_t expected) {
    if (length != expected)
        throw Error(ErrorCode::invalid_input, "there are " + std::to_string(length) + " " + what + ", but " +
                                                  std::to_string(expected) + " are needed");
}

}  // namespace

struct PositionRefiner::State {
    std::uint32_t control_count;
    RunContext context;
    detail::RefinedPoints points{};
    PolygonMesh mesh{};
};

PositionRefiner::PositionRefiner(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                 const RefineOptions& options)
    : state_(std::make_unique<State>(State{mesh.vertex_count(), options.context})) {
    state_->mesh = detail::refine_with_points(mesh, scheme, levels, options, &state_->points);
}

PositionRefiner::PositionRefiner(const ControlMesh& mesh, std::string_view scheme, int levels,
                                 const RefineOptions& options)
    : PositionRefiner(mesh, scheme_named(scheme), levels, options) {}

PositionRefiner::~PositionRefiner() = default;
PositionRefiner::PositionRefiner(PositionRefiner&&) noexcept = default;
PositionRefiner& PositionRefiner::operator=(PositionRefiner&&) noexcept = default;

const PolygonMesh& PositionRefiner::mesh() const { return state_->mesh; }

void PositionRefiner::refine(std::span<const Vec3d> control, std::span<Vec3d> positions,
                             std::span<Vec3d> normals) const {
    const State& s = *state_;
    check_length("control positions", control.size(), s.control_count);
    check_length("positions to write", positions.size(), s.mesh.positions.size());
    if (!normals.empty()) check_length("normals to write", normals.size(), s.mesh.normals.size());
    if (positions.empty()) return;
    with_threads(s.context, [&] {
        if (positions.size() == s.points.count) return s.points.refine(control, positions, normals);
        detail::PodArray<Vec3d> buffer;
        const std::size_t count = s.points.count;
        buffer.resize(normals.empty() ? count : 2 * count);
        Vec3d* const all = buffer.data();
        s.points.refine(control, {all, count}, {all + count, normals.empty() ? 0 : count});
        for_each_index(static_cast<std::uint32_t>(positions.size()), [&](std::uint32_t i) {
            const std::uint32_t from = s.points.used[i];
            positions[i] = all[from];
            if (!normals.empty()) normals[i] = all[count + from];
        });
    });
}

}  // namespace tetrakis
