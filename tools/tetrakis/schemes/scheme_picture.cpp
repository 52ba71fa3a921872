#include "scheme_picture.hpp"

#include "canvas.hpp"
#include "fan_patch.hpp"

#include "../../../eval/render/render.hpp"
#include "../../../schemes/parts/sector_fan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

namespace tetrakis::cli {
namespace {

constexpr int k_columns = 4, k_cell = 380, k_margin = 24, k_head = 84, k_caption = 40;
constexpr int k_width = k_columns * k_cell + 2 * k_margin, k_large = (k_width - 3 * k_margin) / 2;
// The patch is refined while it has fewer vertices than this, which takes about a second.
constexpr int k_most_vertices = 200'000, k_most_steps = 5;
const Vec3f k_ink(0.14f, 0.17f, 0.22f), k_grey(0.62f, 0.66f, 0.71f);
const Vec3f k_blue(0.12f, 0.33f, 0.62f), k_red(0.80f, 0.22f, 0.16f), k_orange(0.88f, 0.48f, 0.10f);

/// "3/8" if the number is a fraction with a small denominator, else a few digits.
std::string weight_text(double x) {
    for (const int denominator :
         {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 20, 24, 27, 32, 36, 40, 64, 81, 128, 256, 512}) {
        const double numerator = x * denominator;
        if (std::round(numerator) != 0 && std::abs(numerator - std::round(numerator)) < 1e-9)
            return denominator == 1 ? fmt::format("{}", std::round(numerator))
                                    : fmt::format("{}/{}", std::round(numerator), denominator);
    }
    constexpr double k_least_fixed = 0.0005;
    return std::abs(x) < k_least_fixed ? fmt::format("{:.0e}", x) : fmt::format("{:.3f}", x);
}

/// Maps a square window of the plane to the canvas.
struct Window {
    Vec2d middle;  // on the canvas
    double scale;

    Vec2d at(Vec2d p) const { return {middle.x + scale * p.x, middle.y - scale * p.y}; }
};

/// Draws the outlines of the faces whose corners are all nearer to the origin than `reach`.
void draw_faces(Canvas& canvas, const Window& window, const RuleMesh& mesh, const std::vector<Vec2d>& plane,
                double reach) {
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto corners = mesh.corners(f);
        if (!std::all_of(corners.begin(), corners.end(), [&](int v) { return glm::length(plane[v]) < reach; }))
            continue;
        for (std::size_t i = 0; i < corners.size(); ++i)
            canvas.line(window.at(plane[corners[i]]), window.at(plane[corners[(i + 1) % corners.size()]]), 1.3, k_ink);
    }
}

double largest(const std::vector<Vec2d>& points) {
    double most = 0;
    for (const Vec2d& p : points) most = std::max(most, glm::length(p));
    return most;
}

/// Positions of the labels in the plane of the patch.
std::vector<Vec2d> label_places(const FanLabels& labels, const FanPatch& patch) {
    std::vector<Vec2d> places;
    std::vector<int> start = patch.start;
    // Hexagons: the middle face is face 0; start at each of its corners.
    for (int s = 0; patch.start.empty() && s < labels.shape().faces; ++s) start.push_back(patch.mesh.face_begin(0) + s);
    for (const int v : find_fan(patch.mesh, start, labels)) places.push_back(patch.plane[v]);
    return places;
}

/// Finds positions of labels next to their dots that cover nothing: first below, then above, then beside the dot.
class LabelPlaces {
  public:
    void keep_free(Vec2d middle, double radius) { taken_.push_back({middle - radius, middle + radius}); }

