// A scheme at an extraordinary vertex: Loop's eigenvalues and limit mask at valence 7.
#include <tetrakis/tetrakis.hpp>

#include <algorithm>
#include <cstddef>
#include <iomanip>
#include <iostream>

int main() {
    const tetrakis::SchemeInfo& scheme = tetrakis::scheme_named("loop");
    const tetrakis::SpectralAnalysis analysis = tetrakis::analyse(scheme, {.faces = 7}, {});

    std::cout << scheme.title << "\neigenvalues:" << std::setprecision(4);
    for (std::size_t i = 0; i < std::min<std::size_t>(5, analysis.eigenvalues.size()); ++i)
        for (int copy = 0; copy < analysis.eigenvalues[i].multiplicity; ++copy)
            std::cout << ' ' << analysis.eigenvalues[i].value.real();
    std::cout << "\ncurvature: " << tetrakis::name(analysis.curvature) << "\nlimit mask:\n";

    // Weights are in the order of the labels: the vertex itself, then the rings around it.
    const tetrakis::SchemeMasks masks = tetrakis::scheme_masks(scheme, analysis, {});
    for (std::size_t i = 0; i < masks.limit.size(); ++i) {
        const tetrakis::FanLabel& label = analysis.matrix.labels.all()[i];
        if (masks.limit[i] != 0 && label.sector == 0)
            std::cout << "  " << label.a << " steps along each edge, " << label.b << " aside: " << masks.limit[i]
                      << '\n';
    }
}
