#pragma once

#include "../../hier/base/memory.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The diamonds that a view may split or merge. Each is listed twice: in a bucket for its urgency, and in a radix heap
/// (Ahuja, Mehlhorn, Orlin, Tarjan 1990) by the odometer reading at which it must be evaluated again. Its entry there,
/// a wait, is sorted anew a few times until it is due; all else is O(1) for a candidate. If a candidate is listed again
/// or removed, its old wait is idle: it stays until it is due, or until there are too many waits.
class Candidates {
  public:
    enum class Kind : std::uint8_t { split, merge };
    static constexpr std::size_t k_odometers = 36;
    static constexpr std::size_t k_revisions = k_odometers;  ///< one more: it reads the surface's revision
    static constexpr std::uint32_t k_none = ~std::uint32_t{0};
    static constexpr int k_buckets = 128;
    static constexpr std::size_t k_batch = 32;  ///< candidates evaluated together, so that their cache misses overlap

    Candidates() : due_((k_odometers + 1) * k_digits) { clear(); }
    /// Removes all candidates; the odometers keep their readings.
    void clear() {
        nodes_.resize(k_rings);
        for (std::uint32_t i = 0; i < k_rings; ++i) nodes_[i].next = nodes_[i].prev = i;
        masks_ = {};
        free_ = k_none;
        unknown_count_ = 0;
        drop_waits();
    }
    void reserve(std::uint32_t candidates) {
        nodes_.reserve(k_rings + std::size_t{candidates});
        wish_for_small_pages(nodes_);
    }

    /// Adds a candidate, which is due at once.
    /// @param owner  a number that the caller associates with it
    std::uint32_t add(Kind kind, std::uint32_t owner) {
        std::uint32_t node = free_;
        if (node == k_none) {
            node = static_cast<std::uint32_t>(nodes_.size());
            nodes_.emplace_back();
        } else {
            free_ = nodes_[node].owner;
        }
        Node& n = nodes_[node];
        n.owner = owner;
        n.kind = kind;
        n.bucket = k_unlisted;
        n.due_at = 0;
        n.round = round_ - 1;
        fresh_.push_back(node);
        return node;
    }
    void remove(std::uint32_t node) {
        leave_bucket(node);
        set_odometer(nodes_[node], 0);
        nodes_[node].due_at = k_free;
        nodes_[node].owner = free_;
        free_ = node;
    }

    Kind kind(std::uint32_t node) const { return nodes_[node].kind; }
    std::uint32_t owner(std::uint32_t node) const { return nodes_[node].owner; }
    void set_owner(std::uint32_t node, std::uint32_t owner) { nodes_[node].owner = owner; }
    /// Whether list() was called for it with `is_own` since the last call of begin_round().
    bool is_known(std::uint32_t node) const { return nodes_[node].round == round_; }
    void begin_round() { ++round_; }
    /// Number of candidates that wait for a revision of the surface.
    std::uint32_t unknown_count() const { return unknown_count_; }

    /// Sets a candidate's bucket, and the reading of an odometer from which on it may belong to another bucket.
    /// `due_at` must exceed the present reading, and differ from the candidate's earlier ones: it identifies the wait.
    /// @param is_own  whether `bucket` is its exact bucket, and not one that several share
    void list(std::uint32_t node, int bucket, bool is_own, std::size_t odometer, double due_at) {
        Node& n = nodes_[node];
        if (n.bucket != bucket) {
            leave_bucket(node);
            n.bucket = static_cast<std::uint8_t>(bucket);
            n.prev = ring(n.kind, bucket);
            n.next = std::exchange(nodes_[n.prev].next, node);
            nodes_[n.next].prev = node;
            mask(n.kind, bucket) |= std::uint64_t{1} << (bucket % 64);
        }
        const bool waits_already = n.due_at == due_at && n.odometer == odometer;
        set_odometer(n, odometer);
        n.due_at = due_at;
        n.round = is_own ? round_ : round_ - 1;
        if (waits_already || due_at == std::numeric_limits<double>::infinity()) return;
        wait(odometer, {due_at, node});
        if (++waits_ > nodes_.size() + nodes_.size() / 8) drop_some_idle_waits();
    }

    /// The highest bucket that is not empty; -1: all are.
    int highest(Kind kind) const {
        const auto& mask = masks_[static_cast<std::size_t>(kind)];
        return mask[1] != 0 ? 127 - std::countl_zero(mask[1]) : mask[0] != 0 ? 63 - std::countl_zero(mask[0]) : -1;
    }
    /// The lowest one; k_buckets: all are empty.
    int lowest(Kind kind) const {
        const auto& mask = masks_[static_cast<std::size_t>(kind)];
        return mask[0] != 0 ? std::countr_zero(mask[0]) : mask[1] != 0 ? 64 + std::countr_zero(mask[1]) : k_buckets;
    }
    std::uint32_t next(std::uint32_t node) const { return nodes_[node].next; }  ///< in its bucket; owner 0: the end
    void prefetch(std::uint32_t node) const {
        if (node != k_none) __builtin_prefetch(&nodes_[node]);
    }
    std::uint32_t first(Kind kind, int bucket) const { return nodes_[ring(kind, bucket)].next; }

