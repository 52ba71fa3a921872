#include "view.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "candidates.hpp"
#include "eye.hpp"
#include "view_buffers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace tetrakis::lod {

namespace {

using detail::bucket_of;
using detail::Candidates;
using detail::DirtySlots;
using detail::edge_of;
using detail::Eye;
using detail::k_buckets_a_doubling;
using detail::k_limit_bucket;
using detail::Odometers;
using detail::packed;
using detail::unpacked;
using Clock = std::chrono::steady_clock;
using Kind = Candidates::Kind;

// Margin factor for errors, so that a camera can move some way before a candidate is evaluated again.
constexpr double k_room = 1.04;
// A box counts as outside if its distance from the frustum is more than this part of its reach: a margin, too.
constexpr double k_beside = 0.1;
// A box inside is evaluated again when it may be outside by this part of its reach; until then it has full weight.
constexpr double k_late = 0.25;
constexpr double k_infinite = std::numeric_limits<double>::infinity();

[[noreturn]] void refuse(const std::string& text) { throw Error(ErrorCode::invalid_input, text); }

bool is_finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

double milliseconds_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

void check(const Camera& camera, const Budget& budget) {
    if (!is_finite(camera.eye) || !is_finite(camera.direction) || !is_finite(camera.up))
        refuse("the camera's eye, direction or up is not finite");
    if (camera.direction == Vec3d(0)) refuse("the camera's direction has no length");
    // Distances have squares, and so have those of control meshes.
    constexpr double k_farthest = 1e60;
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(camera.eye[axis]) > k_farthest)
            refuse(fmt::format("a camera at {}; {} is the farthest", camera.eye[axis], k_farthest));
    if (!(camera.vertical_fov > 0 && camera.vertical_fov < M_PI))
        refuse(fmt::format("a vertical field of view of {}; it has to be between 0 and pi", camera.vertical_fov));
    if (camera.width == 0 || camera.height == 0)
        refuse(fmt::format("a picture of {} times {} pixels", camera.width, camera.height));
    if (!(budget.pixel_error > 0 && std::isfinite(budget.pixel_error)))
        refuse(fmt::format("a pixel error of {}; it has to be a positive number", budget.pixel_error));
    if (!(budget.milliseconds >= 0))
        refuse(fmt::format("a budget of {} milliseconds; it has to be zero or positive", budget.milliseconds));
}

}  // namespace

class View::Impl {
  public:
    Impl(const Surface& surface, const ViewOptions& options)
        : surface_(surface),
          options_(options),
          forest_(surface.roots()),
          odometers_(surface.roots().bounding_box().diagonal()) {
        if (!(options.outside_weight >= 0 && options.outside_weight <= 1))
            refuse(fmt::format("a weight of {} outside the frustum; it has to be from 0 to 1", options.outside_weight));
        if (!(options.hysteresis >= 0.1 && options.hysteresis <= 0.8))
            refuse(fmt::format("a hysteresis of {}; it has to be from 0.1 to 0.8", options.hysteresis));
        if (options.max_ranges == 0) refuse("no range of a buffer is allowed; one is the least");
        merge_bucket_ =
            k_limit_bucket + static_cast<int>(std::lround(k_buckets_a_doubling * std::log2(options.hysteresis)));
        const std::uint32_t roots = forest_.leaf_count();
        std::uint64_t leaves = std::max(options.max_leaves, roots);
        if (options.max_bytes != 0) {
            if (options.max_bytes < room(roots).bytes)
                throw Error(ErrorCode::memory_limit, fmt::format("{} bytes are too few for {} roots; {} are the least",
                                                                 options.max_bytes, roots, room(roots).bytes));
            std::uint64_t beyond = leaves + 1;  // so many do not fit, and `leaves` do
            for (leaves = roots; beyond - leaves > 1;) {
                const std::uint64_t middle = leaves + (beyond - leaves) / 2;
                (room(middle).bytes <= options.max_bytes ? leaves : beyond) = middle;
            }
        }
        max_leaves_ = static_cast<std::uint32_t>(leaves);
        const auto [slots, points, midpoints, candidates, bytes] = room(leaves);
        // Memory is reserved and written here, so that no update waits long for it.
        const auto fill = [](auto& array, std::uint64_t size, auto value) {
            array.reserve(size);
            detail::wish_for_small_pages(array);
            array.assign(size, value);
        };
        forest_.reserve(leaves, midpoints);
        forest_.map_room();
        fill(leaf_candidate_, slots, Candidates::k_none);
        fill(point_candidate_, points, Candidates::k_none);
        fill(triangles_, slots, Triangle{});
        fill(vertices_, points, Vertex{});
        dirty_triangles_.resize(slots);
        dirty_vertices_.resize(points);
        candidates_.reserve(static_cast<std::uint32_t>(candidates));
        start();
    }

