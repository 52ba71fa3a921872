#include "stencil_writer.hpp"

#include "../../hier/base/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <span>

namespace tetrakis {

namespace {

/// One line of numbers.
template <class T>
void write_array(AtomicFile& file, std::span<const T> numbers) {
    constexpr std::size_t k_block = std::size_t{1} << 16;
    for (std::size_t i = 0; i < numbers.size(); i += k_block)
        file.write(fmt::format("{}{}", i == 0 ? "" : " ",
                               fmt::join(numbers.subspan(i, std::min(k_block, numbers.size() - i)), " ")));
    file.write("\n");
}

}  // namespace

void write_stencils(AtomicFile& file, const StencilTable& table, int control_vertices) {
    file.write(
        fmt::format("tetrakis-stencils 2\n{} {} {}\n", table.row_count(), control_vertices, table.points().size()));
    write_array(file, table.begins());
    write_array(file, table.points());
    write_array(file, table.weights());
}

void write_stencils(const std::filesystem::path& path, const StencilTable& table, int control_vertices) {
    AtomicFile file(path);
    write_stencils(file, table, control_vertices);
    file.commit();
}

}  // namespace tetrakis
