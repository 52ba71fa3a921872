#include "corner_templates.hpp"

#include "../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <span>
#include <utility>

namespace tetrakis::detail {

namespace {

/// The roots around a corner as a mesh: each is one face, whose first vertex is the corner.
RuleMesh base_of(const CornerKind& kind, std::uint32_t sides) {
    const auto roots = static_cast<int>(kind.roots()), spokes = static_cast<int>(kind.sharp.size());
    const int n = static_cast<int>(sides);
    RuleMesh::Builder faces;
    // Twins are explicit: the far sides of two triangles join the same vertices, but are not twins.
    std::vector<int> twins(static_cast<std::size_t>(n * roots), RuleMesh::none);
    for (int i = 0; i < roots; ++i) {
        faces.corner(0);
        faces.corner(1 + i);
        if (sides == 4) faces.corner(1 + spokes + i);
        faces.corner(1 + (i + 1) % spokes);
        faces.end_face();
        if (!kind.closed && i + 1 == roots) continue;
        const int last = n * i + n - 1, next = n * ((i + 1) % roots);
        twins[static_cast<std::size_t>(last)] = next;
        twins[static_cast<std::size_t>(next)] = last;
    }
    faces.set_twins(std::move(twins));
    return RuleMesh(1 + spokes + (sides == 4 ? roots : 0), std::move(faces));
}

/// The lattices of these roots as a mesh with the kind's tags and angles; its vertices are in the order of RootLayout.
RuleMesh lattice_of(const CornerKind& kind, const RootLattices& net, std::uint32_t segments) {
    const std::uint32_t sides = net.side_count(), corners = sides * segments * segments;
    const std::vector<std::uint32_t> vertices = net.faces(segments, {}).vertices;
    std::vector<float> sharpness(vertices.size(), 0.0f), at_corner(net.place_count(net.layout(segments)), 0.0f);
    std::vector<double> angles(kind.angle.empty() ? 0 : vertices.size(), 0.0);
    std::vector<int> tags(vertices.size(), 0);
    for (std::uint32_t i = 0; i < kind.roots(); ++i) {
        const std::uint32_t first = corners * i;
        // Along the side, every second triangle is upright.
        for (std::uint32_t x = 0; x < segments; ++x) sharpness[first + (sides == 4 ? 4 : 6) * x] = kind.sharp[i];
        if (!angles.empty()) angles[first] = kind.angle[i];
        // The edges across the corner of two triangles that share two sides have the same ends, so they get tags.
        if (sides == 3) tags[first + 1] = tags[first + 5] = static_cast<int>(i) + 1;
    }
    at_corner[0] = kind.corner;
    RuleMesh::Builder faces;
    for (std::uint32_t h = 0; h < vertices.size(); ++h) {
        faces.corner(static_cast<int>(vertices[h]), sharpness[h], tags[h]);
        if ((h + 1) % sides == 0) faces.end_face();
    }
    faces.set_corner_angles(std::move(angles));
    const auto count = static_cast<int>(at_corner.size());
    return RuleMesh(count, std::move(faces), std::move(at_corner));
}

/// A mesh whose first dual refinement has a corner of that kind.
RuleMesh cage_of(const CornerKind& kind) {
    RuleMesh::Builder faces;
    if (!kind.crease_end) {
        // A closed corner is the centre of a face. Others are on the boundary; at a sharp vertex if they have one root.
        const int n = kind.closed ? static_cast<int>(kind.roots()) : 4;
        for (int v = 0; v < n; ++v) faces.corner(v);
        faces.end_face();
        std::vector<float> sharpness(static_cast<std::size_t>(n), 0.0f);
        if (kind.roots() == 1) sharpness[0] = k_sharpness_infinity;
        return RuleMesh(n, std::move(faces), std::move(sharpness));
    }
    // Two rows of quads with a crease of one edge between them. Its ends are two darts, or a dart and the boundary.
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
    const RuleMesh& base = net.base();
    kind.resize(net.halfedge_count());
    root.resize(net.halfedge_count());
    std::map<CornerKind, std::uint32_t> numbers;
    std::vector<std::uint32_t> smooth;  // by valence, for smooth interior corners: number of the kind plus one; 0: none
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
    for (int v = 0; v < base.vertex_count(); ++v) {
        if (base.first(v) == RuleMesh::none) continue;
        around.clear();
        found.closed = base.for_each_leaving(v, [&](std::uint32_t h) { around.push_back(h); });
        found.crease_end =
            std::binary_search(net.crease_ends().begin(), net.crease_ends().end(), static_cast<std::uint32_t>(v));
        found.corner = halfedge.empty() ? 0.0f : seen(mesh.vertex_sharpness(mesh.origin(halfedge[base.first(v)])));
        found.sharp.clear();
        const auto sharpness = [&](std::uint32_t g) {
            if (base.twin(g) == RuleMesh::none) return k_sharpness_infinity;
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
            // Of all rotations the lexicographically smallest one represents the kind.
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
      net_(like.in_cells() ? RootLattices::of_corners(mesh_, kind.crease_end)
                           : RootLattices::of_faces(mesh_, std::vector<std::uint32_t>(kind.roots()))) {
    if (!like.in_cells()) {
        const std::uint32_t n = segments_, sides = net_.side_count();
        mesh_ = lattice_of(kind_, net_, n);
        number_.resize(mesh_.vertex_count());
        std::iota(number_.begin(), number_.end(), 0);
        // The cells at a root's corners, in the order of RootLattices::faces().
        const std::vector<std::uint32_t> cells =
            sides == 4 ? std::vector{0u, n - 1, n * n - 1, n * n - n} : std::vector{0u, 2 * n - 2, n * n - 1};
        for (std::uint32_t i = 0; i < kind_.roots(); ++i) {
            corner_.push_back(sides * i);
            for (std::uint32_t k = 0; k < sides; ++k)
                first_.push_back(static_cast<int>(sides * (n * n * i + cells[k]) + k));
        }
        return;
    }
    find_corner();
    RuleStep step = scheme.step(mesh_, rules);  // gives one cell per root
    first_ = std::move(step.child_halfedge);
    mesh_ = std::move(step.mesh);
    for (std::uint32_t n = 1; n < segments_; n *= 2) {
        step = scheme.step(mesh_, rules);
        first_ = children(step);
        mesh_ = std::move(step.mesh);
    }
    if (const auto numbers = net_.vertices(net_.layout(segments_), mesh_, first_)) number_ = *numbers;
}

/// Finds the half-edges of the net that leave the corner.
void CornerTemplate::find_corner() {
    const CornerKinds found(net_, mesh_, {}, CornerKinds::Sees::one_step, false);
    corner_.resize(kind_.roots());
    int corner = RuleMesh::none;
    for (std::uint32_t h = 0; h < found.kind.size(); ++h) {
        const int v = net_.base().origin(h);
        if (found.kinds[found.kind[h]] != kind_ || (corner != RuleMesh::none && corner != v)) continue;
        corner = v;
        corner_[found.root[h]] = h;
    }
}

std::vector<int> CornerTemplate::children(const RuleStep& step) const {
    std::vector<int> result = first_;
    for (int& h : result) h = h < 0 ? h : step.child_halfedge[static_cast<std::size_t>(h)];
    return result;
}

std::optional<std::vector<int>> CornerTemplate::finer_numbers(const RuleStep& step, std::uint32_t factor) const {
    const std::vector<int> first = children(step);
    if (std::find(first.begin(), first.end(), RuleMesh::none) != first.end()) return std::nullopt;
    return net_.vertices(net_.layout(factor * segments_), step.mesh, first);
}

}  // namespace tetrakis::detail
