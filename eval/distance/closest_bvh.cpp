#include "closest_bvh.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"
#include "embree_scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <mutex>
#include <vector>

namespace tetrakis {

struct ClosestBvh::State {
    State(std::uint64_t max_memory_bytes) : scene(RTC_SCENE_FLAG_NONE, max_memory_bytes) {}
    detail::EmbreeScene scene;
    detail::LocalFrame frame;
    std::uint32_t count = 0;
    std::vector<bool> is_empty;                                   // by primitives: its box
    const std::function<Box3d(std::uint32_t)>* box_of = nullptr;  // during the build only
    std::mutex thrown_mutex;
    std::exception_ptr thrown;  // by box_of, the first; nothing may be thrown through Embree
};

struct ClosestBvhCallbacks {
    static void bounds(const RTCBoundsFunctionArguments* args) {
        auto& state = *static_cast<ClosestBvh::State*>(args->geometryUserPtr);
        Box3d box;
        try {
            box = (*state.box_of)(args->primID);
        } catch (...) {
            const std::lock_guard lock(state.thrown_mutex);
            if (!state.thrown) state.thrown = std::current_exception();
        }
        RTCBounds& out = *args->bounds_o;
        if (box.empty()) {
            // Embree leaves out primitives with an inverted box.
            out.lower_x = out.lower_y = out.lower_z = std::numeric_limits<float>::infinity();
            out.upper_x = out.upper_y = out.upper_z = -std::numeric_limits<float>::infinity();
            return;
        }
        const Vec3d lower = state.frame.to_local(box.lower), upper = state.frame.to_local(box.upper);
        out.lower_x = detail::round_down(lower.x);
        out.lower_y = detail::round_down(lower.y);
        out.lower_z = detail::round_down(lower.z);
        out.upper_x = detail::round_up(upper.x);
        out.upper_y = detail::round_up(upper.y);
        out.upper_z = detail::round_up(upper.z);
    }

    static bool candidate(RTCPointQueryFunctionArguments* args) {
        auto& search = *static_cast<ClosestBvh::Search*>(args->userPtr);
        if (search.thrown) return false;
        double distance = 0;
        try {
            distance = search.call(search.exact, args->primID, search.hit.distance);
        } catch (...) {  // nothing may be thrown through Embree
            search.thrown = std::current_exception();
            args->query->radius = 0;
            return true;
        }
        if (!(distance <= search.hit.distance)) return false;
        if (distance == search.hit.distance) {
            search.hit.primitive = std::min(search.hit.primitive, args->primID);
            return false;
        }
        search.hit = {args->primID, distance};
        const float radius = detail::search_radius(distance * search.scale, search.slack);
        if (radius >= args->query->radius) return false;
        args->query->radius = radius;
        return true;
    }
};

ClosestBvh::~ClosestBvh() = default;

ClosestBvh::ClosestBvh(std::uint32_t count, const std::function<Box3d(std::uint32_t)>& box_of,
                       const RunContext& context)
    : state_(std::make_unique<State>(context.max_memory_bytes)) {
    Box3d bounds;
    constexpr std::uint32_t k_boxes_per_report = 4096;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (i % k_boxes_per_report == 0) context.report("build", static_cast<double>(i) / count);
        const Box3d box = box_of(i);
        for (int axis = 0; axis < 3; ++axis)
            if (std::isnan(box.lower[axis]) || std::isnan(box.upper[axis]) ||
                (!box.empty() && (std::isinf(box.lower[axis]) || std::isinf(box.upper[axis]))))
                throw Error(ErrorCode::invalid_input, fmt::format("the bounding box of primitive {} is not finite", i));
        if (!box.empty()) bounds.add(box);
        state_->is_empty.push_back(box.empty());
    }
    state_->count = count;
    state_->frame = detail::LocalFrame::of(bounds);
    state_->box_of = &box_of;
    if (count > 0) {
        RTCGeometry geometry = rtcNewGeometry(state_->scene.device(), RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, count);
        rtcSetGeometryUserData(geometry, state_.get());
        rtcSetGeometryBoundsFunction(geometry, &ClosestBvhCallbacks::bounds, nullptr);
        rtcSetGeometryPointQueryFunction(geometry, &ClosestBvhCallbacks::candidate);
        with_threads(context, [&] { state_->scene.build(geometry, context); });
    }
    state_->box_of = nullptr;
    if (state_->thrown) std::rethrow_exception(state_->thrown);
}

void ClosestBvh::run(Search& search) const {
    if (state_->count == 0) return;
    const detail::LocalFrame& frame = state_->frame;
    const Vec3d local = frame.to_local(search.point);
    const double reach = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)});
    if (!(reach <= detail::k_farthest_float_query)) {  // too far for squares of floats: no pruning needed or possible
        for (std::uint32_t i = 0; i < state_->count; ++i) {
            if (state_->is_empty[i]) continue;
            const double distance = search.call(search.exact, i, search.hit.distance);
            if (distance < search.hit.distance || (distance == search.hit.distance && !search.hit.found()))
                search.hit = {i, distance};
        }
        return;
    }
    RTCPointQuery query;
    query.x = static_cast<float>(local.x);
    query.y = static_cast<float>(local.y);
    query.z = static_cast<float>(local.z);
    query.time = 0;
    search.scale = frame.scale;
    search.slack = glm::length(local - Vec3d(query.x, query.y, query.z));
    query.radius = detail::search_radius(search.hit.distance * search.scale, search.slack);
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(state_->scene.scene(), &query, &context, nullptr, &search);
    if (search.thrown) std::rethrow_exception(search.thrown);
}

}  // namespace tetrakis