    /// Advances an odometer; its readings are not negative and never fall.
    void advance(std::size_t odometer, double reading) {
        double& now = now_[odometer];
        if (reading == now) return;
        const auto highest = static_cast<std::size_t>(std::bit_width(bits(reading) ^ bits(now)));
        now = reading;
        // Waits whose highest different digit was below the highest digit that changes now are due. Waits that differed
        // first in that digit are due or have to be sorted anew.
        for (std::size_t i = 0; i <= highest; ++i)
            for (auto& lists = due_[odometer * k_digits + i]; !lists.empty(); lists.pop_back())
                ripe_.push_back({odometer, std::move(lists.back())});
    }
    /// Sets all odometers but k_revisions to `reading`, which may be smaller; all candidates are due. O(candidates).
    void restart(double reading) {
        std::fill_n(now_.begin(), k_odometers, reading);
        advance_all();
    }
    /// Makes all candidates due. O(candidates).
    void advance_all() {
        drop_waits();
        for (std::uint32_t i = k_rings; i < nodes_.size(); ++i) {
            if (nodes_[i].due_at == k_free) continue;
            nodes_[i].due_at = 0;
            nodes_[i].round = round_ - 1;
            fresh_.push_back(i);
        }
    }
    /// Whether at least a batch of candidates is due whatever the odometers read: mostly after advance_all().
    bool has_many_fresh() const { return fresh_.size() >= k_batch; }
    /// Whether to call take_due() although others are as urgent as those that were split. New candidates can wait until
    /// there are many: their errors are smaller than the error of the diamond whose split made them possible.
    bool has_many_due() const { return !ripe_.empty() || has_many_fresh(); }
    /// Takes due candidates, written to the front of `nodes`; the caller must then call list() for each.
    /// @return  their number; 0: none is due
    std::size_t take_due(std::array<std::uint32_t, k_batch>& nodes) {
        std::size_t count = 0;
        while (count == 0 && !(fresh_.empty() && ripe_.empty())) {
            std::array<Wait, k_batch> taken;
            std::size_t waits = 0;
            const auto take = [&](const Wait& wait) {
                __builtin_prefetch(&nodes_[wait.node]);
                taken[waits++] = wait;
            };
            for (; waits < k_batch && !fresh_.empty(); fresh_.pop_back()) take({0.0, fresh_.back()});
            while (waits < k_batch && !ripe_.empty()) {
                auto& [odometer, list] = ripe_.back();
                for (; waits < k_batch && !list.empty(); list.pop_back()) {
                    if (list.back().due_at > now_[odometer]) {
                        wait(odometer, list.back());
                    } else {
                        take(list.back());
                        --waits_;
                    }
                }
                if (list.empty()) ripe_.pop_back();
            }
            for (const Wait& wait : std::span(taken).first(waits)) {
                Node& n = nodes_[wait.node];
                if (n.due_at != wait.due_at) continue;
                n.due_at = k_taken;
                nodes[count++] = wait.node;
            }
        }
        return count;
    }
    /// Makes candidates due again that were taken, but not evaluated.
    void give_back(std::span<const std::uint32_t> nodes) {
        for (const std::uint32_t node : nodes) nodes_[node].due_at = 0;
        fresh_.insert(fresh_.end(), nodes.begin(), nodes.end());
    }
    /// Writes the first candidates of a bucket to `nodes`, but none from the first is_known() candidate on. Returns
    /// their number.
    std::size_t take_unknown(Kind kind, int bucket, std::span<std::uint32_t> nodes) const {
        std::size_t count = 0;
        for (std::uint32_t node = first(kind, bucket);
             count < nodes.size() && node != ring(kind, bucket) && !is_known(node); node = nodes_[node].next)
            nodes[count++] = node;
        return count;
    }

    std::uint64_t memory_bytes() const {
        std::uint64_t waits = 0;
        for (const auto& lists : due_)
            for (const Waits& list : lists) waits += list.capacity();
        for (const auto& [odometer, list] : ripe_) waits += list.capacity();
        // Nodes that are only reserved take no memory.
        return nodes_.size() * sizeof(Node) + waits * sizeof(Wait) + fresh_.capacity() * sizeof(std::uint32_t);
    }

  private:
    using Reading [[gnu::aligned(4)]] = double;  // so that structs have no padding
    struct Node {
        Reading due_at;            // 0: in fresh_
        std::uint32_t next, prev;  // in the circular list of its bucket
        std::uint32_t owner;       // of unused nodes: the next unused one
        std::uint32_t round;       // last round in which its bucket was its own
        Kind kind;
        std::uint8_t odometer = 0, bucket;
    };
    static_assert(sizeof(Node) == 28);
    struct Wait {
        Reading due_at;
        std::uint32_t node;
    };
    static_assert(sizeof(Wait) == 12);
    using Waits = std::vector<Wait>;  // at most k_most_waits, so that no operation takes long
    static constexpr std::size_t k_most_waits = 1024;
    static constexpr std::uint32_t k_rings = 2 * k_buckets;  // the first nodes: heads of the buckets' lists
    static constexpr std::size_t k_digits = 65;
    static constexpr std::uint8_t k_unlisted = 255;
    static constexpr double k_free = -1, k_taken = -2;  // due_at of nodes not in use; being evaluated

