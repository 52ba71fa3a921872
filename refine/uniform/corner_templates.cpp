#include "corner_templates.hpp"

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <span>
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

/// Twins of the half-edges of faces in two roots: an edge of each may lie between the same vertices.
std::vector<int> twins_of_two_roots(const RootLattices::Faces& faces) {
    struct Edge {
        std::uint32_t root, from, to;
        auto operator<=>(const Edge&) const = default;
    };
    std::vector<int> twins(faces.vertices.size(), RuleMesh::none);
    std::map<Edge, int> open;
    const auto pair_with = [&](const Edge& other, int h) {
        const auto at = open.find(other);
        if (at == open.end()) return false;
        twins[static_cast<std::size_t>(h)] = at->second;
        twins[static_cast<std::size_t>(at->second)] = h;
        open.erase(at);
        return true;
    };
    for (std::size_t f = 0; f + 1 < faces.offsets.size(); ++f)
        for (std::uint32_t c = faces.offsets[f]; c < faces.offsets[f + 1]; ++c) {
            const std::uint32_t a = faces.vertices[c], root = faces.control[f],
                                b = faces.vertices[c + 1 == faces.offsets[f + 1] ? faces.offsets[f] : c + 1];
            if (!pair_with({root, b, a}, static_cast<int>(c))) open[{root, a, b}] = static_cast<int>(c);
        }
    const std::map<Edge, int> sides = open;
    for (const auto& [edge, h] : sides)
        if (edge.root == 0 && pair_with({1, edge.to, edge.from}, h)) open.erase(edge);
    return twins;
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
        std::uint32_t h = first;
        do {
            around.push_back(h);
            h = base.twin[base.prev(h)];
        } while (h != RootLattices::none && h != first);
        found.closed = h == first;
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

CornerTemplate::CornerTemplate(const CornerKind& kind, std::uint32_t sides, bool in_cells, std::uint32_t segments)
    : kind_(kind), segments_(segments), net_(RootLattices::of_template(base_of(kind, sides), in_cells)) {
    if (in_cells)
        make_cells();
    else
        make_lattice();
}

void CornerTemplate::make_lattice() {
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
    const auto sharpness = [&](std::uint32_t a, std::uint32_t b) {
        const int at_a = spoke[a], at_b = spoke[b], on = a == 0 ? at_b : at_a;
        const bool along = a == 0 || b == 0 || at_a == at_b;
        return along && on >= 0 ? kind_.sharp[static_cast<std::size_t>(on)] : 0.0f;
    };
    RuleMesh::Builder builder;
    std::vector<double> angles;
    for (std::size_t f = 0; f + 1 < faces.offsets.size(); ++f) {
        const std::uint32_t begin = faces.offsets[f], end = faces.offsets[f + 1];
        for (std::uint32_t c = begin; c < end; ++c) {
            const std::uint32_t a = faces.vertices[c], b = faces.vertices[c + 1 == end ? begin : c + 1];
            builder.corner(static_cast<int>(a), sharpness(a, b));
            if (!kind_.angle.empty()) angles.push_back(a == 0 ? kind_.angle[faces.control[f]] : 0);
        }
        builder.end_face();
    }
    builder.set_corner_angles(std::move(angles));
    if (kind_.closed && kind_.roots() == 2) builder.set_twins(twins_of_two_roots(faces));
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

/// Faces around the points between cells, each corner with the place of its cell's quarter there.
void CornerTemplate::make_cells() {
    const MeshLevel& base = net_.base();
    const std::uint32_t n = segments_;
    const RootLayout coarse = net_.layout(n), fine = net_.layout(2 * n);
    RuleMesh::Builder builder;
    std::vector<std::uint32_t> corners;
    // The quarter of cell (a, b) seen from half-edge h that lies up or down along a and b.
    const auto corner = [&](std::uint32_t h, std::uint32_t a, std::uint32_t b, std::uint32_t up_a, std::uint32_t up_b) {
        corners.push_back(first_place(net_.number(coarse, h, a, b)));
        child_place_.push_back(net_.number(fine, h, 2 * a + up_a, 2 * b + up_b));
    };
    // A crease that ends inside: the first cells of the first root, and the corner of that between both sides.
    const auto on_crease = [&](std::uint32_t place) {
        const bool along = kind_.roots() == 3 && place < n;
        return kind_.crease_end && (along || place == net_.number_at(coarse, 1, {0, 0}) ||
                                    (kind_.closed && place == net_.number_at(coarse, 0, {0, 0})));
    };
    const auto end_face = [&] {
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const bool sharp = on_crease(corners[i]) && on_crease(corners[(i + 1) % corners.size()]);
            builder.corner(static_cast<int>(corners[i]), sharp ? k_sharpness_infinity : 0.0f);
        }
        builder.end_face();
        corners.clear();
    };
    for (std::uint32_t i = 0; i < kind_.roots(); ++i)
        for (std::uint32_t y = 0; y + 1 < n; ++y)
            for (std::uint32_t x = 0; x + 1 < n; ++x) {
                corner(halfedge(i), x, y, 1, 1);
                corner(halfedge(i), x + 1, y, 0, 1);
                corner(halfedge(i), x + 1, y + 1, 0, 0);
                corner(halfedge(i), x, y + 1, 1, 0);
                end_face();
            }
    net_.for_each_inner_edge([&](std::uint32_t h) {
        const std::uint32_t t = base.twin[h];
        for (std::uint32_t j = 1; j < n; ++j) {
            corner(t, n - j, 0, 0, 0);
            corner(t, n - 1 - j, 0, 1, 0);
            corner(h, j, 0, 0, 0);
            corner(h, j - 1, 0, 1, 0);
            end_face();
        }
    });
    if (kind_.closed && !kind_.crease_end) {
        for (std::uint32_t i = 0; i < kind_.roots(); ++i) corner(halfedge(i), 0, 0, 0, 0);
        end_face();
    }
    const std::uint32_t count = net_.place_count(coarse);
    std::vector<float> sharpness;
    if (!kind_.closed && kind_.roots() == 1) {
        // The tip of a corner.
        sharpness.assign(count, 0.0f);
        sharpness[net_.number(coarse, 0, 0, 0)] = k_sharpness_infinity;
    }
    mesh_ = RuleMesh(static_cast<int>(count), std::move(builder), std::move(sharpness));
}

/// Where a crease ends inside, the points on it belong to its first side.
std::uint32_t CornerTemplate::first_of(const RootLayout& at, std::uint32_t place) const {
    if (!kind_.crease_end || kind_.roots() != 3) return place;
    const std::uint32_t n = at.segments(), second = net_.number_at(at, 2, {0, 0});
    return place >= second && place % n == 0 ? (place - second) / n : place;
}

std::uint32_t CornerTemplate::other_place(std::uint32_t place) const {
    const std::uint32_t first = first_place(place);
    if (first != place) return first;
    const bool shared = kind_.crease_end && kind_.roots() == 3 && place < segments_;
    return shared ? net_.number_at(net_.layout(segments_), 2, {0, place}) : place;
}

std::optional<CornerTemplate::Step> CornerTemplate::step(const SchemeInfo& scheme, const RuleOptions& rules,
                                                         std::uint32_t factor) const {
    RuleStep step = scheme.step(mesh_, rules);
    std::optional<std::vector<int>> row;
    if (kind_.crease_end) {
        row = rows_of_crease_end(step);
    } else if (net_.in_cells()) {
        row = rows_of_cells(step.mesh);
    } else {
        std::vector<int> first = first_;
        for (int& h : first) h = step.child_halfedge[static_cast<std::size_t>(h)];
        if (std::find(first.begin(), first.end(), RuleMesh::none) != first.end()) return std::nullopt;
        row = net_.vertices(net_.layout(factor * segments_), step.mesh, first);
    }
    if (!row) return std::nullopt;
    return Step{std::move(step.stencils), std::move(*row)};
}

/// The points of a crease lie one cell further out than the children of the corners beside it.
std::vector<int> CornerTemplate::rows_of_crease_end(const RuleStep& step) const {
    const RootLayout fine = net_.layout(2 * segments_);
    const std::uint32_t n = fine.segments();
    std::vector<int> row(net_.place_count(fine), -1);
    for (std::size_t h = 0; h < child_place_.size(); ++h) row[child_place_[h]] = static_cast<int>(h);
    const auto outwards = [&](int h) {
        const std::uint32_t child = child_place_[static_cast<std::size_t>(h)], root = child / (n * n);
        const bool whole = kind_.roots() == 3;
        return whole && root == 0 ? child - n : whole && root == 2 ? child - 1 : net_.number_at(fine, root, {0, 0});
    };
    for (int h = 0; h < mesh_.halfedge_count(); ++h) {
        if (!mesh_.sharp(h) || mesh_.twin(h) == RuleMesh::none) continue;
        const int crease = step.child_crease[static_cast<std::size_t>(h)];
        row[outwards(h)] = step.mesh.origin(crease);
        row[outwards(mesh_.next(h))] = step.mesh.target(crease);
    }
    for (std::uint32_t place = 0; place < row.size(); ++place)
        if (const std::uint32_t first = first_of(fine, place); first != place) row[place] = row[first];
    return row;
}

/// The first points are the children of the corners. What else there is lies along the ends of open roots, whose
/// cells make one lattice: it is found from them, face by face.
std::optional<std::vector<int>> CornerTemplate::rows_of_cells(const RuleMesh& finer) const {
    const RootLayout fine = net_.layout(2 * segments_);
    std::vector<int> row(net_.place_count(fine), -1);
    if (finer.vertex_count() < static_cast<int>(child_place_.size())) return std::nullopt;
    for (std::size_t h = 0; h < child_place_.size(); ++h) row[child_place_[h]] = static_cast<int>(h);
    if (kind_.closed) return row;
    if (kind_.roots() > 2) return std::nullopt;
    struct Place {
        int x, y;
        bool known = false;
    };
    const auto n = static_cast<int>(2 * segments_), cells = n * n;
    std::vector<Place> place(static_cast<std::size_t>(finer.vertex_count()));
    for (std::size_t h = 0; h < child_place_.size(); ++h) {
        const auto at = static_cast<int>(child_place_[h]), x = at % n, y = at / n % n;
        place[h] = at < cells ? Place{x, y, true} : Place{-y - 1, x, true};
    }
    for (bool again = true; again;) {
        again = false;
        for (int h = 0; h < finer.halfedge_count(); ++h) {
            if (finer.face_size(finer.face(h)) != 4) continue;
            // On from an edge: two corners more, to its left.
            const int third = finer.next(finer.next(h));
            const Place p = place[static_cast<std::size_t>(finer.origin(h))],
                        q = place[static_cast<std::size_t>(finer.target(h))];
            if (!p.known || !q.known) continue;
            const int left_x = p.y - q.y, left_y = q.x - p.x;
            Place &r = place[static_cast<std::size_t>(finer.origin(third))],
                  &s = place[static_cast<std::size_t>(finer.target(third))];
            again = again || !r.known || !s.known;
            if (!r.known) r = {q.x + left_x, q.y + left_y, true};
            if (!s.known) s = {p.x + left_x, p.y + left_y, true};
        }
    }
    for (std::size_t v = 0; v < place.size(); ++v) {
        const Place& p = place[v];
        const bool second = p.x < 0;
        const int x = second ? p.y : p.x, y = second ? -p.x - 1 : p.y;
        if (!p.known || (second && kind_.roots() < 2) || x < 0 || y < 0 || x >= n || y >= n) continue;
        row[static_cast<std::size_t>((second ? cells : 0) + y * n + x)] = static_cast<int>(v);
    }
    return row;
}

}  // namespace tetrakis::detail
