#include "turning_strip.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/rules/averaging.hpp"
#include "../rules/limit_search.hpp"
#include "../rules/mesh_part.hpp"
#include "../rules/parallel_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace tetrakis::detail {

namespace {

using Heading = RootNet::Heading;

/// The cell's quarter between that way and the next one, counter-clockwise, which is the child of the corner there.
Heading child(const Heading& from) {
    constexpr std::uint32_t right[] = {1, 0, 0, 1}, up[] = {1, 1, 0, 0};
    return {from.root, 2 * from.x + right[from.way], 2 * from.y + up[from.way], from.way};
}

/// The children's headings, of a step by split_vertices().
class ChildHeadings {
  public:
    ChildHeadings(const RootNet& net, std::uint32_t segments, const RuleMesh& level, std::span<const Heading> headings,
                  const RuleStep& step)
        : net_(net), n_(segments), finer_(step.mesh), headings_(static_cast<std::size_t>(finer_.halfedge_count())) {
        for (int h = 0; h < level.halfedge_count(); ++h) {
            if (!headings[h].known()) continue;
            const int first = step.child_halfedge[h];
            headings_[first] = child(headings[h]);
            turn(first, 3);
            turn_back(first, 3);
        }
        // Of a crease the points at both ends of an edge, one cell outwards from the corners' children; each has two
        // half-edges on either side, whether it is sharp from here on or not.
        for (int h = 0; h < level.halfedge_count(); ++h) {
            const int along = step.child_crease[h];
            if (along == RuleMesh::none) continue;
            headings_[along] = net_.ahead(n_, headings_[step.child_halfedge[h]].turned(3)).turned(1);
            turn(along, 1);
            const int inwards = finer_.next(along);
            headings_[inwards] = net_.ahead(n_, headings_[step.child_halfedge[level.next(h)]].turned(2)).turned(2);
            turn_back(inwards, 1);
        }
        // Tips: beyond a point on a crease, from its face.
        for (int h = 0; h < finer_.halfedge_count(); ++h)
            if (headings_[h].known() && !headings_[finer_.next(h)].known())
                headings_[finer_.next(h)] = net_.ahead(n_, headings_[h]).turned(1);
    }

    std::vector<Heading> take() { return std::move(headings_); }

  private:
    /// So many half-edges counter-clockwise from one that is known.
    void turn(int h, int count) {
        for (; count > 0; --count) {
            const int next = finer_.twin(finer_.prev(h));
            if (next == RuleMesh::none || headings_[next].known()) return;
            headings_[next] = headings_[h].turned(1);
            h = next;
        }
    }
    void turn_back(int h, int count) {
        for (; count > 0 && finer_.twin(h) != RuleMesh::none; --count) {
            const int next = finer_.next(finer_.twin(h));
            if (headings_[next].known()) return;
            headings_[next] = headings_[h].turned(3);
            h = next;
        }
    }