    Update update(const Camera& camera, const Budget& budget) {
        check(camera, budget);
        const auto begin = Clock::now();
        // Bounds that are known when a diamond is evaluated stay known until the vertices are written.
        const SurfaceUse use(surface_);
        if (vertex_milliseconds_ == 0) write_vertices();  // of the roots, to measure it
        // Bounds that are loaded from now on are evaluated by the next update.
        revision_ = surface_.revision();
        candidates_.advance(Candidates::k_revisions, static_cast<double>(revision_));
        const Eye eye(camera);
        if (is_elsewhere(eye)) start();
        move_to(eye, budget);
        Update update;
        const std::uint32_t most = std::min(budget.leaves, max_leaves_);
        const auto changed_split = [&](const Diamond& diamond) {
            after_split(diamond);
            ++update.splits;
        };
        const auto changed_merge = [&](const Diamond& diamond) {
            after_merge(diamond);
            ++update.merges;
        };
        const auto is_over = [&](std::uint32_t steps) {
            // Time is left for writing the new vertices.
            return budget.milliseconds > 0 && steps % 4 == 0 &&
                   milliseconds_since(begin) + update.splits * vertex_milliseconds_ > 0.9 * budget.milliseconds;
        };
        for (std::uint32_t steps = 1;; ++steps) {
            const bool too_many = forest_.leaf_count() > most;
            if (!too_many && is_over(steps)) {
                update.complete = false;
                break;
            }
            const int split = candidates_.highest(Kind::split);
            if ((split < level_ || candidates_.has_many_due()) && look_at_due()) continue;
            const int merge = candidates_.lowest(Kind::merge);
            level_ = std::max(k_limit_bucket, split);
            exact_from_ = std::min(exact_from_, level_);
            bool may_merge = merge < merge_bucket_ || (too_many && merge < Candidates::k_buckets);
            if (!too_many && split >= k_limit_bucket) {
                const std::uint32_t node = candidates_.first(Kind::split, split);
                const std::uint32_t room = most - forest_.leaf_count();
                // Without room for a split only one is evaluated: tiles in use stay loaded, and others find no room.
                if (look_at_first(Kind::split, split, room >= 2 ? Candidates::k_batch : 1)) continue;
                const LeafId leaf(candidates_.owner(node));
                if (forest_.split_cost(leaf).leaves <= room && forest_.split_diamond(leaf, changed_split)) continue;
                // No room for the split, unless merging a smaller error makes some.
                may_merge = may_merge || merge <= split - 2;
            }
            if (!may_merge) {
                if (look_at_due()) continue;
                break;
            }
            const std::uint32_t node = candidates_.first(Kind::merge, merge);
            if (look_at_first(Kind::merge, merge)) continue;
            forest_.merge_diamond(LeafId(candidates_.owner(node)), changed_merge);
        }
        exact_from_ = level_;
        work_ended_ = update.complete;
        update.complete = work_ended_ && !is_stale_;
        close_up(is_over);
        const int left = candidates_.highest(Kind::split);
        const double over = update.complete && left >= k_limit_bucket ? edge_of(left + 1)
                            : update.complete                         ? 1
                                                                      : k_infinite;
        update.pixel_error = over * budget.pixel_error;
        // Incomplete updates keep the scale of the last complete one; before that it is by the budget's pixel error. An
        // infinite error counts as the lower edge of the last bucket.
        if (update.complete || morph_scale_ == 0)
            morph_scale_ = eye_.pixels / budget.pixel_error /
                           (update.complete ? std::min(over, edge_of(Candidates::k_buckets - 1)) : 1);
        update.morph_scale = morph_scale_;
        update.leaves = forest_.leaf_count();
        update.waiting = candidates_.unknown_count();
        write_vertices();
        dirty_triangles_.take_ranges(forest_.leaf_slots(), options_.max_ranges, triangle_ranges_);
        dirty_vertices_.take_ranges(forest_.point_slots(), options_.max_ranges, vertex_ranges_);
        update.triangles = triangle_ranges_;
        update.vertices = vertex_ranges_;
        return update;
    }

