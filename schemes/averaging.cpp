#include "tetrakis/schemes/averaging.hpp"

#include "tetrakis/schemes/catmull_clark.hpp"
#include "tetrakis/schemes/doo_sabin.hpp"
#include "tetrakis/schemes/face_split.hpp"
#include "tetrakis/schemes/linear.hpp"
#include "tetrakis/schemes/vertex_split.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace tetrakis {

namespace {

/// A mesh with copies of its boundary around it; creases inside are smooth.
struct Layered {
    RuleMesh mesh;
    std::vector<int> source;  ///< vertex of the original mesh that each vertex is a copy of
    std::vector<int> outer;   ///< of a boundary half-edge h of the original: the half-edge of h's quad from h's origin
    std::vector<int> tip;     ///< of a corner vertex of the original: the half-edge of its quad from the vertex
};

bool is_tip(const RuleMesh& mesh, int v) {
    return mesh.first(v) != RuleMesh::none && mesh.on_boundary(v) && is_sharp(mesh.vertex_sharpness(v));
}

Layered smooth_inside(const RuleMesh& mesh) {
    Layered result;
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (const int v : mesh.corners(f)) faces.corner(v);
        faces.end_face();
    }
    result.mesh = RuleMesh(mesh.vertex_count(), std::move(faces), mesh.vertex_sharpness());
    result.source.resize(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) result.source[v] = v;
    return result;
}

/// One more layer. The first layer's quads are remembered.
void add_layer(Layered& layered) {
    const RuleMesh& mesh = layered.mesh;
    RuleMesh::Builder faces;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (const int v : mesh.corners(f)) faces.corner(v);
        faces.end_face();
    }
    int count = mesh.vertex_count();
    std::vector<int> source = layered.source;
    const auto copy = [&](int v) {
        source.push_back(layered.source[v]);
        return count++;
    };
    // Copies of each boundary vertex, seen from its boundary edge ahead and behind, and at a corner the one between.
    std::vector<std::array<int, 3>> copies(mesh.vertex_count(), {-1, -1, -1});
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (mesh.first(v) == RuleMesh::none || !mesh.on_boundary(v)) continue;
        const int first = copy(v);
        copies[v] = {first, first, -1};
        if (is_tip(mesh, v)) copies[v] = {first, copy(v), copy(v)};
    }
    const bool remember = layered.outer.empty();
    std::vector<int> outer(mesh.halfedge_count(), RuleMesh::none), tip(mesh.vertex_count(), RuleMesh::none);
    for (int h = 0; h < mesh.halfedge_count(); ++h) {
        if (mesh.twin(h) != RuleMesh::none) continue;
        const int u = mesh.origin(h), v = mesh.target(h);
        outer[h] = faces.halfedge_count() + 1;
        faces.face({v, u, copies[u][0], copies[v][1]});
    }
    std::vector<float> sharpness;
    if (!mesh.vertex_sharpness().empty()) sharpness.assign(count, 0.0f);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (copies[v][2] < 0) continue;
        tip[v] = faces.halfedge_count();
        faces.face({v, copies[v][1], copies[v][2], copies[v][0]});
        sharpness[copies[v][2]] = mesh.vertex_sharpness(v);
    }
    layered.mesh = RuleMesh(count, std::move(faces), std::move(sharpness));
    layered.source = std::move(source);
    if (!remember) return;
    layered.outer = std::move(outer);
    layered.tip = std::move(tip);
}

/// The averages on the split mesh. Points without all they need are empty.
struct Averages {
    RuleMesh split;
    std::vector<StencilRow> vertex,
        quad;  ///< per vertex of the split mesh; per quad (one per half-edge), odd steps only
};

StencilRow gathered(StencilRow row) {
    row.gather();
    return row;
}

