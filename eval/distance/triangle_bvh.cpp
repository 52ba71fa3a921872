#include "triangle_bvh.hpp"

#include "../../hier/base/parallel.hpp"
#include "../surface/local_frame.hpp"
#include "../triangles/point_triangle.hpp"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <thread>

namespace tetrakis {

namespace {

// Local coordinates up to this have squares and sums that stay finite in float.
constexpr double k_farthest_float_query = 0x1p60;

/// A search for the nearest triangle.
struct NearestSearch {
    double distance;  ///< least distance so far
    /// The distance of a triangle; may be any larger number if it exceeds `best`. It must not throw through Embree.
    std::function<double(std::uint32_t triangle, double best)> exact;
    double scale = 1;  ///< of the local frame
    double slack = 0;  ///< largest shift of query point and triangles by float rounding, in the local frame

    /// Takes one more candidate; returns whether it is nearer than all before.
    bool offer(std::uint32_t triangle) {
        const double offered = exact(triangle, distance);
        if (!(offered < distance)) return false;
        distance = offered;
        return true;
    }
    /// The search radius in float, rounded so that no triangle within `distance` is missed.
    float radius() const {
        // Embree computes squared box distances in float: one rounding in each difference of coordinates, five in
        // squares and sum, one in the squared radius; together below 8 * 2^-24 relative in the square, 2^-22 in the
        // distance. Four times that also covers the double roundings of the local frame.
        constexpr double k_inflation = 0x1p-20;
        // The square must not underflow to zero, or a primitive that touches the point would be culled.
        constexpr double k_smallest = 0x1p-60;
        const double radius = (distance * scale + slack) * (1 + k_inflation);
        return radius < std::numeric_limits<float>::max() ? detail::round_up(std::max(radius, k_smallest))
                                                          : std::numeric_limits<float>::infinity();
    }
    static bool on_candidate(RTCPointQueryFunctionArguments* args) {
        auto& search = *static_cast<NearestSearch*>(args->userPtr);
        if (!search.offer(args->primID)) return false;
        const float radius = search.radius();
        if (radius >= args->query->radius) return false;
        args->query->radius = radius;
        return true;
    }
};

/// Reports Embree's progress. Embree calls from all of its threads; reports are made by the calling thread only.
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

/// An Embree device with one scene of one geometry. Embree reports its failures through the device; TriangleBvh() turns
/// them into Errors.
struct TriangleBvh::State {
    std::span<const Vec3d> positions;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    Box3d bounds;
    detail::LocalFrame frame;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::atomic<std::int64_t> bytes = 0;  ///< memory that Embree holds now
    std::int64_t limit = 0;               ///< largest allowed `bytes`; 0: no limit
    std::atomic<int> failure = RTC_ERROR_NONE;

