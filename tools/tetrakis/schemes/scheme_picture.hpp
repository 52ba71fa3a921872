#pragma once

#include "fan_patch.hpp"

#include "../../../eval/io/png.hpp"
#include "../../../hier/base/run_context.hpp"
#include "../../../schemes/analysis/spectrum.hpp"

#include <optional>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// What draw_scheme() draws of a scheme.
struct SchemePicture {
    struct Mask {
        std::string title;
        std::vector<double> weights;   ///< in the order of the labels
        std::optional<int> new_point;  ///< the label of the point that it makes, marked by a circle
    };

    std::string title, subtitle;
    const SchemeInfo& scheme;
    const SpectralAnalysis& analysis;
    RuleOptions rules;
    std::vector<Mask> masks;
};

/// One sheet: the masks on the characteristic map's net, the isoparametric lines of that map over four rings, and a
/// basis function as a shaded surface. At a boundary all of it on one side of it.
Image draw_scheme(const SchemePicture& picture, const RunContext& context);

}  // namespace tetrakis::cli