Averages average(const Layered& layered, int steps, const BlockRunner* runner) {
    const RuleMesh& mesh = layered.mesh;
    Averages a;
    a.split = detail::split_polygons(mesh);
    const RuleMesh& split = a.split;
    a.vertex.resize(split.vertex_count());
    const auto at = [&](int v) { return layered.source[v]; };
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (mesh.first(v) != RuleMesh::none) a.vertex[v] = {{at(v), 1}};
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        a.vertex[mesh.vertex_count() + e] = gathered({{at(mesh.origin(h)), 0.5}, {at(mesh.target(h)), 0.5}});
    }
    for (int f = 0; f < mesh.face_count(); ++f) {
        StencilRow row;
        for (const int v : mesh.corners(f)) row.add(at(v), 1.0 / mesh.face_size(f));
        a.vertex[mesh.vertex_count() + mesh.edge_count() + f] = gathered(std::move(row));
    }
    const auto each = [&](int count, const auto& body) {
        detail::for_row_blocks(runner, count, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) body(i);
        });
    };
    for (int step = 0; step < steps; ++step) {
        if (step % 2 == 0) {
            a.quad.assign(split.face_count(), {});
            each(split.face_count(), [&](int q) {
                StencilRow row;
                bool whole = true;
                for (const int v : split.corners(q)) {
                    whole = whole && !a.vertex[v].terms.empty();
                    row.add(a.vertex[v], 0.25);
                }
                if (whole) a.quad[q] = gathered(std::move(row));
            });
            continue;
        }
        each(split.vertex_count(), [&](int v) {
            StencilRow row;
            bool whole = split.first(v) != RuleMesh::none && !split.on_boundary(v);
            if (whole) {
                const RuleMesh::Ring ring = split.ring(v);
                for (const int h : ring.halfedge) {
                    whole = whole && !a.quad[split.face(h)].terms.empty();
                    row.add(a.quad[split.face(h)], 1.0 / ring.faces());
                }
            }
            a.vertex[v] = whole ? gathered(std::move(row)) : StencilRow{};
        });
        a.quad.clear();
    }
    return a;
}

RuleStep receding_primal(const RuleMesh& mesh, const Averages& a) {
    RuleStep step;
    const RuleMesh& split = a.split;
    std::vector<char> kept(split.face_count(), 1);
    std::vector<int> number(split.vertex_count(), RuleMesh::none);
    int count = 0;
    for (int q = 0; q < split.face_count(); ++q)
        for (const int v : split.corners(q)) kept[q] = kept[q] && !a.vertex[v].terms.empty();
    for (int q = 0; q < split.face_count(); ++q)
        if (kept[q])
            for (const int v : split.corners(q)) number[v] = 0;
    for (int v = 0; v < split.vertex_count(); ++v)
        if (number[v] == 0) {
            number[v] = count++;
            step.stencils.push(a.vertex[v]);
        }
    RuleMesh::Builder faces;
    step.child_halfedge.assign(mesh.halfedge_count(), RuleMesh::none);
    for (int q = 0; q < split.face_count(); ++q) {
        if (!kept[q]) continue;
        step.child_halfedge[q] = faces.halfedge_count();  // quad q belongs to half-edge q
        for (const int v : split.corners(q)) faces.corner(number[v]);
        faces.end_face();
        step.parent_face.push_back(mesh.face(q));
    }
    if (count == 0) throw std::invalid_argument("the averaging steps use up the whole mesh; replicate its boundary");
    step.mesh = RuleMesh(count, std::move(faces));
    return step;
}

RuleStep receding_dual(const RuleMesh& mesh, const Averages& a) {
    RuleStep step;
    const RuleMesh& split = a.split;
    // Faces: the vertices of the split mesh all of whose quads have points.
    std::vector<std::vector<int>> polygons;
    std::vector<int> number(split.face_count(), RuleMesh::none);
    for (int v = 0; v < split.vertex_count(); ++v) {
        if (split.first(v) == RuleMesh::none || split.on_boundary(v)) continue;
        std::vector<int> polygon;
        for (const int h : split.ring(v).halfedge) polygon.push_back(split.face(h));
        if (polygon.size() < 3) continue;
        bool whole = true;
        for (const int q : polygon) whole = whole && !a.quad[q].terms.empty();
        if (!whole) continue;
        for (const int q : polygon) number[q] = 0;
        polygons.push_back(std::move(polygon));
    }
    int count = 0;
    for (int q = 0; q < split.face_count(); ++q)
        if (number[q] == 0) {
            number[q] = count++;
            step.stencils.push(a.quad[q]);
        }
    if (count == 0) throw std::invalid_argument("the averaging steps use up the whole mesh; replicate its boundary");
    RuleMesh::Builder faces;
    step.child_halfedge.assign(mesh.halfedge_count(), RuleMesh::none);
    for (const std::vector<int>& polygon : polygons) {
        // Quad q belongs to half-edge q; around a face's centre the quads are in the face's order.
        const bool around_face =
            mesh.face(polygon[0]) == mesh.face(polygon[1]) && mesh.face(polygon[1]) == mesh.face(polygon[2]);
        for (const int q : polygon) {
            if (around_face) step.child_halfedge[q] = faces.halfedge_count();
            faces.corner(number[q]);
        }
        faces.end_face();
        step.parent_face.push_back(mesh.face(polygon[0]));
    }
    step.mesh = RuleMesh(count, std::move(faces));
    return step;
}

