#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace tetrakis::test {

inline const std::map<FaceVaryingRule, OpenSubdiv::Sdc::Options::FVarLinearInterpolation> k_osd_rule = {
    {FaceVaryingRule::smooth_all, OpenSubdiv::Sdc::Options::FVAR_LINEAR_NONE},
    {FaceVaryingRule::corners_only, OpenSubdiv::Sdc::Options::FVAR_LINEAR_CORNERS_ONLY},
    {FaceVaryingRule::corners_plus1, OpenSubdiv::Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1},
    {FaceVaryingRule::corners_plus2, OpenSubdiv::Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2},
    {FaceVaryingRule::boundaries, OpenSubdiv::Sdc::Options::FVAR_LINEAR_BOUNDARIES},
    {FaceVaryingRule::linear_all, OpenSubdiv::Sdc::Options::FVAR_LINEAR_ALL}};

/// OpenSubdiv's own representation of a control mesh, tags and rules included; unrefined.
/// @param uvs  texture coordinates as well
inline std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> osd_refiner(const ControlMeshData& data, SchemeKind scheme,
                                                                     bool uvs) {
    namespace Far = OpenSubdiv::Far;
    namespace Sdc = OpenSubdiv::Sdc;
    Sdc::Options options;
    options.SetFVarLinearInterpolation(k_osd_rule.at(data.face_varying_rule));
    options.SetVtxBoundaryInterpolation(data.boundary_rule == BoundaryRule::none ? Sdc::Options::VTX_BOUNDARY_NONE
                                        : data.boundary_rule == BoundaryRule::edge_and_corner
                                            ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                            : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    options.SetCreasingMethod(data.crease_method == CreaseMethod::chaikin ? Sdc::Options::CREASE_CHAIKIN
                                                                          : Sdc::Options::CREASE_UNIFORM);
    std::vector<int> sizes, vertices(data.face_vertices.begin(), data.face_vertices.end()), pairs, corners;
    std::vector<int> holes(data.holes.begin(), data.holes.end());
    std::vector<float> pair_sharpness, corner_sharpness;
    for (std::size_t f = 0; f + 1 < data.face_offsets.size(); ++f)
        sizes.push_back(static_cast<int>(data.face_offsets[f + 1] - data.face_offsets[f]));
    for (const auto& crease : data.creases) {
        pairs.push_back(static_cast<int>(crease.a));
        pairs.push_back(static_cast<int>(crease.b));
        pair_sharpness.push_back(std::min(crease.sharpness, k_infinite_sharpness));
    }
    for (const auto& corner : data.corners) {
        corners.push_back(static_cast<int>(corner.vertex));
        corner_sharpness.push_back(std::min(corner.sharpness, k_infinite_sharpness));
    }
    Far::TopologyDescriptor d;
    d.numVertices = static_cast<int>(data.positions.size());
    d.numFaces = static_cast<int>(sizes.size());
    d.numVertsPerFace = sizes.data();
    d.vertIndicesPerFace = vertices.data();
    d.numCreases = static_cast<int>(pair_sharpness.size());
    d.creaseVertexIndexPairs = pairs.data();
    d.creaseWeights = pair_sharpness.data();
    d.numCorners = static_cast<int>(corners.size());
    d.cornerVertexIndices = corners.data();
    d.cornerWeights = corner_sharpness.data();
    d.numHoles = static_cast<int>(holes.size());
    d.holeIndices = holes.data();
    std::vector<int> face_uvs(data.face_uvs.begin(), data.face_uvs.end());
    Far::TopologyDescriptor::FVarChannel channel;
    channel.numValues = static_cast<int>(data.uvs.size());
    channel.valueIndices = face_uvs.data();
    if (uvs && !face_uvs.empty()) {
        d.numFVarChannels = 1;
        d.fvarChannels = &channel;
    }
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    const auto type = scheme == SchemeKind::loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
    return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(d, Factory::Options(type, options)));
}

struct FarPoint {
    Vec3d p{0};
    void Clear(void* = nullptr) { p = Vec3d(0); }
    void AddWithWeight(const FarPoint& other, double w) { p += w * other.p; }
};

/// A level of a mesh refined by OpenSubdiv, texture coordinates included.
struct FarLevel {
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    std::vector<FarPoint> points, uvs;

    FarLevel(const ControlMeshData& data, SchemeKind scheme, int levels, bool full_topology = true)
        : refiner(osd_refiner(data, scheme, true)) {
        OpenSubdiv::Far::TopologyRefiner::UniformOptions uniform(levels);
        uniform.fullTopologyInLastLevel = full_topology;
        refiner->RefineUniform(uniform);
        const OpenSubdiv::Far::PrimvarRefinerReal<double> primvars(*refiner);
        for (const Vec3d& p : data.positions) points.push_back({p});
        for (const Vec2d& uv : data.uvs) uvs.push_back({Vec3d(uv, 0)});
        std::vector<FarPoint> finer;
        for (int l = 1; l <= levels; ++l) {
            finer.resize(static_cast<std::size_t>(refiner->GetLevel(l).GetNumVertices()));
            primvars.Interpolate(l, points, finer);
            std::swap(points, finer);
            if (uvs.empty()) continue;
            finer.resize(static_cast<std::size_t>(refiner->GetLevel(l).GetNumFVarValues()));
            primvars.InterpolateFaceVarying(l, uvs, finer);
            std::swap(uvs, finer);
        }
    }
    const OpenSubdiv::Far::TopologyLevel& topology() const { return refiner->GetLevel(refiner->GetMaxLevel()); }
};

}  // namespace tetrakis::test
