#pragma once

#include "../../refine/attributes/uv_mesh.hpp"
#include "../distance/surface_family.hpp"
#include "../distance/triangle_bvh.hpp"
#include "../surface/height_image.hpp"
#include "../surface/hidden_detail.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tetrakis::detail {

/// Texture coordinates anywhere on a surface: the limit of the UV layer's own mesh under the face-varying rule, or
/// linear interpolation.
template <class Family>
class UvSurface {
  public:
    /// @param warnings  receives a warning if the UV layer cannot be subdivided (uv_mesh.hpp) and is linear instead
    UvSurface(const ControlMesh& mesh, std::vector<std::string>& warnings) : mesh_(mesh) {
        if (mesh.face_varying_rule() == FaceVaryingRule::linear_all) return;
        try {
            uv_mesh_ = uv_mesh(mesh);
            patches_ = std::make_unique<typename Family::Patches>(uv_mesh_);
        } catch (const Error& error) {
            warnings.push_back(std::string("the UV layer cannot be subdivided and is interpolated linearly (") +
                               error.what() + ")");
        }
    }
    Vec2d at(HalfedgeId root, double x, double y) const {
        if (patches_) return Vec2d(patches_->position(root, x, y));
        return Family::linear(mesh_, root, x, y, [&](HalfedgeId h) { return mesh_.data().uvs[mesh_.uv_index(h)]; });
    }
    /// The same at a lattice point, by its canonical site in the UV layer: same bits on both sides of unbroken edges.
    Vec2d at(const Site& address) const {
        if (patches_) {
            const Site site = Family::canonical_site(uv_mesh_, address);
            return Vec2d(patches_->limit(site.root, site.at, site.level));
        }
        const double step = std::ldexp(1.0, -address.level);
        return at(address.root, address.at.x * step, address.at.y * step);
    }
    /// Patches of the UV layer; null if it is linear.
    const typename Family::Patches* patches() const { return patches_.get(); }

  private:
    const ControlMesh& mesh_;
    ControlMesh uv_mesh_;
    std::unique_ptr<typename Family::Patches> patches_;  ///< null: linear
};

/// Maps limit points to output points: the same point, displaced along the normal, or projected onto a target.
template <class Family>
class SurfaceMap {
  public:
    const typename Family::Patches* patches = nullptr;
    std::unique_ptr<UvSurface<Family>> uv;
    const HeightImage* heights = nullptr;  ///< of a displacement
    std::optional<HeightRanges> ranges{};  ///< of `heights`
    double amplitude = 0;
    std::unique_ptr<TriangleBvh> target;
    const TriangleMesh* target_mesh = nullptr;  ///< the mesh of `target`

    bool plain() const { return !heights && !target; }
    Vec3d apply(const SurfacePoint& point, const Vec2d& at) const {
        Vec3d p = point.position;
        if (heights) p += amplitude * heights->sample(at) * point.normal;
        if (target) p = target->closest(p).point;
        return p;
    }
    /// apply() at a point of the surface, with the data for a search of displacement details around it.
    DisplacedSample sample(const SurfaceParameter& at) const {
        const SurfacePoint point = patches->evaluate(at.root, at.x, at.y);
        const Vec2d place = heights ? uv->at(at.root, at.x, at.y) : Vec2d(0);
        return {apply(point, place), point.normal, place};
    }
    /// Whether the displacement may have details between samples. With a target they do not matter.
    bool has_detail() const { return heights && !target; }
    /// Height of the displacement at a point, as a length.
    double height(HalfedgeId root, double x, double y) const { return amplitude * heights->sample(uv->at(root, x, y)); }
    /// Position of an output vertex, by its canonical site.
    Vec3d vertex(const Site& site) const {
        if (plain()) return patches->limit(site.root, site.at, site.level);
        return apply(patches->vertex(site.root, site.at, site.level), heights ? uv->at(site) : Vec2d(0));
    }
    /// Output point at any parameter. On edges where a displacement jumps (UV seams, hard creases): of the given root.
    Vec3d operator()(const SurfaceParameter& at) const {
        if (plain()) return patches->position(at.root, at.x, at.y);
        return apply(patches->evaluate(at.root, at.x, at.y), heights ? uv->at(at.root, at.x, at.y) : Vec2d(0));
    }
    /// nearby_distance() from q to the limit surface or displaced surface; not for targets.
    double nearby_distance(const Vec3d& q, const SurfaceParameter& start) const {
        return tetrakis::nearby_distance<Family>(patches->mesh(), q, start, [&](const SurfaceParameter& at) {
            return heights ? displaced(at) : patches->frame(at.root, at.x, at.y);
        });
    }

  private:
    /// A point of a displaced surface with its first derivatives. Derivatives of the surface and its normal are in
    /// closed form, those of the heights are finite differences.
    SurfacePoint displaced(const SurfaceParameter& at) const {
        // Differences over a thousandth of a root: displacement images are smooth at that scale or coarser than the
        // mesh.
        constexpr double k_step = 1e-3;
        SurfacePoint s = patches->evaluate(at.root, at.x, at.y);
        const double here = height(at.root, at.x, at.y);
        const auto slope = [&](double ux, double uy) {
            for (const double h : {k_step, -k_step})
                if (const double x = at.x + h * ux, y = at.y + h * uy;
                    std::min(x, y) >= 0 && std::max(x, y) <= 1 && Family::inside(x, y))
                    return (height(at.root, x, y) - here) / h;
            return 0.0;  // a corner of a triangle
        };
        const double across = glm::length(glm::cross(s.du, s.dv));
        const auto turn = [&](const Vec3d& by) {  // derivative of the normal, from that of du x dv
            return s.has_second && across > 0 ? (by - glm::dot(by, s.normal) * s.normal) / across : Vec3d(0);
        };
        const Vec3d normal_u = turn(glm::cross(s.duu, s.dv) + glm::cross(s.du, s.duv));
        const Vec3d normal_v = turn(glm::cross(s.duv, s.dv) + glm::cross(s.du, s.dvv));
        s.position += here * s.normal;
        s.du += slope(1, 0) * s.normal + here * normal_u;
        s.dv += slope(0, 1) * s.normal + here * normal_v;
        return s;
    }
};

}  // namespace tetrakis::detail
