#include "render.hpp"

#include "../../hier/base/parallel.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../tessellate/shading_normals.hpp"
#include "heat_map.hpp"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/gtc/color_space.hpp>
#include <glm/trigonometric.hpp>

#include <cmath>
#include <numbers>

namespace tetrakis {

namespace {

// Constants of the lighting, tuned by eye on the project's models. Intensities have one common unit.
constexpr double k_key_light = 2.65, k_fill_light = 0.42, k_rim_light = 0.55, k_sky_light = 0.60;
constexpr double k_key_spread = 0.10;       // radius of the key light on the unit sphere: how soft its shadow is
constexpr double k_occlusion_reach = 0.35;  // as a share of the model's diagonal
constexpr double k_specular = 0.045;        // reflectance looking straight at the surface
constexpr double k_roughness = 0.42;
constexpr double k_legend_strip = 0.17;                  // of the picture's width
constexpr double k_ground_shadow = 0.55;                 // largest darkening of the ground
constexpr double k_ground_reach = 1.5;                   // distance where shadows end, as a share of the diagonal
constexpr double k_wire_faint = 1.5, k_wire_full = 6.0;  // pixels of triangle height between which lines fade in

constexpr double k_gamma = 2.4;  // of sRGB
Vec3d linear(const Vec3f& srgb) { return glm::convertSRGBToLinear(Vec3d(srgb), k_gamma); }

// Light above 0.7 is compressed smoothly towards 1, so that highlights keep their shading.
double soft_clip(double x) {
    constexpr double k_knee = 0.7;
    return x <= k_knee ? x : k_knee + (1 - k_knee) * (1 - std::exp(-(x - k_knee) / (1 - k_knee)));
}

// A hash of a sample's coordinates, as a number in [0, 1) (after Jarzynski and Olano 2020, pcg).
double noise(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    std::uint32_t state = x * 747796405u + 2891336453u;
    state = (state ^ y) * 747796405u + 2891336453u;
    state = (state ^ z) * 747796405u + 2891336453u;
    const std::uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return ((word >> 22) ^ word) * 0x1p-32;
}

// Two directions at right angles to n and each other.
void frame_of(const Vec3d& n, Vec3d& s, Vec3d& t) {
    const Vec3d axis = std::abs(n.x) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    s = glm::normalize(glm::cross(axis, n));
    t = glm::cross(n, s);
}

Vec3d on_disk(double a, double b, const Vec3d& s, const Vec3d& t) {
    const double radius = std::sqrt(a), angle = 2 * std::numbers::pi * b;
    return radius * (std::cos(angle) * s + std::sin(angle) * t);
}

struct Sample {
    std::uint32_t x, y, index;  // the pixel, and the sample's number in the pixel
};

class Renderer {
  public:
    Renderer(const TriangleMesh& mesh, const RenderOptions& options, const RunContext& context)
        : mesh_(mesh), options_(options), context_(context), bvh_(mesh, context) {
        if (options.shading == Shading::smooth) normals_ = detail::corner_normals(mesh, options.crease_degrees);
        diagonal_ = bvh_.bounds().diagonal();
        set_camera();
        set_lights();
        top_ = linear(options.background_top);
        bottom_ = linear(options.background_bottom);
        surface_ = linear(options.surface_colour);
        back_ = linear(options.back_colour);
        wire_ = linear(options.wire_colour);
        highest_ = options.highest_value.value_or(0.0);
        if (!options.highest_value)
            for (const float value : options.triangle_values) highest_ = std::max(highest_, double(value));
        occlusion_per_sample_ = (options.occlusion_samples + samples() - 1) / samples();
    }

    Image run() {
        Image image{options_.width, options_.height, {}};
        image.rgb.resize(std::size_t{3} * options_.width * options_.height);
        constexpr std::uint32_t k_tile = 32;  // pixels of a row per task: neighbouring rays visit the same nodes
        const std::uint32_t tiles_across = (options_.width + k_tile - 1) / k_tile;
        for_each_reported(tiles_across * options_.height, 1, context_, "render", 0, 1, [&](std::uint32_t i) {
            const std::uint32_t y = i / tiles_across, first = i % tiles_across * k_tile;
            for (std::uint32_t x = first; x < std::min<std::uint32_t>(first + k_tile, options_.width); ++x) {
                const Vec3d colour = 255.0 * glm::convertLinearToSRGB(pixel(x, y), k_gamma);
                for (int c = 0; c < 3; ++c)
                    image.rgb[3 * (std::size_t{y} * options_.width + x) + c] =
                        static_cast<std::uint8_t>(std::lround(colour[c]));
            }
        });
        if (!options_.triangle_values.empty() && options_.legend)
            detail::draw_legend(image, options_.lowest_value, highest_, options_.legend_title);
        return image;
    }