    /// The centre for a label of that size at a dot of that radius.
    /// @param must  if every position covers something: true returns the best position, false returns nothing
    std::optional<Vec2d> find(Vec2d dot, double radius, Vec2d size, bool must) {
        constexpr double k_gap = 3;
        const Vec2d off = 0.5 * size + radius + k_gap;
        const double right = off.x, down = off.y;
        const Vec2d places[] = {{0, down},     {0, -down},     {right, 0},     {-right, 0},
                                {right, down}, {-right, down}, {right, -down}, {-right, -down}};
        Vec2d best = dot + places[0];
        double least = 1e30;
        for (const Vec2d& place : places) {
            const Vec2d low = dot + place - 0.5 * size, high = dot + place + 0.5 * size;
            double covered = 0;
            for (const Box& box : taken_) {
                const Vec2d common = glm::min(high, box.high) - glm::max(low, box.low);
                if (common.x > 0 && common.y > 0) covered += common.x * common.y;
            }
            if (covered >= least) continue;
            least = covered;
            best = dot + place;
        }
        if (least > 0 && !must) return std::nullopt;
        taken_.push_back({best - 0.5 * size, best + 0.5 * size});
        return best;
    }

  private:
    struct Box {
        Vec2d low, high;
    };
    std::vector<Box> taken_;
};

/// Clips a segment to a square around the origin. Returns the parameters (0 to 1) of the part inside, or nothing.
std::optional<Vec2d> part_within(Vec2d from, Vec2d to, double half) {
    Vec2d part(0, 1);
    for (int k = 0; k < 2; ++k) {
        const double along = to[k] - from[k];
        if (std::abs(along) < 1e-12 * half) {
            if (std::abs(from[k]) > half) return std::nullopt;
            continue;
        }
        const double a = (-half - from[k]) / along, b = (half - from[k]) / along;
        part.x = std::max(part.x, std::min(a, b));
        part.y = std::min(part.y, std::max(a, b));
    }
    if (part.x >= part.y) return std::nullopt;
    return part;
}

/// Writes the weights next to their dots. If dots are crowded, each weight is written once, the largest first, at the
/// first dot that has room; very small weights are left out.
void label_weights(Canvas& canvas, LabelPlaces& labels, const SchemePicture::Mask& mask, const std::vector<Vec2d>& dots,
                   const std::vector<double>& radius, bool crowded) {
    constexpr double k_light = 0.01;  // of the largest weight
    const double height = crowded ? 8 : 11, gap = crowded ? 6 : 4;
    std::vector<int> order;
    double heaviest = 0;
    for (std::size_t i = 0; i < dots.size(); ++i) {
        if (radius[i] != 0) order.push_back(static_cast<int>(i));
        heaviest = std::max(heaviest, std::abs(mask.weights[i]));
    }
    if (crowded) {
        std::erase_if(order, [&](int i) { return std::abs(mask.weights[i]) < k_light * heaviest; });
        std::stable_sort(order.begin(), order.end(),
                         [&](int a, int b) { return std::abs(mask.weights[a]) > std::abs(mask.weights[b]) + 1e-12; });
    }
    std::set<std::string> written;
    for (const int i : order) {
        const double w = mask.weights[i];
        const std::string text = weight_text(w);
        if (crowded && written.contains(text)) continue;
        const Vec2d size(Canvas::text_width(text, height) + gap, height + gap);
        const auto at = labels.find(dots[i], radius[i], size, !crowded);
        if (!at) continue;
        canvas.label(*at, height, text, w > 0 ? k_ink : k_orange);
        written.insert(text);
    }
}

void draw_mask(Canvas& canvas, Vec2d corner, const SchemePicture::Mask& mask, const std::vector<Vec2d>& places,
               const FanPatch& patch, const std::vector<bool>& inner, Vec2d lambda) {
    constexpr double k_clearance = 46;  // around the outermost dot, for its text
    std::vector<Vec2d> used;
    double heaviest = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (std::abs(mask.weights[i]) > 1e-13) {
            used.push_back(places[i]);
            heaviest = std::max(heaviest, std::abs(mask.weights[i]));
        }
    const bool crowded = used.size() > 24;
    // The window shows the mask's support; for limit masks at least the middle face or the one-ring.
    if (!mask.new_point)
        for (std::size_t i = 0; i < places.size(); ++i)
            if (inner[i]) used.push_back(places[i]);
    Vec2d low(1e30), high(-1e30);
    for (const Vec2d& p : used) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const Vec2d centre = 0.5 * (low + high);
    const double half = std::max({0.5 * (high.x - low.x), 0.5 * (high.y - low.y), 0.2 * largest(places)});
    const double scale = (0.5 * k_cell - k_clearance) / half;
    const Vec2d middle = corner + Vec2d(0.5 * k_cell, k_caption + 0.5 * k_cell);
    const Window window{middle - scale * Vec2d(centre.x, -centre.y), scale};
    const double clip = half + 0.65 * k_clearance / scale;
    for (int e = 0; e < patch.mesh.edge_count(); ++e) {
        const int h = patch.mesh.edge_halfedge(e);
        const Vec2d a = patch.plane[patch.mesh.origin(h)], b = patch.plane[patch.mesh.target(h)];
        if (const auto part = part_within(a - centre, b - centre, clip))
            canvas.line(window.at(a + part->x * (b - a)), window.at(a + part->y * (b - a)), 1.6, k_grey);
    }
    LabelPlaces labels;
    std::vector<double> radius(places.size(), 0.0);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double w = mask.weights[i];
        if (std::abs(w) <= 1e-13) continue;
        radius[i] = (crowded ? 5 : 8) * std::sqrt(std::abs(w) / heaviest) + 2.5;
        canvas.disc(window.at(places[i]), radius[i], w > 0 ? k_blue : k_orange);
        labels.keep_free(window.at(places[i]), radius[i]);
    }
    // On the next level the point of the same label is nearer to the middle by lambda.
    if (mask.new_point) {
        constexpr double k_ring = 12, k_ring_width = 2.4;
        const Vec2d at = window.at(lambda * places[*mask.new_point]);
        canvas.circle(at, k_ring, k_ring_width, k_red);
        labels.keep_free(at, k_ring + k_ring_width);
    }
    std::vector<Vec2d> dots;
    for (const Vec2d& p : places) dots.push_back(window.at(p));
    label_weights(canvas, labels, mask, dots, radius, crowded);
    if (crowded) canvas.text(corner + Vec2d(14, 31), 8, "each weight once, none below 1 % of the largest", k_grey);
    canvas.text(corner + Vec2d(14, 10), 13, mask.title, k_ink);
}

