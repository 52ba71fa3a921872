#pragma once

#include "../../../hier/mesh/control_mesh.hpp"
#include "../../../schemes/core/scheme_table.hpp"

#include <opensubdiv/bfr/surfaceFactory.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

/// Tessellations by OpenSubdiv's Bfr, in float on one thread, for comparison.
namespace tetrakis::bench {

/// An indexed triangle mesh in float, as peers make it.
struct PeerMesh {
    std::vector<std::array<float, 3>> positions, normals;
    std::vector<std::array<int, 3>> triangles;
};

/// Bfr's approximation levels near irregular vertices (smooth) and creases (sharp). Its defaults are 2 and 6.
struct BfrLevels {
    int smooth = 2, sharp = 6;
    /// Levels for a smooth level. The sharp level must not be much below it, but a high sharp level is expensive.
    static BfrLevels of(int smooth) { return {smooth, smooth <= 4 ? 6 : smooth <= 6 ? 8 : 10}; }
};

inline OpenSubdiv::Bfr::SurfaceFactory::Options bfr_options(BfrLevels levels) {
    OpenSubdiv::Bfr::SurfaceFactory::Options options;
    options.SetApproxLevelSmooth(levels.smooth);
    options.SetApproxLevelSharp(levels.sharp);
    return options;
}

struct PeerOptions {
    SchemeKind scheme = SchemeKind::catmull_clark;
    BfrLevels levels;
};

/// Tessellates with one rate for all edges and faces.
PeerMesh bfr_uniform(const ControlMeshData& data, const PeerOptions& options, int rate);

/// Tessellates with rates for each edge and each face's inside: k sqrt(2 d / tolerance), rounded up. d is the largest
/// normal component of a second difference of the limit over quarters of the edge or of the face's rows. On a curve of
/// constant second derivative, k = 1 makes the chord's error equal to the tolerance; k adjusts all other cases.
PeerMesh bfr_adaptive(const ControlMeshData& data, const PeerOptions& options, double tolerance, double k);

}  // namespace tetrakis::bench