    void set_regions(std::vector<Region> regions) {
        for (const Region& region : regions)
            if (!is_finite(region.center) || !(region.radius >= 0) || !(region.boost >= 1) ||
                !std::isfinite(region.boost))
                refuse(fmt::format("a region of radius {} with a boost of {}; radii start at 0, boosts at 1",
                                   region.radius, region.boost));
        regions_ = std::move(regions);
        is_stale_ = true;
        mark_vertices();
    }

    void set_origin(const Vec3d& origin) {
        constexpr double k_farthest = 1e30;  // coordinates must fit in floats
        if (!is_finite(origin) || std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)}) > k_farthest)
            refuse(fmt::format("an origin at ({}, {}, {}); coordinates are finite, up to {}", origin.x, origin.y,
                               origin.z, k_farthest));
        for (std::uint32_t p = 0; p < forest_.point_slots(); ++p) {
            if (!is_vertex(PointId(p))) continue;
            Vertex& v = vertices_[p];
            v.position = packed(unpacked(v.position) + origin_ - origin);
            v.on_edge = packed(unpacked(v.on_edge) + origin_ - origin);
        }
        origin_ = origin;
        mark_vertices();
    }

    std::uint64_t memory_bytes() const {
        return forest_.memory_bytes() + candidates_.memory_bytes() + dirty_triangles_.memory_bytes() +
               dirty_vertices_.memory_bytes() + triangles_.capacity() * sizeof(Triangle) +
               vertices_.capacity() * sizeof(Vertex) +
               (leaf_candidate_.capacity() + point_candidate_.capacity()) * sizeof(std::uint32_t);
    }

    const Surface& surface_;
    ViewOptions options_;
    BisectionForest forest_;
    std::uint32_t max_leaves_ = 0;
    Vec3d origin_{};
    detail::PoolVector<Triangle> triangles_;  // by leaf slots
    detail::PoolVector<Vertex> vertices_;     // by points

  private:
    /// Slots, points, candidates and bytes for `leaves` leaves. Valid only while all leaves are roots.
    struct Room {
        std::uint64_t slots, points, midpoints, candidates, bytes;
    };
    Room room(std::uint64_t leaves) const {
        constexpr std::uint64_t k_slot_bytes = sizeof(BisectionLeaf) + sizeof(Triangle) + sizeof(std::uint32_t) + 1,
                                k_point_bytes = sizeof(Site) + sizeof(Vertex) + sizeof(std::uint32_t) + 1,
                                k_candidate_bytes = 44,  // with its waits
            k_bytes = 384 << 10;
        const std::uint64_t roots = forest_.leaf_count(), sides = forest_.mesh().halfedge_count();
        Room room{};
        room.slots = leaves + sides - roots;
        // Half as many vertices as triangles, and on the boundary some multiple of the square root of `leaves`.
        room.midpoints = leaves / 2 + 4 * static_cast<std::uint64_t>(std::sqrt(static_cast<double>(leaves))) + roots;
        room.points = room.midpoints + forest_.point_slots();
        // One candidate to split for two leaves, and one to merge for four leaves; more along the boundary.
        room.candidates = leaves - leaves / 4 + roots;
        room.bytes =
            room.slots * k_slot_bytes + room.points * k_point_bytes + room.candidates * k_candidate_bytes + k_bytes;
        return room;
    }
    /// A diamond as seen from the eye.
    struct Look {
        double size = 0;  // error on screen at distance 1, in multiples of the allowed one
        double distance = 0;
        bool inside = true;         // the frustum
        double gap = 0, reach = 0;  // motion after which `inside` may change; distance of the box's farthest point
        double at(double weight) const { return size == 0 ? 0 : weight * size / distance; }
    };

    void move_to(const Eye& eye, const Budget& budget) {
        const double scale = eye.pixels / budget.pixel_error;
        const bool is_other = is_stale_ || scale != scale_ || !eye.has_opening_of(eye_);
        is_stale_ = is_other;
        // With a time budget, a full re-evaluation of all candidates is finished over several updates before the next
        // one begins. The changes that it leads to then get as many updates again.
        ++updates_since_look_;
        if (is_looking_ && candidates_.has_many_fresh())
            updates_to_look_ = updates_since_look_;
        else
            is_looking_ = false;
        if (is_stale_ && (budget.milliseconds == 0 || work_ended_ || updates_since_look_ > 2 * updates_to_look_)) {
            candidates_.advance_all();
            is_stale_ = false;
            is_looking_ = true;
            updates_since_look_ = updates_to_look_ = 0;
        }
        const double travel = glm::length(eye.at - eye_.at), turn = eye.turn_to(eye_);
        // If the camera stands still, evaluations stay valid, unless the surface may have unloaded bounds since.
        if (is_other || travel > 0 || turn > 0 || revision_ != 0) candidates_.begin_round();
        eye_ = eye;
        scale_ = scale;
        odometers_.move(travel, turn, candidates_);
    }

    /// Restarts from the roots.
    void start() {
        forest_.clear();
        candidates_.clear();
        is_stale_ = false;
        std::fill(leaf_candidate_.begin(), leaf_candidate_.end(), Candidates::k_none);
        std::fill(point_candidate_.begin(), point_candidate_.end(), Candidates::k_none);
        mark_vertices();
        for (std::uint32_t i = 0; i < forest_.leaf_slots(); ++i)
            if (forest_.is_leaf(LeafId(i))) added(LeafId(i));
    }

    /// Whether half of the diamonds that can be merged are so much farther from `eye` than before that they have to be.
    /// A restart from the roots then takes less time than the merges.
    bool is_elsewhere(const Eye& eye) const {
        constexpr std::uint32_t k_samples = 64;
        const std::uint32_t slots = forest_.point_slots();
        std::uint32_t count = 0, far = 0;
        for (std::uint32_t i = 0; i < k_samples; ++i) {
            const auto p = static_cast<std::uint32_t>(std::uint64_t{slots} * i / k_samples);
            if (point_candidate_[p] == Candidates::k_none) continue;
            const Vec3d at = unpacked(vertices_[p].position) + origin_;
            ++count;
            far += options_.hysteresis * glm::length(at - eye.at) > glm::length(at - eye_.at);
        }
        return count >= k_samples / 4 && 2 * far >= count;
    }

    double boost(const DiamondBounds& bounds) const {
        double boost = 1;
        for (const Region& region : regions_) {
            const Vec3d off = glm::max(glm::abs(bounds.center - region.center) - bounds.half_sides, Vec3d(0));
            if (region.boost > boost && glm::dot(off, off) <= region.radius * region.radius) boost = region.boost;
        }
        return boost;
    }

    Look look_at(const DiamondBounds& bounds) const {
        const Vec3d center = bounds.center - eye_.at, off = detail::absolute(center);
        Look look;
        look.distance = glm::length(glm::max(off - bounds.half_sides, Vec3d(0)));
        look.size = std::min(1e300, bounds.error * boost(bounds) * scale_);  // products with weights stay finite
        // `least` and `reach` are no smaller for a box that contains this one. So if a diamond is inside, a coarser one
        // whose box contains its box is inside, too.
        const double least = eye_.inside(center, bounds.half_sides);
        look.reach = glm::length(off + bounds.half_sides);
        look.inside = least >= -k_beside * look.reach;
        // A box that leaves the frustum may be noticed late, but not a box that enters it.
        look.gap = look.inside ? std::max(least, 0.0) + k_late * look.reach : -least;
        return look;
    }

    /// Evaluates a batch of due candidates; false: none is due.
    bool look_at_due() {
        const std::size_t count = candidates_.take_due(due_);
        look(std::span(due_).first(count));
        return count > 0;
    }
    /// Evaluates candidates for the present eye, and lists them accordingly.
    void look(std::span<const std::uint32_t> nodes) {
        // Bound by memory latency: the cache misses of a batch overlap.
        for (const std::uint32_t node : nodes) __builtin_prefetch(&forest_.leaf(LeafId(candidates_.owner(node))));
        for (const std::uint32_t node : nodes)
            __builtin_prefetch(&forest_.point_site(forest_.leaf(LeafId(candidates_.owner(node))).vertex[2]));
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const LeafId leaf(candidates_.owner(nodes[i]));
            sites_[i] = candidates_.kind(nodes[i]) == Kind::split ? midpoint_site(leaf)
                                                                  : forest_.point_site(forest_.leaf(leaf).vertex[2]);
        }
        try {
            surface_.bounds(std::span(sites_).first(nodes.size()), std::span(bounds_).first(nodes.size()));
        } catch (...) {
            candidates_.give_back(nodes);
            throw;
        }
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (bounds_[i].known)
                list(nodes[i], look_at(bounds_[i]));
            else
                wait_for_revision(nodes[i]);
        }
    }
    /// Lists a candidate of unknown bounds: it is never split, and merged only if there are too many leaves.
    void wait_for_revision(std::uint32_t node) {
        const bool is_split = candidates_.kind(node) == Kind::split;
        // It is due at the next revision; the fraction distinguishes this wait from earlier ones of the candidate.
        constexpr std::uint32_t k_parts = 1 << 20;
        const double part = static_cast<double>(++revision_waits_ % k_parts + 1) / k_parts;
        candidates_.list(node, is_split ? 0 : Candidates::k_buckets - 1, true, Candidates::k_revisions,
                         static_cast<double>(revision_) + part);
    }
    /// Evaluates at most `most` candidates at the front of a bucket, unless the first one is known. Returns whether the
    /// first one has left the bucket.
    bool look_at_first(Kind kind, int bucket, std::size_t most = Candidates::k_batch) {
        const std::uint32_t first = candidates_.first(kind, bucket);
        // A split or merge reads and writes leaves beside and behind its own. For the next ones in the bucket, their
        // cache misses overlap with this change. (In a function of their own, compiled by GCC 12, they gained nothing.)
        const std::uint32_t second = candidates_.next(first), third = candidates_.next(second);
        const std::uint32_t fourth = candidates_.next(third);
        candidates_.prefetch(candidates_.next(fourth));
        __builtin_prefetch(&forest_.leaf(LeafId(candidates_.owner(fourth))));
        for (const LeafId beside : forest_.leaf(LeafId(candidates_.owner(third))).neighbour) {
            if (!beside.valid()) continue;
            __builtin_prefetch(&forest_.leaf(beside));
            __builtin_prefetch(&leaf_candidate_[beside.value]);
        }
        for (const LeafId beside : forest_.leaf(LeafId(candidates_.owner(second))).neighbour) {
            if (!beside.valid()) continue;
            candidates_.prefetch(leaf_candidate_[beside.value]);
            for (const LeafId behind : forest_.leaf(beside).neighbour)
                if (behind.valid()) __builtin_prefetch(&forest_.leaf(behind));
        }
        look(std::span(due_).first(candidates_.take_unknown(kind, bucket, std::span(due_).first(most))));
        return candidates_.first(kind, bucket) != first;
    }
    void list(std::uint32_t node, const Look& look) {
        const bool is_split = candidates_.kind(node) == Kind::split;
        const double weight = look.inside ? 1 : options_.outside_weight;
        // The weight to which a change can reverse the decision.
        const double other_weight = is_split ? 1 : options_.outside_weight;
        const int own = bucket_of(is_split ? look.at(weight) * k_room : look.at(weight) / k_room);
        // Errors far from the limit share a bucket.
        const int bucket = is_split ? std::max(own, exact_from_ - 1) : std::min(own, level_ - 1);
        const double edge = edge_of(is_split ? bucket + 1 : bucket);
        const bool always = look.size == 0 || edge == (is_split ? k_infinite : 0);
        // How far the eye may travel until the bucket may change.
        const double nearer = look.distance - weight * look.size / edge;
        double way = always ? k_infinite : is_split ? nearer : -nearer;
        std::size_t odometer = Odometers::k_travel;
        if (!always && weight != other_weight) {
            // A shorter length counts turns less, but allows less motion. It need not allow more than `way`.
            odometer = odometers_.at(look.reach * std::min(1.0, way / look.gap));
            way = std::min(way, odometers_.way(odometer, look.gap, look.reach));
        }
        const double now = odometers_.reading(odometer);
        candidates_.list(node, bucket, bucket == own, odometer,
                         std::max(now + way, now * (1 + std::numeric_limits<double>::epsilon())));
    }

    Site midpoint_site(LeafId id) const {
        const BisectionLeaf& leaf = forest_.leaf(id);
        return canonical(forest_.mesh(), {leaf.cell, leaf.shape().middle(leaf.depth), lattice_level(leaf.depth + 1)});
    }

    void forget(std::uint32_t& candidate) {
        if (candidate == Candidates::k_none) return;
        candidates_.remove(candidate);
        candidate = Candidates::k_none;
    }
    void show(LeafId id) {
        const auto& v = forest_.leaf(id).vertex;
        triangles_[id.value] = {v[0].value, v[1].value, v[2].value};
        dirty_triangles_.mark(id.value);
    }
    /// Makes the diamond at a leaf's base a candidate, unless it is one by the leaf across the base. If that leaf is
    /// coarser, the diamond at its own base must be split first: its error and box are larger.
    void consider(LeafId id) {
        const BisectionLeaf& leaf = forest_.leaf(id);
        if (leaf.depth >= surface_.max_depth() || leaf_candidate_[id.value] != Candidates::k_none) return;
        const LeafId across = leaf.neighbour[0];
        if (across.valid() &&
            (forest_.depth(across) < leaf.depth || leaf_candidate_[across.value] != Candidates::k_none))
            return;
        leaf_candidate_[id.value] = candidates_.add(Kind::split, id.value);
    }
    void added(LeafId id) {
        show(id);
        consider(id);
    }

    void after_split(const Diamond& diamond) {
        const auto siblings = diamond.siblings();
        for (const auto& [child0, child1] : siblings) {
            forget(leaf_candidate_[child0.value]);
            forget(point_candidate_[forest_.leaf(child0).vertex[0].value]);  // the parents' apexes
        }
        for (const auto& [child0, child1] : siblings) {
            added(child0);
            added(child1);
        }
        point_candidate_[diamond.midpoint.value] = candidates_.add(Kind::merge, siblings[0][0].value);
        dirty_vertices_.mark(diamond.midpoint.value);
    }

    void after_merge(const Diamond& diamond) {
        forget(point_candidate_[diamond.midpoint.value]);
        for (const auto& [child0, child1] : diamond.siblings()) {
            forget(leaf_candidate_[child0.value]);
            forget(leaf_candidate_[child1.value]);
            triangles_[child1.value] = {};
            dirty_triangles_.mark(child1.value);
        }
        for (const auto& pair : diamond.siblings()) {
            const LeafId parent = pair[0];
            added(parent);
            const BisectionLeaf& leaf = forest_.leaf(parent);
            for (const LeafId beside : {leaf.neighbour[1], leaf.neighbour[2]})
                if (beside.valid() && forest_.depth(beside) > leaf.depth) forget(leaf_candidate_[beside.value]);
            const Diamond above = forest_.find_diamond(parent);
            if (above.pair_count == 0) continue;
            std::uint32_t& candidate = point_candidate_[above.midpoint.value];
            if (candidate == Candidates::k_none) candidate = candidates_.add(Kind::merge, above.pairs[0][0].value);
        }
    }

    /// If a third of the slots is free, moves the last triangles to free slots until only a fifth is free.
    template <class IsOver>
    void close_up(const IsOver& is_over) {
        constexpr std::uint32_t k_few = 256;
        const std::uint32_t leaves = forest_.leaf_count();
        if (forest_.leaf_slots() < leaves + leaves / 2 + k_few) return;
        const auto moved = [&](LeafId from, LeafId to) {
            std::uint32_t& candidate = leaf_candidate_[from.value];
            leaf_candidate_[to.value] = std::exchange(candidate, Candidates::k_none);
            if (leaf_candidate_[to.value] != Candidates::k_none)
                candidates_.set_owner(leaf_candidate_[to.value], to.value);
            // The leaf may have been the owner of its diamond's candidate.
            const std::uint32_t above = point_candidate_[forest_.leaf(to).vertex[2].value];
            if (above != Candidates::k_none && candidates_.owner(above) == from.value)
                candidates_.set_owner(above, to.value);
            show(to);
        };
        for (std::uint32_t steps = 1; forest_.leaf_slots() > leaves + leaves / 4 + k_few && !is_over(steps); ++steps)
            if (!forest_.move_last_leaf(moved)) return;
    }

    /// Vertices and centres of holes are points of the forest, but not of the surface.
    bool is_beside(const Site& site) const { return forest_.mesh().is_hole(forest_.mesh().face(site.root)); }
    bool is_vertex(PointId p) const { return forest_.is_point(p) && !is_beside(forest_.point_site(p)); }
    void mark_vertices() {
        for (std::uint32_t p = 0; p < forest_.point_slots(); ++p)
            if (is_vertex(PointId(p))) dirty_vertices_.mark(p);
    }
    void write_vertices() {
        constexpr std::size_t k_batch = 256;
        const auto begin = Clock::now();
        std::uint32_t count = 0;
        batch_points_.clear();
        batch_sites_.clear();
        const auto write = [&] {
            batch_places_.resize(batch_points_.size());
            batch_bounds_.resize(batch_points_.size());
            surface_.places(batch_sites_, batch_places_);
            // Vertices and centres of roots halve no edge.
            const auto moving = static_cast<std::size_t>(
                std::partition_point(batch_points_.begin(), batch_points_.end(),
                                     [&](std::uint32_t p) { return forest_.is_fixed(PointId(p)); }) -
                batch_points_.begin());
            surface_.bounds(std::span(batch_sites_).subspan(moving), std::span(batch_bounds_).subspan(moving));
            for (std::size_t i = 0; i < batch_points_.size(); ++i) {
                const Place& place = batch_places_[i];
                const DiamondBounds& bounds = batch_bounds_[i];
                if (!place.known) continue;  // it stays as it was
                vertices_[batch_points_[i]] = {.position = packed(place.position - origin_),
                                               .on_edge = packed(place.on_edge - origin_),
                                               .normal = detail::octahedral(place.normal),
                                               .uv = {static_cast<float>(place.uv.x), static_cast<float>(place.uv.y)},
                                               .error = i < moving ? std::numeric_limits<float>::infinity()
                                                                   : static_cast<float>(bounds.error * boost(bounds))};
            }
            batch_points_.clear();
            batch_sites_.clear();
        };
        dirty_vertices_.for_each([&](std::uint32_t p) {
            if (!forest_.is_point(PointId(p))) return;
            ++count;
            batch_points_.push_back(p);
            batch_sites_.push_back(forest_.point_site(PointId(p)));
            if (batch_sites_.size() == k_batch) write();
        });
        write();
        if (count != 0) vertex_milliseconds_ = milliseconds_since(begin) / count;
    }

    detail::PoolVector<std::uint32_t> leaf_candidate_, point_candidate_;  // by leaf slots and points
    Candidates candidates_;
    DirtySlots dirty_triangles_, dirty_vertices_;
    std::vector<Update::Range> triangle_ranges_, vertex_ranges_;
    std::vector<Region> regions_;
    Eye eye_{Camera{}};
    double scale_ = 0;  // size on screen of length 1 at distance 1, in multiples of the allowed pixel error
    Odometers odometers_;
    // The batch that is being evaluated.
    std::array<std::uint32_t, Candidates::k_batch> due_{};
    std::array<Site, Candidates::k_batch> sites_{};
    std::array<DiamondBounds, Candidates::k_batch> bounds_{};
    double morph_scale_ = 0;
    double vertex_milliseconds_ = 0;  // for writing a vertex, in the last update that wrote some
    std::uint64_t revision_ = 0;      // of the surface
    std::uint32_t revision_waits_ = 0;
    bool is_stale_ = false;    // evaluations are for other pixels or regions
    bool is_looking_ = false;  // a full re-evaluation is unfinished
    bool work_ended_ = true;   // in the last update
    std::uint64_t updates_since_look_ = 0, updates_to_look_ = 0;
    int merge_bucket_ = 0;
    int level_ = k_limit_bucket;       // bucket of the largest errors that are left
    int exact_from_ = k_limit_bucket;  // lowest level_ since the last update; smaller errors share a bucket
    std::vector<std::uint32_t> batch_points_;
    std::vector<Site> batch_sites_;
    std::vector<Place> batch_places_;
    std::vector<DiamondBounds> batch_bounds_;
};

