#pragma once

#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/most_frequent.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Corners of a face of a dual scheme that lie on the same side of every seam.
struct SeamRun {
    int first, size;
};

/// The run whose UVs a face takes: the one with the most corners, then the one that begins in the lowest control face.
/// @param goes_on  (i): whether the corner after i lies on the same side
/// @param home     (i): the control face that corner i lies in
template <class GoesOn, class Home>
SeamRun longest_run(int size, const GoesOn& goes_on, const Home& home) {
    SeamRun best{0, 0};
    for (int i = 0; i < size; ++i) {
        if (goes_on((i + size - 1) % size)) continue;
        int length = 1;
        while (length < size && goes_on((i + length - 1) % size)) ++length;
        if (length > best.size || (length == best.size && home(i) < home(best.first))) best = {i, length};
    }
    return best.size == 0 ? SeamRun{0, size} : best;  // all of it on one side, and round
}

/// The control face that most corners of a run lie in; the lowest of several.
template <class Home>
std::uint32_t home_of(const SeamRun& run, int size, const Home& home) {
    std::vector<std::uint32_t> homes;
    for (int i = 0; i < run.size; ++i) homes.push_back(home((run.first + i) % size));
    return most_frequent(homes);
}

/// UVs of the corners beyond a run, from those that the chart goes on with: as many as there are, those; else evenly
/// along them, as new UVs.
inline void continue_uvs(const SeamRun& run, std::span<const std::uint32_t> beyond, std::span<std::uint32_t> corners,
                         std::vector<Vec2d>& uvs) {
    const int size = static_cast<int>(corners.size()), missing = size - run.size,
              last = static_cast<int>(beyond.size()) - 1;
    for (int i = 0; i < missing && last >= 0; ++i) {
        const double along = missing == 1 ? 0.5 * last : double(i) * last / (missing - 1);
        const int k = std::min(static_cast<int>(along), std::max(last - 1, 0));
        const double t = along - k;
        std::uint32_t& to = corners[static_cast<std::size_t>((run.first + run.size + i) % size)];
        const auto at = static_cast<std::size_t>(k);
        if (t == 0 || t == 1) {
            to = beyond[t == 0 ? at : at + 1];
        } else {
            to = static_cast<std::uint32_t>(uvs.size());
            uvs.push_back((1 - t) * uvs[beyond[at]] + t * uvs[beyond[at + 1]]);
        }
    }
}

}  // namespace tetrakis::detail
