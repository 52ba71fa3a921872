#include "limit_search.hpp"

#include "../core/corner_angles.hpp"
#include "../core/masks.hpp"
#include "../parts/sector_fan.hpp"
#include "mesh_part.hpp"
#include "spectrum.hpp"

#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace tetrakis::detail {

namespace {

using Mask = ClosedMasks::Mask;

// Steps that are tried after the last semi-sharp tag is gone: a fan of up to four rings is regular after three.
constexpr int k_most_steps = 5;
// Smaller weights of numeric eigenvectors are rounding errors: the largest weights are of order one.
constexpr double k_no_weight = 1e-12;

using Rows = LimitRows;

StencilRow gathered(StencilRow row) {
    row.gather();
    return row;
}

/// Site of a limit: a vertex (named by a half-edge that leaves it), a face of a dual mesh (by one of its half-edges)
/// or a crease edge of a dual mesh.
struct FanSite {
    enum class Kind { vertex, face, crease } kind;
    int halfedge;
};

}  // namespace

ClosedMasks limit_masks(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options) {
    ClosedMasks masks = scheme.closed_masks(shape, options);
    const FanLattice lattice = fan_lattice(scheme, shape, options);
    if (!scheme.is_linear() && (masks.limit.empty() || masks.tangent1.empty() || masks.tangent2.empty())) {
        try {
            const SpectralAnalysis analysis = analyse(scheme, shape, options);
            const SchemeMasks found = scheme_masks(scheme, analysis, options);
            const auto mask = [&](const std::vector<double>& weights) {
                Mask result;
                for (std::size_t i = 0; i < weights.size(); ++i)
                    if (std::abs(weights[i]) > k_no_weight)
                        result.emplace_back(analysis.matrix.labels.all()[i], weights[i]);
                return result;
            };
            masks = {mask(found.limit), mask(found.tangent1), mask(found.tangent2)};
        } catch (const std::invalid_argument&) {
            // The shape has no local matrix. Its limit may still have a formula.
        }
    }
    double sum = 0;
    for (const auto& [label, weight] : masks.limit) sum += weight;
    for (auto& [label, weight] : masks.limit) weight /= sum;
    // At an interior vertex of valence 2 the modes span no plane.
    const bool folded = lattice != FanLattice::dual && !shape.boundary && shape.faces == 2;
    if (masks.tangent1.empty() || masks.tangent2.empty() || folded) return {.limit = std::move(masks.limit)};
    const FanLabels middle(lattice, shape, 0);
    const auto in_plane = [&](const Mask& mask) {
        glm::dvec2 direction(0);
        for (const auto& [label, weight] : mask) direction += weight * fan_place(middle, label);
        return direction;
    };
    const glm::dvec2 a = in_plane(masks.tangent1), b = in_plane(masks.tangent2);
    if (!(a.x * b.y - a.y * b.x > 0)) std::swap(masks.tangent1, masks.tangent2);
    return masks;
}

class LimitSearch::Finder {
  public:
    Finder(const SchemeInfo& scheme, const RuleOptions& options)
        : scheme_(scheme),
          options_(options),
          lattice_(fan_lattice(scheme, options)),
          dual_(lattice_ == FanLattice::dual),
          hexagons_(scheme.family == MeshFamily::hexagons),
          ignores_creases_(ignores_creases(scheme, options)) {
        // Under the plain rules, limits of these schemes depend on the one-ring alone, except near corners with angles.
        const bool plain = options.edge_beside_crease == EdgeBesideCrease::plain && !options.hoppe_crease;
        one_ring_ = plain && scheme.one_ring_limits;
    }

    /// Rows of the sites, empty where none is found.
    std::vector<std::optional<Rows>> find(const RuleMesh& mesh, const std::vector<FanSite>& sites, int step) {
        std::vector<std::optional<Rows>> found(sites.size());
        std::vector<std::size_t> open;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            found[i] = here(mesh, sites[i], step);
            if (!found[i]) open.push_back(i);
        }
        if (step == 0 && !open.empty()) most_steps_ = k_most_steps + steps_until_smooth(mesh);
        if (open.empty() || step == most_steps_) return found;