/// Draws the lattice lines over k_patch_rings rings, as polylines through the points of a refined patch.
void draw_lines(Canvas& canvas, const Window& window, const FanPatch& patch, const std::vector<Vec2d>& places,
                const FanLabels& labels) {
    const int n = labels.shape().faces, m = patch.intervals;
    const bool dual = labels.lattice() == FanLattice::dual, triangles = labels.lattice() == FanLattice::triangles;
    const bool boundary = labels.shape().boundary;
    const int rim = labels.rings() - (dual ? 1 : 0);
    const auto line = [&](Vec2d from, Vec2d to, bool bold) {
        canvas.line(window.at(from), window.at(to), bold ? 3.2 : 1.5, bold ? k_blue : k_ink);
    };
    // One step of a line from one label to another, if it is on a lattice line and not outside the rim.
    const auto step = [&](bool on_line, FanLabel from, FanLabel to, bool bold = false) {
        if (!on_line || std::max(to.a, to.b) > rim) return;
        const int a = labels.find(from), b = labels.find(to);
        if (a >= 0 && b >= 0) line(places[a], places[b], bold);
    };
    Vec2d centre(0);  // of a dual fan's middle face
    const bool around_face = dual && !boundary;
    for (int s = 0; s < n && around_face; ++s) centre += places[labels.find({s, 0, 0})] / static_cast<double>(n);
    const int sectors = around_face ? n : dual ? 2 : n + (boundary ? 1 : 0);
    for (int s = 0; s < sectors; ++s) {
        if (around_face) line(centre, places[labels.find({s, 0, 0})], true);
        for (int i = 0; i <= rim; ++i)
            for (int j = 0; j <= rim; ++j) {
                if (around_face) {
                    // Around the middle face's shrunk children a whole interval ends one line short of a multiple.
                    // From quadrant s, over the side before its corner, to the quadrant before.
                    const int before = (s + n - 1) % n;
                    step(i == 0 || i % m == m - 1, {s, i, j}, {s, i, j + 1}, i == 0);
                    step(j % m == m - 1, {before, i, j}, {before, i + 1, j});
                    step(i == 0 && j % m == m - 1, {s, j, 0}, {before, 0, j});
                    continue;
                }
                step(j == 0 || ((dual || s < n) && j % m == 0), {s, i, j}, {s, i + 1, j}, j == 0);
                if (dual) {
                    step(s == 0 && i == 0 && j % m == 0, {1, 0, j}, {0, 0, j}, j == 0);
                    step(i % m == m / 2, {s, i, j}, {s, i, j + 1});
                } else if (s < n) {  // s = n: only the ray along the other half of the boundary
                    step(i > 0 && i % m == 0, {s, i, j}, {s, i, j + 1});
                    step(triangles && i > 0 && (i + j) % m == 0, {s, i, j}, {s, i - 1, j + 1});
                }
            }
    }
}

}  // namespace

