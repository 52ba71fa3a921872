#include "sampled_surface.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../triangles/point_triangle.hpp"
#include "lattice_diamond.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

namespace tetrakis::lod {

namespace {

using detail::LatticeDiamond;
using detail::LatticePlace;

/// Atomic maximum: several threads may call it, and the result does not depend on their order.
void raise(std::uint8_t& code, std::uint8_t to) {
    std::atomic_ref<std::uint8_t> shared(code);
    std::uint8_t now = shared.load(std::memory_order_relaxed);
    while (now < to && !shared.compare_exchange_weak(now, to, std::memory_order_relaxed)) {
    }
}

double twice_area(const LatticePlace& a, const LatticePlace& b, const LatticePlace& c) {
    return double(b.x - a.x) * (c.y - a.y) - double(b.y - a.y) * (c.x - a.x);
}

}  // namespace

SampledSurface::SampledSurface(ControlMesh roots, int level, const RunContext& context, std::uint64_t point_bytes,
                               std::uint64_t work_bytes)
    : roots_(std::move(roots)), level_(level) {
    if (level < 1 || level > k_max_level)
        throw Error(ErrorCode::invalid_input,
                    fmt::format("a surface of {} levels; they have to be 1 to {}", level, k_max_level));
    cell_of_.assign(roots_.halfedge_count(), 0);
    for (std::uint32_t h = 0; h < roots_.halfedge_count(); ++h) {
        if (roots_.is_hole(roots_.face(HalfedgeId(h)))) continue;
        cell_of_[h] = static_cast<std::uint32_t>(cells_.size());
        cells_.push_back(HalfedgeId(h));
    }
    if (cells_.empty()) throw Error(ErrorCode::invalid_input, "a surface without faces, but for holes");
    const std::uint64_t threads = context.threads > 0 ? context.threads : std::thread::hardware_concurrency(),
                        point_work = sizeof(Site) + sizeof(Vec3d) + 2 * sizeof(float);
    detail::check_memory(fmt::format("{} points of a surface of level {} need", point_count(), level),
                         point_count() * (2 + point_bytes) + std::min<std::uint64_t>(threads, cells_.size()) *
                                                                 (point_count() / cells_.size()) *
                                                                 (point_work + work_bytes),
                         context.max_memory_bytes, "choose a lower level");
}

std::uint64_t SampledSurface::memory_bytes() const {
    return errors_.capacity() + radii_.capacity() + cells_.capacity() * sizeof(HalfedgeId) +
           cell_of_.capacity() * sizeof(std::uint32_t);
}

void SampledSurface::finest_errors(HalfedgeId, std::span<float> errors) const { std::ranges::fill(errors, 0.0f); }

Site SampledSurface::site_at(HalfedgeId cell, std::int64_t x, std::int64_t y) const {
    const std::int64_t n = std::int64_t{1} << level_;
    CellPoint p{cell, x, y};
    for (;;) {
        if (p.y < 0)
            p = cross(roots_, p, CellSide::edge, n);
        else if (p.x < 0)
            p = cross(roots_, p, CellSide::prev_edge, n);
        else if (p.x > n)
            p = cross(roots_, p, CellSide::next_cell, n);
        else if (p.y > n)
            p = cross(roots_, p, CellSide::prev_cell, n);
        else
            break;
        if (!p.root.valid()) return {};
    }
    const Site site = canonical(roots_, {p.root,
                                         {static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y)},
                                         static_cast<std::uint8_t>(level_)});
    return roots_.is_hole(roots_.face(site.root)) ? Site{} : site;
}

Vec3d SampledSurface::position(const Site& site) const {
    Vec3d position;
    positions({&site, 1}, {&position, 1});
    return position;
}

std::vector<Site> SampledSurface::sites_of(HalfedgeId cell) const {
    const std::uint32_t n = 1u << level_;
    std::vector<Site> sites;
    sites.reserve((std::size_t{n} + 1) * (n + 1));
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x)
            sites.push_back(canonical(roots_, {cell, {x, y}, static_cast<std::uint8_t>(level_)}));
    return sites;
}

