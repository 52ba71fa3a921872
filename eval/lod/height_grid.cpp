#include "height_grid.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "../../hier/base/memory.hpp"
#include "../surface/picture.hpp"
#include "gdal_heights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

namespace tetrakis {

namespace {

constexpr float k_missing = std::numeric_limits<float>::quiet_NaN();

HeightFormat format_of(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".png") return HeightFormat::png;
    if (extension == ".hgt") return HeightFormat::hgt;
    if (extension == ".r16" || extension == ".raw") return HeightFormat::raw16;
    if (extension == ".r32" || extension == ".f32") return HeightFormat::raw_float;
    return HeightFormat::gdal;
}

/// Heights from the numbers of a file.
class Decoder {
  public:
    Decoder(const std::filesystem::path& path, const HeightReadOptions& options) : path_(path), options_(options) {}

    HeightGrid decode() const {
        const HeightFormat format = options_.format == HeightFormat::automatic ? format_of(path_) : options_.format;
        const Size raw_size{options_.columns, options_.rows};
        HeightGrid grid;
        switch (format) {
            case HeightFormat::automatic:
            case HeightFormat::png:
            case HeightFormat::terrain_rgb:
                grid = from_picture(format);
                break;
            case HeightFormat::raw16:
                grid = from_bytes(2, options_.big_endian, raw_size, [](std::uint32_t bits) { return double(bits); });
                break;
            case HeightFormat::raw_float:
                grid = from_bytes(4, options_.big_endian, raw_size,
                                  [](std::uint32_t bits) { return double{std::bit_cast<float>(bits)}; });
                break;
            case HeightFormat::hgt:
                grid = from_bytes(2, true, Size{}, [](std::uint32_t bits) {
                    const auto height = static_cast<std::int16_t>(bits);
                    return height == std::numeric_limits<std::int16_t>::min() ? double{k_missing}
                                                                              : static_cast<double>(height);
                });
                grid.spacing = hgt_spacing(grid);
                break;
            case HeightFormat::gdal:
                grid = detail::read_with_gdal(path_, options_);
                break;
        }
        if (options_.spacing) grid.spacing = *options_.spacing;
        return grid;
    }

  private:
    /// Zero: not known.
    struct Size {
        std::uint64_t columns = 0, rows = 0;
    };
    [[noreturn]] void refuse(const std::string& text) const { throw Error(ErrorCode::invalid_input, text, path_); }

    float height_of(double number) const {
        if (!std::isfinite(number) || (options_.no_data && number == *options_.no_data)) return k_missing;
        return static_cast<float>(options_.offset + options_.scale * number);
    }

    HeightGrid from_picture(HeightFormat format) const {
        const detail::Picture picture = detail::read_picture(path_, options_.context);
        const auto stride = static_cast<std::size_t>(picture.channels);
        if (format == HeightFormat::terrain_rgb && stride < 3)
            refuse("the picture is grey; terrain-RGB has its heights in colours");
        if (stride >= 3 && picture.has_16_bits) refuse("the picture has colours of 16 bits; terrain-RGB has 8");
        HeightGrid grid = detail::empty_grid(static_cast<std::uint64_t>(picture.width),
                                             static_cast<std::uint64_t>(picture.height), path_, options_.context);
        const std::uint16_t* pixel = picture.samples.data();
        for (float& height : grid.heights) {
            // In tenths first, which are whole numbers.
            const double number =
                stride >= 3 ? ((pixel[0] >> 8) * 65536.0 + (pixel[1] >> 8) * 256.0 + (pixel[2] >> 8) - 1e5) / 10
                            : (picture.has_16_bits ? pixel[0] : pixel[0] >> 8);
            height = height_of(number);
            pixel += stride;
        }
        return grid;
    }

