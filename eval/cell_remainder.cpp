#include "tetrakis/eval/cell_remainder.hpp"

#include "tetrakis/schemes/modified_butterfly.hpp"
#include "tetrakis/schemes/sector_fan.hpp"
#include "tetrakis/schemes/stencil_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

// Levels that a weight is looked at directly; below them it is a sum of others.
constexpr int k_levels = 3;
// Weights and sums of rounding errors alone.
constexpr double k_nothing = 1e-11;
// The iteration: it ends where nothing changes by more than this, and has failed where weights grow or creep.
constexpr double k_settled = 1e-10, k_most_weight = 1e3;
constexpr int k_most_rounds = 400;
// Added to what the iteration approaches from below: a hundred times its last change.
constexpr double k_beyond = 1e-8;
constexpr double k_infinite = std::numeric_limits<double>::infinity();

using Coordinates = std::array<double, 2>;

std::array<double, 4> affine(const Coordinates& p, int corners) {
    if (corners == 3) return {1 - p[0] - p[1], p[0], p[1], 0};
    return {1 - p[0] - p[1], p[0], 0, p[1]};
}
std::array<double, 4> bilinear(const Coordinates& p) {
    const double x = p[0], y = p[1];
    return {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
}
std::array<double, 4> hats(const Coordinates& p, int corners) {
    return corners == 3 ? affine(p, corners) : bilinear(p);
}
std::array<Coordinates, 4> unit_cell(int corners) {
    if (corners == 3) return {{{0, 0}, {1, 0}, {0, 1}, {0, 0}}};
    return {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
}
Coordinates middle(const Coordinates& a, const Coordinates& b) { return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2}; }

/// A cell some levels down, and where its corners are in the first one's coordinates.
struct SmallCell {
    CellFrame frame;
    std::array<Coordinates, 4> at;
};

SmallCell child_of(const RuleMesh& mesh, const RuleStep& step, const SmallCell& cell, int child, int n) {
    SmallCell result{n == 3 ? triangle_child(mesh, step, cell.frame, child) : quad_child(mesh, step, cell.frame, child),
                     cell.at};
    if (n == 3) {
        for (int k = 0; k < 3; ++k)
            result.at[k] =
                child < 3 ? middle(cell.at[k], cell.at[child]) : middle(cell.at[(k + 1) % 3], cell.at[(k + 2) % 3]);
        return result;
    }
    for (int k = 0; k < 4; ++k) result.at[k] = middle(cell.at[k], cell.at[child]);
    return result;
}

/// Where a lattice that goes on from the first face has its vertices: face by face across edges.
std::vector<Coordinates> unrolled(const RuleMesh& mesh, int corners) {
    std::vector<Coordinates> at(mesh.vertex_count());
    std::vector<char> seen(mesh.vertex_count(), 0), entered(mesh.face_count(), 0);
    const std::array<Coordinates, 4> first = unit_cell(corners);
    for (int k = 0; k < corners; ++k) {
        at[mesh.origin(k)] = first[k];
        seen[mesh.origin(k)] = 1;
    }
    std::vector<std::pair<int, std::array<Coordinates, 4>>> queue{{0, first}};  // a half-edge, and its face from there
    entered[0] = 1;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const auto [h, cell] = queue[i];
        int side = h;
        for (int k = 0; k < corners; ++k, side = mesh.next(side)) {
            const int t = mesh.twin(side);
            if (t == RuleMesh::none || entered[mesh.face(t)]) continue;
            entered[mesh.face(t)] = 1;
            const Coordinates &a = cell[k], &b = cell[(k + 1) % corners];
            const auto beyond = [&](const Coordinates& base, const Coordinates& inner, const Coordinates& other) {
                return Coordinates{base[0] + other[0] - inner[0], base[1] + other[1] - inner[1]};
            };
            // The twin leaves b.
            std::array<Coordinates, 4> next{b, a};
            if (corners == 3) {
                next[2] = beyond(a, cell[(k + 2) % 3], b);
            } else {
                next[2] = beyond(a, cell[(k + 3) % 4], a);
                next[3] = beyond(b, cell[(k + 2) % 4], b);
            }
            int at_corner = t;
            for (int c = 0; c < corners; ++c, at_corner = mesh.next(at_corner))
                if (!std::exchange(seen[mesh.origin(at_corner)], 1)) at[mesh.origin(at_corner)] = next[c];
            queue.emplace_back(t, next);
        }
    }
    return at;
}