    explicit State(std::uint64_t max_memory_bytes) : limit(static_cast<std::int64_t>(max_memory_bytes)) {
        device = rtcNewDevice(nullptr);
        if (device == nullptr)
            throw Error(ErrorCode::unsupported, fmt::format("Embree cannot start on this machine (error {})",
                                                            static_cast<int>(rtcGetDeviceError(nullptr))));
        rtcSetDeviceErrorFunction(device, &State::on_error, this);
        rtcSetDeviceMemoryMonitorFunction(device, &State::on_memory, this);
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT);
    }
    ~State() {
        if (scene != nullptr) rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    State(const State&) = delete;

    /// Offers all triangles within search.distance, and perhaps more. Embree's float radii are rounded outward, so that
    /// not even equal distances are missed; search.exact computes the distances. Thread-safe.
    void run(NearestSearch& search, const Vec3d& point) const {
        if (triangles.empty()) return;
        // Rounding to float moves a local coordinate c by at most 2^-24 |c|. Let a point have coordinates up to r, and
        // a box the distance d from it: the box's nearest sides have coordinates up to r + d. Rounding moves the
        // distance by sqrt(3) 2^-24 r, and by a share of d that radius() allows for.
        constexpr double k_vertex_rounding = 1.7320508075688774 * 0x1p-24;
        const Vec3d local = frame.to_local(point);
        const double reach = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)});
        if (!(reach <= k_farthest_float_query)) {  // squares of floats overflow: every triangle is a candidate
            for (std::uint32_t t = 0; t < triangles.size(); ++t) search.offer(t);
            return;
        }
        RTCPointQuery query;
        query.x = static_cast<float>(local.x);
        query.y = static_cast<float>(local.y);
        query.z = static_cast<float>(local.z);
        query.time = 0;
        search.scale = frame.scale;
        search.slack = glm::length(local - Vec3d(query.x, query.y, query.z)) + k_vertex_rounding * reach;
        query.radius = search.radius();
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(scene, &query, &context, nullptr, &search);
    }

    static bool on_memory(void* self, ssize_t bytes, bool /*post*/) {
        auto& state = *static_cast<State*>(self);
        const std::int64_t total = state.bytes.fetch_add(bytes) + bytes;
        // Releasing memory is always allowed, else Embree cannot unwind.
        return bytes <= 0 || state.limit == 0 || total <= state.limit;
    }
    static void on_error(void* self, RTCError code, const char* /*text*/) {
        int none = RTC_ERROR_NONE;
        static_cast<State*>(self)->failure.compare_exchange_strong(none, static_cast<int>(code));
    }
};

namespace {

/// The median of each coordinate, of finite values. Floats relative to it resolve most of the model even if a few
/// vertices lie far away.
Vec3d median(std::span<const Vec3d> positions) {
    Vec3d result{0.0};
    std::vector<double> values;
    values.reserve(positions.size());
    for (int axis = 0; axis < 3; ++axis) {
        values.clear();
        for (const Vec3d& p : positions)
            if (std::isfinite(p[axis])) values.push_back(p[axis]);
        if (values.empty()) continue;
        const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::ranges::nth_element(values, middle);
        result[axis] = *middle;
    }
    return result;
}

}  // namespace

TriangleBvh::~TriangleBvh() = default;
TriangleBvh::TriangleBvh(TriangleBvh&&) noexcept = default;
TriangleBvh& TriangleBvh::operator=(TriangleBvh&&) noexcept = default;

TriangleBvh::TriangleBvh(std::span<const Vec3d> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
                         const RunContext& context)
    : state_(std::make_unique<State>(context.max_memory_bytes)) {
    State& state = *state_;
    state.positions = positions;
    state.triangles = triangles;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (const std::uint32_t v : triangles[t]) {
            if (v >= positions.size())
                throw Error(
                    ErrorCode::invalid_input,
                    fmt::format("triangle {} uses vertex {}, but there are {} vertices", t, v, positions.size()));
            const Vec3d& p = positions[v];
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                throw Error(ErrorCode::invalid_input, fmt::format("vertex {} of triangle {} is not finite", v, t));
            state.bounds.add(p);
        }
    if (triangles.empty()) return;
    state.frame =
        detail::LocalFrame::around(glm::clamp(median(positions), state.bounds.lower, state.bounds.upper), state.bounds);
    RTCGeometry geometry = rtcNewGeometry(state.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), positions.size()));
    if (vertices == nullptr) {
        rtcReleaseGeometry(geometry);
        throw Error(ErrorCode::memory_limit, "no memory left for the bounding volume hierarchy");
    }
    with_threads(context, [&] {
        for_each_index(static_cast<std::uint32_t>(positions.size()), [&](std::uint32_t v) {
            const Vec3d local = state.frame.to_local(positions[v]);
            for (int axis = 0; axis < 3; ++axis) vertices[3 * std::size_t(v) + axis] = static_cast<float>(local[axis]);
        });
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                                   sizeof(triangles[0]), triangles.size());
        rtcSetGeometryPointQueryFunction(geometry, &NearestSearch::on_candidate);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(state.scene, geometry, 0);
        rtcReleaseGeometry(geometry);
        BuildMonitor monitor(context);
        if (context.progress) rtcSetSceneProgressMonitorFunction(state.scene, &BuildMonitor::on_progress, &monitor);
        // Inside a parallel loop, a thread that waits here must not start another iteration of that loop.
        oneapi::tbb::this_task_arena::isolate([&] { rtcCommitScene(state.scene); });
        rtcSetSceneProgressMonitorFunction(state.scene, nullptr, nullptr);
        if (monitor.thrown) std::rethrow_exception(monitor.thrown);
    });
    if (state.failure == RTC_ERROR_NONE) return;
    if (state.failure == RTC_ERROR_OUT_OF_MEMORY)
        throw Error(ErrorCode::memory_limit,
                    state.limit > 0 ? fmt::format("the bounding volume hierarchy needs more than the {} bytes left for "
                                                  "it",
                                                  state.limit)
                                    : std::string("no memory left for the bounding volume hierarchy"));
    throw Error(ErrorCode::invalid_input, fmt::format("Embree rejects the geometry (error {})", state.failure.load()));
}