View::View(const Surface& surface, const ViewOptions& options) : impl_(std::make_unique<Impl>(surface, options)) {}
View::~View() = default;
View::View(View&&) noexcept = default;
View& View::operator=(View&&) noexcept = default;

Update View::update(const Camera& camera, const Budget& budget) { return impl_->update(camera, budget); }
void View::set_regions(std::vector<Region> regions) { impl_->set_regions(std::move(regions)); }
Vec3d View::origin() const { return impl_->origin_; }
void View::set_origin(const Vec3d& origin) { impl_->set_origin(origin); }
std::span<const Vertex> View::vertices() const {
    return std::span(impl_->vertices_).first(impl_->forest_.point_slots());
}
std::span<const Triangle> View::triangles() const {
    return std::span(impl_->triangles_).first(impl_->forest_.leaf_slots());
}
std::uint32_t View::leaf_count() const { return impl_->forest_.leaf_count(); }
std::uint32_t View::max_leaves() const { return impl_->max_leaves_; }
std::uint32_t View::vertex_capacity() const { return static_cast<std::uint32_t>(impl_->vertices_.size()); }
std::uint32_t View::triangle_capacity() const { return static_cast<std::uint32_t>(impl_->triangles_.size()); }
std::uint64_t View::memory_bytes() const { return impl_->memory_bytes(); }