bool annihilates(std::span<const double> functional, const std::vector<std::array<double, 4>>& anchor) {
    std::array<double, 4> sum{};
    double size = 1;
    for (std::size_t i = 0; i < functional.size(); ++i) {
        size += std::abs(functional[i]);
        for (int k = 0; k < 4; ++k) sum[k] += functional[i] * anchor[i][k];
    }
    return std::all_of(sum.begin(), sum.end(), [&](double s) { return std::abs(s) < k_nothing * size; });
}

}  // namespace

/// A kind of surroundings on the way to its weights.
struct CellRemainder::Draft {
    int points = 0;
    std::vector<std::array<double, 4>> anchor;  // of all points
    std::vector<double> direct;                 // per point: of its basis function, k_levels down, without the hat
    std::vector<int> active;
    std::vector<double> weight;
    std::vector<double> rows;  // of the vertices k_levels down, dense
    struct Child {
        Key key;
        std::vector<int> vertices;
        /// Per active point of the child: how far it is from where the child's corners would have it, as a combination
        /// of the same of the parent's points; sizes of weights.
        std::vector<std::vector<std::pair<int, double>>> offsets;
        const std::vector<double>* weight = nullptr;  ///< of these points
    };
    std::vector<Child> children;
    bool none = false;  // there are no weights

    std::vector<std::array<double, 4>> constant() const {
        return std::vector<std::array<double, 4>>(points, {1, 0, 0, 0});
    }
    std::span<const double> row(int v) const {
        return {rows.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(points),
                static_cast<std::size_t>(points)};
    }
    /// Points that are where the corners would have them whatever they are.
    bool free(int i) const {
        for (int k = 0; k < 4; ++k)
            if (anchor[i][k] != (k == i ? 1.0 : 0.0)) return true;
        return false;
    }
};

CellRemainder::CellRemainder(const SchemeInfo& scheme, const RuleOptions& options)
    : scheme_(scheme), options_(options), corners_(scheme.family == MeshFamily::triangles ? 3 : 4) {
    // Rules of edges look two rings around a cell; Kobbelt's virtual points add theirs one further out.
    rings_ = scheme.step == modified_butterfly_step || scheme.step == butterfly_step ? 2 : 3;
    const Key key = key_of({.faces = corners_ == 3 ? 6 : 4});
    regular_ = norms(key);
    if (regular_ != nullptr) regular_walk_ = walk_of(key, *regular_);
}

CellRemainder::~CellRemainder() = default;

CellRemainder::Key CellRemainder::key_of(const FanShape& shape) const {
    // Beyond the rings around the cell one more, so that the fan's own end is out of sight.
    const SectorFan fan(corners_ == 3 ? FanLattice::triangles : FanLattice::quads, shape, rings_ + 2);
    MeshPartFinder parts;
    return surroundings(fan.mesh, fan.start[0], parts)->key;
}

std::optional<CellRemainder::Total> CellRemainder::total(const FanShape& shape) const {
    const Norms* const found = norms(key_of(shape));
    if (found == nullptr) return std::nullopt;
    Total total{0, false};
    for (const double w : found->weight) total.sum += w;
    for (const std::array<double, 4>& a : found->anchor) total.linear = total.linear || a[0] != 1;
    return total;
}

