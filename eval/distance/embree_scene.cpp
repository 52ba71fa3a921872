#include "embree_scene.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <exception>
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