std::uint32_t TriangleBvh::triangle_count() const { return static_cast<std::uint32_t>(state_->triangles.size()); }

double TriangleBvh::longest_side(std::uint32_t triangle) const {
    const auto& corner = state_->triangles[triangle];
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
        longest =
            std::max(longest, glm::distance(state_->positions[corner[k]], state_->positions[corner[(k + 1) % 3]]));
    return longest;
}
Box3d TriangleBvh::bounds() const { return state_->bounds; }
std::uint64_t TriangleBvh::memory_bytes() const { return static_cast<std::uint64_t>(state_->bytes); }

ClosestPoint TriangleBvh::closest(const Vec3d& point, double max_distance) const noexcept {
    const State& state = *state_;
    ClosestPoint result;
    const auto exact = [&](std::uint32_t t, double best) {
        constexpr double k_too_far = std::numeric_limits<double>::infinity();
        const auto& corner = state.triangles[t];
        const Vec3d &a = state.positions[corner[0]], &b = state.positions[corner[1]], &c = state.positions[corner[2]];
        const double best_squared = best * best * (1 + 0x1p-50);
        // The triangle's own box excludes most candidates: Embree's boxes hold several triangles each.
        const Vec3d low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
        const Vec3d off = glm::max(glm::max(low - point, point - high), Vec3d(0));
        if (glm::dot(off, off) > best_squared) return k_too_far;
        const detail::TrianglePoint nearest = detail::nearest_on_triangle(point, a, b, c);
        if (nearest.squared_distance > best_squared) return k_too_far;
        const double distance = std::sqrt(nearest.squared_distance);
        if (distance < best || (distance == best && t < result.triangle))
            result = {nearest.point, distance, t, nearest.u, nearest.v};
        return distance;
    };
    NearestSearch search{max_distance, std::ref(exact)};
    state.run(search, point);
    return result;
}

std::vector<std::uint32_t> TriangleBvh::within(const Vec3d& point, double distance) const {
    std::vector<std::uint32_t> result;
    std::exception_ptr thrown;
    const auto take = [&](std::uint32_t t, double) {
        try {
            result.push_back(t);
        } catch (...) {
            thrown = std::current_exception();
        }
        return std::numeric_limits<double>::infinity();
    };
    NearestSearch search{distance, std::ref(take)};
    state_->run(search, point);
    if (thrown) std::rethrow_exception(thrown);
    return result;
}