/// How many layers of copies the points beside the boundary reach over.
int layers_needed(int steps) { return (steps + 3) / 4; }

}  // namespace

RuleStep averaging_step(const RuleMesh& mesh, const RuleOptions& options) {
    const int steps = options.averaging_steps;
    if (steps < 0) throw std::invalid_argument("the number of averaging steps must not be negative");
    if (steps == 0) return bilinear_step(mesh, options);
    const bool recedes = options.averaging_boundary == AveragingBoundary::recede;
    // Two steps take Catmull-Clark's rules at boundaries, creases and corners; the others have none inside.
    const bool sharp_rules = steps == 2 && !recedes;
    Layered layered = smooth_inside(mesh);
    if (sharp_rules) layered.mesh = mesh;
    if (recedes) {
        const Averages a = average(layered, steps, options.runner);
        return steps % 2 == 0 ? receding_primal(mesh, a) : receding_dual(mesh, a);
    }
    const RuleMesh inside = layered.mesh;
    if (!sharp_rules)
        for (int i = 0; i < layers_needed(steps); ++i) add_layer(layered);
    const Averages a = average(layered, steps, options.runner);
    if (steps % 2 == 1)
        return detail::split_vertices(
            inside, options.runner, [&](int h) { return a.quad[h]; },
            [&](int h, int near) {
                const int from_origin = layered.outer[h];
                return a.quad[inside.origin(h) == near ? from_origin : layered.mesh.prev(from_origin)];
            },
            [&](int v) { return a.quad[layered.tip[v]]; });
    // Numbers of vertices, edges and faces in the layered mesh start with those of the mesh; edges by half-edge.
    const auto split_edge = [&](int h) { return layered.mesh.vertex_count() + layered.mesh.edge(h); };
    const auto split_face = [&](int f) { return layered.mesh.vertex_count() + layered.mesh.edge_count() + f; };
    return detail::split_polygons(
        inside, options.runner,
        [&](int v) -> StencilRow {
            if (inside.first(v) == RuleMesh::none) return {{v, 1}};
            if (!sharp_rules) return a.vertex[v];
            return detail::blended_vertex_row(inside, v, inside.ring(v), [&] { return a.vertex[v]; });
        },
        [&](int h) {
            if (!sharp_rules) return a.vertex[split_edge(h)];
            const float s = inside.sharpness(h), child = child_sharpness(s);
            const double crease = edge_crease_weight(s, child, child);
            StencilRow row;
            if (crease != 0) row.add({{inside.origin(h), 0.5}, {inside.target(h), 0.5}}, crease);
            if (crease != 1) row.add(a.vertex[split_edge(h)], 1 - crease);
            return row;
        },
        [&](int f) { return sharp_rules ? detail::face_mean(inside, f) : a.vertex[split_face(f)]; });
}

RuleStep biquartic_step(const RuleMesh& mesh, const RuleOptions& options) {
    RuleOptions three = options;
    three.averaging_steps = 3;
    return averaging_step(mesh, three);
}

