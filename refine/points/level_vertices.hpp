#pragma once

#include "../../hier/base/vec.hpp"
#include "../lattices/root_lattices.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// The vertices of one level that a block needs, each once, and their stencils on the level above.
class LevelVertices {
  public:
    std::vector<RootPlace> keys;
    std::vector<std::uint32_t> stencil_begin;  ///< per key, into `source` and `weight`
    std::vector<std::uint32_t> source;         ///< vertices of the level above
    std::vector<double> weight;
    std::vector<Vec3d> value;

    std::uint32_t insert(const RootPlace& key) {
        if (2 * (std::size_t{count_} + 1) > slots_.size()) grow();
        Slot& slot = find_slot(key);
        if (slot.number == k_empty) {
            // What may throw comes first: a slot that is not listed would never be emptied.
            keys.push_back(key);
            slot_of_.push_back(static_cast<std::uint32_t>(&slot - slots_.data()));
            slot = {key, count_++};
        }
        return slot.number;
    }
    /// Cost: that of what is in it; the table keeps its size, unless it is large.
    void clear() {
        constexpr std::size_t k_large = 1u << 15;
        if (slots_.size() > k_large) {
            *this = LevelVertices();
            return;
        }
        for (const std::uint32_t s : slot_of_) slots_[s] = Slot{};
        slot_of_.clear();
        keys.clear();
        count_ = 0;
        stencil_begin.clear();
        source.clear();
        weight.clear();
        value.clear();
    }

  private:
    static constexpr std::uint32_t k_empty = 0xFFFF'FFFFu;
    struct Slot {
        RootPlace key{};
        std::uint32_t number = k_empty;
    };

    static std::uint64_t hash(const RootPlace& key) {
        // Multiplicative mixing (Knuth, TAOCP 3, 6.4, with 64-bit odd constants), the upper bits being the good ones.
        std::uint64_t h = (std::uint64_t{key.x} << 32 | key.y) * 0x9E37'79B9'7F4A'7C15u;
        h = (h ^ h >> 29 ^ key.root) * 0xBF58'476D'1CE4'E5B9u;
        return h ^ h >> 32;
    }
    Slot& find_slot(const RootPlace& key) {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t i = hash(key) & mask;; i = (i + 1) & mask)
            if (slots_[i].number == k_empty || slots_[i].key == key) return slots_[i];
    }
    void grow() {
        slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), Slot{});
        for (std::uint32_t i = 0; i < keys.size(); ++i) {
            Slot& slot = find_slot(keys[i]);
            slot = {keys[i], i};
            slot_of_[i] = static_cast<std::uint32_t>(&slot - slots_.data());
        }
    }

    std::vector<Slot> slots_;
    std::vector<std::uint32_t> slot_of_;  // per key
    std::uint32_t count_ = 0;             // of the keys
};

/// Points of the vertices collected on levels 1 to `deepest`, from those that they lead to: everything above them is
/// collected first, level by level. Level 0 is whole: its vertices are numbers.
/// @param stencil  (vertex, level, add): calls add(vertex of the level above, weight) for its terms
/// @param number   (vertex of level 0)
/// @param base     points of level 0
template <class Stencil, class Number>
void evaluate_levels(std::span<LevelVertices> levels, int deepest, const Stencil& stencil, const Number& number,
                     std::span<const Vec3d> base) {
    for (int l = deepest; l > 0; --l) {
        LevelVertices &level = levels[static_cast<std::size_t>(l)], &above = levels[static_cast<std::size_t>(l) - 1];
        level.stencil_begin.push_back(0);
        for (const RootPlace& key : level.keys) {
            stencil(key, l, [&](const RootPlace& from, double weight) {
                level.source.push_back(l == 1 ? number(from) : above.insert(from));
                level.weight.push_back(weight);
            });
            level.stencil_begin.push_back(static_cast<std::uint32_t>(level.source.size()));
        }
    }
    for (int l = 1; l <= deepest; ++l) {
        LevelVertices& level = levels[static_cast<std::size_t>(l)];
        const std::span<const Vec3d> above =
            l == 1 ? base : std::span<const Vec3d>(levels[static_cast<std::size_t>(l) - 1].value);
        level.value.resize(level.keys.size());
        for (std::size_t i = 0; i < level.keys.size(); ++i) {
            Vec3d sum(0);
            for (std::uint32_t k = level.stencil_begin[i]; k < level.stencil_begin[i + 1]; ++k)
                sum += level.weight[k] * above[level.source[k]];
            level.value[i] = sum;
        }
    }
}

}  // namespace tetrakis::detail
