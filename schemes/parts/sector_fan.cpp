#include "sector_fan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace tetrakis {

FanLabels::FanLabels(FanLattice lattice, const FanShape& shape, int rings)
    : lattice_(lattice), shape_(shape), rings_(rings) {
    if (shape.hexagons && (lattice != FanLattice::dual || shape.boundary || rings > 1))
        throw std::invalid_argument("hexagons lie around a face, in one ring");
    if (shape.faces < 1 || rings < 0) throw std::invalid_argument("a fan has at least one face");
    const bool dual = lattice == FanLattice::dual;
    const int n = shape.faces;
    if (!dual) labels_.push_back({});
    if (lattice == FanLattice::pentagons) {
        // Ring 1: the two pentagons, in the order of their corners. Ring 2: the hexagon between them.
        constexpr std::pair<int, int> beside[] = {{1, 0}, {2, 0}, {2, 1}, {0, 1}};
        for (const auto& [a, b] : beside)
            for (int s = 0; s < 2 && rings >= 1; ++s) labels_.push_back({s, a, b});
        for (const FanLabel l : {FanLabel{0, 0, 2}, FanLabel{1, 0, 2}, FanLabel{0, 0, 3}})
            if (rings >= 2) labels_.push_back(l);
    }
    const int most = rings + (dual && shape.boundary ? 1 : 0);
    for (int ring = 0; ring <= rings && lattice != FanLattice::pentagons; ++ring)
        for (int b = 0; b <= most; ++b)
            for (int a = rings; a >= (dual ? 0 : 1); --a) {
                if (ring_of({0, a, b}) != ring) continue;
                const int sectors = dual ? (shape.boundary ? 2 : n) : shape.boundary && b == 0 ? n + 1 : n;
                for (int s = 0; s < sectors; ++s) labels_.push_back({s, a, b});
            }
    for (int i = 0; i < size(); ++i) number_[labels_[i]] = i;
}

int FanLabels::ring_of(FanLabel label) const {
    if (lattice_ == FanLattice::triangles) return label.a + label.b;
    if (lattice_ == FanLattice::pentagons) return label.b > 1 ? 2 : label.a + label.b > 0 ? 1 : 0;
    if (lattice_ == FanLattice::dual && shape_.boundary) return std::max(label.a, label.b - 1);
    return std::max(label.a, label.b);
}

FanLabel FanLabels::canonical(FanLabel label) const {
    if (lattice_ == FanLattice::dual) return label;
    if (label.a == 0 && label.b == 0) return {};
    if (lattice_ == FanLattice::pentagons) return label;
    if (label.a == 0) label = {label.sector + 1, label.b, 0};
    if (!shape_.boundary) label.sector = (label.sector % shape_.faces + shape_.faces) % shape_.faces;
    return label;
}

int FanLabels::find(FanLabel label) const {
    const auto at = number_.find(canonical(label));
    return at == number_.end() ? -1 : at->second;
}

FanLabel FanLabels::mirrored(FanLabel label) const {
    const int n = shape_.faces;
    if (lattice_ == FanLattice::dual) {
        if (shape_.boundary) return {1 - label.sector, label.a, label.b};
        return {(n - label.sector) % n, label.b, label.a};
    }
    if (lattice_ == FanLattice::pentagons) {
        const bool on_axis = label.a == 0 && label.b != 1 && label.b != 2;
        return {on_axis ? label.sector : 1 - label.sector, label.a, label.b};
    }
    if (label.a == 0) return label;
    return canonical(label.b == 0 ? FanLabel{n - label.sector, label.a, 0}
                                  : FanLabel{n - 1 - label.sector, label.b, label.a});
}

