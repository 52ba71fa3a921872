#pragma once

#include "../../hier/base/most_frequent.hpp"
#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Corners of a face of a dual scheme that lie on the same side of every seam.
struct SeamRun {
    int first, size;
};

/// Where a corner of a face of a dual scheme comes from. Where a seam runs over an inner vertex of two faces, both of
/// its sides meet in faces across it twice: then what lies in one control face has come from two corners there.
struct SeamOrigin {
    std::uint32_t home;    ///< control face
    std::uint32_t corner;  ///< half-edge of level 1, from there on
    auto operator<=>(const SeamOrigin&) const = default;
};

/// The run whose UVs a face takes: the one with the most corners, then the one that begins in the lowest control face,
/// then at the lowest corner of level 1.
/// @param goes_on  (i): whether the corner after i lies on the same side
/// @param origin   (i): the SeamOrigin of corner i
template <class GoesOn, class Origin>
SeamRun longest_run(int size, const GoesOn& goes_on, const Origin& origin) {
    SeamRun best{0, 0};
    for (int i = 0; i < size; ++i) {
        if (goes_on((i + size - 1) % size)) continue;
        int length = 1;
        while (length < size && goes_on((i + length - 1) % size)) ++length;
        if (length > best.size || (length == best.size && origin(i) < origin(best.first))) best = {i, length};
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

/// Where the corners beyond a run lie along those that the chart goes on with: as many as there are, at those; else
/// evenly.
/// @param size    of the face
/// @param beyond  how many the chart goes on with; nothing is visited where there are none
/// @param visit   (i, k, t): corner i of the face lies at the share t of the way from the k-th to the next one
template <class Visit>
void for_each_beyond(const SeamRun& run, int size, int beyond, Visit&& visit) {
    const int missing = size - run.size, last = beyond - 1;
    for (int i = 0; i < missing && last >= 0; ++i) {
        const double along = missing == 1 ? 0.5 * last : double(i) * last / (missing - 1);
        const int k = std::min(static_cast<int>(along), std::max(last - 1, 0));
        visit((run.first + run.size + i) % size, static_cast<std::size_t>(k), along - k);
    }
}

/// UVs of the corners beyond a run, from those that the chart goes on with, or as new ones between them.
inline void continue_uvs(const SeamRun& run, std::span<const std::uint32_t> beyond, std::span<std::uint32_t> corners,
                         std::vector<Vec2d>& uvs) {
    for_each_beyond(run, static_cast<int>(corners.size()), static_cast<int>(beyond.size()),
                    [&](int i, std::size_t k, double t) {
                        std::uint32_t& to = corners[static_cast<std::size_t>(i)];
                        if (t == 0 || t == 1) {
                            to = beyond[t == 0 ? k : k + 1];
                        } else {
                            to = static_cast<std::uint32_t>(uvs.size());
                            uvs.push_back((1 - t) * uvs[beyond[k]] + t * uvs[beyond[k + 1]]);
                        }
                    });
}

/// The UVs of a face's corners, from one side of the seams that it lies across. Returns the control face that it
/// belongs to there.
/// @param partner  (i): the half-edge of the charts that corner i is
/// @param from     (i): the SeamOrigin of corner i
/// @param next     (p): the half-edge of the charts after that one in its face
/// @param origin   (p): number of the UVs where it begins
template <class Partner, class From, class Next, class Origin>
std::uint32_t take_side(std::span<std::uint32_t> corners, const Partner& partner, const From& from, const Next& next,
                        const Origin& origin, std::vector<Vec2d>& uvs) {
    const int size = static_cast<int>(corners.size());
    for (int i = 0; i < size; ++i)
        corners[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(origin(partner(i)));
    const auto around = [&](int i) { return partner(i % size); };
    const SeamRun run = longest_run(
        size, [&](int i) { return next(around(i)) == around(i + 1); }, from);
    const std::uint32_t control = home_of(run, size, [&](int i) { return from(i).home; });
    if (run.size == size) return control;
    std::vector<std::uint32_t> beyond;
    for (auto p = next(around(run.first + run.size - 1)); p != partner(run.first); p = next(p))
        beyond.push_back(static_cast<std::uint32_t>(origin(p)));
    continue_uvs(run, beyond, corners, uvs);
    return control;
}

}  // namespace tetrakis::detail
