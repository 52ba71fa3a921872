#include "corner_templates.hpp"

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

namespace tetrakis::detail {

namespace {

/// The roots around a corner: one face each, which starts there.
RuleMesh base_of(const CornerKind& kind, std::uint32_t sides) {
    const auto roots = static_cast<int>(kind.roots()), spokes = static_cast<int>(kind.sharp.size());
    const int n = static_cast<int>(sides);
    RuleMesh::Builder faces;
    // Of two triangles the far sides lie between the same vertices, and are no twins all the same.
    std::vector<int> twins(static_cast<std::size_t>(n * roots), RuleMesh::none);
    for (int i = 0; i < roots; ++i) {
        const int from = 1 + i, to = 1 + (i + 1) % spokes;
        if (sides == 4)
            faces.face({0, from, 1 + spokes + i, to});
        else
            faces.face({0, from, to});
        if (!kind.closed && i + 1 == roots) continue;
        const int last = n * i + n - 1, next = n * ((i + 1) % roots);
        twins[static_cast<std::size_t>(last)] = next;
        twins[static_cast<std::size_t>(next)] = last;
    }
    faces.set_twins(std::move(twins));
    return RuleMesh(1 + spokes + (sides == 4 ? roots : 0), std::move(faces));
}

/// A mesh whose cells make such a corner.
RuleMesh cage_of(const CornerKind& kind) {
    RuleMesh::Builder faces;
    if (!kind.crease_end) {
        // The middle of a face; or on the boundary, at a sharp vertex where there is one root alone.
        const int n = kind.closed ? static_cast<int>(kind.roots()) : 4;
        for (int v = 0; v < n; ++v) faces.corner(v);
        faces.end_face();
        std::vector<float> sharpness(static_cast<std::size_t>(n), 0.0f);
        if (kind.roots() == 1) sharpness[0] = k_sharpness_infinity;
        return RuleMesh(n, std::move(faces), std::move(sharpness));
    }
    // Two rows of quads, with a crease of one edge between them: from one dart to another, or to the boundary.
    const int columns = kind.closed ? 3 : 2, line = columns + 1;
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < columns; ++x) {
            const int v = y * line + x;
            const float sharpness = x == 1 ? k_sharpness_infinity : 0.0f;
            faces.corner(v, y == 1 ? sharpness : 0.0f);
            faces.corner(v + 1);
            faces.corner(v + line + 1, y == 0 ? sharpness : 0.0f);
            faces.corner(v + line);
            faces.end_face();
        }
    return RuleMesh(3 * line, std::move(faces));
}

}  // namespace

void CornerKind::turn() {
    std::rotate(sharp.begin(), sharp.begin() + 1, sharp.end());
    if (!angle.empty()) std::rotate(angle.begin(), angle.begin() + 1, angle.end());
}

