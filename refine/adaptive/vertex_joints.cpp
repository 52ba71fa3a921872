#include "vertex_joints.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

using JointPlace = VertexJoint::Place;

constexpr std::uint8_t k_never = VertexRoots::never;

/// How many steps see an edge or vertex as sharp.
std::uint8_t steps_sharp(float sharpness) {
    std::uint8_t steps = 0;
    for (; is_sharp(sharpness) && steps < k_never; sharpness = child_sharpness(sharpness)) ++steps;
    return steps;
}
std::uint8_t step_less(std::uint8_t steps) {
    return static_cast<std::uint8_t>(steps == k_never || steps == 0 ? steps : steps - 1);
}
/// The level from which on something is smooth.
std::uint8_t level_after(int level, std::uint8_t steps) {
    return static_cast<std::uint8_t>(std::min<int>(steps == k_never ? k_never : level + steps, k_never));
}

VertexCell cell_child(const VertexCell& cell, unsigned child) {
    return {cell.root,
            {2 * cell.at.x + (child == 1 || child == 2 ? 1 : 0), 2 * cell.at.y + (child >= 2 ? 1 : 0)},
            static_cast<std::uint8_t>(cell.level + 1)};
}

/// A vertex, and what surrounds it counter-clockwise. Edge i comes before face i; where the surface ends, there is one
/// edge more.
struct SplitVertex {
    struct Face {
        std::uint32_t cell;
        unsigned corner;
    };
    struct Edge {
        std::uint8_t steps = 0;  ///< that see it sharp
        bool cut = false;        ///< the cells beside it end there
    };
    int level = 0;
    std::vector<VertexCell> cells;
    std::vector<Face> faces;
    std::vector<Edge> edges;
    bool closed = true;
    bool tip = false;  ///< its cells have a child in their outer corner
    std::uint8_t tag = 0;
};

class JointFinder {
  public:
    explicit JointFinder(VertexRoots& roots) : roots_(roots) {}

    void follow(const SplitVertex& v);

  private:
    /// The sharp edges from `first` on, and faces between two of them.
    struct Sector {
        std::size_t edge, next_edge, first, last;
    };
    std::vector<Sector> sectors(const SplitVertex& v, const std::vector<std::size_t>& sharp) const;
    void follow_children(const SplitVertex& v, const std::vector<std::size_t>& sharp, bool corner);
    VertexJoint joint(const SplitVertex& v, const std::vector<std::size_t>& sharp, bool corner) const;

    VertexRoots& roots_;
};

std::size_t face_before(const SplitVertex& v, std::size_t edge) {
    return edge > 0 ? edge - 1 : v.faces.size() - 1;  // of an open one's first edge: not to be asked for
}
bool is_inside(const SplitVertex& v, std::size_t edge) { return v.closed || (edge > 0 && edge < v.faces.size()); }

std::vector<JointFinder::Sector> JointFinder::sectors(const SplitVertex& v,
                                                      const std::vector<std::size_t>& sharp) const {
    std::vector<Sector> result;
    for (std::size_t i = 0; i + (v.closed ? 0 : 1) < sharp.size(); ++i) {
        const std::size_t next = sharp[(i + 1) % sharp.size()];
        result.push_back({sharp[i], next, sharp[i], face_before(v, next)});
    }
    return result;
}