namespace {

constexpr float k_infinite = std::numeric_limits<float>::infinity();

/// Faces of a primal fan, counter-clockwise; the first one of a sector starts at the centre.
template <class Face>
void primal_faces(const FanLabels& labels, Face&& face) {
    const int R = labels.rings();
    const bool triangles = labels.lattice() == FanLattice::triangles;
    for (int s = 0; s < labels.shape().faces; ++s)
        for (int a = 0; a < R; ++a)
            for (int b = 0; b < R; ++b) {
                if (!triangles) {
                    face({{s, a, b}, {s, a + 1, b}, {s, a + 1, b + 1}, {s, a, b + 1}});
                    continue;
                }
                if (a + b < R) face({{s, a, b}, {s, a + 1, b}, {s, a, b + 1}});
                if (a + b + 1 < R) face({{s, a + 1, b}, {s, a + 1, b + 1}, {s, a, b + 1}});
            }
}

template <class Face>
void dual_faces(const FanLabels& labels, Face&& face) {
    const int n = labels.shape().faces, R = labels.rings();
    std::vector<FanLabel> middle;
    for (int s = 0; s < n; ++s) middle.push_back({s, 0, 0});
    face(middle);
    for (int s = 0; s < n && labels.shape().hexagons; ++s) {
        const int next = (s + 1) % n;
        face({{next, 0, 0}, {s, 0, 0}, {s, 1, 1}, {s, 0, 1}, {next, 1, 0}, {next, 1, 1}});
    }
    for (int s = 0; s < n && !labels.shape().hexagons; ++s) {
        const int before = (s + n - 1) % n;
        for (int a = 1; a <= R; ++a) {
            // The quad beyond the side from corner s - 1 to corner s, then the quads beyond corner s.
            face({{before, 0, a - 1}, {before, 0, a}, {s, a, 0}, {s, a - 1, 0}});
            for (int b = 1; b <= R; ++b) face({{s, a - 1, b - 1}, {s, a, b - 1}, {s, a, b}, {s, a - 1, b}});
        }
    }
}

template <class Face>
void dual_boundary_faces(const FanLabels& labels, Face&& face) {
    const int R = labels.rings();
    for (int b = 0; b <= R; ++b) {
        face({{1, 0, b}, {0, 0, b}, {0, 0, b + 1}, {1, 0, b + 1}});
        for (int a = 0; a < R; ++a) {
            face({{0, a, b}, {0, a + 1, b}, {0, a + 1, b + 1}, {0, a, b + 1}});
            face({{1, a + 1, b}, {1, a, b}, {1, a, b + 1}, {1, a + 1, b + 1}});
        }
    }
}

template <class Face>
void pentagon_faces(Face&& face) {
    face({{}, {0, 1, 0}, {0, 2, 0}, {0, 2, 1}, {0, 0, 1}});
    face({{}, {0, 0, 1}, {0, 0, 2}, {0, 0, 3}, {1, 0, 2}, {1, 0, 1}});
    face({{}, {1, 0, 1}, {1, 2, 1}, {1, 2, 0}, {1, 1, 0}});
}

RuleMesh fan_mesh(const FanLabels& labels) {
    const FanShape& shape = labels.shape();
    RuleMesh::Builder faces;
    std::vector<double> angles;
    const bool two_triangles = labels.lattice() == FanLattice::triangles && !shape.boundary && shape.faces == 2;
    const auto face = [&](const std::vector<FanLabel>& corners) {
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const int v = labels.find(corners[i]);
            const FanLabel from = labels.all()[v], to = labels.canonical(corners[(i + 1) % corners.size()]);
            // The centre is on every ray; its label has sector 0.
            const bool on_first_ray = from.sector == 0 && to.sector == 0 && from.b == 0 && to.b == 0;
            // Two triangles that share two edges: their third edges have the same ends, but are different edges.
            const bool in_both = two_triangles && from.a == 1 && from.b == 0 && to.a == 1 && to.b == 0;
            faces.corner(v, shape.dart && on_first_ray ? k_infinite : 0.0f, in_both ? corners[0].sector : 0);
            angles.push_back(v == 0 ? shape.angle : 0);
        }
        faces.end_face();
    };
    if (labels.lattice() == FanLattice::pentagons)
        pentagon_faces(face);
    else if (labels.lattice() != FanLattice::dual)
        primal_faces(labels, face);
    else if (shape.boundary)
        dual_boundary_faces(labels, face);
    else
        dual_faces(labels, face);
    std::vector<float> sharpness;
    if (shape.corner) {
        sharpness.assign(labels.size(), 0.0f);
        sharpness[0] = k_infinite;
        if (shape.angle != 0) faces.set_corner_angles(std::move(angles));
    }
    return RuleMesh(labels.size(), std::move(faces), std::move(sharpness));
}

}  // namespace

SectorFan::SectorFan(FanLattice lattice, const FanShape& shape, int rings)
    : labels(lattice, shape, rings), mesh(fan_mesh(labels)) {
    const auto add = [&](FanLabel from, FanLabel to) {
        const RuleMesh::Ring ring = mesh.ring(labels.find(from));
        start.push_back(ring.halfedge[ring.position(labels.find(to))]);
    };
    const int n = shape.faces;
    if (lattice == FanLattice::dual && shape.boundary)
        add({1, 0, 0}, {0, 0, 0});
    else if (lattice == FanLattice::pentagons)
        add({}, {0, 1, 0});
    else
        for (int s = 0; s < n; ++s)
            lattice == FanLattice::dual ? add({s, 0, 0}, {(s + 1) % n, 0, 0}) : add({}, {s, 1, 0});
}