RayHit TriangleBvh::intersect(const Vec3d& origin, const Vec3d& direction, double t_min, double t_max) const noexcept {
    RayHit result;
    const State& state = *state_;
    const double length = glm::length(direction);
    if (state.triangles.empty() || !(length > 0) || !std::isfinite(length)) return result;
    // In the local frame, with unit direction: a parameter t of the given ray is t * unit - start on this one.
    const Vec3d along = direction / length;
    Vec3d local = state.frame.to_local(origin);
    const double unit = length * state.frame.scale;
    double start = 0;
    // A far start moves along the ray to just before the model, which lies within 4 of the frame's middle.
    constexpr double k_far = 16, k_before = 8, k_rounding = 4e-15;
    if (const double away = -glm::dot(local, along); away > k_far) {
        start = away - k_before - k_rounding * away;
        local += start * along;
    }
    // Larger coordinates overflow in Embree.
    if (!(glm::length(local) <= k_farthest_float_query)) return result;
    RTCRayHit query;
    RTCRay& ray = query.ray;
    ray.org_x = static_cast<float>(local.x);
    ray.org_y = static_cast<float>(local.y);
    ray.org_z = static_cast<float>(local.z);
    ray.dir_x = static_cast<float>(along.x);
    ray.dir_y = static_cast<float>(along.y);
    ray.dir_z = static_cast<float>(along.z);
    ray.tnear = static_cast<float>(std::max(std::max(t_min, 0.0) * unit - start, 0.0));
    ray.tfar = static_cast<float>(t_max * unit - start);
    ray.time = 0;
    ray.mask = 0xFFFF'FFFFu;
    ray.id = 0;
    ray.flags = 0;
    // Embree cannot take numbers that are not finite: such a ray meets nothing.
    if (!(ray.tnear <= ray.tfar) || !std::isfinite(ray.tnear)) return result;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(state.scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return result;
    result.triangle = query.hit.primID;
    const auto& corner = state.triangles[result.triangle];
    const Vec3d a = state.positions[corner[0]];
    const Vec3d ab = state.positions[corner[1]] - a, ac = state.positions[corner[2]] - a, ao = origin - a;
    const Vec3d normal = glm::cross(ab, ac);
    const double slope = glm::dot(normal, direction);
    const double t = -glm::dot(normal, ao) / slope;
    const double float_t = (double{ray.tfar} + start) / unit;
    // If the ray is almost parallel to the plane, t by the plane is inaccurate: keep Embree's float result.
    constexpr double k_float_error = 1e-5;
    if (!(std::abs(t - float_t) * unit <= k_float_error * (1 + double{ray.tfar}))) {
        result.t = float_t;
        result.u = query.hit.u;
        result.v = query.hit.v;
        return result;
    }
    const Vec3d at = ao + t * direction;
    const double normal_squared = glm::dot(normal, normal);
    result.t = t;
    result.u = std::clamp(glm::dot(glm::cross(at, ac), normal) / normal_squared, 0.0, 1.0);
    result.v = std::clamp(glm::dot(glm::cross(ab, at), normal) / normal_squared, 0.0, 1.0 - result.u);
    return result;
}

void TriangleBvh::closest(std::span<const Vec3d> points, std::span<ClosestPoint> out, const RunContext& context) const {
    if (points.size() != out.size())
        throw Error(ErrorCode::invalid_input,
                    fmt::format("{} points, but room for {} results", points.size(), out.size()));
    constexpr std::size_t k_block = 256;
    const auto blocks = static_cast<std::uint32_t>((points.size() + k_block - 1) / k_block);
    with_threads(context, [&] {
        for_each_reported(blocks, 1, context, "measure", 0, 1, [&](std::uint32_t b) {
            CoherentClosest walker(*this);
            for (std::size_t i = b * k_block; i < std::min((b + 1) * k_block, points.size()); ++i)
                out[i] = walker.closest(points[i]);
        });
    });
}

ClosestPoint CoherentClosest::closest(const Vec3d& point) noexcept {
    // The surplus covers rounding of the distances; if it ever does not, the search is repeated without a bound.
    constexpr double k_surplus = 1e-9;
    const double bound = (last_distance_ + glm::length(point - last_point_)) * (1 + k_surplus);
    ClosestPoint result = bvh_->closest(point, bound);
    if (!result.found()) result = bvh_->closest(point);
    last_point_ = point;
    last_distance_ = result.distance;
    return result;
}

}  // namespace tetrakis
