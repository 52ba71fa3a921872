#pragma once

#include "../../hier/base/vec.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace tetrakis {

/// Numbers that a vertex has besides its position: colours, weights, temperatures.
struct VertexAttribute {
    std::string name;
    int width = 1;              ///< numbers per vertex
    std::vector<float> values;  ///< vertex by vertex
};

/// An indexed polygon mesh with shared vertices: the result of uniform refinement. It has V vertices, F faces and H
/// face corners; an empty optional array means that the mesh has no such data.
struct PolygonMesh {
    std::vector<Vec3d> positions;              ///< V points
    std::vector<Vec3d> normals;                ///< V unit normals, 0 where faces cancel out; or empty
    std::vector<std::uint32_t> face_offsets;   ///< F + 1; corners of face f are [face_offsets[f], face_offsets[f + 1])
    std::vector<std::uint32_t> face_vertices;  ///< H vertex numbers, counter-clockwise seen from outside
    std::vector<Vec2d> uvs;                    ///< distinct texture coordinates, or empty
    std::vector<std::uint32_t> face_uvs;       ///< H numbers into `uvs`, or empty
    std::vector<std::uint32_t> face_material;  ///< F numbers into `materials`, or empty
    std::vector<std::string> materials;
    std::vector<std::uint32_t> face_group;  ///< F numbers into `groups`, or empty
    std::vector<std::string> groups;
    std::vector<VertexAttribute> attributes;  ///< V times `width` values each
    std::vector<std::string> warnings;        ///< warnings of the steps that made this mesh, one sentence each

    std::uint32_t face_count() const {
        return face_offsets.empty() ? 0 : static_cast<std::uint32_t>(face_offsets.size() - 1);
    }
};

}  // namespace tetrakis