Image draw_scheme(const SchemePicture& picture, const RunContext& context) {
    const FanLabels& labels = picture.analysis.matrix.labels;
    const bool boundary = labels.shape().boundary;
    FanPatch patch = fan_patch(picture.scheme, picture.analysis, picture.rules);
    // In a sketch, the lines of the next level lie between the lines of the first.
    const double between_lines = picture.scheme.refinement == Refinement::sqrt3 ? 1.0 / 3 : 0.5;
    const Vec2d lambda =
        patch.characteristic ? Vec2d(picture.analysis.lambda1, picture.analysis.lambda2) : Vec2d(between_lines);
    const int mask_rows = (static_cast<int>(picture.masks.size()) + k_columns - 1) / k_columns;
    const int large_top = k_head + mask_rows * (k_cell + k_caption);
    Canvas canvas(k_width, large_top + k_caption + k_large + k_margin);
    constexpr double k_title = 22, k_room = k_width - 2 * k_margin;
    const double title_height = k_title * std::min(1.0, k_room / Canvas::text_width(picture.title, k_title));
    canvas.text({k_margin, k_title}, title_height, picture.title, k_ink);
    canvas.text({k_margin, 56}, 13, picture.subtitle, k_blue);

    const std::vector<Vec2d> places = label_places(labels, patch);
    std::vector<bool> inner;
    for (const FanLabel label : labels.all())
        inner.push_back(labels.ring_of(label) <= (labels.lattice() == FanLattice::dual ? 0 : 1));
    for (std::size_t i = 0; i < picture.masks.size(); ++i)
        draw_mask(canvas,
                  {k_margin + static_cast<double>(i % k_columns) * k_cell,
                   k_head + static_cast<double>(i / k_columns) * (k_cell + k_caption)},
                  picture.masks[i], places, patch, inner, lambda);

    // Extents of the two pictures: k_patch_rings rings of the lattice, and the support of the basis function.
    const bool hexagons = patch.start.empty();
    const double hexagon_reach = 0.5 * largest(patch.plane);
    std::vector<Vec2d> coarse = patch.plane;
    const RuleMesh coarse_mesh = patch.mesh;
    double basis_reach = 0.62 * hexagon_reach;
    int basis_rings = 0;
    if (!hexagons) {
        const bool dual = labels.lattice() == FanLattice::dual;
        const double support = support_radius(picture.scheme, picture.rules);
        basis_rings = std::clamp(static_cast<int>(std::ceil(support)) + (dual ? 1 : 0), 1, k_patch_rings);
        const FanLabels near(labels.lattice(), labels.shape(), basis_rings);
        std::vector<Vec2d> points;
        for (const int v : find_fan(patch.mesh, patch.start, near)) points.push_back(patch.plane[v]);
        basis_reach = largest(points);
    }
    const int growth = picture.scheme.refinement == Refinement::sqrt3 ? 9 : 4;
    // Every two averaging steps widen the rows by one ring.
    const int most = k_most_vertices / (1 + averaging_steps(picture.scheme, picture.rules) / 2);
    while (patch.steps < k_most_steps && (patch.steps < 2 || patch.mesh.vertex_count() * growth < most))
        refine(patch, picture.scheme, picture.rules);

    const Vec2d middle(k_margin + 0.5 * k_large, large_top + k_caption + 0.5 * k_large);
    canvas.text({k_margin + 14.0, large_top + 10.0}, 15,
                hexagons ? "characteristic map, approximately: the mesh after two steps"
                         : fmt::format("{} over {} rings",
                                       patch.characteristic ? "characteristic map: isoparametric lines"
                                                            : "no characteristic map: a sketch",
                                       k_patch_rings),
                k_ink);
    if (hexagons) {
        FanPatch twice{coarse_mesh, coarse, std::vector<double>(coarse.size()), {}};
        for (int i = 0; i < 2; ++i) refine(twice, picture.scheme, picture.rules);
        const Window window{middle, 0.47 * k_large / hexagon_reach};
        draw_faces(canvas, window, twice.mesh, twice.plane, hexagon_reach);
    } else {
        const FanLabels rings(labels.lattice(), labels.shape(), k_patch_rings * patch.intervals);
        std::vector<Vec2d> fine;
        for (const int v : find_fan(patch.mesh, patch.start, rings)) fine.push_back(patch.plane[v]);
        // The half-plane of a boundary is centred.
        const double scale = 0.47 * k_large / largest(fine);
        double top = 0;
        for (const Vec2d& p : fine) top = std::max(top, p.y);
        const Window window{boundary ? middle + Vec2d(0, 0.5 * scale * top) : middle, scale};
        draw_lines(canvas, window, patch, fine, rings);
    }

    const int right = 2 * k_margin + k_large;
    // Scale the graph to be about as high as wide. Its largest value is at the middle point or near it.
    double highest = 0;
    for (const double h : patch.height) highest = std::max(highest, h);
    const double height = 0.8 * basis_reach / highest;
    std::vector<int> near;
    if (hexagons) {
        for (int v = 0; v < patch.mesh.vertex_count(); ++v)
            if (glm::length(patch.plane[v]) <= basis_reach) near.push_back(v);
    } else {
        near = find_fan(patch.mesh, patch.start,
                        FanLabels(labels.lattice(), labels.shape(), basis_rings * patch.intervals));
    }
    const BasisSurface basis = basis_surface(patch, picture.scheme, picture.rules, near, height);
    // At a vertex the limit mask gives the largest value exactly; in dual schemes it lies between the points drawn.
    const bool between = labels.lattice() == FanLattice::dual;
    canvas.text({right + 14.0, large_top + 10.0}, 15,
                fmt::format("basis function, its largest value {}",
                            between ? fmt::format("{:.3f}", basis.peak) : fmt::format("{:.4g}", basis.peak)),
                k_ink);
    RenderOptions options;
    options.occlusion_samples = 12;  // enough for one smooth surface
    options.width = options.height = k_large;
    options.view.azimuth_degrees = boundary ? 200 : 20;  // 200: do not look at the underside through the cut
    options.view.elevation_degrees = 30;
    options.view.margin = 0.04;
    options.crease_degrees = 180;
    options.ground = false;
    canvas.paste(right, large_top + k_caption, render(basis.mesh, options, context));
    return canvas.image();
}

}  // namespace tetrakis::cli
