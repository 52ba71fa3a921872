#pragma once

#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/exported_triangles.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/adaptive/adaptive_refinement.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/attributes/uv_mesh.hpp"
#include "../distance/surface_family.hpp"
#include "../surface/local_frame.hpp"
#include "../surface/site_limits.hpp"
#include "measure.hpp"
#include "tessellate_run.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// A tessellation whose leaves are triangles: bisected quads, red-green quadtrees, those of sqrt(3). A derived class
/// says where vertices are and what estimates errors.
/// @tparam Family  the hierarchy; all but sqrt(3), whose leaves lie in no cells: sites of their points, too
template <class Family>
class CellTessellator : public TessellationRun {
  protected:
    using TessellationRun::TessellationRun;

    /// refine() by an estimator. hierarchy_ is known.
    /// @param base_bytes  that are in use, for the memory limit
    void refine_by(const ErrorEstimator& estimator, std::uint64_t base_bytes, std::uint64_t bytes_per_triangle) {
        AdaptiveOptions adaptive{aim_, options_.max_triangles, min_depth_, max_depth_};
        adaptive.max_memory_bytes = context_.max_memory_bytes;
        adaptive.base_bytes = base_bytes;
        adaptive.bytes_per_triangle = bytes_per_triangle;
        choose_coarsest();
        refinement_.emplace(*hierarchy_, estimator, adaptive, context_);
        refinement_->run();
        estimate_seconds_ = refinement_->estimate_seconds();
    }
    void export_mesh() final {
        context_.report("export", 0);
        const auto exported = [&] {
            if constexpr (std::is_same_v<Family, QuadFamily>)
                if (!fans_.offsets.empty()) return hierarchy_->forest().exported(fans_, hierarchy_->fans());
            return hierarchy_->forest().exported();
        };
        exported_ = exported();
        TriangleMesh& mesh = result_.mesh;
        mesh = {};
        mesh.triangles = std::move(exported_.triangles);
        mesh.positions.resize(exported_.sites.size());
        mesh.normals.resize(options_.normals ? exported_.sites.size() : 0);
        place(exported_.sites, mesh.positions, mesh.normals, "export", 0.9);
        const std::size_t count = mesh.triangles.size();
        part_.assign(count, 0);
        result_.triangle_face.resize(count);
        result_.triangle_error.resize(count);
        result_.deepest_level = 0;
        for (std::size_t t = 0; t < count; ++t) {
            const LeafId leaf = exported_.leaves[t];
            const FaceId face = exported_.faces[t];
            // A fan's or a green leaf's triangles stand next to each other.
            if (t > 0 && exported_.leaves[t - 1] == leaf && (leaf.valid() || exported_.faces[t - 1] == face))
                part_[t] = static_cast<std::uint8_t>(part_[t - 1] + 1);
            result_.triangle_face[t] = face.value;
            result_.triangle_error[t] = round_up(estimated_error(t));
            if (leaf.valid()) result_.deepest_level = std::max(result_.deepest_level, hierarchy_->level(leaf));
        }
        context_.report("export", 1.0);
    }
    bool repair(int) override {
        std::vector<LeafId> leaves;
        std::vector<FaceId> fans;
        for (std::uint32_t t = 0; t < result_.triangle_error.size(); ++t) {
            if (!(error_of(t) > off_above_)) continue;
            const LeafId leaf = exported_.leaves[t];
            if (!leaf.valid())
                fans.push_back(exported_.faces[t]);
            else if (hierarchy_->level(leaf) < max_depth_)
                leaves.push_back(leaf);
        }
        if (leaves.empty() && fans.empty()) return false;
        refinement_->split(leaves, fans);
        return true;
    }
    bool left_over() const override { return refinement_->left_over(); }
    void add_attributes() override {
        context_.report("attributes", 0);
        if (options_.normals) add_normals();
        if (options_.uvs && mesh_.has_uvs()) add_uvs(corner_uvs());
        context_.report("attributes", 1);
    }

    /// Where canonical sites are in the output. Reports a stage from 0 to `share`.
    /// @param normals  may receive limit normals; may be empty
    virtual void place(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals,
                       std::string_view stage, double share) = 0;
    /// By face, of those that have one in fans_; infinite where there is no bound.
    virtual std::vector<double> fan_errors() { return {}; }
    /// Of a triangle, as the last measurement found it.
    virtual double error_of(std::uint32_t t) const { return double{result_.triangle_error[t]}; }
    /// Those of the surface, split where one does not do.
    virtual void add_normals() = 0;
    /// Three a triangle; none where they are left out.
    virtual std::vector<Vec2d> corner_uvs() = 0;

