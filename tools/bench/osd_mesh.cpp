#include "osd_mesh.hpp"

#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <vector>

namespace tetrakis::bench {

namespace osd = OpenSubdiv;

std::unique_ptr<osd::Far::TopologyRefiner> make_refiner(const ControlMeshData& data, SchemeKind scheme) {
    std::vector<int> sizes(data.face_offsets.size() - 1), crease_vertices, corner_vertices;
    for (std::size_t f = 0; f < sizes.size(); ++f)
        sizes[f] = static_cast<int>(data.face_offsets[f + 1] - data.face_offsets[f]);
    std::vector<float> crease_weights, corner_weights;
    for (const auto& tag : data.creases) {
        crease_vertices.insert(crease_vertices.end(), {static_cast<int>(tag.a), static_cast<int>(tag.b)});
        crease_weights.push_back(std::min(tag.sharpness, k_infinite_sharpness));
    }
    for (const auto& tag : data.corners) {
        corner_vertices.push_back(static_cast<int>(tag.vertex));
        corner_weights.push_back(std::min(tag.sharpness, k_infinite_sharpness));
    }

    osd::Far::TopologyDescriptor descriptor;
    descriptor.numVertices = static_cast<int>(data.positions.size());
    descriptor.numFaces = static_cast<int>(sizes.size());
    descriptor.numVertsPerFace = sizes.data();
    descriptor.vertIndicesPerFace = reinterpret_cast<const int*>(data.face_vertices.data());
    descriptor.numCreases = static_cast<int>(crease_weights.size());
    descriptor.creaseVertexIndexPairs = crease_vertices.data();
    descriptor.creaseWeights = crease_weights.data();
    descriptor.numCorners = static_cast<int>(corner_weights.size());
    descriptor.cornerVertexIndices = corner_vertices.data();
    descriptor.cornerWeights = corner_weights.data();
    descriptor.numHoles = static_cast<int>(data.holes.size());
    descriptor.holeIndices = reinterpret_cast<const int*>(data.holes.data());

    using Rules = osd::Sdc::Options;
    Rules rules;
    rules.SetVtxBoundaryInterpolation(data.boundary_rule == BoundaryRule::none ? Rules::VTX_BOUNDARY_NONE
                                      : data.boundary_rule == BoundaryRule::edge_only
                                          ? Rules::VTX_BOUNDARY_EDGE_ONLY
                                          : Rules::VTX_BOUNDARY_EDGE_AND_CORNER);
    rules.SetCreasingMethod(data.crease_method == CreaseMethod::chaikin ? Rules::CREASE_CHAIKIN
                                                                        : Rules::CREASE_UNIFORM);
    using Factory = osd::Far::TopologyRefinerFactory<osd::Far::TopologyDescriptor>;
    const auto kind = scheme == SchemeKind::loop ? osd::Sdc::SCHEME_LOOP : osd::Sdc::SCHEME_CATMARK;
    return std::unique_ptr<osd::Far::TopologyRefiner>(Factory::Create(descriptor, Factory::Options(kind, rules)));
}

}  // namespace tetrakis::bench
