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

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// A tessellation whose leaves are triangles: of bisected quads, red-green quadtrees, or sqrt(3) forests. A derived
/// class computes vertex positions and chooses the error estimator.
/// @tparam Family  the hierarchy; except for sqrt(3), whose leaves lie in no cells, also the sites of triangles' points
template <class Family>
class CellTessellator : public TessellationRun {
  protected:
    using TessellationRun::TessellationRun;

    /// refine() with an estimator. hierarchy_ is set before.
    /// @param base_bytes  memory in use already, which counts for the memory limit
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
        place(exported_.sites, mesh.positions, "export", 0.9);
        const std::size_t count = mesh.triangles.size();
        part_.assign(count, 0);
        result_.triangle_face.resize(count);
        result_.triangle_error.resize(count);
        result_.deepest_level = 0;
        for (std::size_t t = 0; t < count; ++t) {
            const LeafId leaf = exported_.leaves[t];
            const FaceId face = exported_.faces[t];
            // Triangles of one fan or one green leaf have consecutive numbers.
            if (t > 0 && exported_.leaves[t - 1] == leaf && (leaf.valid() || exported_.faces[t - 1] == face))
                part_[t] = static_cast<std::uint8_t>(part_[t - 1] + 1);
            result_.triangle_face[t] = face.value;
            result_.triangle_error[t] = round_up(estimated_error(t));
            if (leaf.valid()) result_.deepest_level = std::max(result_.deepest_level, quadtree_level(leaf));
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
        if (options_.uvs && mesh_.has_uvs())
            if (const std::vector<Vec2d> uvs = corner_uvs(); !uvs.empty())
                add_uvs(number_uvs({result_.mesh.triangles.front().data(), uvs.size()}, uvs));
        context_.report("attributes", 1);
    }

    /// Computes the output positions of canonical sites. Reports progress of `stage` from 0 to `share`.
    virtual void place(std::span<const Site> sites, std::span<Vec3d> positions, std::string_view stage,
                       double share) = 0;
    virtual void limit_normals(std::span<const Site> sites, std::span<Vec3d> normals) const = 0;
    /// Level in the numbering of TessellationRun.
    virtual int quadtree_level(LeafId leaf) const { return hierarchy_->level(leaf); }
    /// Errors of faces' fans; infinite if there is no bound. Called with some thousand faces at a time.
    virtual void fan_errors(std::span<const FaceId>, std::span<double>) {}
    /// Error of a triangle in the last measurement.
    virtual double error_of(std::uint32_t t) const { return double{result_.triangle_error[t]}; }
    /// Texture coordinates of triangle corners, three a triangle; empty if they are left out.
    virtual std::vector<Vec2d> corner_uvs() = 0;

