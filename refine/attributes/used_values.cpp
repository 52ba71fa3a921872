#include "used_values.hpp"

#include "../../hier/base/parallel.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <tuple>

namespace tetrakis::detail {

FaceUvs number_uvs(std::span<const std::uint32_t> face_vertices, std::span<const Vec2d> values) {
    struct Corner {
        std::uint32_t vertex, number;
        Vec2d uv;
    };
    const auto count = static_cast<std::uint32_t>(values.size());
    std::vector<Corner> corners(count);
    for_each_index(count, [&](std::uint32_t c) { corners[c] = {face_vertices[c], c, values[c]}; });
    oneapi::tbb::parallel_sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
        return std::tie(a.vertex, a.uv.x, a.uv.y, a.number) < std::tie(b.vertex, b.uv.x, b.uv.y, b.number);
    });
    FaceUvs result;
    result.face_uvs.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Corner& c = corners[i];
        if (i == 0 || corners[i - 1].vertex != c.vertex || corners[i - 1].uv != c.uv) result.uvs.push_back(c.uv);
        result.face_uvs[c.number] = static_cast<std::uint32_t>(result.uvs.size() - 1);
    }
    return result;
}

}  // namespace tetrakis::detail