    /// Measures against the mesh of limit points of the leaves of another one.
    void measure_against(const typename Family::Hierarchy& finer) {
        context_.report("measure", 0);
        ExportedTriangles leaves = finer.forest().exported();
        TriangleMesh reference;
        reference.triangles = std::move(leaves.triangles);
        reference.positions.resize(leaves.sites.size());
        place(leaves.sites, reference.positions, {}, "measure", 0.5);
        measure_triangles(reference, result_, options_.measure_samples / 2, context_);
    }

    /// Of a triangle, as its leaf or fan was estimated.
    double estimated_error(std::uint32_t t) const {
        if constexpr (std::is_same_v<Family, QuadFamily>)
            if (!exported_.leaves[t].valid()) return hierarchy_->fan_error(exported_.faces[t]);
        return refinement_->error(exported_.leaves[t]);
    }

    /// The largest certified error, tight to a twentieth where it exceeds the aim that is certified, or what was
    /// measured. The first triangle of a fan stands for all of it.
    /// @param known  (t) an error that is certified already; infinite: none
    /// @param bound  (triangles, floor, errors) finds errors of some, which need be tight above `floor` only; triangles
    ///               of leaves come first, then those of fans
    template <class Known, class Bound>
    double largest_error(const Known& known, const Bound& bound) const {
        double largest = 0, floor = 0;
        if (certified())
            floor = aim_;
        else if (result_.measured_error)
            floor = result_.measured_error->hausdorff;  // it settles most triangles at first sight
        std::vector<std::uint32_t> open, rest;
        std::vector<double> errors;
        // What one block finds settles most triangles of the next.
        const auto settle = [&](double from, double to) {
            constexpr std::size_t k_first = 64, k_most = 2048;
            for (std::size_t begin = 0, size = k_first; begin < open.size();
                 begin += size, size = std::min(2 * size, k_most)) {
                context_.report("certify",
                                from + (to - from) * static_cast<double>(begin) / static_cast<double>(open.size()));
                const auto some = std::span(std::as_const(open)).subspan(begin, std::min(size, open.size() - begin));
                errors.assign(some.size(), 0.0);
                bound(some, floor, std::span(errors));
                for (const double error : errors) largest = std::max(largest, error);
                floor = std::max(floor, largest);
            }
        };
        for (const bool fans : {false, true})
            for (std::uint32_t t = 0; t < part_.size(); ++t)
                if (exported_.leaves[t].valid() != fans && (!fans || part_[t] == 0))
                    (std::isfinite(known(t)) ? rest : open).push_back(t);
        // First those that nothing is known of; what is known may be loose, where all of it matters.
        settle(0, 0.9);
        open.clear();
        for (const std::uint32_t t : rest)
            if (const double error = known(t); error <= floor)
                largest = std::max(largest, error);
            else
                open.push_back(t);
        settle(0.9, 1);
        return largest;
    }

    OutputTriangle origin(std::uint32_t t) const {
        OutputTriangle from;
        if (exported_.leaves[t].valid()) {
            std::array<CellTriangle, 3> parts;
            hierarchy_->triangles(exported_.leaves[t], parts);
            from.cell = parts[part_[t]];
            return from;
        }
        from.fan = exported_.faces[t];
        const auto corners = fans_.of(from.fan)[part_[t]];
        for (std::size_t k = 0; k < 3; ++k) from.fan_corner[k] = corners[k];
        return from;
    }
    /// An address of each triangle's corner inside its root.
    Site corner_site(std::uint32_t t, std::size_t k) const { return origin(t).template corner_site<Family>(mesh_, k); }
    /// Limit normals at the corners of triangles, each seen from inside its triangle: continued linearly from two
    /// points near by.
    /// @param normals  (canonical sites, receives their limit normals)
    SideNormals normals_from_inside(std::function<void(std::span<const Site>, std::span<Vec3d>)> normals) const {
        return [this, normals = std::move(normals)](std::span<const std::uint64_t> corners, std::span<Vec3d> out) {
            // At 2^-8 of a triangle: continued from there, a normal is off by less than a thousandth of the bend.
            constexpr int k_finer = 8, k_least = 3;
            std::vector<Site> sites;
            std::vector<std::size_t> place;
            for (std::size_t i = 0; i < corners.size(); ++i) {
                const OutputTriangle from = origin(static_cast<std::uint32_t>(corners[i] / 3));
                const int finer = std::min(k_finer, k_max_level - (from.fan.valid() ? 0 : from.cell.level));
                if (finer < k_least) continue;
                for (const std::uint32_t steps : {1u, 2u})
                    sites.push_back(Family::canonical_site(
                        mesh_, from.template inner_site<Family>(mesh_, corners[i] % 3, finer, steps)));
                place.push_back(i);
            }
            std::vector<Vec3d> found(sites.size());
            normals(sites, found);
            for (std::size_t j = 0; j < place.size(); ++j)
                out[place[j]] = unit_or_zero(2.0 * found[2 * j] - found[2 * j + 1]);
        };
    }

