#include "tetrakis/eval/embree_scene.hpp"

#include <fmt/format.h>

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

void EmbreeScene::build(RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_, geometry, 0);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
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