std::optional<CellRemainder::Surroundings> CellRemainder::surroundings(const RuleMesh& mesh, int halfedge,
                                                                       MeshPartFinder& parts) const {
    std::vector<int> seeds;
    for (const int v : mesh.corners(mesh.face(halfedge))) seeds.push_back(v);
    const MeshPart part = parts.find(mesh, seeds, rings_);
    const RuleMesh& here = part.mesh;
    for (int h = 0; h < here.halfedge_count(); ++h)
        if (is_semi_sharp(here.sharpness(h)) || is_semi_sharp(here.vertex_sharpness(here.origin(h))))
            return std::nullopt;
    Surroundings result;
    std::vector<int> number(here.vertex_count(), -1), entry{part.halfedge(mesh, halfedge)};
    std::vector<char> entered(here.face_count(), 0);
    entered[here.face(entry[0])] = 1;
    Key& key = result.key;
    for (std::size_t i = 0; i < entry.size(); ++i) {
        int h = entry[i];
        key.push_back(-here.face_size(here.face(h)));
        do {
            const int v = here.origin(h), t = here.twin(h);
            if (number[v] < 0) {
                number[v] = static_cast<int>(result.vertices.size());
                result.vertices.push_back(part.vertex[v]);
            }
            // Inner edges alone: a part's own end is sharp, too.
            const bool sharp = t != RuleMesh::none && is_sharp(here.sharpness(h));
            key.push_back(2 * number[v] + (sharp ? 1 : 0));
            if (t != RuleMesh::none && !std::exchange(entered[here.face(t)], 1)) entry.push_back(t);
            h = here.next(h);
        } while (h != entry[i]);
    }
    if (entry.size() != static_cast<std::size_t>(here.face_count())) return std::nullopt;  // in pieces
    constexpr int k_corners = std::numeric_limits<int>::min();
    key.push_back(k_corners);
    for (std::size_t v = 0; v < number.size(); ++v)
        if (is_sharp(here.vertex_sharpness(static_cast<int>(v)))) key.push_back(number[v]);
    std::sort(std::find(key.begin(), key.end(), k_corners) + 1, key.end());
    return result;
}

RuleMesh CellRemainder::mesh_of(const Key& key) const {
    RuleMesh::Builder faces;
    int vertices = 0;
    std::size_t i = 0;
    for (; key[i] != std::numeric_limits<int>::min();) {
        const int size = -key[i++];
        for (int c = 0; c < size; ++c, ++i) {
            faces.corner(key[i] / 2, key[i] % 2 != 0 ? std::numeric_limits<float>::infinity() : 0.0f);
            vertices = std::max(vertices, key[i] / 2 + 1);
        }
        faces.end_face();
    }
    std::vector<float> sharpness(vertices, 0.0f);
    for (++i; i < key.size(); ++i) sharpness[key[i]] = std::numeric_limits<float>::infinity();
    return RuleMesh(vertices, std::move(faces), std::move(sharpness));
}

bool CellRemainder::is_regular(const RuleMesh& mesh, int vertex) const {
    const int valence = corners_ == 3 ? 6 : 4;
    const RuleMesh::Ring ring = mesh.ring(vertex);
    switch (mesh.rule(vertex)) {
        case VertexRule::smooth:
            return ring.closed && ring.edges() == valence;
        case VertexRule::crease: {
            if (!ring.closed) return ring.faces() == valence / 2;
            if (ring.edges() != valence) return false;
            for (int i = 0; i < valence; ++i)
                if (is_sharp(ring.sharpness[i])) return is_sharp(ring.sharpness[(i + valence / 2) % valence]);
            return false;
        }
        default:
            return false;
    }
}

/// Cells only, and no more than one extraordinary point among the vertices whose surroundings are whole.
bool CellRemainder::is_simple(const RuleMesh& mesh) const {
    if (!mesh.all_faces_have(corners_)) return false;
    std::vector<int> ring(mesh.vertex_count(), -1), front;
    for (const int v : mesh.corners(0)) {
        ring[v] = 0;
        front.push_back(v);
    }
    int special = 0;
    for (std::size_t i = 0; i < front.size(); ++i) {
        const int v = front[i];
        if (ring[v] >= rings_) break;
        special += is_regular(mesh, v) ? 0 : 1;
        const RuleMesh::Ring around = mesh.ring(v);
        for (const int h : around.halfedge)
            for (const int w : mesh.corners(mesh.face(h)))
                if (ring[w] < 0) {
                    ring[w] = ring[v] + 1;
                    front.push_back(w);
                }
    }
    return special <= 1;
}