CornerKinds::CornerKinds(const RootLattices& net, const RuleMesh& mesh, std::span<const int> halfedge, Sees sees,
                         bool angles) {
    const MeshLevel& base = net.base();
    kind.resize(base.halfedge_count());
    root.resize(base.halfedge_count());
    std::map<CornerKind, std::uint32_t> numbers;
    std::vector<std::uint32_t> smooth;  // by the number of roots where they close: the number, plus one
    const auto number_of = [&](const CornerKind& found) {
        const auto [at, is_new] = numbers.try_emplace(found, static_cast<std::uint32_t>(kinds.size()));
        if (is_new) kinds.push_back(found);
        return at->second;
    };
    const auto seen = [&](float sharpness) {
        return sees == Sees::one_step && sharpness > 1 ? k_sharpness_infinity : sharpness;
    };
    std::vector<std::uint32_t> around;
    CornerKind found, turned;
    for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
        const std::uint32_t first = base.vertex_halfedge[v];
        if (first == RootLattices::none) continue;
        around.clear();
        found.closed = base.for_each_around(v, [&](std::uint32_t h) { around.push_back(h); });
        found.crease_end = std::binary_search(net.crease_ends().begin(), net.crease_ends().end(), v);
        found.corner = halfedge.empty() ? 0.0f : seen(mesh.vertex_sharpness(mesh.origin(halfedge[first])));
        found.sharp.clear();
        const auto sharpness = [&](std::uint32_t g) {
            if (base.twin[g] == RootLattices::none) return k_sharpness_infinity;
            return halfedge.empty() ? 0.0f : seen(mesh.sharpness(halfedge[g]));
        };
        for (const std::uint32_t g : around) found.sharp.push_back(sharpness(g));
        if (!found.closed) found.sharp.push_back(k_sharpness_infinity);
        found.angle.clear();
        if (angles && mesh.has_corner_angles() && !halfedge.empty()) {
            for (const std::uint32_t g : around) found.angle.push_back(mesh.corner_angle(halfedge[g]));
            if (std::all_of(found.angle.begin(), found.angle.end(), [](double a) { return a == 0; }))
                found.angle.clear();
        }
        std::uint32_t number = 0;
        std::size_t start = 0;
        if (found.closed && found.corner == 0 && !found.crease_end && found.angle.empty() &&
            std::count(found.sharp.begin(), found.sharp.end(), 0) == std::ssize(around)) {
            if (smooth.size() <= around.size()) smooth.resize(around.size() + 1, 0);
            std::uint32_t& known = smooth[around.size()];
            if (known == 0) known = number_of(found) + 1;
            number = known - 1;
        } else {
            // Of the ways to go round it the one that comes first.
            turned = found;
            for (std::size_t i = 1; found.closed && i < around.size(); ++i) {
                turned.turn();
                if (turned < found) {
                    found = turned;
                    start = i;
                }
            }
            number = number_of(found);
        }
        for (std::size_t i = 0; i < around.size(); ++i) {
            const std::uint32_t g = around[(start + i) % around.size()];
            kind[g] = number;
            root[g] = static_cast<std::uint32_t>(i);
        }
    }
}

CornerTemplate::CornerTemplate(const CornerKind& kind, const RootLattices& like, std::uint32_t segments,
                               const SchemeInfo& scheme, const RuleOptions& rules)
    : kind_(kind),
      segments_(segments),
      mesh_(like.in_cells() ? cage_of(kind) : base_of(kind, like.side_count())),
      net_(like.in_cells()
               ? RootLattices::of_corners(mesh_, std::vector<std::uint32_t>(mesh_.halfedge_count()), kind.crease_end)
                     .value()
               : RootLattices::of_faces(mesh_)) {
    if (like.in_cells())
        refine_cage(scheme, rules);
    else
        make_lattice();
    if (const auto numbers = net_.vertices(net_.layout(segments_), mesh_, first_)) number_ = *numbers;
}

/// The rules' own level: cells begin with one a root.
void CornerTemplate::refine_cage(const SchemeInfo& scheme, const RuleOptions& rules) {
    const CornerKinds found(net_, mesh_, {}, CornerKinds::Sees::one_step, false);
    corner_.resize(kind_.roots());
    std::uint32_t corner = RootLattices::none;
    for (std::uint32_t h = 0; h < found.kind.size(); ++h) {
        const std::uint32_t v = net_.base().origin[h];
        if (found.kinds[found.kind[h]] != kind_ || (corner != RootLattices::none && corner != v)) continue;
        corner = v;
        corner_[found.root[h]] = h;
    }
    for (std::uint32_t n = 0; n < segments_; n = n == 0 ? 1 : 2 * n) {
        RuleStep step = scheme.step(mesh_, rules);
        first_ = n == 0 ? std::move(step.child_halfedge) : children(step);
        mesh_ = std::move(step.mesh);
    }
}

std::vector<int> CornerTemplate::children(const RuleStep& step) const {
    std::vector<int> result = first_;
    for (int& h : result) h = h < 0 ? h : step.child_halfedge[static_cast<std::size_t>(h)];
    return result;
}