    static constexpr std::uint32_t ring(Kind kind, int bucket) {
        return static_cast<std::uint32_t>(kind) * k_buckets + static_cast<std::uint32_t>(bucket);
    }
    std::uint64_t& mask(Kind kind, int bucket) {
        return masks_[static_cast<std::size_t>(kind)][static_cast<std::size_t>(bucket) / 64];
    }
    void leave_bucket(std::uint32_t node) {
        Node& n = nodes_[node];
        if (n.bucket == k_unlisted) return;
        nodes_[n.prev].next = n.next;
        nodes_[n.next].prev = n.prev;
        if (n.next == n.prev && n.next == ring(n.kind, n.bucket))
            mask(n.kind, n.bucket) &= ~(std::uint64_t{1} << (n.bucket % 64));
        n.bucket = k_unlisted;
    }

    void set_odometer(Node& n, std::size_t odometer) {
        unknown_count_ -= n.odometer == k_revisions;
        unknown_count_ += odometer == k_revisions;
        n.odometer = static_cast<std::uint8_t>(odometer);
    }

    // As integers, the bits of readings have the same order.
    static std::uint64_t bits(double reading) { return std::bit_cast<std::uint64_t>(reading); }
    void wait(std::size_t odometer, const Wait& wait) {
        const int digit = std::bit_width(bits(wait.due_at) ^ bits(now_[odometer]));
        auto& lists = due_[odometer * k_digits + static_cast<std::size_t>(digit)];
        if (lists.empty() || lists.back().size() == k_most_waits) lists.emplace_back();
        lists.back().push_back(wait);
    }
    void drop_waits() {
        for (auto& lists : due_) lists.clear();
        ripe_.clear();
        fresh_.clear();
        waits_ = 0;
    }
    /// Removes the idle waits of one list; the next call takes the next list.
    void drop_some_idle_waits() {
        auto& lists = due_[swept_];
        if (next_swept_ >= lists.size()) {
            std::erase_if(lists, [](const Waits& list) { return list.empty(); });
            swept_ = (swept_ + 1) % due_.size();
            next_swept_ = 0;
            return;
        }
        Waits& list = lists[next_swept_++];
        for (const Wait& wait : list) __builtin_prefetch(&nodes_[wait.node]);
        waits_ -= std::erase_if(list, [&](const Wait& wait) { return nodes_[wait.node].due_at != wait.due_at; });
        if (list.capacity() > list.size() + list.size() / 2) list.shrink_to_fit();
    }

    PoolVector<Node> nodes_;
    std::uint32_t free_ = k_none, round_ = 0, unknown_count_ = 0;
    std::array<std::array<std::uint64_t, 2>, 2> masks_{};  // by kind: buckets that are not empty
    std::array<double, k_odometers + 1> now_{};
    std::vector<std::vector<Waits>> due_;  // by odometer and highest digit in which due_at differs from now_
    std::vector<std::pair<std::size_t, Waits>> ripe_;  // lists of waits that may be due, with their odometers
    std::vector<std::uint32_t> fresh_;
    std::size_t waits_ = 0;                   // their number in due_ and ripe_
    std::size_t swept_ = 0, next_swept_ = 0;  // next list for drop_some_idle_waits()
};

// Errors are multiples of the budget's pixel error, in four buckets to a doubling.
inline constexpr int k_buckets_a_doubling = 4, k_limit_bucket = 48;
/// Bucket i holds the errors e with k_edges[i] <= e < k_edges[i + 1].
inline const std::array<double, Candidates::k_buckets + 1> k_edges = [] {
    std::array<double, Candidates::k_buckets + 1> edges{};
    for (int i = 1; i < Candidates::k_buckets; ++i)
        edges[i] = std::exp2(double(i - k_limit_bucket) / k_buckets_a_doubling);
    edges.back() = std::numeric_limits<double>::infinity();
    return edges;
}();
inline double edge_of(int bucket) { return k_edges[static_cast<std::size_t>(bucket)]; }
/// The integer part floor(log2(x)) for a normal positive `x`.
inline int exponent_of(double x) { return static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52) - 1023; }
inline int bucket_of(double error) {
    static_assert(k_buckets_a_doubling == 4 && k_limit_bucket % 4 == 0);
    if (!(error >= edge_of(1))) return 0;
    if (error >= edge_of(Candidates::k_buckets - 1)) return Candidates::k_buckets - 1;
    // As by std::log2(), but faster, and exact at the edges of buckets.
    const int octave = 4 * exponent_of(error) + k_limit_bucket;
    return octave + (error >= edge_of(octave + 1)) + (error >= edge_of(octave + 2)) + (error >= edge_of(octave + 3));
}

}  // namespace tetrakis::detail