CellRemainder::Draft CellRemainder::draft(const Key& key) const {
    Draft draft;
    RuleMesh mesh;
    try {
        mesh = mesh_of(key);
    } catch (const std::invalid_argument&) {
        draft.none = true;  // a part that ends in another way than a mesh
        return draft;
    }
    if (!is_simple(mesh)) {
        draft.none = true;
        return draft;
    }
    const int n = mesh.vertex_count();
    draft.points = n;
    const std::vector<Coordinates> at = unrolled(mesh, corners_);
    StencilTable rows;
    for (int v = 0; v < n; ++v) rows.push({{v, 1}});
    std::vector<SmallCell> cells{{{0, 0}, unit_cell(corners_)}};
    MeshPartFinder parts;
    for (int level = 0; level < k_levels; ++level) {
        std::vector<int> seeds;
        for (const SmallCell& c : cells)
            for (const int v : mesh.corners(mesh.face(c.frame.halfedge))) seeds.push_back(v);
        const MeshPart part = parts.find(mesh, seeds, rings_);
        StencilTable kept;
        for (const int v : part.vertex) kept.push(rows.row(v));
        const RuleStep step = scheme_.step(part.mesh, options_);
        std::vector<SmallCell> finer;
        for (SmallCell c : cells) {
            c.frame.halfedge = part.halfedge(mesh, c.frame.halfedge);
            for (int child = 0; child < 4; ++child) finer.push_back(child_of(part.mesh, step, c, child, corners_));
        }
        rows = kept.then(step.stencils);
        mesh = step.mesh;
        cells = std::move(finer);
    }
    draft.rows.assign(static_cast<std::size_t>(rows.row_count()) * static_cast<std::size_t>(n), 0.0);
    for (int v = 0; v < rows.row_count(); ++v)
        for (std::size_t i = 0; i < rows.points(v).size(); ++i)
            draft.rows[static_cast<std::size_t>(v) * static_cast<std::size_t>(n) +
                       static_cast<std::size_t>(rows.points(v)[i])] = rows.weights(v)[i];
    for (const SmallCell& c : cells) {
        std::optional<Surroundings> around = surroundings(mesh, face_corner(mesh, c.frame, 0, corners_), parts);
        if (!around) throw std::logic_error("a small cell has other tags than the large one");
        draft.children.push_back({std::move(around->key), std::move(around->vertices), {}});
    }

    // The vertices of the small cells, without the hats.
    std::vector<std::vector<double>> off;
    for (std::size_t c = 0; c < cells.size(); ++c)
        for (int k = 0; k < corners_; ++k) {
            const std::span<const double> row = draft.row(draft.children[c].vertices[k]);
            off.emplace_back(row.begin(), row.end());
            const std::array<double, 4> hat = hats(cells[c].at[k], corners_);
            for (int i = 0; i < corners_; ++i) off.back()[i] -= hat[i];
        }
    draft.direct.assign(n, 0.0);
    for (const std::vector<double>& f : off)
        for (int i = 0; i < n; ++i) draft.direct[i] = std::max(draft.direct[i], std::abs(f[i]));
    for (int i = 0; i < n; ++i)
        if (i < corners_ || draft.direct[i] > k_nothing) draft.active.push_back(i);
    // The anchor that the rules reproduce.
    const auto reproduces = [&](auto&& anchor) {
        draft.anchor.clear();
        for (int i = 0; i < n; ++i) draft.anchor.push_back(anchor(at[i]));
        return std::all_of(off.begin(), off.end(),
                           [&](const std::vector<double>& f) { return annihilates(f, draft.anchor); });
    };
    // Around many edges a lattice may close after several turns: its points are far from there.
    std::vector<Coordinates> places;
    for (const int i : draft.active) places.push_back(at[i]);
    std::sort(places.begin(), places.end());
    const bool flat = std::adjacent_find(places.begin(), places.end()) == places.end();
    const bool linear = flat && ((corners_ == 4 && reproduces(bilinear)) ||
                                 reproduces([&](const Coordinates& p) { return affine(p, corners_); }));
    if (!linear) draft.anchor = draft.constant();
    return draft;
}