    Hierarchy chart_hierarchy(const ControlMesh& chart) const {
        return make_hierarchy(chart, options_.scheme.info(),
                              {.rules = chart_rules(options_.rules), .whole_levels = true, .context = context_});
    }
    /// Texture coordinates at the corners of triangles: limits of the chart by the scheme, or linear.
    /// @param points   chart_hierarchy(), where the chart can be subdivided
    /// @param site_of  (corner 3 t + k) its canonical site in the chart; else
    /// @param linear   (corner) its coordinates
    template <class SiteOf, class Linear>
    std::vector<Vec2d> chart_uvs(const std::optional<Hierarchy>& points, const SiteOf& site_of,
                                 const Linear& linear) const {
        std::vector<Vec2d> uvs(3 * result_.mesh.triangles.size());
        std::vector<Site> sites(points ? uvs.size() : 0);
        for_each_index(static_cast<std::uint32_t>(result_.mesh.triangles.size()), [&](std::uint32_t t) {
            for (std::size_t corner = 3 * std::size_t{t}; corner < 3 * (std::size_t{t} + 1); ++corner)
                if (points)
                    sites[corner] = site_of(corner);
                else
                    uvs[corner] = linear(corner);
        });
        if (!points) return uvs;
        std::vector<Vec3d> positions(sites.size());
        limit_positions_once(*points, sites, positions,
                             [&](double done) { context_.report("attributes", 0.5 * done); });
        for (std::size_t i = 0; i < uvs.size(); ++i) uvs[i] = Vec2d(positions[i]);
        return uvs;
    }

    int min_depth_ = options_.min_level, max_depth_ = options_.max_level;  ///< of the hierarchy's leaves
    std::optional<typename Family::Hierarchy> hierarchy_;
    std::optional<AdaptiveRefinement<typename Family::Hierarchy>> refinement_;
    FanChoice fans_;
    std::vector<Vec3d> corners_;      ///< of the fans in the output, by control vertex
    ExportedTriangles exported_;      ///< the triangles themselves are the result's
    std::vector<std::uint8_t> part_;  ///< by triangle: which of its leaf's or fan's triangles it is

  private:
    /// eval/README.md, Coarsest mesh: faces that do without their centre.
    void choose_coarsest() {
        if constexpr (std::is_same_v<Family, QuadFamily>) {
            if (options_.min_level > 0) return;
            std::vector<Site> sites;
            std::vector<std::uint32_t> vertex;
            corners_.assign(mesh_.positions().begin(), mesh_.positions().end());
            for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
                if (const HalfedgeId h = mesh_.vertex_halfedge(VertexId(v)); h.valid()) {
                    sites.push_back(canonical(mesh_, {h, {0, 0}, 0}));
                    vertex.push_back(v);
                }
            std::vector<Vec3d> positions(sites.size());
            place(sites, positions, {}, "coarsest", 0.2);
            for (std::size_t i = 0; i < vertex.size(); ++i) corners_[vertex[i]] = positions[i];
            fans_ = choose_fans(mesh_, corners_);
            const std::vector<double> errors = fan_errors();
            const double most = options_.max_triangles != 0 ? std::numeric_limits<double>::max() : aim_;
            for (std::uint32_t f = 0; f < mesh_.face_count(); ++f)
                if (fans_.has(FaceId(f)) && errors[f] <= most) hierarchy_->accept_fan(FaceId(f), errors[f]);
        }
    }
};

}  // namespace tetrakis::detail