    const RootNet& net_;
    std::uint32_t n_;
    const RuleMesh& finer_;
    std::vector<Heading> headings_;
};

/// Of the level that the strip starts from.
std::vector<Heading> first_headings(const RootNet& net, std::uint32_t segments, const RuleMesh& level,
                                    std::span<const int> halfedge) {
    std::vector<Heading> headings(static_cast<std::size_t>(level.halfedge_count()));
    std::vector<int> open;
    const auto set = [&](int h, const Heading& heading) {
        if (h == RuleMesh::none || !heading.known() || headings[h].known()) return;
        headings[h] = heading;
        open.push_back(h);
    };
    for (std::uint32_t root = 0; root < halfedge.size(); ++root)
        set(halfedge[root], {root, segments - 1, segments - 1, 0});
    while (!open.empty()) {
        const int h = open.back();
        open.pop_back();
        const Heading there = net.ahead(segments, headings[h]);
        set(level.next(h), there.turned(1));
        if (!level.sharp(h)) set(level.twin(h), there.turned(2));
    }
    return headings;
}

void sort_once(std::vector<std::uint32_t>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

struct TurningStrip::Level {
    RuleMesh mesh;
    std::vector<Heading> headings;  ///< by half-edge
    std::vector<char> changed;      ///< vertices that are not, or not as, the net says
    CornerFaces faces;
};

class TurningStrip::Maker {
  public:
    Maker(const RootNet& net, const Start& start, const SchemeInfo& scheme, const RuleOptions& rules,
          const Demand& demand)
        : net_(net), start_(start), scheme_(scheme), rules_(rules), demand_(demand), segments_(1) {
        rules_.runner = &runner_;
    }

    std::optional<TurningStrip> make(const RunContext& context) {
        const RuleMesh& first = start_.levels.last();
        Level at{first, first_headings(net_, segments_, start_.cut, start_.halfedge), first_changed(),
                 start_.levels.corner_faces()};
        left_ = start_.steps;
        const MeshPart part = cut(at);
        strip_.from_ = part.vertex;
        while (left_ > 0 && at.mesh.face_count() > 0) {
            context.report("refine", 0);
            if (!step(at)) return std::nullopt;
        }
        // Tags of vertices without creases have nothing to turn.
        if (at.mesh.face_count() > 0 && !finish(at)) return std::nullopt;
        return std::move(strip_);
    }

  private:
    bool asks_for_limits() const { return demand_.limit || demand_.normals; }
    /// Rings of faces beyond its own that the rules of a corner's child see.
    int reach() const { return averaging_steps(scheme_, rules_) / 2; }
    /// Rings of faces around what has changed in which limits and normals see it. Without averages those of a vertex
    /// are the face's that it becomes, which depend on the faces around it; and one more.
    int limit_rings() const {
        constexpr int k_around = 2;
        return reach() == 0 ? k_around : rule_limit_rings(scheme_, rules_);
    }
    /// Whether a tag matters that is sharp now.
    bool turns(float sharpness) const {
        return is_semi_sharp(sharpness) && (asks_for_limits() || sharpness <= static_cast<float>(left_ - 1));
    }
    /// Rings of faces around what has changed and what will that a level needs. A step changes the children of the
    /// faces around what has changed before, so that rings there begin half a ring further out; and around the last
    /// vertices whose face is wanted there is one more. Rules that reach further change more, from further away.
    int rings(int left) const {
        if (left == 0) return asks_for_limits() ? limit_rings() + rule_limit_rings(scheme_, rules_) : 1;
        return (rings(left - 1) + 1) / 2 + 1 + 3 * reach();
    }

    /// Of the first level: what has turned smooth on the way to it.
    std::vector<char> first_changed() const {
        const RuleMesh &now = start_.levels.last(), &cut = start_.cut;
        std::vector<char> changed(static_cast<std::size_t>(now.vertex_count()), 0);
        for (int v = 0; v < now.vertex_count(); ++v)
            changed[v] = is_sharp(cut.vertex_sharpness(v)) != is_sharp(now.vertex_sharpness(v)) ? 1 : 0;
        for (int h = 0; h < now.halfedge_count(); ++h)
            if (cut.sharp(h) != now.sharp(h)) changed[now.origin(h)] = changed[now.target(h)] = 1;
        return changed;
    }

    /// Vertices that have changed, or are tagged by what will.
    std::vector<int> seeds(const Level& at) const {
        std::vector<int> seeds;
        for (int v = 0; v < at.mesh.vertex_count(); ++v)
            if (at.changed[v] != 0 || turns(at.mesh.vertex_sharpness(v))) seeds.push_back(v);
        for (int h = 0; h < at.mesh.halfedge_count(); ++h)
            if (turns(at.mesh.sharpness(h))) {
                seeds.push_back(at.mesh.origin(h));
                seeds.push_back(at.mesh.target(h));
            }
        std::sort(seeds.begin(), seeds.end());
        seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
        return seeds;
    }

    /// Leaves what the further steps need.
    MeshPart cut(Level& at) {
        MeshPart part = finder_.find(at.mesh, seeds(at), rings(left_));
        const bool corners = !at.faces.point_face.empty();
        Level rest;
        for (std::size_t f = 0; f < part.face.size(); ++f) {
            const int begin = at.mesh.face_begin(part.face[f]), end = begin + at.mesh.face_size(part.face[f]);
            rest.faces.control_face.push_back(at.faces.control_face[part.face[f]]);
            rest.headings.insert(rest.headings.end(), &at.headings[begin], at.headings.data() + end);
            for (int h = begin; corners && h < end; ++h) {
                rest.faces.corner_face.push_back(at.faces.corner_face[h]);
                rest.faces.point_face.push_back(at.faces.point_face[h]);
            }
        }
        for (const int v : part.vertex) rest.changed.push_back(at.changed[v]);
        rest.mesh = std::move(part.mesh);
        part.mesh = RuleMesh();
        at = std::move(rest);
        return part;
    }

    /// Vertices that have changed, or have in the rings that rules reach.
    std::vector<char> changed_nearby(const Level& at) const {
        std::vector<char> changed = at.changed;
        for (int ring = 0; ring < reach(); ++ring) {
            const std::vector<char> before = changed;
            for (int f = 0; f < at.mesh.face_count(); ++f) {
                const auto corners = at.mesh.corners(f);
                if (std::any_of(corners.begin(), corners.end(), [&](int v) { return before[v] != 0; }))
                    for (const int v : corners) changed[v] = 1;
            }
        }
        return changed;
    }

    std::vector<char> changed_children(const Level& at, const RuleStep& step) const {
        const RuleMesh& finer = step.mesh;
        const std::vector<char> nearby = changed_nearby(at);
        std::vector<char> changed(static_cast<std::size_t>(finer.vertex_count()), 0), is_known(changed);
        for (int f = 0; f < at.mesh.face_count(); ++f) {
            const auto corners = at.mesh.corners(f);
            const char sees =
                std::any_of(corners.begin(), corners.end(), [&](int v) { return nearby[v] != 0; }) ? 1 : 0;
            for (int h = at.mesh.face_begin(f); h < at.mesh.face_begin(f) + at.mesh.face_size(f); ++h) {
                const int v = finer.origin(step.child_halfedge[h]);
                changed[v] = sees;
                is_known[v] = 1;
            }
        }
        // What has just turned smooth is where it was, but its children will not be; and so are limits.
        const bool matters = left_ > 1 || asks_for_limits();
        for (int h = 0; h < at.mesh.halfedge_count(); ++h) {
            const int along = step.child_crease[h];
            if (along == RuleMesh::none) continue;
            const bool sees = nearby[at.mesh.origin(h)] != 0 || nearby[at.mesh.target(h)] != 0,
                       turned = matters && !is_sharp(child_sharpness(at.mesh.sharpness(h)));
            for (const int v : {finer.origin(along), finer.target(along)}) {
                changed[v] = changed[v] != 0 || sees || turned ? 1 : 0;
                is_known[v] = 1;
            }
        }
        // Tips of corners: they see what the points on their creases see.
        for (int v = 0; v < finer.vertex_count(); ++v) {
            if (is_known[v] != 0 || finer.first(v) == RuleMesh::none) continue;
            const RuleMesh::Ring ring = finer.ring(v);
            bool corner = ring.edges() > 2 || is_sharp(finer.vertex_sharpness(v)), sees = false;
            for (int i = 0; i < ring.edges(); ++i) {
                corner = corner && is_sharp(ring.sharpness[i]);
                sees = sees || changed[ring.neighbour[i]] != 0;
            }
            changed[v] = sees || (matters && !corner) ? 1 : 0;
        }
        return changed;
    }

    bool step(Level& at) {
        RuleStep step = scheme_.step(at.mesh, rules_);
        std::vector<char> changed = changed_children(at, step);
        const std::uint32_t n = segments_, finer_n = 2 * segments_;
        std::vector<Heading> headings = ChildHeadings(net_, finer_n, at.mesh, at.headings, step).take();
        at.faces.follow(at.mesh, step);
        std::vector<std::uint32_t> dead;
        dead.reserve(4 * dead_.size());
        for (const std::uint32_t place : dead_) {
            const std::uint32_t root = place / (n * n), y = place / n % n, x = place % n;
            for (std::uint32_t i = 0; i < 4; ++i)
                dead.push_back(net_.place(finer_n, {root, 2 * x + i % 2, 2 * y + i / 2, 0}));
        }
        for (int h = 0; h < step.mesh.halfedge_count(); ++h)
            if (changed[step.mesh.origin(h)] != 0 && headings[h].known())
                dead.push_back(net_.place(finer_n, headings[h]));
        sort_once(dead);
        dead_ = std::move(dead);
        segments_ = finer_n;
        --left_;
        at.mesh = std::move(step.mesh);
        at.headings = std::move(headings);
        at.changed = std::move(changed);
        const MeshPart part = cut(at);
        StencilTable rows;
        for (const int v : part.vertex) rows.push(step.stencils.row(v));
        strip_.steps_.push_back(std::move(rows));
        return is_worth_it(at);
    }

    /// Whether the next step is one to be made.
    bool is_worth_it(const Level& at) {
        // Of a half-edge of the strip: as by the rules; and its children.
        constexpr double k_bytes = 160, k_children = 4;
        const double halfedges = at.mesh.halfedge_count();
        bytes_ += k_bytes * halfedges;
        const auto wider = std::ranges::count(at.changed, 1);
        const double points = static_cast<double>(at.mesh.vertex_count()) * std::pow(2.0, left_) +
                              static_cast<double>(wider) * (std::pow(4.0, left_) - std::pow(2.0, left_));
        if (demand_.most_points != 0 && points > demand_.most_points) return false;
        const double next = left_ > 0 ? k_children * k_bytes * halfedges : 0;
        return demand_.max_bytes == 0 || bytes_ + next <= static_cast<double>(demand_.max_bytes);
    }

    bool finish(Level& at) {
        const RuleMesh& mesh = at.mesh;
        const RootLayout layout = net_.layout(segments_);
        const RootNet::Numbers numbers = net_.point_numbers(layout);
        for (std::uint32_t& place : dead_) place = numbers.of(place);
        sort_once(dead_);
        strip_.first_number_ = numbers.count;
        std::vector<std::uint32_t> number(static_cast<std::size_t>(mesh.vertex_count()), RootNet::none);
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            if (at.changed[v] == 0) continue;
            number[v] = numbers.count + strip_.point_count();
            strip_.own_.push_back(v);
        }
        const auto number_at = [&](int h) {
            std::uint32_t& n = number[mesh.origin(h)];
            if (n == RootNet::none && at.headings[h].known()) n = numbers.of(net_.place(segments_, at.headings[h]));
            return n;
        };
        RootNet::Faces& faces = strip_.faces_;
        const auto changed = [&](int v) { return at.changed[v] != 0; };
        for (int f = 0; f < mesh.face_count(); ++f) {
            const auto corners = mesh.corners(f);
            if (std::none_of(corners.begin(), corners.end(), changed)) continue;
            for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + mesh.face_size(f); ++h) {
                const std::uint32_t n = number_at(h);
                if (n == RootNet::none || std::binary_search(dead_.begin(), dead_.end(), n)) return false;
                faces.vertices.push_back(n);
            }
            faces.offsets.push_back(static_cast<std::uint32_t>(faces.vertices.size()));
            faces.control.push_back(static_cast<std::uint32_t>(at.faces.control_face[f]));
        }
        strip_.dead_ = std::move(dead_);
        if (!asks_for_limits()) return true;
        const std::vector<int> seeds = this->seeds(at);
        const MeshPart near = finder_.find(mesh, seeds, limit_rings());
        for (int h = 0; h < mesh.halfedge_count(); ++h) number_at(h);
        for (const int v : near.vertex)
            if (number[v] != RootNet::none) strip_.seen_.push_back(v);
        for (const int v : strip_.seen_) strip_.number_.push_back(number[v]);
        strip_.limits_ = RuleLimitFinder(scheme_, rules_).find(mesh, strip_.seen_);
        strip_.limit_ = demand_.limit;
        strip_.normals_ = demand_.normals;
        strip_.mesh_ = std::move(at.mesh);
        return true;
    }