glm::dvec2 fan_place(const FanLabels& labels, FanLabel l) {
    const bool dual = labels.lattice() == FanLattice::dual, boundary = labels.shape().boundary;
    if (dual && boundary) return {l.sector == 0 ? 0.5 + l.a : -0.5 - l.a, l.b};
    // A single face does not fill the half plane: its angle is at most 2 pi / 3.
    constexpr double pi = std::numbers::pi;
    const double turn = std::min((boundary ? 1 : 2) * pi / labels.shape().faces, 2 * pi / 3);
    const auto ray = [&](int s) { return glm::dvec2(std::cos(s * turn), std::sin(s * turn)); };
    const glm::dvec2 at = ray(l.sector), after = ray(l.sector + 1);
    if (!dual) return double(l.a) * at + double(l.b) * after;
    return at + double(l.a) * (at - after) + double(l.b) * (at - ray(l.sector - 1));
}

namespace {

/// The last half-edge, counter-clockwise, that leaves the boundary vertex at the origin of `h`.
int last_leaving(const RuleMesh& mesh, int h) {
    while (mesh.twin(mesh.prev(h)) != RuleMesh::none) h = mesh.twin(mesh.prev(h));
    return h;
}

// The mesh of a pentagon fan has the hexagon between the two pentagons, whose points are the labels of ring 2.
int least_rings(FanLattice lattice) {
    return lattice == FanLattice::pentagons ? 2 : lattice == FanLattice::dual ? 0 : 1;
}

}  // namespace

FanSearch::FanSearch(const FanLabels& of)
    : labels(of), fan_(of.lattice(), of.shape(), std::max(of.rings(), least_rings(of.lattice()))) {
    for (const FanLabel label : fan_.labels.all()) number_.push_back(labels.find(label));
    if (labels.lattice() == FanLattice::pentagons) fan_.start.push_back(last_leaving(fan_.mesh, fan_.start[0]));
    std::vector<char> seen(fan_.mesh.face_count(), 0);
    const auto add = [&](int from, int to) {
        const auto corners = fan_.mesh.corners(fan_.mesh.face(to));
        if (std::exchange(seen[fan_.mesh.face(to)], 1) != 0) return;
        if (std::ranges::none_of(corners, [&](int v) { return number_[v] < 0; })) faces_.push_back({from, to});
    };
    for (std::size_t s = 0; s < fan_.start.size(); ++s) add(-1 - static_cast<int>(s), fan_.start[s]);
    for (std::size_t i = 0; i < faces_.size(); ++i)
        for (int h = fan_.mesh.next(faces_[i].to); h != faces_[i].to; h = fan_.mesh.next(h))
            if (fan_.mesh.twin(h) != RuleMesh::none) add(h, fan_.mesh.twin(h));
}

std::vector<int> FanSearch::find(const RuleMesh& mesh, std::span<const int> start) const {
    std::vector<int> found(labels.size(), -1), at(fan_.mesh.halfedge_count());
    const auto see = [&](int label, int v) {
        if (found[label] >= 0 && found[label] != v) throw std::logic_error("the mesh around the vertex is no lattice");
        found[label] = v;
    };
    if (labels.lattice() != FanLattice::dual) see(0, mesh.origin(start[0]));
    for (const auto& [from, to] : faces_) {
        const std::size_t s = from < 0 ? static_cast<std::size_t>(-1 - from) : 0;
        int there = from >= 0 ? mesh.twin(at[from]) : s < start.size() ? start[s] : last_leaving(mesh, start[0]);
        if (there == RuleMesh::none) throw std::logic_error("the fan is larger than the mesh");
        if (mesh.face_size(mesh.face(there)) != fan_.mesh.face_size(fan_.mesh.face(to)))
            throw std::logic_error("the faces around the vertex are not those of the lattice");
        int h = to;
        do {
            at[h] = there;
            see(number_[fan_.mesh.origin(h)], mesh.origin(there));
            h = fan_.mesh.next(h);
            there = mesh.next(there);
        } while (h != to);
    }
    return found;
}

int crease_end_halfedge(const RuleMesh& fine, int along) {
    const int inwards = fine.twin(fine.prev(along));
    return inwards == RuleMesh::none ? inwards : fine.prev(inwards);
}

std::vector<int> child_start(const SectorFan& fan, const RuleStep& step) {
    // In honeycomb's steps old vertices keep their numbers.
    if (fan.labels.lattice() == FanLattice::pentagons) return {step.mesh.first(fan.mesh.origin(fan.start[0]))};
    if (fan.labels.shape().boundary && !step.child_crease.empty()) {
        const int along = step.child_crease[fan.start[0]];
        if (fan.labels.lattice() == FanLattice::dual) return {along};
        return {crease_end_halfedge(step.mesh, along)};
    }
    std::vector<int> result;
    for (const int h : fan.start) result.push_back(step.child_halfedge[h]);
    return result;
}

}  // namespace tetrakis