  private:
    int samples() const { return options_.supersampling * options_.supersampling; }

    // Leaves a strip on the right for the legend if the picture is wider than high.
    Camera fitted_camera(double aspect) const {
        const bool legend = !options_.triangle_values.empty() && options_.legend && aspect > 1;
        const double strip = legend ? k_legend_strip : 0;
        std::vector<std::uint8_t> used(mesh_.positions.size(), 0);
        for (const auto& triangle : mesh_.triangles)
            for (const std::uint32_t v : triangle) used[v] = 1;
        std::vector<Vec3d> points;
        for (std::size_t v = 0; v < used.size(); ++v)
            if (used[v] != 0) points.push_back(mesh_.positions[v]);
        Camera camera = fit_camera(points, aspect * (1 - strip), options_.view);
        const Vec3d look = camera.target - camera.eye;
        const Vec3d right = glm::cross(look, camera.up);
        if (strip > 0 && glm::length(right) > 0) {
            const double half_width =
                glm::length(look) * aspect * std::tan(glm::radians(camera.vertical_fov_degrees) / 2);
            const Vec3d shift = strip * half_width * glm::normalize(right);
            camera.eye += shift;
            camera.target += shift;
        }
        return camera;
    }

    void set_camera() {
        const double aspect = static_cast<double>(options_.width) / options_.height;
        const Camera camera = options_.camera ? *options_.camera : fitted_camera(aspect);
        const Vec3d look = camera.target - camera.eye;
        const double distance = glm::length(look), up_length = glm::length(camera.up);
        if (!(distance > 0) || !std::isfinite(distance) || !(up_length > 0) || !std::isfinite(up_length))
            throw Error(ErrorCode::invalid_input, "the camera's eye and target coincide, or its up is zero");
        if (!(camera.vertical_fov_degrees > 0 && camera.vertical_fov_degrees < 180))
            throw Error(ErrorCode::invalid_input, "the camera's field of view must lie between 0 and 180 degrees");
        eye_ = camera.eye;
        up_ = camera.up / up_length;
        forward_ = look / distance;
        Vec3d right = glm::cross(forward_, up_);
        if (!(glm::length(right) > 1e-9)) {  // looking along up: any direction to the right is possible
            Vec3d unused;
            frame_of(forward_, right, unused);
        }
        right_ = glm::normalize(right);
        above_ = glm::cross(right_, forward_);
        tan_v_ = std::tan(glm::radians(camera.vertical_fov_degrees) / 2);
        tan_h_ = tan_v_ * aspect;
        // The ground is a plane through the lowest point along up; from below it is not drawn: it would hide the model.
        ground_height_ = std::numeric_limits<double>::infinity();
        for (const auto& triangle : mesh_.triangles)
            for (const std::uint32_t v : triangle)
                ground_height_ = std::min(ground_height_, glm::dot(mesh_.positions[v], up_));
        has_ground_ = options_.ground && glm::dot(eye_, up_) > ground_height_ + 0.02 * diagonal_;
    }

    void set_lights() {
        // Lights are relative to the camera, so all views are lit alike; the key light is above, to cast a shadow.
        const Vec3d back = glm::cross(right_, up_);
        key_ = glm::normalize(-0.75 * right_ + 0.65 * back + 1.15 * up_);
        fill_ = glm::normalize(1.0 * right_ + 0.55 * back + 0.15 * up_);
        rim_ = glm::normalize(0.55 * right_ - 1.0 * back + 0.55 * up_);
        frame_of(key_, key_s_, key_t_);
    }