const CellRemainder::Norms* CellRemainder::norms(const Key& key) const {
    {
        const std::shared_lock lock(reading_);
        if (const auto at = known_.find(key); at != known_.end()) return at->second.get();
    }
    const std::lock_guard writer(writing_);
    std::map<Key, Draft> drafts;
    std::vector<Key> queue{key};
    while (!queue.empty()) {
        const Key next = std::move(queue.back());
        queue.pop_back();
        if (known_.contains(next) || drafts.contains(next)) continue;
        const Draft& made = drafts.emplace(next, draft(next)).first->second;
        if (made.none) continue;
        for (const Draft::Child& child : made.children) queue.push_back(child.key);
    }
    solve(drafts);
    const std::unique_lock lock(reading_);
    for (auto& [of, made] : drafts) {
        std::unique_ptr<Norms> result;
        if (!made.none) {
            result = std::make_unique<Norms>();
            for (std::size_t a = 0; a < made.active.size(); ++a) {
                const int i = made.active[a];
                if (!made.free(i)) continue;
                result->point.push_back(i);
                result->weight.push_back(made.weight[a] + k_beyond);
                result->anchor.push_back(made.anchor[i]);
            }
        }
        known_.emplace(of, std::move(result));
    }
    return known_.at(key).get();
}

void CellRemainder::solve(std::map<Key, Draft>& drafts) const {
    // What the children are made of: those of this call are in `drafts`, others are known by their weights.
    struct Made {
        std::vector<int> point;
        std::vector<std::array<double, 4>> anchor;
        const std::vector<double>* weight = nullptr;
    };
    const auto made_of = [&](const Key& key) -> std::optional<Made> {
        Made made;
        if (const auto at = drafts.find(key); at != drafts.end()) {
            if (at->second.none) return std::nullopt;
            made.point = at->second.active;
            for (const int i : made.point) made.anchor.push_back(at->second.anchor[i]);
            made.weight = &at->second.weight;
            return made;
        }
        const Norms* known = known_.at(key).get();
        if (known == nullptr) return std::nullopt;
        made.point = known->point;
        made.anchor = known->anchor;
        made.weight = &known->weight;
        return made;
    };
    /// Visits how far the child's points are from where its corners would have them. False where that is not known from
    /// how far the parent's are from where its own corners would have them.
    const auto for_each_offset = [&](Draft& draft, Draft::Child& child, const Made& made, auto&& visit) {
        std::vector<double> offset;
        for (std::size_t j = 0; j < made.point.size(); ++j) {
            const std::span<const double> row = draft.row(child.vertices[made.point[j]]);
            offset.assign(row.begin(), row.end());
            for (int k = 0; k < corners_; ++k) {
                const double a = made.anchor[j][k];
                if (a == 0) continue;
                const std::span<const double> corner = draft.row(child.vertices[k]);
                for (int i = 0; i < draft.points; ++i) offset[i] -= a * corner[i];
            }
            if (!annihilates(offset, draft.anchor)) return false;
            visit(offset);
        }
        return true;
    };
    // A point that matters to a small cell does to the large one.
    for (bool again = true; again;) {
        again = false;
        for (auto& [key, draft] : drafts) {
            std::vector<char> active(draft.points, 0);
            for (const int i : draft.active) active[i] = 1;
            for (Draft::Child& child : draft.children) {
                const std::optional<Made> made = made_of(child.key);
                draft.none = draft.none || !made;
                if (draft.none) break;
                const bool known = for_each_offset(draft, child, *made, [&](std::span<const double> offset) {
                    for (int i = 0; i < draft.points; ++i) {
                        if (std::abs(offset[i]) <= k_nothing || active[i] != 0) continue;
                        active[i] = 1;
                        draft.active.push_back(i);
                        again = true;
                    }
                });
                if (known) continue;
                // Inside the cell the rules reproduce more than around it.
                draft.none = draft.anchor == draft.constant();
                draft.anchor = draft.constant();
                again = true;
            }
        }
    }
    for (auto& [key, draft] : drafts) {
        if (draft.none) continue;
        std::vector<int> place(draft.points, -1);
        for (std::size_t a = 0; a < draft.active.size(); ++a) {
            place[draft.active[a]] = static_cast<int>(a);
            draft.weight.push_back(draft.direct[draft.active[a]]);
        }
        for (Draft::Child& child : draft.children) {
            const std::optional<Made> made = made_of(child.key);
            if (!made) continue;
            child.weight = made->weight;
            for_each_offset(draft, child, *made, [&](std::span<const double> offset) {
                auto& terms = child.offsets.emplace_back();
                for (int i = 0; i < draft.points; ++i)
                    if (std::abs(offset[i]) > k_nothing && draft.free(i))
                        terms.emplace_back(place[i], std::abs(offset[i]));
            });
        }
    }
    // What has no weights has none for those that are made of it.
    const auto spread_none = [&] {
        for (bool again = true; again;) {
            again = false;
            for (auto& [key, draft] : drafts)
                if (!draft.none)
                    for (const Draft::Child& child : draft.children)
                        if (const auto at = drafts.find(child.key); at != drafts.end() && at->second.none)
                            draft.none = again = true;
        }
    };
    spread_none();
    double change = k_infinite;
    for (int round = 0; round < k_most_rounds && change > k_settled; ++round) {
        change = 0;
        for (auto& [key, draft] : drafts) {
            if (draft.none) continue;
            std::vector<double> below(draft.active.size(), 0.0), sum(draft.active.size());
            for (const Draft::Child& child : draft.children) {
                std::fill(sum.begin(), sum.end(), 0.0);
                for (std::size_t j = 0; j < child.offsets.size(); ++j)
                    for (const auto& [a, size] : child.offsets[j]) sum[a] += (*child.weight)[j] * size;
                for (std::size_t a = 0; a < sum.size(); ++a) below[a] = std::max(below[a], sum[a]);
            }
            for (std::size_t a = 0; a < below.size(); ++a) {
                const double now = draft.direct[draft.active[a]] + below[a];
                change = std::max(change, now - draft.weight[a]);
                draft.weight[a] = now;
                if (now > k_most_weight) draft.none = true;
            }
        }
    }
    if (change > k_settled)
        for (auto& [key, draft] : drafts) draft.none = true;
    spread_none();
}