VertexJoint JointFinder::joint(const SplitVertex& v, const std::vector<std::size_t>& sharp, bool corner) const {
    VertexJoint joint;
    joint.cells = v.cells;
    joint.children.resize(v.cells.size());
    const auto child = [&](std::uint32_t cell, unsigned k) -> VertexJoint::Child& {
        return joint.children[cell][k % 4];
    };
    const auto add = [&](std::uint32_t cell, unsigned k) -> VertexJoint::Child& {
        child(cell, k) = {true, 0, {k_never, k_never, k_never, k_never}};
        return child(cell, k);
    };
    const auto at = [](std::uint32_t cell, unsigned k, unsigned side) {
        return JointPlace{cell, static_cast<std::uint8_t>(k % 4), static_cast<std::uint8_t>(side % 4)};
    };
    const auto set_crease = [](VertexJoint::Child& c, unsigned side, std::uint8_t smooth_from) {
        c.crease = static_cast<std::uint8_t>(c.crease | 1u << side % 4);
        c.smooth_from[side % 4] = smooth_from;
    };
    for (const SplitVertex::Face& f : v.faces) add(f.cell, f.corner);
    for (std::size_t e = 0; e < v.edges.size(); ++e)
        if (v.edges[e].steps == 0) {
            const auto [before, b] = v.faces[face_before(v, e)];
            const auto [after, a] = v.faces[e];
            joint.joined.push_back({at(before, b, b + 1), at(after, a, a + 2)});
        }
    if (sharp.size() == 1) {
        // The crease ends here now: its point is in one cell, which goes around its end.
        const auto [before, b] = v.faces[face_before(v, sharp[0])];
        const auto [after, a] = v.faces[sharp[0]];
        const unsigned d = a + 3;
        add(after, d);
        joint.joined.push_back({at(after, d, d + 1), at(after, a, a + 2)});
        joint.joined.push_back({at(after, d, d + 2), at(before, b, b + 1)});
        joint.in_place.push_back({at(after, d, d + 3), at(before, b + 1, b)});
        return joint;
    }
    if (sharp.empty()) return joint;
    std::uint8_t longest = 0;
    for (const std::size_t e : sharp) longest = std::max(longest, v.edges[e].steps);
    for (const Sector& s : sectors(v, sharp)) {
        const auto [first, a] = v.faces[s.first];
        const auto [last, b] = v.faces[s.last];
        const auto smooth = [&](std::size_t e) { return level_after(v.level, corner ? v.edges[e].steps : longest); };
        VertexJoint::Child& ahead = add(first, a + 3);
        if (is_inside(v, s.edge)) set_crease(ahead, a + 2, smooth(s.edge));
        VertexJoint::Child& behind = add(last, b + 1);
        if (is_inside(v, s.next_edge)) set_crease(behind, b + 1, smooth(s.next_edge));
        joint.joined.push_back({at(first, a + 3, a), at(first, a, a + 2)});
        joint.joined.push_back({at(last, b + 1, b + 3), at(last, b, b + 1)});
        const JointPlace end_ahead = at(first, a + 3, a + 1), end_behind = at(last, b + 1, b + 2);
        if (!corner) {
            joint.joined.push_back({end_ahead, end_behind});
            continue;
        }
        VertexJoint::Child& tip = add(first, a + 2);
        if (is_inside(v, s.edge)) set_crease(tip, a + 2, smooth(s.edge));
        if (is_inside(v, s.next_edge)) set_crease(tip, a + 1, smooth(s.next_edge));
        joint.joined.push_back({end_ahead, at(first, a + 2, a + 3)});
        joint.joined.push_back({end_behind, at(first, a + 2, a)});
        if (s.first != s.last) joint.in_place.push_back({at(first, a + 2, a + 1), at(last, b + 2, b + 1)});
    }
    return joint;
}

// Those whose splits cannot be told from the cells they come from: at the ends of creases, where they change, corners.
void JointFinder::follow_children(const SplitVertex& v, const std::vector<std::size_t>& sharp, bool corner) {
    SplitVertex next;
    next.level = v.level + 1;
    if (sharp.empty() && v.closed && v.faces.size() == 2)
        // Below it there is no face: either child has three, and the other one beside it twice.
        for (const auto& [cell, c] : v.faces) {
            next.cells = {cell_child(v.cells[cell], c)};
            next.faces = {{0, (c + 3) % 4}, {0, c}, {0, (c + 1) % 4}};
            next.edges = {{0, true}, {}, {}};
            follow(next);
        }
    if (sharp.empty()) return;
    std::uint8_t longest = 0;
    for (const std::size_t e : sharp) longest = std::max(longest, v.edges[e].steps);
    for (const std::size_t e : sharp) {
        if (!is_inside(v, e)) continue;
        const auto [before, b] = v.faces[face_before(v, e)];
        const auto [after, a] = v.faces[e];
        const std::uint8_t out = step_less(v.edges[e].steps), in = corner ? out : step_less(longest);
        next.cells = {cell_child(v.cells[after], (a + 3) % 4)};
        if (sharp.size() == 1) {
            next.faces = {{0, a % 4}, {0, (a + 1) % 4}, {0, (a + 2) % 4}};
            next.edges = {{out, true}, {}, {}};
        } else if (out != in) {
            next.cells.push_back(cell_child(v.cells[before], (b + 1) % 4));
            next.faces = {{0, a % 4}, {0, (a + 1) % 4}, {1, (b + 3) % 4}, {1, b % 4}};
            next.edges = {{out, true}, {}, {in, true}, {}};
        } else {
            continue;
        }
        follow(next);
    }
    if (!corner) return;
    next.cells.clear();
    next.faces.clear();
    next.edges.clear();
    for (const Sector& s : sectors(v, sharp)) {
        const auto [first, a] = v.faces[s.first];
        next.cells.push_back(cell_child(v.cells[first], (a + 2) % 4));
        next.faces.push_back({static_cast<std::uint32_t>(next.cells.size() - 1), a % 4});
    }
    for (const std::size_t e : sharp) next.edges.push_back({step_less(v.edges[e].steps), true});
    next.closed = v.closed;
    next.tip = true;
    next.tag = step_less(v.tag);
    follow(next);
}