    Size size_of(std::uint64_t count, const Size& asked) const {
        auto [columns, rows] = asked;
        if (columns == 0 && rows == 0) {
            columns = static_cast<std::uint64_t>(std::llround(std::sqrt(static_cast<double>(count))));
            if (columns * columns != count)
                refuse(fmt::format("the file has {} heights, which are not a square; say how many columns there are",
                                   count));
            return {columns, columns};
        }
        if (columns == 0) columns = count / rows;
        if (rows == 0) rows = count / columns;
        if (columns * rows != count)
            refuse(fmt::format("the file has {} heights, not {} columns times {} rows", count, columns, rows));
        return {columns, rows};
    }

    template <class Number>
    HeightGrid from_bytes(std::size_t size, bool big_endian, const Size& asked, const Number& number) const {
        const std::string bytes = detail::read_file(path_, options_.context);
        if (bytes.empty()) refuse("the file is empty");
        if (bytes.size() % size != 0)
            refuse(
                fmt::format("{} bytes are no whole number of heights of {} bytes: the file is cut off or has another "
                            "format",
                            bytes.size(), size));
        const auto [columns, rows] = size_of(bytes.size() / size, asked);
        HeightGrid grid = detail::empty_grid(columns, rows, path_, options_.context);
        const auto* next = reinterpret_cast<const unsigned char*>(bytes.data());
        for (float& height : grid.heights) {
            std::uint32_t bits = 0;
            for (std::size_t i = 0; i < size; ++i)
                bits |= std::uint32_t{next[big_endian ? size - 1 - i : i]} << (8 * i);
            height = height_of(number(bits));
            next += size;
        }
        return grid;
    }

    /// Metres between samples of a square of one degree, whose name is that of its corner in the south-west.
    Vec2d hgt_spacing(const HeightGrid& grid) const {
        const std::string name = path_.stem().string();
        if (name.size() < 3 || std::string_view("NnSs").find(name[0]) == std::string_view::npos ||
            std::isdigit(static_cast<unsigned char>(name[1])) == 0 ||
            std::isdigit(static_cast<unsigned char>(name[2])) == 0)
            return {1, 1};
        const double south = (name[0] == 'S' || name[0] == 's' ? -1 : 1) * ((name[1] - '0') * 10 + (name[2] - '0'));
        constexpr double k_metres_a_degree =
            6371008.8 * std::numbers::pi / 180;  // of a sphere with Earth's mean radius
        const double along = k_metres_a_degree / (grid.rows - 1);
        return {along * std::cos((south + 0.5) * std::numbers::pi / 180), along};
    }

    const std::filesystem::path& path_;
    const HeightReadOptions& options_;
};

}  // namespace

HeightGrid detail::empty_grid(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path,
                              const RunContext& context) {
    if (columns < 2 || rows < 2)
        throw Error(ErrorCode::invalid_input,
                    fmt::format("{} columns and {} rows of heights; two of each are the least", columns, rows), path);
    const std::uint64_t bytes = columns * rows * sizeof(float);
    if (context.max_memory_bytes != 0 && bytes > context.max_memory_bytes)
        throw Error(ErrorCode::memory_limit,
                    fmt::format("{} x {} heights take {} MiB, and the limit is {} MiB", columns, rows, bytes >> 20,
                                context.max_memory_bytes >> 20),
                    path);
    HeightGrid grid{
        .columns = static_cast<std::uint32_t>(columns), .rows = static_cast<std::uint32_t>(rows), .heights = {}};
    resize_large(grid.heights, static_cast<std::size_t>(columns * rows));
    return grid;
}

HeightGrid load_height_grid(const std::filesystem::path& path, const HeightReadOptions& options) {
    HeightGrid grid = Decoder(path, options).decode();
    if (std::all_of(grid.heights.begin(), grid.heights.end(), [](float height) { return std::isnan(height); }))
        throw Error(ErrorCode::invalid_input, "no sample has data", path);
    return grid;
}