        std::vector<FanSite> left;
        for (const std::size_t i : open) left.push_back(sites[i]);
        const MeshPart part = parts_.find(mesh, seeds(mesh, left), rule_limit_rings(scheme_, options_));
        const RuleStep finer = scheme_.step(part.mesh, options_);
        std::vector<FanSite> below;
        std::vector<std::size_t> of;
        for (const std::size_t i : open) {
            const std::optional<FanSite> child =
                child_of(part.mesh, finer, FanSite{sites[i].kind, part.halfedge(mesh, sites[i].halfedge)});
            if (!child) continue;
            below.push_back(*child);
            of.push_back(i);
        }
        std::vector<std::optional<Rows>> rows = find(finer.mesh, below, step + 1);
        const auto back = [&](const StencilRow& row) {
            StencilRow coarse, result;
            for (const auto& [point, weight] : row.terms) coarse.add(finer.stencils.row(point), weight);
            for (const auto& [point, weight] : coarse.terms) result.add(part.vertex[point], weight);
            return gathered(std::move(result));
        };
        for (std::size_t k = 0; k < of.size(); ++k) {
            if (!rows[k]) continue;
            Rows up{back(rows[k]->limit), {}};
            for (const auto& [t1, t2] : rows[k]->tangents) up.tangents.push_back({back(t1), back(t2)});
            found[of[k]] = std::move(up);
        }
        return found;
    }

  private:
    /// Masks as rows over a fan's points. tangent1 x tangent2 is outwards; both are empty for shapes without tangents.
    struct FanMasks {
        FanSearch search;  ///< for the rings that have weights
        StencilRow limit{}, tangent1{}, tangent2{};
    };

    static int steps_until_smooth(const RuleMesh& mesh) {
        float sharpest = 0;
        const auto look = [&](float sharpness) {
            if (is_semi_sharp(sharpness)) sharpest = std::max(sharpest, sharpness);
        };
        for (int h = 0; h < mesh.halfedge_count(); ++h) look(mesh.sharpness(h));
        for (const float sharpness : mesh.vertex_sharpness()) look(sharpness);
        return static_cast<int>(std::ceil(sharpest));
    }
    static std::vector<int> seeds(const RuleMesh& mesh, const std::vector<FanSite>& sites) {
        std::vector<int> result;
        for (const FanSite& site : sites) {
            if (site.kind == FanSite::Kind::vertex)
                result.push_back(mesh.origin(site.halfedge));
            else
                for (const int v : mesh.corners(mesh.face(site.halfedge))) result.push_back(v);
        }
        return result;
    }

    const FanMasks& masks(const FanShape& shape) {
        const auto at = masks_.find(shape);
        if (at != masks_.end()) return at->second;
        const ClosedMasks weights = limit_masks(scheme_, shape, options_);
        const FanLattice lattice = fan_lattice(scheme_, shape, options_);
        const FanLabels middle(lattice, shape, 0);
        int rings = 0;
        for (const Mask* mask : {&weights.limit, &weights.tangent1, &weights.tangent2})
            for (const auto& [label, weight] : *mask) rings = std::max(rings, middle.ring_of(label));
        FanMasks& masks = masks_.emplace(shape, FanMasks{FanSearch(FanLabels(lattice, shape, rings))}).first->second;
        const auto row = [&](const Mask& mask) {
            StencilRow result;
            for (const auto& [label, weight] : mask) result.add(masks.search.labels.find(label), weight);
            return result;
        };
        masks.limit = row(weights.limit);
        masks.tangent1 = row(weights.tangent1);
        masks.tangent2 = row(weights.tangent2);
        return masks;
    }

    bool semi_sharp(const RuleMesh& mesh, int v, const RuleMesh::Ring& ring) const {
        return is_semi_sharp(mesh.vertex_sharpness(v)) ||
               std::any_of(ring.sharpness.begin(), ring.sharpness.end(), is_semi_sharp);
    }

    /// Rows of a crease from those of its two sides: the limit of `left`, and the tangents of both.
    static std::optional<Rows> both(std::optional<Rows> left, std::optional<Rows> right) {
        if (!left || !right) return std::nullopt;
        for (auto& tangents : right->tangents) left->tangents.push_back(std::move(tangents));
        return left;
    }

    std::optional<Rows> here(const RuleMesh& mesh, const FanSite& site, int step) {
        if (hexagons_) return on_honeycomb(mesh, mesh.origin(site.halfedge));
        if (site.kind == FanSite::Kind::face) return around_face(mesh, site.halfedge);
        if (site.kind == FanSite::Kind::crease) {
            const FanShape shape{.faces = 4, .boundary = true};
            std::optional<Rows> rows = by_masks(mesh, shape, std::span(&site.halfedge, 1));
            const int twin = mesh.twin(site.halfedge);
            return twin == RuleMesh::none ? rows : both(std::move(rows), by_masks(mesh, shape, std::span(&twin, 1)));
        }
        const int v = mesh.origin(site.halfedge);
        const RuleMesh::Ring ring = mesh.ring(v);
        const auto tagged_corner = [&] {
            return by_masks(mesh, {.faces = ring.faces(), .boundary = true, .corner = true}, ring.halfedge);
        };
        // Dual vertices other than corners, and all vertices if the scheme ignores creases, are found after one step.
        if (dual_) {
            if (semi_sharp(mesh, v, ring) || mesh.rule(v) != VertexRule::corner) return std::nullopt;
            if (!ignores_creases_) return Rows{{{v, 1}}, {}};
            if (ring.closed || ring.faces() != 1) return std::nullopt;
            return tagged_corner();
        }
        if (ignores_creases_ && step == 0) return std::nullopt;
        if (semi_sharp(mesh, v, ring)) return std::nullopt;
        VertexRule rule = mesh.rule(v);
        if (ignores_creases_) {
            if (rule == VertexRule::corner && ring.closed) rule = VertexRule::smooth;
            if (rule == VertexRule::corner) return tagged_corner();
        }
        if (rule == VertexRule::corner) return Rows{{{v, 1}}, {}};
        if (rule == VertexRule::smooth) return by_masks(mesh, {.faces = ring.faces()}, ring.halfedge);
        std::vector<int> sharp;
        for (int i = 0; i < ring.edges(); ++i)
            if (is_sharp(ring.sharpness[i])) sharp.push_back(i);
        const auto from = [&](int first, int count) {
            std::vector<int> start;
            for (int i = 0; i < count; ++i) start.push_back(ring.halfedge[(first + i) % ring.faces()]);
            return start;
        };
        // The first of its two simple steps moves a dart before the second cuts the edge.
        if (scheme_.refinement == Refinement::sqrt3 &&
            std::any_of(sharp.begin(), sharp.end(), [&](int i) { return mesh.rule(ring.at(i)) == VertexRule::dart; }))
            return std::nullopt;
        if (rule == VertexRule::dart) {
            if (!ring.closed) return std::nullopt;
            return by_masks(mesh, {.faces = ring.faces(), .dart = true}, from(sharp[0], ring.faces()));
        }
        if (!ring.closed) return by_masks(mesh, {.faces = ring.faces(), .boundary = true}, ring.halfedge);
        const int one = sharp[1] - sharp[0];
        std::optional<Rows> left = by_masks(mesh, {.faces = one, .boundary = true}, from(sharp[0], one));
        std::optional<Rows> right =
            by_masks(mesh, {.faces = ring.faces() - one, .boundary = true}, from(sharp[1], ring.faces() - one));
        // Both sides give the same limit, except on Hoppe's crease, which is regular only if both sides are.
        if (options_.hoppe_crease && one == 3 && left && right) left->limit = right->limit;
        return both(std::move(left), std::move(right));
    }

    /// Rows of a honeycomb vertex. Creases are cubic B-splines that do not depend on the faces beside them.
    std::optional<Rows> on_honeycomb(const RuleMesh& mesh, int v) {
        const RuleMesh::Ring ring = mesh.ring(v);
        if (semi_sharp(mesh, v, ring)) return std::nullopt;
        const VertexRule rule = mesh.rule(v);
        if (rule == VertexRule::corner) return Rows{{{v, 1}}, {}};
        StencilRow row;
        if (rule == VertexRule::crease) {
            row.add(v, k_crease_limit_mask.vertex);
            for (const int e : mesh.sharp_neighbours(v)) row.add(e, k_crease_limit_mask.neighbour);
            return Rows{gathered(std::move(row)), {}};
        }
        // Left eigenvector: weights of the vertex, its neighbours, the other corners of its hexagons, and three corners
        // of the hexagon beyond each neighbour. The total weight over all edges does not depend on their number.
        constexpr double k_vertex = 552.0 / 1426, k_edge[] = {541, 128, 72, 128, 2, 1, 2};
        const double edge = 1 / (1426.0 * ring.edges());
        row.add(v, k_vertex);
        for (const int h : ring.halfedge) {
            const int e = mesh.target(h);
            const int beyond = mesh.twin(mesh.next(h));
            // The mask needs hexagons, and neighbours of valence 3. After a few steps the mesh is so.
            if (rule != VertexRule::smooth || mesh.rule(e) != VertexRule::smooth || mesh.ring(e).edges() != 3 ||
                mesh.face_size(mesh.face(h)) != 6 || mesh.face_size(mesh.face(beyond)) != 6)
                return std::nullopt;
            int at = h;
            for (int k = 0; k < 7; ++k) {
                row.add(mesh.target(at), k_edge[k] * edge);
                at = k == 3 ? mesh.next(mesh.next(beyond)) : mesh.next(at);
            }
        }
        return Rows{gathered(std::move(row)), {}};
    }

    std::optional<Rows> around_face(const RuleMesh& mesh, int h) {
        std::vector<int> start;
        for (int at = h; start.empty() || at != h; at = mesh.next(at)) start.push_back(at);
        return by_masks(mesh, {.faces = static_cast<int>(start.size())}, start);
    }

    std::optional<Rows> by_masks(const RuleMesh& mesh, const FanShape& shape, std::span<const int> start) {
        const FanMasks& m = masks(shape);
        if (m.limit.terms.empty()) return std::nullopt;
        const std::optional<std::vector<int>> fan = find(mesh, m.search, start);
        if (!fan) return std::nullopt;
        const auto row = [&](const StencilRow& mask) {
            StencilRow result;
            for (const auto& [point, weight] : mask.terms) result.add((*fan)[point], weight);
            return gathered(std::move(result));
        };
        Rows rows{row(m.limit), {}};
        if (!m.tangent1.terms.empty()) rows.tangents.push_back({row(m.tangent1), row(m.tangent2)});
        return rows;
    }

    /// Whether one of the vertices is a corner with an angle. The edges at such a corner have rules of their own.
    bool bends(const RuleMesh& mesh, std::span<const int> vertices) const {
        if (!scheme_.takes_corner_angles || !may_have_angles(mesh, options_)) return false;
        return std::any_of(vertices.begin(), vertices.end(), [&](int v) {
            if (mesh.rule(v) != VertexRule::corner) return false;
            const RuleMesh::Ring ring = mesh.ring(v);
            return std::any_of(ring.halfedge.begin(), ring.halfedge.end(),
                               [&](int h) { return sector_angle(mesh, h, options_) > 0; });
        });
    }

    /// The mesh's vertices at the fan's labels; empty if the mesh there is not the one that the masks are made for.
    std::optional<std::vector<int>> find(const RuleMesh& mesh, const FanSearch& search,
                                         std::span<const int> start) const {
        const FanLabels& labels = search.labels;
        const FanShape& shape = labels.shape();
        const int size = lattice_ == FanLattice::triangles ? 3 : 4;
        const bool dual = labels.lattice() == FanLattice::dual, dual_face = dual && !shape.boundary;
        if (!dual_face)
            for (const int h : start)
                if (mesh.face_size(mesh.face(h)) != size) return std::nullopt;
        std::vector<int> fan;
        try {
            fan = search.find(mesh, start);
        } catch (const std::logic_error&) {
            return std::nullopt;  // the fan meets another extraordinary point or the boundary
        }
        if (dual_face && labels.rings() == 0) return fan;
        if (one_ring_) return bends(mesh, fan) ? std::nullopt : std::optional(std::move(fan));
        // All vertices of the fan except its middle must be regular.
        for (int i = 0; i < labels.size(); ++i) {
            const FanLabel l = labels.all()[i];
            const bool middle = !dual && l.a == 0 && l.b == 0;
            if (middle) continue;
            const bool on_ray = l.b == 0 && (l.sector == 0 || l.sector == shape.faces);
            const bool sharp =
                dual ? shape.boundary && l.b == 0 : on_ray && (shape.boundary || (shape.dart && l.sector == 0));
            const RuleMesh::Ring ring = mesh.ring(fan[i]);
            if (semi_sharp(mesh, fan[i], ring)) return std::nullopt;
            if (sharp) {
                if (mesh.rule(fan[i]) != VertexRule::crease) return std::nullopt;
                // A regular crease vertex has the same number of faces on each side.
                const int faces = lattice_ == FanLattice::triangles ? 3 : 2;
                if (ring.faces() != (ring.closed ? 2 : 1) * faces) return std::nullopt;
                const auto first = std::find_if(ring.sharpness.begin(), ring.sharpness.end(), is_sharp);
                if (ring.closed && !is_sharp(first[faces])) return std::nullopt;
            } else if (!ring.closed || ring.edges() != (size == 3 ? 6 : 4) || mesh.rule(fan[i]) != VertexRule::smooth) {
                return std::nullopt;
            }
            // All faces at these vertices must be regular, except the middle face of a dual fan.
            for (const int h : ring.halfedge)
                if (mesh.face_size(mesh.face(h)) != size && !(dual_face && mesh.face(h) == mesh.face(start[0])))
                    return std::nullopt;
        }
        return fan;
    }

    std::optional<FanSite> child_of(const RuleMesh& mesh, const RuleStep& step, const FanSite& site) const {
        using enum FanSite::Kind;
        const auto at = [](FanSite::Kind kind, int h) {
            return h == RuleMesh::none ? std::optional<FanSite>() : std::optional<FanSite>({kind, h});
        };
        const int h = site.halfedge;
        if (hexagons_) return at(vertex, step.mesh.first(mesh.origin(h)));  // old vertices keep their numbers
        if (site.kind == crease) {
            const int along = step.child_crease.empty() ? RuleMesh::none : step.child_crease[h];
            if (along != RuleMesh::none) return at(crease, along);
            // The crease has become smooth. The edge becomes a face, which has the same middle.
            const int side = step.child_halfedge[h];
            return at(face, side == RuleMesh::none ? side : step.mesh.twin(side));
        }
        if (site.kind == face || !dual_) return at(site.kind, step.child_halfedge[h]);
        // A vertex of a dual scheme becomes a face. A vertex on a crease becomes one face per side, and the crease edge
        // of one of them is taken. A corner keeps a point of its own.
        const RuleMesh& fine = step.mesh;
        const int v = mesh.origin(h);
        const RuleMesh::Ring ring = mesh.ring(v);
        int smooth = RuleMesh::none, sharp = RuleMesh::none, sharp_count = 0;
        for (int i = 0; i < ring.edges(); ++i) {
            const bool counts = is_sharp(ring.sharpness[i]) && !(ignores_creases_ && ring.closed) &&
                                !(ignores_creases_ && i > 0 && i + 1 < ring.edges());
            sharp_count += counts ? 1 : 0;
            if (i >= ring.faces()) continue;
            int& which = counts ? sharp : smooth;
            if (which == RuleMesh::none) which = ring.halfedge[i];
        }
        if (sharp_count >= 2) {
            if (step.child_crease.empty() || step.child_crease[sharp] == RuleMesh::none) return std::nullopt;
            const bool corner = sharp_count > 2 || is_sharp(mesh.vertex_sharpness(v));
            return at(corner ? vertex : crease, crease_end_halfedge(fine, step.child_crease[sharp]));
        }
        if (ring.faces() < 3 || smooth == RuleMesh::none || step.child_halfedge[smooth] == RuleMesh::none)
            return std::nullopt;
        const int edge = fine.twin(step.child_halfedge[smooth]);
        if (edge == RuleMesh::none) return std::nullopt;
        return at(face, fine.twin(fine.next(edge)));
    }

    const SchemeInfo& scheme_;
    RuleOptions options_;
    FanLattice lattice_;
    bool dual_, hexagons_, ignores_creases_, one_ring_;
    int most_steps_ = k_most_steps;
    MeshPartFinder parts_;
    std::map<FanShape, FanMasks> masks_;
};

int rule_limit_rings(const SchemeInfo& scheme, const RuleOptions& options) {
    // A step uses the rings that its rules reach, and two more by which a rule is chosen (honeycomb's rules are the
    // same everywhere). The factor 2: the next step needs as many rings of the finer mesh.
    const int chosen_by = scheme.family == MeshFamily::hexagons ? 0 : 2;
    return 2 * (rule_rings(scheme, options) + chosen_by);
}

LimitSearch::LimitSearch(const SchemeInfo& scheme, const RuleOptions& options)
    : scheme_(scheme), finder_(std::make_unique<Finder>(scheme, options)) {}
LimitSearch::~LimitSearch() = default;

std::vector<std::optional<LimitRows>> LimitSearch::find(const RuleMesh& mesh, std::span<const int> vertices) {
    std::vector<FanSite> sites;
    for (const int v : vertices) sites.push_back({FanSite::Kind::vertex, mesh.first(v)});
    return finder_->find(mesh, sites, 0);
}

std::optional<LimitRows> LimitSearch::at_face(const RuleMesh& mesh, int halfedge) {
    return std::move(finder_->find(mesh, {{FanSite::Kind::face, halfedge}}, 0)[0]);
}

}  // namespace tetrakis::detail