ClosedMasks averaging_closed_masks(const FanShape& shape, const RuleOptions& options) {
    const int m = options.averaging_steps, n = shape.faces;
    ClosedMasks masks;
    if (m == 0) return linear_closed_masks(shape, options);
    if (m == 1) return doo_sabin_catmull_clark_closed_masks(shape, options);
    const auto add = [&](FanLabel label, double weight) { masks.limit.emplace_back(label, weight); };
    if (m == 2) {
        if (shape.dart || (shape.corner && !shape.boundary)) return masks;
        if (shape.boundary) {
            if (shape.corner) {
                add({}, 1);
                return masks;
            }
            add({}, k_crease_limit_mask.vertex);
            add({0, 1, 0}, k_crease_limit_mask.neighbour);
            add({n, 1, 0}, k_crease_limit_mask.neighbour);
            masks.lambda1 = 0.5;
            masks.tangent1 = {{{0, 1, 0}, 1}, {{n, 1, 0}, -1}};
            return masks;
        }
        const double angle = 2 * std::numbers::pi / n, A = CatmullClark::tangent_edge_factor(angle);
        masks.lambda1 = masks.lambda2 = CatmullClark::mode_eigenvalue(angle);
        add({}, 4.0 / 9);
        for (int i = 0; i < n; ++i) {
            const FanLabel edge{i, 1, 0}, face{i, 1, 1};
            add(edge, 4.0 / (9 * n));
            add(face, 1.0 / (9 * n));
            masks.tangent1.emplace_back(edge, A * std::cos(i * angle));
            masks.tangent1.emplace_back(face, std::cos(i * angle) + std::cos((i + 1) * angle));
            masks.tangent2.emplace_back(edge, A * std::sin(i * angle));
            masks.tangent2.emplace_back(face, std::sin(i * angle) + std::sin((i + 1) * angle));
        }
        return masks;
    }
    if (m != 3) return masks;
    // At an end, in one direction: children (15, 1) / 16 and (11, 5) / 16 of p_0, p_1; the fixed point is (11, 1) / 12.
    if (shape.corner) {
        for (const FanLabel edge : {FanLabel{0, 1, 0}, FanLabel{1, 1, 0}}) add(edge, 11.0 / 144);
        add({}, 121.0 / 144);
        add({0, 1, 1}, 1.0 / 144);
        masks.lambda1 = masks.lambda2 = 0.25;
        return masks;
    }
    if (shape.boundary) {
        masks.lambda1 = 0.5;
        return masks;
    }
    for (int i = 0; i < n; ++i) {
        add({i, 0, 0}, 484.0 / (576 * n));
        add({i, 1, 0}, 88.0 / (2 * 576 * n));
        add({i, 0, 1}, 88.0 / (2 * 576 * n));
        add({i, 1, 1}, 4.0 / (576 * n));
    }
    return masks;
}

ClosedMasks biquartic_closed_masks(const FanShape& shape, const RuleOptions& options) {
    RuleOptions three = options;
    three.averaging_steps = 3;
    return averaging_closed_masks(shape, three);
}

BiquarticMask biquartic_mask(int k, BiquarticChild child) {
    const std::vector<double> w = DooSabin::weights_catmull_clark(k);
    BiquarticMask mask;
    mask.ring.resize(k);
    // Zorin, Schroeder 2001, figure 4.17 and equation 4.5, with Catmull and Clark's weights; the bases are those that
    // three averagings leave.
    for (int i = 0; i < k; ++i) {
        const double before = w[(i + k - 1) % k], after = w[(i + 1) % k];
        switch (child) {
            case BiquarticChild::north_west:
                mask.ring[i] = (64.0 / k + 48 * w[i] + 16 * before + 16 * after) / 256;
                break;
            case BiquarticChild::north_east:
                mask.ring[i] = (32 * w[i] + 16 * before) / 256;
                break;
            case BiquarticChild::south_east:
                mask.ring[i] = 16 * w[i] / 256;
                break;
        }
    }
    constexpr std::array<double, 8> base[] = {
        {15, 5, 15, 51, 10, 5, 10, 1}, {35, 25, 3, 79, 50, 1, 10, 5}, {7, 5, 7, 91, 50, 5, 50, 25}};
    for (int i = 0; i < 8; ++i) mask.around[i] = base[static_cast<int>(child)][i] / 256;
    return mask;
}

}  // namespace tetrakis
