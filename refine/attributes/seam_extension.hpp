#pragma once

#include "../../hier/base/most_frequent.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// The UV layer, cut along its seams (see uv_mesh()), with rows of quads beyond them that continue each chart straight:
/// beside a seam, schemes whose new faces lie across it then take their smooth rules. Half-edge h of the control mesh
/// is half-edge h of `mesh`; the quads beyond come after.
///
/// Beyond a vertex of a seam goes its mirror image of the mean of its neighbours inside the chart, or, at the end of a
/// seam in the mesh's boundary, of the neighbour along that boundary. The corner of a chart (one face) gets a quad of
/// its own, as on a grid: mirror images of either neighbour, and of their sum.
struct SeamExtension {
    RuleMesh mesh;
    std::vector<Vec2d> uvs;  ///< of its vertices
};

/// As the scheme's rules need it, for dual schemes, honeycomb, and where extends_charts(): along seams, but those of
/// boundaries and of creases that stay.
/// @param mesh     must have UVs
/// @param surface  rule_mesh(mesh)
SeamExtension extend_over_seams(const ControlMesh& mesh, const RuleMesh& surface, const SchemeInfo& scheme,
                                const RuleOptions& rules);

/// Corners of a face of a dual scheme that lie on the same side of every seam.
struct SeamRun {
    int first, size;
};

/// The run whose UVs a face takes: the one with the most corners, then the one that begins at the lowest origin.
/// @param goes_on  (i): whether the corner after i lies on the same side
/// @param origin   (i): of corner i: its control face, and what more it takes to tell runs apart
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

}  // namespace tetrakis::detail