TriangleMesh View::mesh() const {
    const BisectionForest& forest = impl_->forest_;
    ExportedTriangles out;
    for (std::uint32_t i = 0; i < forest.leaf_slots(); ++i) {
        if (!forest.is_leaf(LeafId(i))) continue;
        const auto& v = forest.leaf(LeafId(i)).vertex;
        out.triangles.push_back({v[0].value, v[1].value, v[2].value});
    }
    detail::number_points(out, forest, out.triangles.size() / 2);
    TriangleMesh mesh;
    mesh.triangles = std::move(out.triangles);
    std::vector<Place> places(out.sites.size());
    impl_->surface_.places(out.sites, places);
    for (std::size_t i = 0; i < places.size(); ++i) {
        Place& place = places[i];
        if (!place.known) {
            const Vertex& v = impl_->vertices_[out.points[i].value];
            place.position = unpacked(v.position) + impl_->origin_;
            place.normal = detail::from_octahedral(v.normal);
            place.uv = {v.uv[0], v.uv[1]};
        }
        mesh.positions.push_back(place.position);
        mesh.normals.push_back(place.normal);
        mesh.uvs.push_back(place.uv);
    }
    mesh.triangle_uvs = mesh.triangles;
    return mesh;
}

std::vector<std::array<Site, 3>> View::leaves() const {
    const BisectionForest& forest = impl_->forest_;
    std::vector<std::array<Site, 3>> leaves;
    for (std::uint32_t i = 0; i < forest.leaf_slots(); ++i) {
        if (!forest.is_leaf(LeafId(i))) continue;
        const auto& v = forest.leaf(LeafId(i)).vertex;
        leaves.push_back({forest.point_site(v[0]), forest.point_site(v[1]), forest.point_site(v[2])});
    }
    return leaves;
}

Vec3d shown_position(const Vertex& vertex, const Vec3d& eye, double morph_scale) {
    const Vec3d at = unpacked(vertex.position), on_edge = unpacked(vertex.on_edge);
    const double ratio = vertex.error > 0 ? glm::length(at - eye) / (double{vertex.error} * morph_scale) : k_infinite;
    return glm::mix(at, on_edge, std::clamp((ratio - k_morph_begin) / (1 - k_morph_begin), 0.0, 1.0));
}

}  // namespace tetrakis::lod