    /// Adds the limit surface's normals; of the triangles, with a warning, if limit normals need whole levels that are
    /// too large. Vertices get several if one cannot serve all triangles around.
    virtual void add_normals() {
        TriangleMesh& mesh = result_.mesh;
        mesh.normals.resize(mesh.positions.size());
        try {
            constexpr std::size_t k_block = 1u << 16;
            for (std::size_t begin = 0; begin < mesh.normals.size(); begin += k_block) {
                context_.report("attributes",
                                0.4 * static_cast<double>(begin) / static_cast<double>(mesh.normals.size()));
                const std::size_t size = std::min(k_block, mesh.normals.size() - begin);
                limit_normals(std::span(exported_.sites).subspan(begin, size), {&mesh.normals[begin], size});
            }
            SideNormals side;
            if constexpr (requires { Family::k_middle; })
                side = [this](auto corners, auto normals) { normals_from_inside(corners, normals); };
            split_creases(side);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::unsupported && error.code() != ErrorCode::memory_limit) throw;
            mesh.triangle_normals.clear();
            geometric_normals(mesh);
            split_creases();
            result_.warnings.push_back(
                "the normals are those of the triangles: for the limit surface's the rules would "
                "have to make levels that are too large");
        }
    }

    /// Error of a triangle, as estimated for its leaf or fan.
    double estimated_error(std::uint32_t t) const {
        if constexpr (std::is_same_v<Family, QuadFamily>)
            if (!exported_.leaves[t].valid()) return hierarchy_->fan_error(exported_.faces[t]);
        return refinement_->error(exported_.leaves[t]);
    }

    /// Whether the estimated error of a triangle, if it is within the aim, is certified: by default with the certified
    /// estimator; an override may decide by the basis of a leaf's error.
    virtual bool is_bound(std::uint32_t) const { return certified(); }
    /// The largest certified error of all triangles, tight to a twentieth if it is above a floor: the aim of the
    /// certified estimator, or else the measured error. A fan is represented by its first triangle.
    /// @param bound  (triangles, floor, errors) finds errors of some triangles, which must be tight only above `floor`:
    ///               all of leaves or all of fans
    template <class Bound>
    double largest_error(const Bound& bound) const {
        double largest = 0, floor = 0;
        if (certified())
            floor = aim_;
        else if (result_.measured_error)
            floor = result_.measured_error->hausdorff;  // loose bounds below it suffice for most triangles
        // Triangles without a known bound come first. Known bounds above the floor may be loose: they are found anew.
        const auto known = [&](std::uint32_t t) {
            const double error = estimated_error(t);
            return is_bound(t) && error > 0 && error <= aim_ ? error : std::numeric_limits<double>::infinity();
        };
        std::array<std::vector<std::uint32_t>, 4> open;  // of leaves, of fans; the same with a known bound
        for (std::uint32_t t = 0; t < part_.size(); ++t)
            if (const bool fan = !exported_.leaves[t].valid(); !fan || part_[t] == 0)
                open[(std::isfinite(known(t)) ? 2 : 0) + (fan ? 1 : 0)].push_back(t);
        std::vector<std::uint32_t> some;
        std::vector<double> errors;
        std::size_t done = 0;
        for (const std::vector<std::uint32_t>& triangles : open) {
            constexpr std::size_t k_first = 64, k_most = 2048;
            // Each block raises the floor, so most triangles of the next block need no tight bound.
            for (std::size_t t = 0, size = k_first; t < triangles.size(); size = std::min(2 * size, k_most)) {
                context_.report("certify", static_cast<double>(done + t) / static_cast<double>(part_.size()));
                for (some.clear(); t < triangles.size() && some.size() < size; ++t)
                    if (const double error = known(triangles[t]); error <= floor)
                        largest = std::max(largest, error);
                    else
                        some.push_back(triangles[t]);
                errors.assign(some.size(), 0.0);
                bound(std::span(std::as_const(some)), floor, std::span(errors));
                for (const double error : errors) largest = std::max(largest, error);
                floor = std::max(floor, largest);
            }
            done += triangles.size();
        }
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
    /// The site of corner k of triangle t, as an address inside its root.
    Site corner_site(std::uint32_t t, std::size_t k) const { return origin(t).template corner_site<Family>(mesh_, k); }
    /// Limit normals at triangle corners, from the triangle's own side of a crease: extrapolated linearly from two
    /// points inside the triangle near the corner.
    void normals_from_inside(std::span<const std::uint64_t> corners, std::span<Vec3d> normals) const {
        // At 2^-8 of a triangle's size: the extrapolated normal's error is less than a thousandth of the bend.
        constexpr int k_finer = 8, k_least = 3;
        std::vector<Site> sites;
        std::vector<std::size_t> place;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const OutputTriangle from = origin(static_cast<std::uint32_t>(corners[i] / 3));
            const int finer = std::min(k_finer, k_max_level - (from.fan.valid() ? 0 : from.cell.level));
            if (finer < k_least) continue;
            for (const std::uint32_t steps : {1u, 2u})
                sites.push_back(from.template inner_site<Family>(mesh_, corners[i] % 3, finer, steps));
            place.push_back(i);
        }
        std::vector<Vec3d> found(sites.size());
        limit_normals(sites, found);
        for (std::size_t j = 0; j < place.size(); ++j)
            normals[place[j]] = unit_or_zero(2.0 * found[2 * j] - found[2 * j + 1]);
    }

    /// Texture coordinates at the corners of triangles: limits of the charts by the scheme, or linear if their tag asks
    /// for it. If the charts cannot be subdivided: with a warning, linear or none.
    /// @param site_of  (charts, corner 3 t + k) the corner's canonical site in the charts
    /// @param linear   (corner) the corner's coordinates
    template <class SiteOf, class Linear>
    std::vector<Vec2d> chart_uvs(const SiteOf& site_of, const Linear& linear, bool linear_for_want_of_better) {
        ControlMesh charts;
        std::optional<Hierarchy> points;
        try {
            if (mesh_.face_varying_rule() != FaceVaryingRule::linear_all) {
                const SchemeInfo& scheme = options_.scheme.info();
                charts = uv_mesh(without_ignored_tags(mesh_, scheme, options_.rules).value_or(mesh_), options_.rules);
                points.emplace(make_hierarchy(
                    charts, scheme, {.rules = chart_rules(options_.rules), .whole_levels = true, .context = context_}));
            }
        } catch (const Error& error) {
            const bool kept = linear_for_want_of_better && error.code() != ErrorCode::cancelled;
            if (!kept && error.code() != ErrorCode::invalid_input) throw;
            result_.warnings.push_back(fmt::format("the UV layer cannot be subdivided and is {} ({})",
                                                   linear_for_want_of_better ? "interpolated linearly" : "left out",
                                                   error.what()));
            if (!linear_for_want_of_better) return {};
        }
        std::vector<Vec2d> uvs(3 * result_.mesh.triangles.size());
        std::vector<Site> sites(points ? uvs.size() : 0);
        for_each_index(static_cast<std::uint32_t>(result_.mesh.triangles.size()), [&](std::uint32_t t) {
            for (std::size_t corner = 3 * std::size_t{t}; corner < 3 * (std::size_t{t} + 1); ++corner)
                if (points)
                    sites[corner] = site_of(charts, corner);
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
    std::vector<Vec3d> corners_;      ///< output positions of fan corners, by control vertex
    ExportedTriangles exported_;      ///< without its triangles, which are moved to result_
    std::vector<std::uint8_t> part_;  ///< by triangle: its number among the triangles of its leaf or fan

  private:
    /// Chooses the faces that are output without their centre (eval/README.md, Coarsest mesh).
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
            place(sites, positions, "coarsest", 0.2);
            for (std::size_t i = 0; i < vertex.size(); ++i) corners_[vertex[i]] = positions[i];
            fans_ = choose_fans(mesh_, corners_);
            const double most = options_.max_triangles != 0 ? std::numeric_limits<double>::max() : aim_;
            constexpr std::size_t k_block = 2048;  // faces between two reports
            std::vector<FaceId> faces;
            std::vector<double> errors;
            for (std::uint32_t f = 0; f < mesh_.face_count(); ++f) {
                if (fans_.has(FaceId(f))) faces.push_back(FaceId(f));
                if (faces.size() < k_block && f + 1 < mesh_.face_count()) continue;
                context_.report("coarsest", 0.4 + 0.6 * f / mesh_.face_count());
                errors.assign(faces.size(), 0.0);
                fan_errors(faces, errors);
                for (std::size_t i = 0; i < faces.size(); ++i)
                    if (errors[i] <= most) hierarchy_->accept_fan(faces[i], errors[i]);
                faces.clear();
            }
        }
    }
};

}  // namespace tetrakis::detail