void SampledSurface::set_bounds(const RunContext& context) {
    std::vector<Site> corners;
    for (const HalfedgeId cell : cells_)
        for (const std::int64_t at : {std::int64_t{0}, std::int64_t{1} << level_})
            corners.push_back(site_at(cell, at, at));
    std::vector<Vec3d> points(corners.size());
    positions(corners, points);
    Box3d box = roots_.bounding_box();
    for (const Vec3d& p : points) box.add(p);
    constexpr double k_more = 4;  // largest length, in diagonals of this box
    lengths_ = detail::ByteLengths(k_more * box.diagonal(), max_depth());
    errors_.assign(point_count(), 0);
    radii_.assign(point_count(), 0);
    const auto cells = static_cast<std::uint32_t>(cells_.size());
    with_threads(context, [&] {
        for_each_reported(cells, 1, context, "errors", 0, 1, [&](std::uint32_t i) { measure_cell(cells_[i]); });
        // Where there are many cells, one alone is little work.
        const std::uint32_t grain = std::max(1u, 4096u >> (2 * level_));
        for (std::int32_t step = 1; step <= 1 << level_; step *= 2) {
            context.report("errors", 1);
            for (const bool centres : {false, true})
                for_each_index(
                    cells, [&](std::uint32_t i) { nest(cells_[i], step, centres); }, grain);
        }
    });
}

/// Raises the errors and radii of diamonds by their triangles in this cell: to the distances of the cell's points from
/// the triangles, and from a diamond's middle to the middles of the diamonds that its split makes possible.
void SampledSurface::measure_cell(HalfedgeId cell) {
    const std::int32_t n = 1 << level_;
    const std::vector<Site> sites = sites_of(cell);
    std::vector<Vec3d> points(sites.size());
    positions(sites, points);
    const auto number = [&](std::int32_t x, std::int32_t y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(n + 1) + static_cast<std::size_t>(x);
    };
    const auto point = [&](const LatticePlace& p) -> const Vec3d& { return points[number(p.x, p.y)]; };
    // By point: the largest finest error in the squares around it. Distances from a triangle are convex, so no point of
    // a finest triangle is farther from a larger one than the farthest of its corners.
    std::vector<float> squares(static_cast<std::size_t>(n) * static_cast<std::size_t>(n)), around(points.size(), 0.0f);
    finest_errors(cell, squares);
    for (std::int32_t y = 0; y < n; ++y)
        for (std::int32_t x = 0; x < n; ++x)
            for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
                float& most = around[number(x + dx, y + dy)];
                most = std::max(
                    most,
                    squares[static_cast<std::size_t>(y) * static_cast<std::size_t>(n) + static_cast<std::size_t>(x)]);
            }
    for (std::int32_t y = 0; y <= n; ++y)
        for (std::int32_t x = 0; x <= n; ++x) {
            // The cell's corners halve no edge, or, on the control mesh's edges, one that reaches beyond the cell.
            if ((x == 0 || x == n) && (y == 0 || y == n)) continue;
            const LatticeDiamond diamond({x, y});
            const std::size_t at = index(sites[number(x, y)]);
            const Vec3d& middle = point(diamond.middle);
            for (const LatticePlace& apex : diamond.apexes) {
                if (apex.x < 0 || apex.y < 0 || apex.x > n || apex.y > n) continue;
                const std::array<LatticePlace, 3> corners{diamond.ends[0], diamond.ends[1], apex};
                const Vec3d &a = point(corners[0]), &b = point(corners[1]), &c = point(corners[2]);
                double error = 0, reach = 0;
                const Vec3d base = b - a, off_base = middle - a - detail::nearest_on_segment(base, middle - a) * base;
                error = glm::length(off_base) + double{around[number(x, y)]};
                const double area = twice_area(corners[0], corners[1], apex);
                const auto [x0, x1] = std::minmax({corners[0].x, corners[1].x, apex.x});
                const auto [y0, y1] = std::minmax({corners[0].y, corners[1].y, apex.y});
                for (std::int32_t py = y0; py <= y1; ++py)
                    for (std::int32_t px = x0; px <= x1; ++px) {
                        const double u = twice_area(corners[0], {px, py}, apex) / area,
                                     v = twice_area(corners[0], corners[1], {px, py}) / area;
                        if (u < 0 || v < 0 || u + v > 1) continue;
                        // The triangle's point with equal parameters is no nearer than its nearest point.
                        const std::size_t i = number(px, py);
                        const double left = error - double{around[i]};
                        const Vec3d off = points[i] - a - u * base - v * (c - a);
                        if (left >= 0 && glm::dot(off, off) <= left * left) continue;
                        error = std::max(error,
                                         std::sqrt(detail::nearest_on_triangle(points[i], a, b, c).squared_distance) +
                                             double{around[i]});
                    }
                if (diamond.step == 1 && !diamond.is_centre) {
                    for (const Vec3d& corner : {a, b, c}) reach = std::max(reach, glm::length(corner - middle));
                    reach += error;
                } else {
                    for (std::size_t k = 0; k < 2; ++k) {
                        const LatticePlace leg{(corners[k].x + apex.x) / 2, (corners[k].y + apex.y) / 2};
                        reach = std::max(reach, glm::length(point(leg) - middle));
                    }
                }
                raise(errors_[at], lengths_.code(error));
                raise(radii_[at], lengths_.code(reach));
            }
        }
}

