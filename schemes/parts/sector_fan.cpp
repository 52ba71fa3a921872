#include "sector_fan.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>
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
        // The two faces in the order of their corners; beyond them a face of six corners between.
        constexpr std::pair<int, int> beside[] = {{1, 0}, {2, 0}, {2, 1}, {0, 1}};
        for (const auto& [a, b] : beside)
            for (int s = 0; s < 2 && rings >= 1; ++s) labels_.push_back({s, a, b});
        for (const FanLabel l : {FanLabel{0, 0, 2}, FanLabel{1, 0, 2}, FanLabel{0, 0, 3}})
            if (rings >= 2) labels_.push_back(l);
        for (int i = 0; i < size(); ++i) number_[labels_[i]] = i;
        return;
    }
    struct Place {
        int ring, a, b;
    };
    std::vector<Place> places;
    const int most = rings + (dual && shape.boundary ? 1 : 0);
    for (int a = dual ? 0 : 1; a <= rings; ++a)
        for (int b = 0; b <= most; ++b) {
            const int ring = ring_of({0, a, b});
            if (ring <= rings) places.push_back({ring, a, b});
        }
    std::sort(places.begin(), places.end(), [](const Place& x, const Place& y) {
        return std::tuple(x.ring, x.b, -x.a) < std::tuple(y.ring, y.b, -y.a);
    });
    for (const Place& p : places) {
        const int sectors = dual ? (shape.boundary ? 2 : n) : shape.boundary && p.b == 0 ? n + 1 : n;
        for (int s = 0; s < sectors; ++s) labels_.push_back({s, p.a, p.b});
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
    if (shape_.boundary)
        return canonical(label.b == 0 ? FanLabel{n - label.sector, label.a, 0}
                                      : FanLabel{n - 1 - label.sector, label.b, label.a});
    return canonical(label.b == 0 ? FanLabel{n - label.sector, label.a, 0}
                                  : FanLabel{2 * n - 1 - label.sector, label.b, label.a});
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
            // Beyond the side from corner s - 1 to corner s, then the quads of the corner itself.
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

/// Where two triangles share two edges, their third ones have the same ends and yet are two edges: those of each sector
/// belong together, which the ends do not tell.
std::vector<int> twins_of_two_triangles(const std::vector<std::tuple<int, int, int>>& halfedges) {
    std::map<std::tuple<int, int, int>, int> number;
    for (std::size_t h = 0; h < halfedges.size(); ++h) number[halfedges[h]] = static_cast<int>(h);
    std::vector<int> twins;
    for (const auto& [from, to, sector] : halfedges) {
        const auto twin = number.find({to, from, sector});
        twins.push_back(twin == number.end() ? RuleMesh::none : twin->second);
    }
    return twins;
}

RuleMesh fan_mesh(const FanLabels& labels) {
    const FanShape& shape = labels.shape();
    RuleMesh::Builder faces;
    std::vector<double> angles;
    const bool two_triangles = labels.lattice() == FanLattice::triangles && !shape.boundary && shape.faces == 2;
    std::vector<std::tuple<int, int, int>> halfedges;  // of two triangles: ends; the sector where they do not tell
    const auto face = [&](const std::vector<FanLabel>& corners) {
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const int v = labels.find(corners[i]);
            const FanLabel from = labels.all()[v], to = labels.canonical(corners[(i + 1) % corners.size()]);
            // The centre counts as a place on every ray; its own sector is 0.
            const bool on_first_ray = from.sector == 0 && to.sector == 0 && from.b == 0 && to.b == 0;
            faces.corner(v, shape.dart && on_first_ray ? k_infinite : 0.0f);
            angles.push_back(v == 0 ? shape.angle : 0);
            if (two_triangles) {
                const bool in_both = from.a == 1 && from.b == 0 && to.a == 1 && to.b == 0;
                halfedges.emplace_back(v, labels.find(to), in_both ? corners[0].sector : 0);
            }
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
    if (two_triangles) faces.set_twins(twins_of_two_triangles(halfedges));
    std::vector<float> sharpness;
    if (shape.corner) {
        sharpness.assign(labels.size(), 0.0f);
        sharpness[0] = k_infinite;
        if (shape.angle != 0) faces.set_corner_angles(std::move(angles));
    }
    return RuleMesh(labels.size(), std::move(faces), std::move(sharpness));
}

/// Walks a mesh from half-edge to half-edge; leaving it is an error.
struct Walk {
    const RuleMesh& mesh;

    int across(int h) const {
        if (mesh.twin(h) == RuleMesh::none) throw std::logic_error("the fan is larger than the mesh");
        return mesh.twin(h);
    }
    int next(int h) const { return mesh.next(h); }
    int prev(int h) const { return mesh.prev(h); }
};

}  // namespace

SectorFan::SectorFan(FanLattice lattice, const FanShape& shape, int rings)
    : labels(lattice, shape, rings), mesh(fan_mesh(labels)) {
    std::vector<std::pair<int, int>> edges;  // to start from: their ends
    const auto add = [&](FanLabel from, FanLabel to) { edges.emplace_back(labels.find(from), labels.find(to)); };
    const int n = shape.faces;
    if (lattice == FanLattice::dual && shape.boundary)
        add({1, 0, 0}, {0, 0, 0});
    else if (lattice == FanLattice::pentagons)
        add({}, {0, 1, 0});
    else
        for (int s = 0; s < n; ++s)
            lattice == FanLattice::dual ? add({s, 0, 0}, {(s + 1) % n, 0, 0}) : add({}, {s, 1, 0});
    std::map<std::pair<int, int>, std::size_t> number;
    for (std::size_t i = 0; i < edges.size(); ++i) number[edges[i]] = i;
    start.assign(edges.size(), RuleMesh::none);
    for (int h = 0; h < mesh.halfedge_count(); ++h)
        if (const auto at = number.find({mesh.origin(h), mesh.target(h)});
            at != number.end() && start[at->second] == RuleMesh::none)
            start[at->second] = h;
    if (std::find(start.begin(), start.end(), RuleMesh::none) != start.end())
        throw std::logic_error("a fan without one of its edges");
}

std::vector<int> find_fan(const RuleMesh& mesh, std::span<const int> start, const FanLabels& labels) {
    const Walk walk{mesh};
    std::vector<int> found(labels.size(), -1);
    const auto see = [&](FanLabel label, int v) {
        const int i = labels.find(label);
        if (i < 0) return;
        if (found[i] >= 0 && found[i] != v) throw std::logic_error("the mesh around the vertex is no lattice");
        found[i] = v;
    };
    const int R = labels.rings(), n = labels.shape().faces;
    const bool dual = labels.lattice() == FanLattice::dual;
    if (labels.lattice() == FanLattice::pentagons) {
        const int ahead = start[0];
        int behind = ahead;
        while (mesh.twin(mesh.prev(behind)) != RuleMesh::none) behind = mesh.twin(mesh.prev(behind));
        if (mesh.face_size(mesh.face(ahead)) != 5 || mesh.face_size(mesh.face(behind)) != 5)
            throw std::logic_error("the faces along the boundary are no pentagons");
        see({}, mesh.origin(ahead));
        constexpr std::pair<int, int> corners[] = {{1, 0}, {2, 0}, {2, 1}, {0, 1}};
        int h = ahead, back = behind;
        for (const auto& [a, b] : corners) {
            see({0, a, b}, mesh.target(h));
            back = mesh.prev(back);
            see({1, a, b}, mesh.origin(back));
            h = mesh.next(h);
        }
    } else if (dual && labels.shape().boundary) {
        for (const bool ahead : {true, false}) {
            int column = start[0];
            for (int a = 0; a <= R; ++a) {
                int h = column;  // the bottom of a quad of this column
                for (int b = 0; b <= R; ++b) {
                    const int top = walk.next(walk.next(h));
                    see({ahead ? 0 : 1, a, b}, ahead ? mesh.target(h) : mesh.origin(h));
                    see({ahead ? 0 : 1, a, b + 1}, ahead ? mesh.origin(top) : mesh.target(top));
                    if (b < R) h = walk.across(top);
                }
                if (a < R)
                    column =
                        ahead ? walk.next(walk.across(walk.next(column))) : walk.prev(walk.across(walk.prev(column)));
            }
        }
    } else if (labels.shape().hexagons) {
        for (int s = 0; s < n; ++s) {
            see({s, 0, 0}, mesh.origin(start[s]));
            int h = walk.across(start[s]);
            if (mesh.face_size(mesh.face(h)) != 6) throw std::logic_error("the faces around a face are no hexagons");
            for (const FanLabel label : {FanLabel{s, 1, 1}, {s, 0, 1}, {(s + 1) % n, 1, 0}}) {
                h = walk.next(h);
                see(label, mesh.target(h));
            }
        }
    } else if (dual) {
        for (int s = 0; s < n; ++s) {
            const int side = start[(s + n - 1) % n];  // from corner s - 1 to corner s
            see({s, 0, 0}, mesh.target(side));
            if (R == 0) continue;
            int x = walk.across(mesh.prev(walk.across(side)));  // from (s, 0, 0) to (s, 1, 0)
            for (int a = 0; a <= R; ++a) {
                see({s, a, 0}, mesh.origin(x));
                int y = walk.across(walk.prev(x));  // from (s, a, 0) to (s, a, 1)
                for (int b = 1; b <= R; ++b) {
                    see({s, a, b}, mesh.target(y));
                    if (b < R) y = walk.next(walk.across(walk.next(y)));
                }
                if (a < R) x = walk.next(walk.across(walk.next(x)));
            }
        }
    } else if (labels.lattice() == FanLattice::quads) {
        see({}, mesh.origin(start[0]));
        for (int s = 0; s < n; ++s) {
            int row = start[s];  // from (s, 0, b) to (s, 1, b), faces on the left
            for (int b = 0; b < R; ++b) {
                int h = row;
                for (int a = 0; a < R; ++a) {
                    see({s, a, b}, mesh.origin(h));
                    see({s, a + 1, b}, mesh.target(h));
                    const int top = walk.next(walk.next(h));
                    see({s, a + 1, b + 1}, mesh.origin(top));
                    see({s, a, b + 1}, mesh.target(top));
                    if (a + 1 < R) h = walk.next(walk.across(walk.next(h)));
                }
                if (b + 1 < R) row = walk.across(walk.next(walk.next(row)));
            }
        }
    } else {
        see({}, mesh.origin(start[0]));
        for (int s = 0; s < n; ++s) {
            int row = start[s];
            for (int b = 0; b < R; ++b) {
                int h = row;
                for (int a = 0; a + b < R; ++a) {
                    see({s, a, b}, mesh.origin(h));
                    see({s, a + 1, b}, mesh.target(h));
                    see({s, a, b + 1}, mesh.origin(mesh.prev(h)));
                    // The triangle across the third side, upside down, leads on along the row.
                    if (a + b + 1 < R) h = walk.next(walk.across(walk.next(walk.across(walk.next(h)))));
                }
                if (b + 1 < R) row = walk.across(walk.next(walk.next(walk.across(walk.next(row)))));
            }
        }
    }
    if (std::find(found.begin(), found.end(), -1) != found.end())
        throw std::logic_error("the fan is larger than the mesh");
    return found;
}

int crease_end_halfedge(const RuleMesh& fine, int along) {
    const int inwards = fine.twin(fine.prev(along));
    return inwards == RuleMesh::none ? inwards : fine.prev(inwards);
}

std::vector<int> child_start(const SectorFan& fan, const RuleStep& step) {
    // Old vertices keep their numbers there.
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
