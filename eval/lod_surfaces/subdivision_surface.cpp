#include "subdivision_surface.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../bounds/dual_bound.hpp"
#include "../distance/surface_family.hpp"
#include "../estimate/linear_bound.hpp"
#include "../estimate/mask_norm_bound.hpp"
#include "../surface/local_frame.hpp"
#include "../tessellate/tessellate.hpp"
#include "dual_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace tetrakis::lod {

namespace {

/// Parameters in a triangle of a point of one of its corner cells. The map is linear on each side of the segment from
/// the corner to the centre, as 4-8 triangles are.
Vec2d in_triangle(const ControlMesh& mesh, HalfedgeId cell, double x, double y) {
    constexpr std::array<Vec2d, 3> k_corners{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};
    const std::uint32_t first = mesh.face_halfedge(mesh.face(cell)).value, k = cell.value - first;
    const Vec2d v = k_corners[k], next = k_corners[(k + 1) % 3], prev = k_corners[(k + 2) % 3];
    const Vec2d centre(1.0 / 3, 1.0 / 3);
    const double in = std::min(x, y);
    return v + in * (centre - v) + (x - in) * 0.5 * (next - v) + (y - in) * 0.5 * (prev - v);
}

/// Errors below this part of the control mesh's diagonal are not distinguished.
constexpr double k_no_error = 0x1p-20;

/// Bounds by norms of masks are at most this many times an error that occurs: tighter ones take several times as long.
constexpr double k_tight = 2;

/// Largest rounding error of a point that is stored as three floats.
double float_rounding(const ControlMesh& mesh) {
    const Box3d box = mesh.bounding_box();
    return glm::length(glm::max(glm::abs(box.lower), glm::abs(box.upper))) * 0x1p-24;
}

Vec2d in_cell(const Site& site) { return {std::ldexp(site.at.x, -site.level), std::ldexp(site.at.y, -site.level)}; }

/// The limit surface over the control mesh's own corner cells.
template <class Family>
class PrimalLimits final : public detail::LatticeLimits {
    static constexpr bool k_quads = std::is_same_v<Family, QuadFamily>;

  public:
    PrimalLimits(const ControlMesh& mesh, const SchemeChoice& scheme, const SubdivisionSurfaceOptions& options)
        : mesh_(mesh) {
        const SchemeInfo& info = scheme.info();
        if (scheme_support(mesh, scheme, options.rules).patches) patches_.emplace(mesh, options.context);
        points_.emplace(make_hierarchy(mesh, info, {.rules = options.rules, .context = options.context}));
        if (k_quads ? points_->family() != "bisection" : !patches_)
            throw Error(ErrorCode::unsupported, fmt::format("LOD takes schemes whose faces become quads, Doo-Sabin, "
                                                            "midedge, and Loop by its plain rules, not {}",
                                                            scheme.name()));
        if (info.is_linear())
            bound_ = std::make_unique<LinearBound>(mesh, info);
        else if (!patches_ && MaskNormBound<Family>::has(info, options.rules, mesh))
            bound_ = std::make_unique<MaskNormBound<Family>>(*points_, info, options.rules, 0, k_tight);
        else if (!patches_)
            throw Error(ErrorCode::unsupported,
                        fmt::format("{} has no certified bound over this mesh, whose semi-sharp tags last too long or "
                                    "of whose edges too many meet",
                                    scheme.name()),
                        mesh.data().source);
    }

    void points(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals) const override {
        if (k_quads && !patches_) {
            points_->limit_positions(sites, positions);
            points_->normals(sites, normals);
            return;
        }
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec2d p = in_cell(sites[i]), at = k_quads ? p : in_triangle(mesh_, sites[i].root, p.x, p.y);
            const SurfacePoint point = k_quads ? patches_->vertex(sites[i].root, sites[i].at, sites[i].level)
                                               : patches_->evaluate(first_halfedge(sites[i].root), at.x, at.y);
            positions[i] = point.position;
            normals[i] = point.normal;
        }
    }

    void bound(std::span<const CellTriangle> triangles, std::span<double> errors) const override {
        if (bound_) return bound_->estimate(triangles, errors);
        typename Family::Bounder bounder(*patches_);
        const double decide_at = k_no_error * mesh_.bounding_box().diagonal();
        for (std::size_t i = 0; i < triangles.size(); ++i)
            if constexpr (k_quads)
                errors[i] = bounder.certified_error(triangles[i], decide_at);
            else
                errors[i] =
                    bounder.part_error(first_halfedge(triangles[i].root), corners(triangles[i]), decide_at).upper;
    }

  private:
    HalfedgeId first_halfedge(HalfedgeId cell) const { return mesh_.face_halfedge(mesh_.face(cell)); }
    /// Corners of a corner cell's triangle, as parameters in the face.
    std::array<Vec2d, 3> corners(const CellTriangle& triangle) const {
        std::array<Vec2d, 3> at;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d p = in_cell({triangle.root, triangle.corner[k], triangle.level});
            at[k] = in_triangle(mesh_, triangle.root, p.x, p.y);
        }
        return at;
    }

    const ControlMesh& mesh_;
    std::optional<typename Family::Patches> patches_;
    std::optional<Hierarchy> points_;
    std::unique_ptr<SurfaceBound> bound_;  // null: the patches give the bounds
};

