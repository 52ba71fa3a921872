#include "nearest_triangle.hpp"

#include <algorithm>
#include <stdexcept>

namespace tetrakis::bench {

namespace {

// In Embree's frame coordinates are at most 1, so a rounded coordinate is off by at most 6e-8; three axes, two ends,
// and the rounding of the query's own arithmetic stay below this.
constexpr double k_slack = 1e-6;

Vec3d on_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b, int i, int j) {
    const Vec3d ab = b - a;
    const double length2 = glm::dot(ab, ab);
    const double t = length2 > 0 ? std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
    Vec3d weights(0.0);
    weights[i] = 1 - t;
    weights[j] += t;
    return weights;
}

}  // namespace

Vec3d nearest_weights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d n = glm::cross(b - a, c - a);
    const double area2 = glm::dot(n, n);
    if (area2 > 0) {  // the foot of the perpendicular, where it lies inside
        const double u = glm::dot(glm::cross(c - b, p - b), n) / area2;
        const double v = glm::dot(glm::cross(a - c, p - c), n) / area2;
        if (u >= 0 && v >= 0 && u + v <= 1) return {u, v, 1 - u - v};
    }
    Vec3d best(0.0);
    double best_distance = std::numeric_limits<double>::infinity();
    for (const Vec3d& w : {on_segment(p, a, b, 0, 1), on_segment(p, b, c, 1, 2), on_segment(p, c, a, 2, 0)}) {
        const double distance = glm::length(w.x * a + w.y * b + w.z * c - p);
        if (distance < best_distance) {
            best_distance = distance;
            best = w;
        }
    }
    return best;
}

struct NearestTriangle::Search {
    const NearestTriangle* mesh;
    Vec3d point;
    Hit hit;
};

struct NearestTriangle::Gathering {
    const NearestTriangle* mesh;
    Vec3d point;
    double radius;
    std::vector<Hit> hits;
};

NearestTriangle::NearestTriangle(std::vector<Vec3d> points, std::vector<std::array<std::uint32_t, 3>> triangles)
    : points_(std::move(points)), triangles_(std::move(triangles)) {
    const Box3d box = bounding_box(points_);
    centre_ = box.centre();
    const Vec3d half = 0.5 * (box.upper - box.lower);
    const double extent = std::max({half.x, half.y, half.z});
    scale_ = extent > 0 ? 1 / extent : 1;
    device_ = rtcNewDevice(nullptr);
    if (device_ == nullptr) throw std::runtime_error("Embree cannot start on this machine");
    scene_ = rtcNewScene(device_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), points_.size()));
    for (std::size_t i = 0; i < points_.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            vertices[3 * i + axis] = static_cast<float>((points_[i][axis] - centre_[axis]) * scale_);
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles_.size()));
    for (std::size_t t = 0; t < triangles_.size(); ++t) std::copy_n(triangles_[t].data(), 3, indices + 3 * t);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
}

NearestTriangle::~NearestTriangle() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

NearestTriangle::Hit NearestTriangle::nearest_on(std::uint32_t triangle, const Vec3d& point) const {
    const auto& [i, j, k] = triangles_[triangle];
    const Vec3d &a = points_[i], &b = points_[j], &c = points_[k];
    const Vec3d w = nearest_weights(point, a, b, c);
    return {triangle, glm::length(w.x * a + w.y * b + w.z * c - point), w};
}

bool NearestTriangle::candidate(RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    const Hit hit = search.mesh->nearest_on(arguments->primID, search.point);
    if (!(hit.distance < search.hit.distance)) return false;
    search.hit = hit;
    arguments->query->radius = static_cast<float>(hit.distance * search.mesh->scale_ + k_slack);
    return true;
}

bool NearestTriangle::gather(RTCPointQueryFunctionArguments* arguments) {
    auto& gathering = *static_cast<Gathering*>(arguments->userPtr);
    const Hit hit = gathering.mesh->nearest_on(arguments->primID, gathering.point);
    if (hit.distance <= gathering.radius) gathering.hits.push_back(hit);
    return false;
}

template <class Query>
void NearestTriangle::query(const Vec3d& point, double radius, RTCPointQueryFunction function, Query& query) const {
    const Vec3d local = (point - centre_) * scale_;
    RTCPointQuery ball;
    ball.x = static_cast<float>(local.x);
    ball.y = static_cast<float>(local.y);
    ball.z = static_cast<float>(local.z);
    ball.time = 0;
    ball.radius = static_cast<float>(radius * scale_ + k_slack);
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &ball, &context, function, &query);
}

NearestTriangle::Hit NearestTriangle::nearest(const Vec3d& point, double within) const {
    Search search{this, point, {}};
    search.hit.distance = within;
    query(point, within, &NearestTriangle::candidate, search);
    return search.hit;
}

std::vector<NearestTriangle::Hit> NearestTriangle::within(const Vec3d& point, double radius) const {
    Gathering gathering{this, point, radius, {}};
    query(point, radius, &NearestTriangle::gather, gathering);
    std::sort(gathering.hits.begin(), gathering.hits.end(), [](const Hit& a, const Hit& b) {
        return a.distance != b.distance ? a.distance < b.distance : a.triangle < b.triangle;
    });
    return std::move(gathering.hits);
}

}  // namespace tetrakis::bench
