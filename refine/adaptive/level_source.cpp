#include "level_source.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/forest/triangle_cell.hpp"
#include "../uniform/site_stencils.hpp"
#include "closure.hpp"
#include "level_frames.hpp"
#include "partial_levels.hpp"

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tetrakis {

namespace {

/// The control vertex at a site, if one is there.
VertexId control_vertex(const ControlMesh& mesh, const Site& site, bool triangles) {
    const std::uint32_t n = 1u << site.level;
    if (site.at.x == 0 && site.at.y == 0) return mesh.origin(site.root);
    if (triangles && site.at.x == n && site.at.y == 0) return mesh.origin(mesh.next(site.root));
    if (triangles && site.at.x == 0 && site.at.y == n) return mesh.origin(mesh.prev(site.root));
    return {};
}

/// Both lattice families: levels, and frames by rings. Quads: lattice level l is scheme level l + 1.
class LatticeLevels : public LevelSource {
  public:
    LatticeLevels(const ControlMesh& mesh, bool triangles) : mesh_(&mesh), rings_(make_rings(mesh, triangles)) {}

    int first_level(const Site& site) const override {
        const int lattice = minimal_level(site).level;
        if (is_triangles()) return lattice;
        return lattice == 0 && control_vertex(*mesh_, site, false).valid() ? 0 : lattice + 1;
    }
    int max_level() const override { return k_max_level + offset(); }

    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const override {
        if (level >= offset()) return lattice_positions(sites, level - offset(), out);
        for (std::size_t i = 0; i < sites.size(); ++i)
            out[i] = mesh_->position(control_vertex(*mesh_, sites[i], false));
    }
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const override {
        if (level < offset()) {
            for (std::size_t i = 0; i < sites.size(); ++i)
                out[i] = detail::control_frame(*mesh_, control_vertex(*mesh_, sites[i], false));
            return;
        }
        const int lattice = level - offset();
        const auto source = [&](std::span<const Site> s, std::span<Vec3d> o) { lattice_positions(s, lattice, o); };
        std::visit([&](const auto& rings) { detail::lattice_frames(*mesh_, rings, sites, lattice, source, out); },
                   rings_);
    }

  protected:
    virtual void lattice_positions(std::span<const Site> sites, int lattice_level, std::span<Vec3d> out) const = 0;
    bool is_triangles() const { return rings_.index() == 1; }
    const ControlMesh& mesh() const { return *mesh_; }

  private:
    using Rings = std::variant<detail::QuadStencils, detail::TriangleStencils>;
    static Rings make_rings(const ControlMesh& mesh, bool triangles) {
        if (triangles) {
            if (!mesh.all_triangles())
                throw Error(ErrorCode::invalid_input, "the scheme needs a mesh of triangles; triangulate it first",
                            mesh.data().source);
            return detail::TriangleStencils(mesh);
        }
        return detail::QuadStencils(mesh);
    }
    int offset() const { return is_triangles() ? 0 : 1; }

    const ControlMesh* mesh_;
    Rings rings_;
};

class ClosureLevels final : public LatticeLevels {
  public:
    ClosureLevels(const ControlMesh& mesh, SchemeKind scheme)
        : LatticeLevels(mesh, scheme == SchemeKind::loop), closure_(mesh, scheme) {}
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        closure_.positions(sites, out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override { closure_.limits(sites, out); }

  private:
    void lattice_positions(std::span<const Site> sites, int lattice_level, std::span<Vec3d> out) const override {
        closure_.control_positions(sites, lattice_level, out);
    }
    Closure closure_;
};

class RuleLevels final : public LatticeLevels {
  public:
    RuleLevels(const ControlMesh& mesh, const SchemeInfo& scheme, PartialLevels levels)
        : LatticeLevels(mesh, scheme.family == MeshFamily::triangles), levels_(std::move(levels)) {}
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        levels_.positions(sites, out);
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override { levels_.limits(sites, out); }

  private:
    void lattice_positions(std::span<const Site> sites, int lattice_level, std::span<Vec3d> out) const override {
        // Written at the level that is asked for.
        std::vector<Site> at_level(sites.size());
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Site s = minimal_level(sites[i]);
            const int up = lattice_level - s.level;
            at_level[i] = {s.root, {s.at.x << up, s.at.y << up}, static_cast<std::uint8_t>(lattice_level)};
        }
        levels_.control_positions(at_level, out);
    }
    PartialLevels levels_;
};

class LinearLevels final : public LatticeLevels {
  public:
    LinearLevels(const ControlMesh& mesh, bool triangles) : LatticeLevels(mesh, triangles) {
        if (triangles) return;
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            Vec3d sum(0);
            const std::uint32_t h = mesh.face_halfedge(FaceId(f)).value, size = mesh.face_size(FaceId(f));
            for (std::uint32_t i = 0; i < size; ++i) sum += mesh.position(mesh.origin(HalfedgeId(h + i)));
            centre_.push_back(sum / static_cast<double>(size));
        }
    }
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        for_each_index(static_cast<std::uint32_t>(sites.size()), [&](std::uint32_t i) { out[i] = at(sites[i]); });
    }
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const override {
        // Flat cells about the site already at its own level: their normals are the surface's.
        for_each_index(
            static_cast<std::uint32_t>(sites.size()),
            [&](std::uint32_t i) {
                frames({&sites[i], 1}, first_level(sites[i]), {&out[i], 1});
                out[i].has_tangent_plane = false;
            },
            64);
    }

  private:
    void lattice_positions(std::span<const Site> sites, int, std::span<Vec3d> out) const override {
        limit_positions(sites, out);
    }
    Vec3d at(const Site& any) const {
        const Site site = is_triangles() ? canonical_triangle_site(mesh(), any) : canonical(mesh(), any);
        const double scale = 1.0 / (1u << site.level), x = site.at.x * scale, y = site.at.y * scale;
        const HalfedgeId h = site.root;
        const Vec3d &a = mesh().position(mesh().origin(h)), &b = mesh().position(mesh().target(h)),
                    &c = mesh().position(mesh().origin(mesh().prev(h)));
        if (is_triangles()) return (1 - x - y) * a + x * b + y * c;
        const Vec3d& m = centre_[mesh().face(h).value];
        return (1 - x) * (1 - y) * a + x * (1 - y) * (0.5 * (a + b)) + (1 - x) * y * (0.5 * (a + c)) + x * y * m;
    }
    std::vector<Vec3d> centre_;
};

}  // namespace

void LevelSource::normals(std::span<const Site> sites, std::span<Vec3d> out) const {
    std::vector<LimitPoint> points(sites.size());
    limits(sites, points);
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = points[i].normal;
}

std::unique_ptr<LevelSource> closure_levels(const ControlMesh& mesh, SchemeKind scheme) {
    return std::make_unique<ClosureLevels>(mesh, scheme);
}

std::unique_ptr<LevelSource> rule_levels(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules) {
    PartialLevels levels(mesh, scheme, rules);
    if (levels.lattice() == FanLattice::dual)
        throw Error(ErrorCode::unsupported,
                    std::string(scheme.name) + " is a dual scheme with these choices: its vertices are no sites");
    return std::make_unique<RuleLevels>(mesh, scheme, std::move(levels));
}

std::unique_ptr<LevelSource> linear_levels(const ControlMesh& mesh, bool triangles) {
    return std::make_unique<LinearLevels>(mesh, triangles);
}

}  // namespace tetrakis
