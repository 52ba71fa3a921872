#include "height_input.hpp"

#include "console.hpp"
#include "files.hpp"

#include <fmt/format.h>

namespace tetrakis::cli {

Option HeightInput::add(CommandLine command, const std::string& what) {
    const auto any = [](double) { return true; };
    const Option file = command.option(
        "IN", "", path,
        !what.empty() ? what
                      : "Heights: .png (grey, or terrain-RGB), .hgt, .r16 or .raw (16 bits), .r32 or .f32 (floats); "
                        "others with GDAL");
    command.option("--spacing", "D", spacing, "Distance between samples (the file's own, else 1)").positive();
    command.option("--scale", "S", read.scale, "Heights are this times the file's numbers (1)").number("a number", any);
    command.option("--offset", "H", read.offset, "What is added to that (0)").number("a number", any);
    command.option("--columns", "N", read.columns, "Of a raw file that is not square");
    command.option("--rows", "N", read.rows, "Of a raw file that is not square");
    command.flag("--big-endian", read.big_endian, "The order of bytes in a raw file");
    command.option("--no-data", "V", read.no_data, "The number in the file that stands for no data");
    return file.required();
}

HeightReadOptions HeightInput::options(const Run& process) const {
    HeightReadOptions options = read;
    options.context = process.context();
    if (spacing > 0) options.spacing = Vec2d(spacing);
    return options;
}

std::unique_ptr<HeightSource> HeightInput::open(const Run& process) const {
    return reading(path, [&] { return open_height_source(path, options(process)); });
}

HeightGrid HeightInput::load(const Run& process, std::vector<std::string>& warnings) const {
    return reading(path, [&] {
        HeightGrid grid = load_height_grid(path, options(process));
        if (const std::uint64_t filled = fill_missing_heights(grid); filled > 0)
            warnings.push_back(
                fmt::format("{} samples have no data and were filled from those around; the error there "
                            "is towards these",
                            format_count(filled)));
        return grid;
    });
}

}  // namespace tetrakis::cli
