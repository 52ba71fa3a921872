#pragma once

#include "../rules/polygon_mesh.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Which of some values corners name.
class UsedValues {
  public:
    /// @param corners  numbers below `count`
    UsedValues(std::span<const std::uint32_t> corners, std::size_t count) : used_(count, 0) {
        for (const std::uint32_t v : corners) used_[v] = 1;
        all_ = std::find(used_.begin(), used_.end(), 0) == used_.end();
    }

    /// Removes the values that are not used; the others keep their order. @param width  of each value
    template <class T>
    void keep(std::vector<T>& values, std::size_t width = 1) const {
        if (all_) return;
        std::size_t count = 0;
        for (std::size_t v = 0; v < used_.size(); ++v) {
            if (used_[v] == 0) continue;
            for (std::size_t i = 0; i < width; ++i) values[count * width + i] = values[v * width + i];
            ++count;
        }
        values.resize(count * width);
    }
    /// Names the values by their numbers among those used.
    void renumber(std::vector<std::uint32_t>& corners) const {
        if (all_) return;
        std::vector<std::uint32_t> number(used_.size());
        std::uint32_t count = 0;
        for (std::size_t v = 0; v < used_.size(); ++v) {
            number[v] = count;
            count += used_[v];
        }
        for (std::uint32_t& v : corners) v = number[v];
    }

  private:
    std::vector<std::uint8_t> used_;
    bool all_;
};

/// Removes the values that no corner names; the others keep their order.
template <class T>
void drop_unused(std::vector<std::uint32_t>& corners, std::vector<T>& values) {
    const UsedValues used(corners, values.size());
    used.keep(values);
    used.renumber(corners);
}

/// Takes the vertices that no face has out, with all that belongs to them. `numbers`, unless null, receives what each
/// of the others was before.
inline void drop_unused_vertices(PolygonMesh& mesh, std::vector<std::uint32_t>* numbers = nullptr) {
    const UsedValues used(mesh.face_vertices, mesh.positions.size());
    if (numbers != nullptr) {
        numbers->resize(mesh.positions.size());
        std::iota(numbers->begin(), numbers->end(), 0u);
        used.keep(*numbers);
    }
    used.keep(mesh.positions);
    if (!mesh.normals.empty()) used.keep(mesh.normals);
    for (VertexAttribute& attribute : mesh.attributes)
        used.keep(attribute.values, static_cast<std::size_t>(attribute.width));
    used.renumber(mesh.face_vertices);
}

}  // namespace tetrakis::detail