/// Makes the bounds of a cell's own diamonds of one size contain those of the next smaller ones.
void SampledSurface::nest(HalfedgeId cell, std::int32_t step, bool centres) {
    const std::int32_t n = 1 << level_;
    if (!centres && step == 1) return;
    if (centres && step == n) return;
    const auto set = [&](std::int32_t x, std::int32_t y) {
        const Site site = site_at(cell, x, y);
        if (site.root != cell) return;  // on a side, owned by the other cell
        const LatticeDiamond diamond({x, y});
        double error = 0, reach = 0, way = 0;
        for (const LatticePlace& child : diamond.children()) {
            const Site below = site_at(cell, child.x, child.y);
            if (!below.root.valid()) continue;
            const std::size_t i = index(below);
            error = std::max(error, lengths_.length(errors_[i]));
            reach = std::max(reach, lengths_.length(radii_[i]));
        }
        const std::size_t at = index(site);
        double own = lengths_.length(errors_[at]);
        way = lengths_.length(radii_[at]);
        if (step == n) {
            // measure_cell() left out the roots, as their points are in two cells. A root's error is at most the error
            // of its halves plus their distance from the root.
            const auto point = [&](const LatticePlace& p) { return position(site_at(cell, p.x, p.y)); };
            const Vec3d middle = position(site);
            own = error + glm::length(middle - 0.5 * (point(diamond.ends[0]) + point(diamond.ends[1])));
            for (const LatticePlace& child : diamond.children())
                if (site_at(cell, child.x, child.y).root.valid())
                    way = std::max(way, glm::length(point(child) - middle));
        }
        errors_[at] = lengths_.code(std::max(own, k_error_ratio * error));
        radii_[at] = lengths_.code(way + reach);
    };
    for (std::int32_t y = centres ? step : 0; y <= n; y += centres ? 2 * step : step)
        for (std::int32_t x = centres || (y / step) % 2 == 0 ? step : 0; x <= n; x += 2 * step) set(x, y);
}

void SampledSurface::places(std::span<const Site> sites, std::span<Place> places) const {
    const std::int64_t n = std::int64_t{1} << level_;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const int shift = level_ - sites[i].level;
        const auto x = static_cast<std::int32_t>(sites[i].at.x << shift),
                   y = static_cast<std::int32_t>(sites[i].at.y << shift);
        places[i].position = places[i].on_edge = position(sites[i]);
        if ((x == 0 && y == 0) || (x == n && y == n)) continue;
        const auto end = [&](const LatticePlace& p) { return position(site_at(sites[i].root, p.x, p.y)); };
        const LatticeDiamond diamond({x, y});
        const Vec3d start = end(diamond.ends[0]), along = end(diamond.ends[1]) - start;
        places[i].on_edge = start + detail::nearest_on_segment(along, places[i].position - start) * along;
    }
    shade(sites, places);
}

void SampledSurface::bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const {
    constexpr std::size_t k_batch = 32;
    std::array<Vec3d, k_batch> centers;
    for (std::size_t begin = 0; begin < sites.size(); begin += k_batch) {
        const std::span batch = sites.subspan(begin, std::min(k_batch, sites.size() - begin));
        positions(batch, std::span(centers).first(batch.size()));
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const std::size_t at = index(batch[i]);
            bounds[begin + i] = {centers[i], Vec3d(lengths_.length(radii_[at])), lengths_.length(errors_[at])};
        }
    }
}

}  // namespace tetrakis::lod
