#include "files.hpp"
#include "console.hpp"

#include "../../eval/io/mesh_writer.hpp"
#include "../../hier/mesh/triangulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace tetrakis::cli {
namespace {

/// Whether both paths name the same file, which need not exist yet.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
    std::error_code error;
    if (std::filesystem::equivalent(a, b, error)) {
        // A device, such as /dev/null, may receive several outputs.
        return std::filesystem::is_regular_file(a, error);
    }
    const auto full_a = std::filesystem::weakly_canonical(a, error),
               full_b = std::filesystem::weakly_canonical(b, error);
    return full_a == full_b && !std::filesystem::exists(a, error);
}

}  // namespace

void add_read_options(CommandLine command, ReadOptions& options) {
    command
        .option("--weld", "[DISTANCE]", options.weld,
                "Join vertices in one place, or within a distance in the unit of the model, so that faces side by\n"
                "side share them; comes before --repair")
        .value_or("0")
        .number("a distance of 0 or more (give the model before --weld, or write --weld=0)",
                [](double x) { return x >= 0; });
    command.flag("--repair", options.repair, "Mend what can be mended safely, and say what was done");
}

LoadedModel load_model(const std::filesystem::path& path, const ReadOptions& options, const RunContext& context,
                       const SchemeInfo* scheme) {
    const std::string extension = lower_extension(path);
    for (const char* other : {".ply", ".glb", ".gltf", ".stl", ".fbx", ".usd", ".usda", ".usdc", ".blend"})
        if (extension == other)
            throw InputError(
                fmt::format("{}: control meshes are read from OBJ files; export it as OBJ", path.string()));
    return reading(path, [&] {
        LoadedModel model;
        const Stopwatch load;
        context.report("load", 0);
        ControlMeshData data = read_obj(path, options, context);
        model.load_seconds = load.seconds();
        const Stopwatch build;
        context.report("build", 0);
        model.mesh = ControlMesh::build(std::move(data), context);
        model.faces = model.mesh.face_count();
        if (scheme != nullptr && scheme->family == MeshFamily::triangles && !model.mesh.all_triangles())
            model.mesh = triangulate(model.mesh, context);
        model.build_seconds = build.seconds();
        return model;
    });
}

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
    const std::string extension = lower_extension(path);
    const bool raw = std::ranges::count(std::array{".r16", ".raw", ".r32", ".f32"}, extension) != 0;
    if (!raw && (read.columns != 0 || read.rows != 0 || read.big_endian))
        throw UsageError("--columns, --rows and --big-endian are for raw files: .r16, .raw, .r32 and .f32");
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

void OutputFiles::add(Kind kind, const std::string& option, const std::filesystem::path& path) {
    if (path.empty()) {
        if (kind == Kind::mesh) throw UsageError(fmt::format("{}: the name of the output file is empty", option));
        return;
    }
    if (kind == Kind::mesh) {
        try {
            mesh_format(path);
        } catch (const Error& error) {
            throw UsageError(fmt::format("{}: {}", option, error.what()));
        }
    }
    if (kind == Kind::picture && lower_extension(path) != ".png")
        throw UsageError(fmt::format("{}: {}: pictures are written as .png", option, path.string()));
    if (kind == Kind::tiles && lower_extension(path) != ".tiles")
        throw UsageError(fmt::format("{}: {}: tiles are written as .tiles", option, path.string()));
    files_.emplace_back(option, path);
}

void OutputFiles::check(const std::vector<std::filesystem::path>& inputs) const {
    for (std::size_t i = 0; i < files_.size(); ++i) {
        const auto& [option, path] = files_[i];
        for (const auto& input : inputs)
            if (!input.empty() && same_file(path, input))
                throw UsageError(fmt::format("{}: {} is an input; choose another name", option, path.string()));
        for (std::size_t j = 0; j < i; ++j)
            if (same_file(path, files_[j].second))
                throw UsageError(
                    fmt::format("{} and {} name the same file, {}", files_[j].first, option, path.string()));
    }
    for (const auto& [option, path] : files_) check_writable(path);
}

}  // namespace tetrakis::cli