    const RootNet& net_;
    const Start& start_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    const Demand& demand_;
    ParallelBlocks runner_;
    MeshPartFinder finder_;
    std::uint32_t segments_;
    int left_ = 0;                     ///< steps
    std::vector<std::uint32_t> dead_;  ///< places
    double bytes_ = 0;
    TurningStrip strip_;
};

std::optional<TurningStrip> TurningStrip::make(const RootNet& net, const Start& start, const SchemeInfo& scheme,
                                               const RuleOptions& rules, const Demand& demand,
                                               const RunContext& context) {
    return Maker(net, start, scheme, rules, demand).make(context);
}

void TurningStrip::put_into(RootNet::Faces& faces) const {
    std::vector<char> dead;
    if (!dead_.empty()) dead.resize(std::size_t{dead_.back()} + 1, 0);
    for (const std::uint32_t v : dead_) dead[v] = 1;
    std::size_t kept = 0, corners = 0;
    for (std::size_t f = 0; f < faces.control.size(); ++f) {
        const std::uint32_t begin = faces.offsets[f], end = faces.offsets[f + 1];
        bool whole = true;
        for (std::uint32_t c = begin; c < end && whole; ++c)
            whole = faces.vertices[c] >= dead.size() || dead[faces.vertices[c]] == 0;
        if (!whole) continue;
        faces.control[kept] = faces.control[f];
        faces.offsets[kept++] = static_cast<std::uint32_t>(corners);
        for (std::uint32_t c = begin; c < end; ++c) faces.vertices[corners++] = faces.vertices[c];
    }
    faces.vertices.resize(corners);
    faces.control.resize(kept);
    faces.offsets.resize(kept);
    for (const std::uint32_t begin : faces_.offsets)
        faces.offsets.push_back(static_cast<std::uint32_t>(corners) + begin);
    faces.vertices.insert(faces.vertices.end(), faces_.vertices.begin(), faces_.vertices.end());
    faces.control.insert(faces.control.end(), faces_.control.begin(), faces_.control.end());
}

void TurningStrip::refine(std::span<const Vec3d> start, std::span<Vec3d> points, std::span<Vec3d> normals) const {
    if (own_.empty() && seen_.empty()) return;
    std::vector<Vec3d> net, finer;
    for (const int v : from_) net.push_back(start[v]);
    for (const StencilTable& step : steps_) {
        finer.resize(static_cast<std::size_t>(step.row_count()));
        apply(step, &net.data()->x, 3, &finer.data()->x);
        net.swap(finer);
    }
    if (!limit_)
        for (std::size_t i = 0; i < own_.size(); ++i) points[first_number_ + i] = net[own_[i]];
    for_each_index(static_cast<std::uint32_t>(seen_.size()), [&](std::uint32_t i) {
        const int row = static_cast<int>(i);
        if (limit_) points[number_[i]] = limit_sum(limits_.positions, row, net);
        if (!normals.empty()) normals[number_[i]] = limit_normal(limits_, row, mesh_, net, seen_[i]);
    });
}

}  // namespace tetrakis::detail