CellRemainder::Walk CellRemainder::walk_of(const Key& key, const Norms& norms) const {
    const RuleMesh mesh = mesh_of(key);
    Walk all;
    std::vector<int> entry{0};
    std::vector<char> entered(mesh.face_count(), 0);
    std::vector<Walk::Point> where(mesh.vertex_count(), {-1, 0});
    entered[0] = 1;
    all.faces.push_back({-1, 0});
    for (std::size_t i = 0; i < entry.size(); ++i) {
        int h = entry[i];
        for (int turns = 0; turns < corners_; ++turns, h = mesh.next(h)) {
            Walk::Point& p = where[mesh.origin(h)];
            if (p.face < 0) p = {static_cast<int>(i), turns};
            const int t = mesh.twin(h);
            if (t == RuleMesh::none || std::exchange(entered[mesh.face(t)], 1)) continue;
            entry.push_back(t);
            all.faces.push_back({static_cast<int>(i), turns});
        }
    }
    // Only the faces on the way to a point.
    std::vector<char> needed(all.faces.size(), 0);
    needed[0] = 1;
    for (const int i : norms.point)
        for (int f = where[i].face; f > 0; f = all.faces[f].from) needed[f] = 1;
    Walk walk;
    std::vector<int> number(all.faces.size(), -1);
    for (std::size_t f = 0; f < all.faces.size(); ++f) {
        if (!needed[f]) continue;
        number[f] = static_cast<int>(walk.faces.size());
        walk.faces.push_back({f == 0 ? -1 : number[all.faces[f].from], all.faces[f].turns});
    }
    for (const int i : norms.point) walk.points.push_back({number[where[i].face], where[i].turns});
    return walk;
}

