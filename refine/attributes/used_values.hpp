#pragma once

#include "../rules/polygon_mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Renumbers the values that corners use, in the same order, without gaps.
/// @param corners  numbers below `count`
/// @return         the old numbers of the values that are used, in increasing order
inline std::vector<std::uint32_t> number_used(std::vector<std::uint32_t>& corners, std::size_t count) {
    std::vector<std::uint32_t> number(count, 0), used;
    for (const std::uint32_t v : corners) number[v] = 1;
    for (std::uint32_t v = 0; v < count; ++v)
        if (std::exchange(number[v], static_cast<std::uint32_t>(used.size())) != 0) used.push_back(v);
    for (std::uint32_t& v : corners) v = number[v];
    return used;
}

/// Removes the values that are not in `used`. @param values  one value for each number, none missing
/// @param width  numbers per value
template <class T>
void keep_used(std::span<const std::uint32_t> used, std::vector<T>& values, std::size_t width = 1) {
    if (used.size() * width == values.size()) return;
    for (std::size_t v = 0; v < used.size(); ++v)
        for (std::size_t i = 0; i < width; ++i) values[v * width + i] = values[used[v] * width + i];
    values.resize(used.size() * width);
}

/// Removes the values that no corner uses; the others keep their order.
template <class T>
void drop_unused(std::vector<std::uint32_t>& corners, std::vector<T>& values) {
    keep_used(number_used(corners, values.size()), values);
}

/// Removes the vertices that no face uses, with their data. Returns the old numbers of the remaining vertices.
inline std::vector<std::uint32_t> drop_unused_vertices(PolygonMesh& mesh) {
    std::vector<std::uint32_t> used = number_used(mesh.face_vertices, mesh.positions.size());
    keep_used(used, mesh.positions);
    if (!mesh.normals.empty()) keep_used(used, mesh.normals);
    for (VertexAttribute& attribute : mesh.attributes)
        keep_used(used, attribute.values, static_cast<std::size_t>(attribute.width));
    return used;
}

}  // namespace tetrakis::detail
