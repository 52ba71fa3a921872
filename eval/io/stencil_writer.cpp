#include "tetrakis/eval/io/stencil_writer.hpp"

#include "tetrakis/hier/atomic_file.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <string>

namespace tetrakis {

void write_stencils(AtomicFile& file, const StencilTable& table, int control_vertices) {
    constexpr std::size_t k_block = std::size_t{1} << 20;
    std::size_t terms = 0;
    for (int r = 0; r < table.row_count(); ++r) terms += table.points(r).size();
    std::string text = fmt::format("tetrakis-stencils 1\n{} {} {}\n", table.row_count(), control_vertices, terms);
    for (int r = 0; r < table.row_count(); ++r) {
        const auto points = table.points(r);
        const auto weights = table.weights(r);
        fmt::format_to(std::back_inserter(text), "{}", points.size());
        for (std::size_t i = 0; i < points.size(); ++i)
            fmt::format_to(std::back_inserter(text), " {} {}", points[i], weights[i]);
        text += '\n';
        if (text.size() < k_block) continue;
        file.write(text);
        text.clear();
    }
    file.write(text);
}

void write_stencils(const std::filesystem::path& path, const StencilTable& table, int control_vertices) {
    AtomicFile file(path);
    write_stencils(file, table, control_vertices);
    file.commit();
}

}  // namespace tetrakis
