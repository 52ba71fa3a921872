#include "embree_scene.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

namespace tetrakis::detail {

EmbreeScene::EmbreeScene(RTCSceneFlags flags, std::uint64_t max_memory_bytes)
    : limit_(static_cast<std::int64_t>(max_memory_bytes)) {
    device_ = rtcNewDevice(nullptr);
    if (device_ == nullptr)
        throw Error(ErrorCode::unsupported, fmt::format("Embree cannot start on this machine (error {})",
                                                        static_cast<int>(rtcGetDeviceError(nullptr))));
    rtcSetDeviceErrorFunction(device_, &EmbreeScene::on_error, this);
    rtcSetDeviceMemoryMonitorFunction(device_, &EmbreeScene::on_memory, this);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, flags);
}

EmbreeScene::~EmbreeScene() {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

namespace {

/// Passes Embree's progress on. Embree asks from all of its threads, the callback is for the calling one alone.
struct BuildMonitor {
    explicit BuildMonitor(const RunContext& to) : context(to) {}
    const RunContext& context;
    std::thread::id caller = std::this_thread::get_id();
    std::atomic<bool> stop = false;
    std::exception_ptr thrown;  // written by the calling thread only

    static bool on_progress(void* self, double fraction) {
        auto& monitor = *static_cast<BuildMonitor*>(self);
        if (std::this_thread::get_id() == monitor.caller && !monitor.stop) {
            try {
                monitor.context.report("build", fraction);
            } catch (...) {  // nothing may be thrown through Embree
                monitor.thrown = std::current_exception();
                monitor.stop = true;
            }
        }
        return !monitor.stop;
    }
};

}  // namespace

void EmbreeScene::build(RTCGeometry geometry, const RunContext& context) {
    rtcSetGeometryPointQueryFunction(geometry, &EmbreeScene::on_candidate);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_, geometry, 0);
    rtcReleaseGeometry(geometry);
    BuildMonitor monitor(context);
    if (context.progress) rtcSetSceneProgressMonitorFunction(scene_, &BuildMonitor::on_progress, &monitor);
    // Often built inside a parallel loop, behind a once_flag: a thread that waits here must not take up another piece
    // of that loop, which would wait for the flag that this thread holds.
    oneapi::tbb::this_task_arena::isolate([&] { rtcCommitScene(scene_); });
    rtcSetSceneProgressMonitorFunction(scene_, nullptr, nullptr);
    if (monitor.thrown) std::rethrow_exception(monitor.thrown);
    const int failure = failure_.load();
    if (failure == RTC_ERROR_NONE) return;
    if (failure == RTC_ERROR_OUT_OF_MEMORY)
        throw Error(ErrorCode::memory_limit,
                    limit_ > 0
                        ? fmt::format("the bounding volume hierarchy needs more than the {} bytes left for it", limit_)
                        : std::string("no memory left for the bounding volume hierarchy"));
    throw Error(ErrorCode::invalid_input, fmt::format("Embree rejects the geometry (error {})", failure));
}

bool EmbreeScene::Search::offer(std::uint32_t primitive) {
    const double offered = call(exact, primitive, distance);
    if (!(offered < distance)) return false;
    distance = offered;
    return true;
}

float EmbreeScene::Search::radius() const {
    // Embree computes squared box distances in float: one rounding in each difference of coordinates, five in squares
    // and sum, one in the squared radius; together below 8 * 2^-24 relative in the square, 2^-22 in the distance. Four
    // times that also covers the double roundings of the local frame.
    constexpr double k_inflation = 0x1p-20;
    // The square must not underflow to zero, or a primitive that touches the point would be culled.
    constexpr double k_smallest = 0x1p-60;
    const double radius = (distance * scale + slack) * (1 + k_inflation);
    return radius < std::numeric_limits<float>::max() ? round_up(std::max(radius, k_smallest))
                                                      : std::numeric_limits<float>::infinity();
}

bool EmbreeScene::on_candidate(RTCPointQueryFunctionArguments* args) {
    auto& search = *static_cast<Search*>(args->userPtr);
    if (search.thrown) return false;
    try {
        if (!search.offer(args->primID)) return false;
    } catch (...) {  // nothing may be thrown through Embree
        search.thrown = std::current_exception();
        args->query->radius = 0;
        return true;
    }
    const float radius = search.radius();
    if (radius >= args->query->radius) return false;
    args->query->radius = radius;
    return true;
}

void EmbreeScene::run(Search& search, const Vec3d& local, std::uint32_t count, double rounding) const {
    const double reach = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)});
    if (!(reach <= k_farthest_float_query)) {  // too far for squares of floats: every primitive is a candidate
        for (std::uint32_t i = 0; i < count; ++i) search.offer(i);
        return;
    }
    RTCPointQuery query;
    query.x = static_cast<float>(local.x);
    query.y = static_cast<float>(local.y);
    query.z = static_cast<float>(local.z);
    query.time = 0;
    search.slack = glm::length(local - Vec3d(query.x, query.y, query.z)) + rounding * reach;
    query.radius = search.radius();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, nullptr, &search);
    if (search.thrown) std::rethrow_exception(search.thrown);
}

bool EmbreeScene::on_memory(void* self, ssize_t bytes, bool /*post*/) {
    auto& scene = *static_cast<EmbreeScene*>(self);
    const std::int64_t total = scene.bytes_.fetch_add(bytes) + bytes;
    // Embree must be allowed to give memory back, else it cannot unwind.
    return bytes <= 0 || scene.limit_ == 0 || total <= scene.limit_;
}

void EmbreeScene::on_error(void* self, RTCError code, const char* /*text*/) {
    auto& scene = *static_cast<EmbreeScene*>(self);
    int none = RTC_ERROR_NONE;
    scene.failure_.compare_exchange_strong(none, static_cast<int>(code));
}

}  // namespace tetrakis::detail