bool is_dual(const SchemeChoice& scheme) { return detail::DualBound::has(scheme.info()); }

}  // namespace

SubdivisionSurface::SubdivisionSurface(const ControlMesh& mesh, const SchemeChoice& scheme,
                                       const SubdivisionSurfaceOptions& options)
    : SampledSurface(is_dual(scheme) ? detail::dual_roots(mesh, scheme.info(), options.rules) : mesh,
                     // An edge of the control mesh is as long as two cells of a dual scheme's first level.
                     is_dual(scheme) && options.level > 1 ? options.level - 1 : options.level, options.context,
                     2 * sizeof(Vec3f),
                     is_dual(scheme)                                       ? 1300
                     : scheme_support(mesh, scheme, options.rules).patches ? 100
                                                                           : 2000),
      by_triangles_(scheme.info().family == MeshFamily::triangles) {
    std::unique_ptr<detail::LatticeLimits> limits;
    if (is_dual(scheme))
        limits = std::make_unique<detail::DualLimits>(mesh, scheme.info(), options.rules, level(), options.context);
    else if (by_triangles_)
        limits = std::make_unique<PrimalLimits<LoopFamily>>(roots(), scheme, options);
    else
        limits = std::make_unique<PrimalLimits<QuadFamily>>(roots(), scheme, options);
    limits_ = limits.get();
    positions_.resize(point_count());
    normals_.resize(point_count());
    with_threads(options.context, [&] {
        const auto make = [&](std::uint32_t i) {
            std::vector<Site> own;
            for (const Site& site : sites_of(cells()[i]))
                if (site.root == cells()[i]) own.push_back(site);
            std::vector<Vec3d> positions(own.size()), normals(own.size());
            limits_->points(own, positions, normals);
            for (std::size_t k = 0; k < own.size(); ++k) {
                if (options.displacement) {
                    Place place{.position = positions[k], .normal = normals[k], .on_edge = positions[k]};
                    shade({&own[k], 1}, {&place, 1});
                    place.normal = normals[k];
                    positions[k] += options.displacement(place) * normals[k];
                }
                positions_[index(own[k])] = positions[k];
                const Vec3d kept = positions_[index(own[k])];
                if (!(std::isfinite(kept.x) && std::isfinite(kept.y) && std::isfinite(kept.z)))
                    throw Error(ErrorCode::invalid_input, "a point of the surface is not finite, or no float");
                normals_[index(own[k])] = normals[k];
            }
        };
        for_each_reported(static_cast<std::uint32_t>(cells().size()), 1, options.context, "points", 0, 1, make);
    });
    if (options.displacement) limits_ = nullptr;  // the finest triangles are the surface
    set_bounds(options.context);
    limits_ = nullptr;
}

std::uint64_t SubdivisionSurface::memory_bytes() const {
    return SampledSurface::memory_bytes() + (positions_.capacity() + normals_.capacity()) * sizeof(Vec3f);
}

void SubdivisionSurface::positions(std::span<const Site> sites, std::span<Vec3d> positions) const {
    for (std::size_t i = 0; i < sites.size(); ++i) positions[i] = positions_[index(sites[i])];
}

void SubdivisionSurface::shade(std::span<const Site> sites, std::span<Place> places) const {
    const ControlMesh& mesh = roots();
    const auto corner = [&](HalfedgeId h) { return mesh.data().uvs[mesh.uv_index(h)]; };
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const HalfedgeId cell = sites[i].root;
        places[i].normal = normals_[index(sites[i])];
        places[i].uv = {};
        if (!mesh.has_uvs()) continue;
        const Vec2d at = in_cell(sites[i]);
        const Vec2d in = by_triangles_ ? in_triangle(mesh, cell, at.x, at.y) : at;
        places[i].uv = by_triangles_ ? LoopFamily::linear(mesh, mesh.face_halfedge(mesh.face(cell)), in.x, in.y, corner)
                                     : QuadFamily::linear(mesh, cell, in.x, in.y, corner);
    }
}

void SubdivisionSurface::finest_errors(HalfedgeId cell, std::span<float> errors) const {
    if (!limits_) return SampledSurface::finest_errors(cell, errors);
    const std::uint32_t n = 1u << level();
    std::vector<CellTriangle> triangles;
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::array<LatticePoint, 4> around{{{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}}};
            const std::size_t turn = (x + y) % 2;  // diagonals run through points with two even coordinates
            // The right angle is the last corner, as hierarchies have it.
            for (const std::size_t first : {turn + 2, turn + 4})
                triangles.push_back({cell,
                                     static_cast<std::uint8_t>(level()),
                                     {around[first % 4], around[(first + 2) % 4], around[(first + 3) % 4]}});
        }
    std::vector<double> found(triangles.size());
    limits_->bound(triangles, found);
    const double rounding = float_rounding(roots());  // of the corners
    for (std::size_t i = 0; i < errors.size(); ++i)
        errors[i] = detail::round_up(rounding + std::max(found[2 * i], found[2 * i + 1]));
}

}  // namespace tetrakis::lod