    Vec3d pixel(std::uint32_t x, std::uint32_t y) const {
        const int n = options_.supersampling;
        Vec3d sum(0);
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
                const Sample sample{x, y, static_cast<std::uint32_t>(j * n + i)};
                const Vec3d light = ray(x + (i + 0.5) / n, y + (j + 0.5) / n, sample);
                sum += Vec3d(soft_clip(light.x), soft_clip(light.y), soft_clip(light.z));
            }
        return sum / static_cast<double>(samples());
    }

    Vec3d ray(double px, double py, const Sample& sample) const {
        const double sx = 2 * px / options_.width - 1, sy = 1 - 2 * py / options_.height;
        const Vec3d direction = glm::normalize(forward_ + sx * tan_h_ * right_ + sy * tan_v_ * above_);
        const RayHit hit = bvh_.intersect(eye_, direction);
        const double slope = glm::dot(direction, up_);
        const double to_ground = has_ground_ && slope < 0 ? (ground_height_ - glm::dot(eye_, up_)) / slope : hit.t + 1;
        const double down = py / options_.height;
        const Vec3d background = glm::mix(top_, bottom_, down * down * (3 - 2 * down));
        if (hit.found() && (!has_ground_ || slope >= 0 || hit.t <= to_ground * (1 + 1e-6)))
            return surface(hit, direction, px, py, sample);
        if (has_ground_ && slope < 0 && std::isfinite(to_ground))
            return background * ground_light(eye_ + to_ground * direction, sample);
        return background;
    }

    double ground_light(const Vec3d& p, const Sample& sample) const {
        const Vec3d centre = bvh_.bounds().centre();
        const Vec3d away = p - centre - glm::dot(p - centre, up_) * up_;
        const double far = glm::length(away) / (k_ground_reach * diagonal_);
        if (far >= 1) return 1;
        const double fade = (1 - far) * (1 - far) * (1 + 2 * far);
        const Vec3d start = p + 1e-4 * diagonal_ * up_;
        const double key = key_visible(start, sample) ? 0.0 : 0.45;
        const double dark = key + 0.8 * (1 - occlusion(start, up_, sample));
        return 1 - k_ground_shadow * fade * std::min(1.0, dark);
    }

    bool key_visible(const Vec3d& p, const Sample& sample) const {
        // One point of the area light per sample; the points of a pixel's samples are spread, and shifted by pixel.
        const double a = glm::fract((sample.index + 0.5) / samples() + noise(sample.x, sample.y, 1));
        const double b = glm::fract(sample.index * 0.6180339887498949 + noise(sample.x, sample.y, 2));
        const Vec3d towards = key_ + k_key_spread * on_disk(a, b, key_s_, key_t_);
        return !bvh_.occluded(p, towards);
    }

    // Visible share of the sky from p, weighted by the cosine to the normal.
    double occlusion(const Vec3d& p, const Vec3d& n, const Sample& sample) const {
        if (occlusion_per_sample_ == 0) return 1;
        Vec3d s, t;
        frame_of(n, s, t);
        int open = 0;
        const int total = occlusion_per_sample_ * samples();
        for (int i = 0; i < occlusion_per_sample_; ++i) {
            const int k = static_cast<int>(sample.index) * occlusion_per_sample_ + i;
            const double a = glm::fract((k + 0.5) / total + noise(sample.x, sample.y, 3));
            const double b = glm::fract(k * 0.6180339887498949 + noise(sample.x, sample.y, 4));
            const Vec3d direction = on_disk(a, b, s, t) + std::sqrt(1 - a) * n;
            open += bvh_.occluded(p, direction, 0, k_occlusion_reach * diagonal_) ? 0 : 1;
        }
        return static_cast<double>(open) / occlusion_per_sample_;
    }