CellRemainder::Level::Level(const CellRemainder& remainder, const RuleMesh& mesh, std::span<const Vec3d> points,
                            MeshPartFinder& parts)
    : remainder_(remainder), mesh_(mesh), points_(points), parts_(parts), irregular_(mesh.vertex_count(), 0) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
        irregular_[v] = mesh.first(v) == RuleMesh::none || mesh.rule(v) != VertexRule::smooth ||
                        mesh.vertex_sharpness(v) > 0 || !remainder.is_regular(mesh, v);
    for (int f = 0; f < mesh.face_count(); ++f) {
        bool other = mesh.face_size(f) != remainder.corners();
        for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + mesh.face_size(f); ++h)
            other = other || mesh.sharpness(h) > 0;
        if (other)
            for (const int v : mesh.corners(f)) irregular_[v] = 1;
    }
    std::vector<std::uint8_t> wider;
    for (int ring = 1; ring < remainder.rings(); ++ring) {
        wider = irregular_;
        for (int f = 0; f < mesh.face_count(); ++f) {
            const std::span<const int> corners = mesh.corners(f);
            if (std::any_of(corners.begin(), corners.end(), [&](int v) { return irregular_[v] != 0; }))
                for (const int v : corners) wider[v] = 1;
        }
        irregular_.swap(wider);
    }
}

double CellRemainder::Level::sum(const Norms& norms, int halfedge, std::span<const int> points) const {
    std::array<Vec3d, 4> corner{};
    int h = halfedge;
    for (int k = 0; k < remainder_.corners(); ++k, h = mesh_.next(h)) corner[k] = points_[mesh_.origin(h)];
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::array<double, 4>& a = norms.anchor[i];
        const Vec3d expected = a[0] * corner[0] + a[1] * corner[1] + a[2] * corner[2] + a[3] * corner[3];
        sum += norms.weight[i] * glm::length(points_[points[i]] - expected);
    }
    return sum;
}

double CellRemainder::Level::operator()(int halfedge) {
    const std::span<const int> corners = mesh_.corners(mesh_.face(halfedge));
    const Norms* const regular = remainder_.regular_;
    if (regular != nullptr && std::none_of(corners.begin(), corners.end(), [&](int v) { return irregular_[v] != 0; })) {
        const Walk& walk = remainder_.regular_walk_;
        entry_.resize(walk.faces.size());
        found_.resize(walk.points.size());
        const auto turned = [&](int h, int turns) {
            for (int i = 0; i < turns; ++i) h = mesh_.next(h);
            return h;
        };
        entry_[0] = halfedge;
        for (std::size_t f = 1; f < entry_.size(); ++f)
            entry_[f] = mesh_.twin(turned(entry_[walk.faces[f].from], walk.faces[f].turns));
        for (std::size_t i = 0; i < found_.size(); ++i)
            found_[i] = mesh_.origin(turned(entry_[walk.points[i].face], walk.points[i].turns));
        return sum(*regular, halfedge, found_);
    }
    const std::optional<Surroundings> around = remainder_.surroundings(mesh_, halfedge, parts_);
    if (!around) return k_infinite;
    const Norms* const norms = remainder_.norms(around->key);
    if (norms == nullptr) return k_infinite;
    found_.clear();
    for (const int i : norms->point) found_.push_back(around->vertices[i]);
    return sum(*norms, halfedge, found_);
}

}  // namespace tetrakis::detail