void JointFinder::follow(const SplitVertex& v) {
    if (v.level >= k_max_level) return;
    std::vector<std::size_t> sharp;
    bool changes = false, ends = false;
    for (std::size_t e = 0; e < v.edges.size(); ++e) {
        const auto [steps, cut] = v.edges[e];
        if (steps != 0) sharp.push_back(e);
        changes = changes || (cut && steps == 0);
        ends = ends || (cut && steps != k_never);
    }
    const bool corner = sharp.size() > 2 || (sharp.size() == 2 && v.tag != 0);
    changes = changes || (v.tip && !corner);
    if (!changes && !ends && !(v.tip && sharp.size() == 2 && v.tag != k_never)) return;
    if (changes) {
        VertexJoint found = joint(v, sharp, corner);
        const auto number = static_cast<std::uint32_t>(roots_.joints.size());
        for (std::uint32_t i = 0; i < found.cells.size(); ++i)
            roots_.joint_cells.push_back({found.cells[i], number, i});
        roots_.joints.push_back(std::move(found));
    }
    follow_children(v, sharp, corner);
}

}  // namespace

void add_joints(VertexRoots& roots, const RuleMesh& level, const RuleMesh& cut, std::span<const std::uint32_t> place) {
    roots.smooth_from.assign(4 * std::size_t{roots.count()}, k_never);
    JointFinder finder(roots);
    for (int v = 0; v < level.vertex_count(); ++v) {
        if (level.first(v) == RuleMesh::none) continue;
        const RuleMesh::Ring ring = level.ring(v), cuts = cut.ring(v);
        SplitVertex around;
        around.closed = ring.closed;
        int cut_count = 0;
        for (int i = 0; i < ring.edges(); ++i) {
            around.edges.push_back({steps_sharp(ring.sharpness[i]), is_sharp(cuts.sharpness[i])});
            cut_count += is_sharp(cuts.sharpness[i]) ? 1 : 0;
        }
        for (int i = 0; i < ring.faces(); ++i) {
            const std::uint32_t at = place[static_cast<std::size_t>(ring.halfedge[i])];
            const VertexCell cell{at / 4, {0, 0}, 0};
            const auto known = std::find(around.cells.begin(), around.cells.end(), cell);
            around.faces.push_back({static_cast<std::uint32_t>(known - around.cells.begin()), at % 4});
            if (known == around.cells.end()) around.cells.push_back(cell);
        }
        around.tip = cut_count > 2 || (cut_count == 2 && is_sharp(cut.vertex_sharpness(v)));
        around.tag = steps_sharp(level.vertex_sharpness(v));
        std::uint8_t longest = 0;
        for (const SplitVertex::Edge& e : around.edges) longest = e.cut ? std::max(longest, e.steps) : longest;
        // From a vertex of two faces: the sides that meet where it was lie both along one edge.
        constexpr std::uint32_t k_after_far_corner = 1;
        if (cut_count == 0 && around.closed && around.faces.size() == 3)
            for (std::size_t e = 0; e < around.faces.size(); ++e)
                around.edges[e].cut = around.faces[e].corner == k_after_far_corner;
        const auto set = [&](const SplitVertex::Face& f, unsigned side, std::size_t e) {
            const std::uint32_t root = around.cells[f.cell].root;
            if ((roots.crease[root] >> side % 4 & 1) != 0)
                roots.smooth_from[4 * std::size_t{root} + side % 4] = around.tip ? around.edges[e].steps : longest;
        };
        for (std::size_t e = 0; e < around.edges.size(); ++e) {
            if (!around.edges[e].cut || !is_inside(around, e)) continue;
            const SplitVertex::Face &after = around.faces[e], &before = around.faces[face_before(around, e)];
            set(after, after.corner + 2, e);
            set(before, before.corner + 1, e);
        }
        finder.follow(around);
    }
    std::sort(roots.joint_cells.begin(), roots.joint_cells.end(),
              [](const auto& a, const auto& b) { return a.cell < b.cell; });
    const auto stays = [](std::uint8_t level_from) { return level_from == k_never; };
    if (roots.joints.empty() && std::all_of(roots.smooth_from.begin(), roots.smooth_from.end(), stays))
        roots.smooth_from.clear();
}

}  // namespace tetrakis::detail
