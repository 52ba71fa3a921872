#pragma once

#include "../../hier/base/most_frequent.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// The UV layer, cut along its seams (see uv_mesh()), with rows of quads outside that continue each chart straight. So
/// schemes whose new faces lie across a seam use their smooth rules beside it. Half-edge h of the control mesh is
/// half-edge h of `mesh`; the quads come after.
///
/// A seam vertex gets a new point outside of its chart: the mirror image of the mean of its neighbours inside the
/// chart, or, where a seam ends at the boundary of the mesh, of its neighbour along that boundary. If the chart has one
/// face there, its corner gets a quad as on a grid: mirror images of both neighbours, and of their sum.
struct SeamExtension {
    RuleMesh mesh;
    std::vector<Vec2d> uvs;  ///< UVs of its vertices
};

/// Extends the charts for dual schemes, for honeycomb, and if extends_charts(). It does so along seams, but not along
/// boundaries; along creases only for averaging schemes.
/// @param mesh     must have UVs
/// @param surface  rule_mesh(mesh)
SeamExtension extend_over_seams(const ControlMesh& mesh, const RuleMesh& surface, const SchemeInfo& scheme,
                                const RuleOptions& rules);

/// Consecutive corners of a dual scheme's face that lie on the same side of every seam.
struct SeamRun {
    int first, size;
};

/// The run whose UVs a face takes: the one with most corners, else the one with the lowest origin.
/// @param goes_on  goes_on(i): whether the corner after corner i lies on the same side
/// @param origin   origin(i): the control face of corner i, with more data if runs need it to differ
template <class GoesOn, class Origin>
SeamRun longest_run(int size, const GoesOn& goes_on, const Origin& origin) {
    SeamRun best{0, 0};
    for (int i = 0; i < size; ++i) {
        if (goes_on((i + size - 1) % size)) continue;
        int length = 1;
        while (length < size && goes_on((i + length - 1) % size)) ++length;
        if (length > best.size || (length == best.size && origin(i) < origin(best.first))) best = {i, length};
    }
    return best.size == 0 ? SeamRun{0, size} : best;  // all corners are on one side
}

/// The control face of most corners of a run; of several such faces, the lowest.
template <class Home>
std::uint32_t home_of(const SeamRun& run, int size, const Home& home) {
    std::vector<std::uint32_t> homes;
    for (int i = 0; i < run.size; ++i) homes.push_back(home((run.first + i) % size));
    return most_frequent(homes);
}

/// Places the corners outside of a run along the corners of the chart's continuation: on these if the numbers agree,
/// else at equal distances.
/// @param size    number of corners of the face
/// @param beyond  number of corners of the continuation; if there are none, nothing is visited
/// @param visit   visit(i, k, t): corner i of the face lies at the share t of the way from corner k to the next one
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
