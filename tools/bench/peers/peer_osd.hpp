#pragma once

#include "../../../hier/mesh/control_mesh.hpp"
#include "../../../schemes/core/scheme_table.hpp"

#include <opensubdiv/bfr/surfaceFactory.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

/// Tessellations by OpenSubdiv's Bfr, in float on one thread: what this library is compared with.
namespace tetrakis::bench {

/// An indexed triangle mesh in float, as the peers write it.
struct PeerMesh {
    std::vector<std::array<float, 3>> positions, normals;
    std::vector<std::array<int, 3>> triangles;
};

/// How well Bfr approximates the limit near irregular vertices (smooth) and creases (sharp); 2 and 6 are its defaults.
struct BfrLevels {
    int smooth = 2, sharp = 6;
    /// The sharp level that goes with a smooth one: it must not be below it by much, and costs much when it is high.
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

/// One rate for all edges and faces.
PeerMesh bfr_uniform(const ControlMeshData& data, const PeerOptions& options, int rate);

/// A rate of its own for each edge and each face's inside: k sqrt(2 d / tolerance), rounded up, where d is the largest
/// normal component of a second difference of the limit over quarters of the edge or of the face's rows. On a curve
/// of constant second derivative, k = 1 makes the chord's error the tolerance; everything else is left to k.
PeerMesh bfr_adaptive(const ControlMeshData& data, const PeerOptions& options, double tolerance, double k);

}  // namespace tetrakis::bench
