#include "vertex_attributes.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tetrakis::detail {

void check_attributes(const ControlMesh& mesh, std::span<const VertexAttribute> attributes) {
    for (const VertexAttribute& attribute : attributes) {
        if (attribute.width < 1)
            throw Error(ErrorCode::invalid_input,
                        "attribute \"" + attribute.name + "\" must have at least one number per vertex");
        const std::size_t expected = std::size_t{mesh.vertex_count()} * static_cast<std::size_t>(attribute.width);
        if (attribute.values.size() == expected) {
            const auto bad = std::ranges::find_if_not(attribute.values, [](double x) { return std::isfinite(x); });
            if (bad == attribute.values.end()) continue;
            const auto vertex = (bad - attribute.values.begin()) / attribute.width;
            throw Error(ErrorCode::invalid_input, "attribute \"" + attribute.name + "\" of vertex " +
                                                      std::to_string(vertex) + " is not finite; give a finite number");
        }
        throw Error(ErrorCode::invalid_input,
                    "attribute \"" + attribute.name + "\" has " + std::to_string(attribute.values.size()) +
                        " values, but " + std::to_string(mesh.vertex_count()) + " vertices with " +
                        std::to_string(attribute.width) + " each need " + std::to_string(expected));
    }
}

std::vector<VertexAttribute> refine_by_threes(
    std::span<const VertexAttribute> attributes, std::uint32_t control_count, std::uint32_t vertex_count,
    const std::function<void(std::span<const Vec3d>, std::span<Vec3d>)>& refine) {
    std::vector<VertexAttribute> result;
    if (attributes.empty()) return result;
    std::vector<Vec3d> control(control_count), refined(vertex_count);
    for (const VertexAttribute& attribute : attributes) {
        const auto width = static_cast<std::size_t>(attribute.width);
        VertexAttribute& out = result.emplace_back(VertexAttribute{attribute.name, attribute.width, {}});
        out.values.resize(vertex_count * width);
        for (std::size_t first = 0; first < width; first += 3) {
            const std::size_t count = std::min<std::size_t>(3, width - first);
            for_each_index(control_count, [&](std::uint32_t v) {
                control[v] = Vec3d(0);
                for (std::size_t k = 0; k < count; ++k)
                    control[v][static_cast<int>(k)] = attribute.values[v * width + first + k];
            });
            refine(control, refined);
            for_each_index(vertex_count, [&](std::uint32_t v) {
                for (std::size_t k = 0; k < count; ++k)
                    out.values[v * width + first + k] = static_cast<float>(refined[v][static_cast<int>(k)]);
            });
        }
    }
    return result;
}

}  // namespace tetrakis::detail