void CornerTemplate::make_lattice() {
    for (std::uint32_t i = 0; i < kind_.roots(); ++i) corner_.push_back(net_.side_count() * i);
    const RootLayout at = net_.layout(segments_);
    const RootLattices::Faces faces = net_.faces(segments_, {});
    // Which of the sides that leave the corner a place is on.
    const auto spokes = static_cast<std::uint32_t>(kind_.sharp.size());
    std::vector<int> spoke(at.vertex_count(), -1);
    for (std::uint32_t i = 0; i < kind_.roots(); ++i)
        for (std::uint32_t j = 1; j <= segments_; ++j) {
            spoke[at.along(halfedge(i), j)] = static_cast<int>(i);
            const std::uint32_t last = net_.base().prev(halfedge(i));
            spoke[at.along(last, segments_ - j)] = static_cast<int>((i + 1) % spokes);
        }
    const auto along = [&](std::uint32_t a, std::uint32_t b) {
        const int at_a = spoke[a], at_b = spoke[b];
        return (a == 0 ? at_b : at_a) >= 0 && (a == 0 || b == 0 || at_a == at_b);
    };
    const auto sharpness = [&](std::uint32_t a, std::uint32_t b) {
        return along(a, b) ? kind_.sharp[static_cast<std::size_t>(spoke[a == 0 ? b : a])] : 0.0f;
    };
    RuleMesh::Builder builder;
    std::vector<double> angles;
    // In two roots edges may lie between the same vertices: those along a side are in both.
    using Edge = std::tuple<int, std::uint32_t, std::uint32_t>;
    std::map<Edge, int> open;
    std::vector<int> twins(kind_.closed && kind_.roots() == 2 ? faces.vertices.size() : 0, RuleMesh::none);
    for (std::size_t f = 0; f + 1 < faces.offsets.size(); ++f) {
        const std::uint32_t begin = faces.offsets[f], end = faces.offsets[f + 1];
        for (std::uint32_t c = begin; c < end; ++c) {
            const std::uint32_t a = faces.vertices[c], b = faces.vertices[c + 1 == end ? begin : c + 1];
            builder.corner(static_cast<int>(a), sharpness(a, b));
            if (!twins.empty()) {
                const int root = along(a, b) ? -1 : static_cast<int>(faces.control[f]), h = static_cast<int>(c);
                if (const auto other = open.find({root, b, a}); other != open.end()) {
                    twins[c] = other->second;
                    twins[static_cast<std::size_t>(other->second)] = h;
                }
                open[{root, a, b}] = h;
            }
            if (!kind_.angle.empty()) angles.push_back(a == 0 ? kind_.angle[faces.control[f]] : 0);
        }
        builder.end_face();
    }
    builder.set_corner_angles(std::move(angles));
    if (!twins.empty()) builder.set_twins(std::move(twins));
    std::vector<float> vertex_sharpness;
    if (is_sharp(kind_.corner)) {
        vertex_sharpness.assign(at.vertex_count(), 0.0f);
        vertex_sharpness[0] = kind_.corner;
    }
    mesh_ = RuleMesh(static_cast<int>(at.vertex_count()), std::move(builder), std::move(vertex_sharpness));
    const std::uint32_t sides = net_.side_count();
    first_.assign(net_.base().halfedge_count(), -1);
    for (int h = 0; h < mesh_.halfedge_count(); ++h) {
        const auto v = static_cast<std::uint32_t>(mesh_.origin(h));
        if (v >= net_.base().vertex_count) continue;
        const std::uint32_t root = faces.control[static_cast<std::size_t>(mesh_.face(h))];
        for (std::uint32_t g = sides * root; g < sides * (root + 1); ++g)
            if (net_.base().origin[g] == v) first_[g] = h;
    }
}

std::optional<CornerTemplate::Step> CornerTemplate::step(const SchemeInfo& scheme, const RuleOptions& rules,
                                                         std::uint32_t factor) const {
    RuleStep step = scheme.step(mesh_, rules);
    const std::vector<int> first = children(step);
    if (std::find(first.begin(), first.end(), RuleMesh::none) != first.end()) return std::nullopt;
    std::optional<std::vector<int>> row = net_.vertices(net_.layout(factor * segments_), step.mesh, first);
    if (!row) return std::nullopt;
    return Step{std::move(step.stencils), std::move(*row)};
}

}  // namespace tetrakis::detail
