#pragma once

#include "fan_patch.hpp"

#include "../../../eval/io/png.hpp"
#include "../../../hier/base/run_context.hpp"
#include "../../../schemes/analysis/spectrum.hpp"

#include <optional>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// Contents of the picture of a scheme.
struct SchemePicture {
    struct Mask {
        std::string title;
        std::vector<double> weights;   ///< in the order of the labels
        std::optional<int> new_point;  ///< index of the label of its new point, which a circle marks
    };

    std::string title, subtitle;
    const SchemeInfo& scheme;
    const SpectralAnalysis& analysis;
    RuleOptions rules;
    std::vector<Mask> masks;
};

/// One picture with the masks on the characteristic map's net, the isoparametric lines of that map over k_patch_rings
/// rings, and a basis function as a shaded surface. At a boundary everything lies on one side of it.
Image draw_scheme(const SchemePicture& picture, const RunContext& context);

}  // namespace tetrakis::cli