    Vec3d surface(const RayHit& hit, const Vec3d& direction, double px, double py, const Sample& sample) const {
        const auto& corner = mesh_.triangles[hit.triangle];
        const Vec3d weights(1 - hit.u - hit.v, hit.u, hit.v);
        Vec3d p(0);
        for (int k = 0; k < 3; ++k) p += weights[k] * mesh_.positions[corner[k]];
        Vec3d face = detail::face_normal(mesh_, hit.triangle);
        if (face == Vec3d(0)) face = -direction;
        const bool back = glm::dot(face, direction) > 0;
        const double side = back ? -1 : 1;
        face *= side;
        Vec3d n = face, start = p;
        if (!normals_.empty()) {
            // Shadow rays start on the curved surface that the normals suggest (Hanika 2021): from the flat facets of a
            // coarse mesh, they would hit the mesh itself.
            const auto& at = normals_[hit.triangle];
            n = Vec3d(0);
            Vec3d lift(0);
            for (int k = 0; k < 3; ++k) {
                const Vec3d corner_normal = side * Vec3d(at[k]);
                n += weights[k] * corner_normal;
                const double below = std::min(0.0, glm::dot(p - mesh_.positions[corner[k]], corner_normal));
                lift -= weights[k] * below * corner_normal;
            }
            n = glm::length(n) > 1e-6 ? glm::normalize(n) : face;
            start += lift;
        }
        start += 2e-5 * diagonal_ * face;
        const Vec3d colour = shade(start, n, -direction, back ? back_ : base_colour(hit.triangle), sample);
        return options_.wireframe ? glm::mix(colour, wire_, wire_cover(hit.triangle, px, py)) : colour;
    }

    Vec3d base_colour(std::uint32_t t) const {
        if (options_.triangle_values.empty()) return surface_;
        const double range = highest_ - options_.lowest_value;
        const double x = range > 0 ? (options_.triangle_values[t] - options_.lowest_value) / range : 0.0;
        return linear(heat_colour(x));
    }

    Vec3d shade(const Vec3d& start, const Vec3d& n, const Vec3d& view, const Vec3d& base, const Sample& sample) const {
        const double open = occlusion(start, n, sample);
        const double facing = std::clamp(glm::dot(n, view), 0.0, 1.0);
        double key = std::max(0.0, glm::dot(n, key_));
        if (key > 0 && !key_visible(start, sample)) key = 0;
        const double wrap = std::max(0.0, (glm::dot(n, fill_) + 0.3) / 1.3);
        const Vec3d warm(1.0, 0.965, 0.91), cool(0.86, 0.93, 1.0);
        // The sky is brighter than the light reflected by the ground.
        const double sky = 0.62 + 0.38 * glm::dot(n, up_);
        Vec3d light = k_key_light * key / std::numbers::pi * warm + k_fill_light * wrap / 1.6 * open * cool +
                      k_sky_light * sky * open * cool;
        Vec3d colour = base * light;
        // Highlights: GGX with Schlick's Fresnel for the key light, a plain Fresnel edge for the rim.
        const double grazing = std::pow(1 - facing, 5.0);
        if (key > 0) {
            const Vec3d half = glm::normalize(key_ + view);
            const double nh = std::max(0.0, glm::dot(n, half)), alpha = k_roughness * k_roughness, a2 = alpha * alpha;
            const double d = nh * nh * (a2 - 1) + 1;
            const double fresnel =
                k_specular + (1 - k_specular) * std::pow(1 - std::max(0.0, glm::dot(half, view)), 5.0);
            colour += k_key_light * key * fresnel * a2 / (4 * std::numbers::pi * d * d) / std::max(0.3, facing) * warm;
        }
        const double rim = std::max(0.0, glm::dot(n, rim_));
        colour += (k_rim_light * rim * grazing * open + 0.16 * grazing * open * std::max(0.0, sky)) * cool;
        return colour;
    }

    // Coverage of the sample by lines, from its distance in pixels to the edges of the triangle at the sample.
    double wire_cover(std::uint32_t t, double px, double py) const {
        Vec2d at[3];
        for (int k = 0; k < 3; ++k) {
            const Vec3d d = mesh_.positions[mesh_.triangles[t][k]] - eye_;
            const double z = glm::dot(d, forward_);
            if (!(z > 0)) return 0;
            at[k] = {(glm::dot(d, right_) / (z * tan_h_) + 1) * 0.5 * options_.width,
                     (1 - glm::dot(d, above_) / (z * tan_v_)) * 0.5 * options_.height};
        }
        const Vec2d here(px, py);
        double nearest = std::numeric_limits<double>::infinity(), longest = 0;
        for (int k = 0; k < 3; ++k) {
            const Vec2d edge = at[(k + 1) % 3] - at[k], offset = here - at[k];
            const double length = glm::length(edge);
            longest = std::max(longest, length);
            if (length > 0) nearest = std::min(nearest, std::abs(edge.x * offset.y - edge.y * offset.x) / length);
        }
        const Vec2d ab = at[1] - at[0], ac = at[2] - at[0];
        const double height = longest > 0 ? std::abs(ab.x * ac.y - ab.y * ac.x) / longest : 0;
        const double fade = std::clamp((height - k_wire_faint) / (k_wire_full - k_wire_faint), 0.0, 1.0);
        const double blur = 0.5 / options_.supersampling;  // half of the sample's width
        const double cover = std::clamp((options_.wire_pixels / 2 - nearest) / (2 * blur) + 0.5, 0.0, 1.0);
        // Lines that fade out are replaced by their mean darkness.
        return 0.85 * (cover * fade + (1 - fade) * 0.18);
    }

