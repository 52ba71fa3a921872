#include "height_input.hpp"

#include "console.hpp"
#include "files.hpp"

#include <fmt/format.h>

namespace tetrakis::cli {

void HeightInput::add(CLI::App& command, const std::string& what) {
    command
        .add_option("IN", path,
                    !what.empty()
                        ? what
                        : "Heights: .png (grey, or terrain-RGB), .hgt, .r16 or .raw (16 bits), .r32 or .f32 (floats); "
                          "others with GDAL")
        ->required()
        ->type_name("");
    command.add_option("--spacing", spacing, "Distance between samples (the file's own, else 1)")
        ->type_name("D")
        ->check(number_check("a positive number", [](double value) { return value > 0; }));
    command.add_option("--scale", read.scale, "Heights are this times the file's numbers (1)")
        ->type_name("S")
        ->check(number_check("a number", [](double) { return true; }));
    command.add_option("--offset", read.offset, "What is added to that (0)")
        ->type_name("H")
        ->check(number_check("a number", [](double) { return true; }));
    command.add_option("--columns", read.columns, "Of a raw file that is not square")->type_name("N");
    command.add_option("--rows", read.rows, "Of a raw file that is not square")->type_name("N");
    command.add_flag("--big-endian", read.big_endian, "The order of bytes in a raw file");
    command.add_option("--no-data", read.no_data, "The number in the file that stands for no data")->type_name("V");
}

HeightGrid HeightInput::load(const Run& process, std::vector<std::string>& warnings) const {
    return reading(path, [&] {
        HeightReadOptions options = read;
        options.context = process.context();
        if (spacing > 0) options.spacing = Vec2d(spacing);
        HeightGrid grid = load_height_grid(path, options);
        if (const std::uint64_t filled = fill_missing_heights(grid); filled > 0)
            warnings.push_back(
                fmt::format("{} samples have no data and were filled from those around; the error there "
                            "is towards these",
                            format_count(filled)));
        return grid;
    });
}

}  // namespace tetrakis::cli
