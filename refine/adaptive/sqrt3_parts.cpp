#include "sqrt3_parts.hpp"

#include <algorithm>
#include <cstddef>

namespace tetrakis::detail {

Sqrt3Parts::Sqrt3Parts(const Sqrt3Levels& levels)
    : levels_(levels), above_(levels.levels.size()), is_wanted_(levels.levels.size()), wanted_(levels.levels.size()) {
    levels.for_each_leaf([&](int level, std::uint32_t face, bool half, FaceId) {
        leaves_.push_back({face, static_cast<std::uint8_t>(level), half});
    });
    for (std::size_t k = 0; k < levels.levels.size(); ++k) {
        const Sqrt3Level& level = levels.levels[k];
        is_wanted_[k].resize(level.face_count(), 0);
        // Faces come in threes, in the order of those that they are in.
        for (std::uint32_t f = 0; f < level.face_count() && k + 1 < levels.levels.size(); ++f)
            if (Sqrt3Level::there(level.child[f])) above_[k + 1].push_back(f);
    }
}

void Sqrt3Parts::want(std::size_t level, std::uint32_t face) {
    if (is_wanted_[level][face] != 0) return;
    is_wanted_[level][face] = 1;
    wanted_[level].push_back(face);
}

/// What is split where a face is there: both faces of the edge that it lies across.
void Sqrt3Parts::want_above(std::size_t level, std::uint32_t face) {
    if (level == 0) return;
    const std::uint32_t above = above_[level][face / 3];
    want(level - 1, above);
    const std::uint32_t twin = levels_.levels[level - 1].twin[3 * above + face % 3];
    if (Sqrt3Level::there(twin)) want(level - 1, twin / 3);
}

Sqrt3Split Sqrt3Parts::split_for(std::span<const Sqrt3LevelLeaf> leaves) {
    for (const Sqrt3LevelLeaf& leaf : leaves) {
        if (leaf.half)
            want(leaf.level, leaf.face / 3);
        else
            want_above(leaf.level, leaf.face);
    }
    Sqrt3Split split;
    for (std::size_t k = levels_.levels.size(); k-- > 0;) {
        std::vector<std::uint32_t>& faces = wanted_[k];
        if (split.empty() && !faces.empty()) split.resize(k + 1);
        const Sqrt3Level& level = levels_.levels[k];
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const std::uint32_t face = faces[i];
            split[k].push_back(level.number[face]);
            want_above(k, face);
            // A cut edge is cut from both sides (Sqrt3Lattice::partner()).
            if (const Sqrt3Line* line = k % 2 != 0 ? level.line(3 * face) : nullptr;
                line != nullptr && Sqrt3Level::there(line->beyond) && level.split[line->beyond / 3] != 0)
                want(k, line->beyond / 3);
        }
        if (!split.empty()) std::sort(split[k].begin(), split[k].end());
        for (const std::uint32_t face : faces) is_wanted_[k][face] = 0;
        faces.clear();
    }
    return split;
}

std::uint32_t Sqrt3Parts::find(const Sqrt3LevelLeaf& leaf, const Sqrt3Levels& part) const {
    const std::uint32_t side = leaf.half ? leaf.face % 3 : 0, face = leaf.half ? leaf.face / 3 : leaf.face;
    const auto& numbers = part.levels[leaf.level].number;
    const auto at = std::lower_bound(numbers.begin(), numbers.end(), levels_.levels[leaf.level].number[face]);
    const auto found = static_cast<std::uint32_t>(at - numbers.begin());
    return leaf.half ? 3 * found + side : found;
}

std::uint64_t Sqrt3Parts::memory_bytes() const {
    std::uint64_t bytes = leaves_.capacity() * sizeof(leaves_[0]);
    for (std::size_t k = 0; k < above_.size(); ++k)
        bytes += above_[k].capacity() * sizeof(std::uint32_t) + is_wanted_[k].capacity() +
                 wanted_[k].capacity() * sizeof(std::uint32_t);
    return bytes;
}

}  // namespace tetrakis::detail