    const TriangleMesh& mesh_;
    const RenderOptions& options_;
    const RunContext& context_;
    TriangleBvh bvh_;
    std::vector<std::array<Vec3f, 3>> normals_;
    double diagonal_ = 0, ground_height_ = 0, tan_h_ = 0, tan_v_ = 0, highest_ = 0;
    bool has_ground_ = false;
    int occlusion_per_sample_ = 0;
    Vec3d eye_{0.0}, up_{0.0}, forward_{0.0}, right_{0.0}, above_{0.0};
    Vec3d key_{0.0}, fill_{0.0}, rim_{0.0}, key_s_{0.0}, key_t_{0.0};
    Vec3d top_{0.0}, bottom_{0.0}, surface_{0.0}, back_{0.0}, wire_{0.0};
};

void check(const TriangleMesh& mesh, const RenderOptions& options) {
    const auto reject = [](const std::string& text) { throw Error(ErrorCode::invalid_input, text); };
    constexpr int k_largest_side = 16384, k_most_supersampling = 16, k_most_occlusion = 4096;
    if (mesh.triangles.empty()) reject("the mesh to draw has no triangles");
    if (options.width < 1 || options.height < 1 || options.width > k_largest_side || options.height > k_largest_side)
        reject(fmt::format("a picture of {} x {} pixels; sides must be 1 to {}", options.width, options.height,
                           k_largest_side));
    if (options.supersampling < 1 || options.supersampling > k_most_supersampling)
        reject(fmt::format("supersampling must be 1 to {}", k_most_supersampling));
    if (options.occlusion_samples < 0 || options.occlusion_samples > k_most_occlusion)
        reject(fmt::format("occlusion samples must be 0 to {}", k_most_occlusion));
    for (const double number :
         {options.crease_degrees, options.wire_pixels, options.lowest_value, options.highest_value.value_or(0),
          options.view.azimuth_degrees, options.view.elevation_degrees})
        if (!std::isfinite(number)) reject("an angle, a line width or an end of the values' range is not finite");
    for (const Vec3f& colour : {options.wire_colour, options.surface_colour, options.back_colour,
                                options.background_top, options.background_bottom})
        for (int c = 0; c < 3; ++c)
            if (!(colour[c] >= 0 && colour[c] <= 1))
                reject(fmt::format("colour ({}, {}, {}); each part must be 0 to 1", colour.r, colour.g, colour.b));
    if (!options.triangle_values.empty() && options.triangle_values.size() != mesh.triangles.size())
        reject(fmt::format("{} values for {} triangles", options.triangle_values.size(), mesh.triangles.size()));
    if (!mesh.triangle_normals.empty() && mesh.triangle_normals.size() != mesh.triangles.size())
        reject(fmt::format("normals for {} triangles of {}", mesh.triangle_normals.size(), mesh.triangles.size()));
    for (const auto& triangle : mesh.triangle_normals)
        for (const std::uint32_t n : triangle)
            if (n >= mesh.normals.size())
                reject(fmt::format("a triangle uses normal {}, but there are {}", n, mesh.normals.size()));
    if (mesh.triangle_normals.empty() && !mesh.normals.empty() && mesh.normals.size() != mesh.positions.size())
        reject(fmt::format("{} normals for {} vertices", mesh.normals.size(), mesh.positions.size()));
}

}  // namespace

Image render(const TriangleMesh& mesh, const RenderOptions& options, const RunContext& context) {
    check(mesh, options);
    return with_threads(context, [&] { return Renderer(mesh, options, context).run(); });
}

}  // namespace tetrakis
