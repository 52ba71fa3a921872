#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// The diamonds that a view may split or merge, each listed twice: by how urgent that is, in buckets, and by how far
/// the camera can move before it has to be looked at again. All of it is O(1), but that a candidate is sorted anew a
/// few times until it is due (a radix heap: Ahuja, Mehlhorn, Orlin, Tarjan 1990).
class Candidates {
  public:
    enum class Kind : std::uint8_t { split, merge };
    static constexpr std::size_t k_odometers = 36;
    static constexpr std::size_t k_revisions = k_odometers;  ///< one more: what waits for a revision of the surface
    static constexpr std::uint32_t k_none = ~std::uint32_t{0};
    static constexpr int k_buckets = 128;

    Candidates() : nodes_(k_rings), due_((k_odometers + 1) * k_digits) {
        for (std::uint32_t i = 0; i < k_rings; ++i) nodes_[i].next = nodes_[i].prev = i;
    }
    void reserve(std::uint32_t candidates) { nodes_.reserve(k_rings + std::size_t{candidates}); }

    /// A new candidate, which has to be looked at.
    /// @param owner  whatever the caller wants to know of it
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
        stop_waiting(node);
        set_odometer(nodes_[node], 0);
        nodes_[node].due_at = k_free;
        nodes_[node].owner = free_;
        free_ = node;
    }

    Kind kind(std::uint32_t node) const { return nodes_[node].kind; }
    std::uint32_t owner(std::uint32_t node) const { return nodes_[node].owner; }
    void set_owner(std::uint32_t node, std::uint32_t owner) { nodes_[node].owner = owner; }
    int bucket(std::uint32_t node) const { return nodes_[node].bucket; }
    /// Whether its own bucket was told since the last call of begin_round().
    bool is_known(std::uint32_t node) const { return nodes_[node].round == round_; }
    void begin_round() { ++round_; }
    bool is_unknown(std::uint32_t node) const { return nodes_[node].odometer == k_revisions; }
    /// How many are.
    std::uint32_t unknown_count() const { return unknown_count_; }

    /// A candidate's bucket, and the reading of an odometer, beyond the present one, at which it is due: from when on
    /// it may belong into another bucket.
    /// @param is_own  whether it belongs there, and not somewhere beyond
    void list(std::uint32_t node, int bucket, bool is_own, std::size_t odometer, double due_at) {
        stop_waiting(node);
        Node& n = nodes_[node];
        if (n.bucket != bucket) {
            leave_bucket(node);
            n.bucket = static_cast<std::uint8_t>(bucket);
            n.prev = ring(n.kind, bucket);
            n.next = std::exchange(nodes_[n.prev].next, node);
            nodes_[n.next].prev = node;
            mask(n.kind, bucket) |= std::uint64_t{1} << (bucket % 64);
        }
        set_odometer(n, odometer);
        n.due_at = due_at;
        n.round = is_own ? round_ : round_ - 1;
        wait(node);
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
    std::uint32_t first(Kind kind, int bucket) const { return nodes_[ring(kind, bucket)].next; }

    /// An odometer moves on; its readings are not negative and never fall.
    void advance(std::size_t odometer, double reading) {
        double& now = now_[odometer];
        if (reading == now) return;
        const auto highest = static_cast<std::size_t>(std::bit_width(bits(reading) ^ bits(now)));
        now = reading;
        // What differed from the reading in lower digits than the highest one that changes is due; what differed in
        // that one is due or to be sorted anew.
        for (std::size_t i = 0; i <= highest; ++i)
            if (auto& list = due_[odometer * k_digits + i]; !list.empty()) ripe_.push_back(std::exchange(list, {}));
    }
    /// Readings begin anew, and everything has to be looked at again. O(candidates).
    void restart(double reading) {
        std::fill_n(now_.begin(), k_odometers, reading);
        advance_all();
    }
    /// Everything has to be looked at again. O(candidates).
    void advance_all() {
        for (auto& list : due_) list.clear();
        ripe_.clear();
        fresh_.clear();
        for (std::uint32_t i = k_rings; i < nodes_.size(); ++i) {
            if (nodes_[i].due_at == k_free) continue;
            nodes_[i].due_at = 0;
            nodes_[i].round = round_ - 1;
            fresh_.push_back(i);
        }
    }
    /// Candidates that are due; list() of each is to follow.
    /// @return  how many there are; 0: no more
    std::size_t take_due(std::span<std::uint32_t> nodes) {
        constexpr std::size_t k_ahead = 8;
        std::size_t count = 0;
        while (count < nodes.size()) {
            if (next_ == current_.size()) {
                next_ = 0;
                current_.clear();
                if (!fresh_.empty()) {
                    std::swap(current_, fresh_);
                } else if (!ripe_.empty()) {
                    current_ = std::move(ripe_.back());
                    ripe_.pop_back();
                } else {
                    break;
                }
            }
            if (next_ + k_ahead < current_.size()) __builtin_prefetch(&nodes_[current_[next_ + k_ahead]]);
            const std::uint32_t node = current_[next_++];
            const Node& n = nodes_[node];
            // It may have been removed or listed since.
            if (n.due_at == k_free || is_waiting(node)) continue;
            if (n.due_at <= now_[n.odometer])
                nodes[count++] = node;
            else
                wait(node);
        }
        return count;
    }

    std::uint64_t memory_bytes() const {
        std::uint64_t waiting = current_.capacity() + fresh_.capacity();
        for (const auto& list : due_) waiting += list.capacity();
        for (const auto& list : ripe_) waiting += list.capacity();
        return nodes_.capacity() * sizeof(Node) + waiting * sizeof(std::uint32_t);
    }

  private:
    struct Node {
        double due_at = 0;         // k_free: not in use
        std::uint32_t next, prev;  // of its bucket, a ring
        std::uint32_t place;       // in a list of due_
        std::uint32_t owner;       // of those not in use: the next one
        std::uint32_t round;       // in which it was listed in its own bucket
        Kind kind;
        std::uint8_t odometer = 0, bucket;
    };
    static_assert(sizeof(Node) == 32);
    static constexpr std::uint32_t k_rings = 2 * k_buckets;  // the first nodes: one in each bucket's ring
    static constexpr std::size_t k_digits = 65;
    static constexpr std::uint8_t k_unlisted = 255;
    static constexpr double k_free = -1;

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

    // As integers, readings have the same order.
    static std::uint64_t bits(double reading) { return std::bit_cast<std::uint64_t>(reading); }
    std::vector<std::uint32_t>& due_list(const Node& n) {
        return due_[n.odometer * k_digits +
                    static_cast<std::size_t>(std::bit_width(bits(n.due_at) ^ bits(now_[n.odometer])))];
    }
    void wait(std::uint32_t node) {
        auto& list = due_list(nodes_[node]);
        nodes_[node].place = static_cast<std::uint32_t>(list.size());
        list.push_back(node);
    }
    /// What a ripe list names is not waiting any more.
    bool is_waiting(std::uint32_t node) {
        const Node& n = nodes_[node];
        if (!(n.due_at > now_[n.odometer])) return false;
        const auto& list = due_list(n);
        return n.place < list.size() && list[n.place] == node;
    }
    void stop_waiting(std::uint32_t node) {
        if (!is_waiting(node)) return;
        auto& list = due_list(nodes_[node]);
        list[nodes_[node].place] = list.back();
        nodes_[list.back()].place = nodes_[node].place;
        list.pop_back();
    }

    std::vector<Node> nodes_;
    std::uint32_t free_ = k_none, round_ = 0, unknown_count_ = 0;
    std::array<std::array<std::uint64_t, 2>, 2> masks_{};  // by kind: buckets that are not empty
    std::array<double, k_odometers + 1> now_{};
    std::vector<std::vector<std::uint32_t>> due_;   // by odometer and the highest digit in which now is different
    std::vector<std::vector<std::uint32_t>> ripe_;  // lists of due_ that are to be gone through
    std::vector<std::uint32_t> fresh_, current_;    // new ones; those that are gone through, from next_ on
    std::size_t next_ = 0;
};

}  // namespace tetrakis::detail