std::uint64_t fill_missing_heights(HeightGrid& grid) {
    const auto missing = static_cast<std::uint64_t>(
        std::count_if(grid.heights.begin(), grid.heights.end(), [](float height) { return std::isnan(height); }));
    if (missing == 0) return 0;
    if (missing == grid.heights.size()) throw Error(ErrorCode::invalid_input, "no sample of the height grid has data");
    // Grids of half the size, of the means of what there is, until nothing is missing.
    HeightGrid half{.columns = (grid.columns + 1) / 2, .rows = (grid.rows + 1) / 2, .heights = {}};
    half.heights.reserve(std::size_t{half.columns} * half.rows);
    for (std::uint32_t r = 0; r < half.rows; ++r)
        for (std::uint32_t c = 0; c < half.columns; ++c) {
            double sum = 0;
            int count = 0;
            for (std::uint32_t y = 2 * r; y < std::min(2 * r + 2, grid.rows); ++y)
                for (std::uint32_t x = 2 * c; x < std::min(2 * c + 2, grid.columns); ++x)
                    if (const float height = grid.at(x, y); !std::isnan(height)) {
                        sum += double{height};
                        ++count;
                    }
            half.heights.push_back(count == 0 ? k_missing : static_cast<float>(sum / count));
        }
    fill_missing_heights(half);
    // Bilinear between the middles of the squares.
    for (std::uint32_t r = 0; r < grid.rows; ++r)
        for (std::uint32_t c = 0; c < grid.columns; ++c) {
            float& height = grid.heights[std::size_t{r} * grid.columns + c];
            if (!std::isnan(height)) continue;
            const auto beside = [](std::uint32_t i, std::uint32_t count) {
                return (i & 1) == 0 ? (i / 2 == 0 ? 0 : i / 2 - 1) : std::min(i / 2 + 1, count - 1);
            };
            const std::uint32_t x = c / 2, y = r / 2, x2 = beside(c, half.columns), y2 = beside(r, half.rows);
            height = 0.75f * (0.75f * half.at(x, y) + 0.25f * half.at(x2, y)) +
                     0.25f * (0.75f * half.at(x, y2) + 0.25f * half.at(x2, y2));
        }
    return missing;
}

void detail::check_surface(const HeightGrid& grid) {
    constexpr std::uint32_t k_most_samples = 1u << 24;  // a side: places then fit into 31 bits
    const auto refuse = [](ErrorCode code, const std::string& text) { throw Error(code, text); };
    if (grid.columns < 2 || grid.rows < 2)
        refuse(ErrorCode::invalid_input, fmt::format("a height grid of {} columns and {} rows has no surface; two of "
                                                     "each are the least",
                                                     grid.columns, grid.rows));
    if (grid.columns > k_most_samples || grid.rows > k_most_samples)
        refuse(ErrorCode::unsupported, fmt::format("a height grid of {} columns and {} rows; at most {} of each are "
                                                   "supported: cut it into tiles",
                                                   grid.columns, grid.rows, k_most_samples));
    if (grid.heights.size() != std::size_t{grid.columns} * grid.rows)
        refuse(ErrorCode::invalid_input, fmt::format("a height grid of {} columns and {} rows with {} heights",
                                                     grid.columns, grid.rows, grid.heights.size()));
    if (!(grid.spacing.x > 0 && grid.spacing.y > 0 && std::isfinite(grid.spacing.x) && std::isfinite(grid.spacing.y)))
        refuse(ErrorCode::invalid_input, fmt::format("spacings of {} and {} between samples; they have to be positive",
                                                     grid.spacing.x, grid.spacing.y));
    for (std::size_t i = 0; i < grid.heights.size(); ++i)
        if (!std::isfinite(grid.heights[i]))
            refuse(ErrorCode::invalid_input,
                   fmt::format("the height at column {}, row {} is missing; fill_missing_heights() gives it one",
                               i % grid.columns, i / grid.columns));
}

}  // namespace tetrakis
