#include "height_grid.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../surface/picture.hpp"
#include "height_files.hpp"
#include "height_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace tetrakis {

namespace {

constexpr float k_missing = std::numeric_limits<float>::quiet_NaN();

void make_room(HeightGrid& grid, const std::filesystem::path& path, const RunContext& context) {
    const std::uint64_t count = std::uint64_t{grid.columns} * grid.rows, bytes = count * sizeof(float);
    detail::check_memory(fmt::format("{} x {} heights need", grid.columns, grid.rows), bytes, context.max_memory_bytes,
                         "allow more", path);
    detail::resize_large(grid.heights, static_cast<std::size_t>(count));
}

HeightGrid from_picture(const std::filesystem::path& path, const HeightReadOptions& options, HeightFormat format) {
    const auto refuse = [&](const char* text) { throw Error(ErrorCode::invalid_input, text, path); };
    const detail::Picture picture = detail::read_picture(path, options.context);
    const auto stride = static_cast<std::size_t>(picture.channels);
    if (format == HeightFormat::terrain_rgb && stride < 3)
        refuse("the picture is grey; terrain-RGB has its heights in colours");
    // Some programs write grey pictures with three channels, or with a palette.
    bool is_grey = stride < 3;
    if (!is_grey && format != HeightFormat::terrain_rgb) {
        is_grey = true;
        for (std::size_t i = 0; is_grey && i < picture.samples.size(); i += stride)
            is_grey = picture.samples[i] == picture.samples[i + 1] && picture.samples[i] == picture.samples[i + 2];
    }
    if (!is_grey && picture.bits == 16) refuse("the picture has colours of 16 bits; terrain-RGB has 8");
    const int unit = 65535 / ((1 << picture.bits) - 1);  // of the file's numbers in 16 bits
    HeightGrid grid = detail::empty_frame(static_cast<std::uint64_t>(picture.width),
                                          static_cast<std::uint64_t>(picture.height), path);
    make_room(grid, path, options.context);
    const std::uint16_t* pixel = picture.samples.data();
    for (float& height : grid.heights) {
        // Tenths of a metre are whole numbers, so the sum is exact.
        const double number = is_grey
                                  ? pixel[0] / unit
                                  : ((pixel[0] >> 8) * 65536.0 + (pixel[1] >> 8) * 256.0 + (pixel[2] >> 8) - 1e5) / 10;
        height = detail::height_of(number, options);
        pixel += stride;
    }
    if (options.spacing) grid.spacing = *options.spacing;
    return grid;
}

HeightGrid from_source(HeightSource& source, const std::filesystem::path& path, const RunContext& context) {
    constexpr std::uint32_t k_rows = 256;  // between two reports
    HeightGrid grid = source.frame();
    make_room(grid, path, context);
    for (std::uint32_t r = 0; r < grid.rows; r += k_rows) {
        context.report("load", static_cast<double>(r) / grid.rows);
        source.read(r, std::min(k_rows, grid.rows - r), std::span(grid.heights).subspan(std::size_t{r} * grid.columns));
    }
    return grid;
}

class GridSource final : public HeightSource {
  public:
    explicit GridSource(std::shared_ptr<const HeightGrid> grid)
        : grid_(std::move(grid)), frame_{grid_->columns, grid_->rows, {}, grid_->spacing, grid_->origin} {}
    const HeightGrid& frame() const override { return frame_; }
    void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) override {
        std::copy_n(grid_->heights.data() + std::size_t{first_row} * grid_->columns,
                    std::size_t{count} * grid_->columns, heights.data());
    }

  private:
    std::shared_ptr<const HeightGrid> grid_;
    HeightGrid frame_;
};

}  // namespace

std::unique_ptr<HeightSource> make_height_source(const HeightGrid& grid) {
    return std::make_unique<GridSource>(std::shared_ptr<const HeightGrid>(std::shared_ptr<void>(), &grid));
}

std::unique_ptr<HeightSource> open_height_source(const std::filesystem::path& path, const HeightReadOptions& options) {
    const HeightFormat format = detail::format_of(path, options);
    if (format == HeightFormat::gdal) return detail::open_with_gdal(path, options);
    if (format == HeightFormat::png || format == HeightFormat::terrain_rgb)
        return std::make_unique<GridSource>(std::make_shared<HeightGrid>(load_height_grid(path, options)));
    return detail::open_raw_heights(path, options, format);
}

namespace {

/// @throws Error  invalid_input, unsupported: too few or too many for a surface
void check_size(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path) {
    constexpr std::uint64_t k_most = 1u << 24;  // grid coordinates then fit into 31 bits
    const auto refuse = [&](ErrorCode code, std::string_view but) {
        throw Error(code, fmt::format("a height grid of {} columns and {} rows; {}", columns, rows, but), path);
    };
    if (columns < 2 || rows < 2) refuse(ErrorCode::invalid_input, "two of each are the least");
    if (columns > k_most || rows > k_most)
        refuse(ErrorCode::unsupported, fmt::format("at most {} of each are supported: cut it into tiles", k_most));
}

}  // namespace

HeightGrid detail::empty_frame(std::uint64_t columns, std::uint64_t rows, const std::filesystem::path& path) {
    check_size(columns, rows, path);
    return {.columns = static_cast<std::uint32_t>(columns), .rows = static_cast<std::uint32_t>(rows), .heights = {}};
}

HeightGrid load_height_grid(const std::filesystem::path& path, const HeightReadOptions& options) {
    const HeightFormat format = detail::format_of(path, options);
    HeightGrid grid = format == HeightFormat::png || format == HeightFormat::terrain_rgb
                          ? from_picture(path, options, format)
                          : from_source(*open_height_source(path, options), path, options.context);
    if (std::all_of(grid.heights.begin(), grid.heights.end(), [](float height) { return std::isnan(height); }))
        throw Error(ErrorCode::invalid_input, "no sample has data", path);
    return grid;
}

std::uint64_t fill_missing_heights(HeightGrid& grid) {
    const auto missing = static_cast<std::uint64_t>(
        std::count_if(grid.heights.begin(), grid.heights.end(), [](float height) { return std::isnan(height); }));
    if (missing == 0) return 0;
    if (missing == grid.heights.size()) throw Error(ErrorCode::invalid_input, "no sample of the height grid has data");
    // Recursion on grids of half the size, with means of the present samples, until none is missing.
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
    // Bilinear interpolation between the middles of the half-size grid's squares.
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

void detail::check_frame(const HeightGrid& grid) {
    check_size(grid.columns, grid.rows, {});
    const auto refuse = [](const std::string& text) { throw Error(ErrorCode::invalid_input, text); };
    constexpr double k_farthest = 1e37;  // coordinates, and the shortest spacing, must fit in single precision
    if (!(grid.spacing.x * k_farthest >= 1 && grid.spacing.y * k_farthest >= 1 && std::isfinite(grid.spacing.x) &&
          std::isfinite(grid.spacing.y)))
        refuse(fmt::format("spacings of {} and {} between samples; they have to be positive, and {} is the least",
                           grid.spacing.x, grid.spacing.y, 1 / k_farthest));
    const double x = std::abs(grid.origin.x) + grid.spacing.x * grid.columns,
                 y = std::abs(grid.origin.y) + grid.spacing.y * grid.rows;
    if (!(x <= k_farthest && y <= k_farthest))
        refuse(fmt::format("a height grid that reaches to {}; {} is the farthest: take a smaller spacing or origin",
                           x <= k_farthest ? y : x, k_farthest));
}

void detail::check_heights(const HeightGrid& grid, std::uint32_t first_row, const char* missing) {
    const auto bad = std::ranges::find_if_not(grid.heights, [](float height) { return std::isfinite(height); });
    if (bad == grid.heights.end()) return;
    const auto i = static_cast<std::uint64_t>(bad - grid.heights.begin());
    throw Error(ErrorCode::invalid_input,
                fmt::format("the height at column {}, row {} is {}", i % grid.columns, first_row + i / grid.columns,
                            std::isnan(*bad) ? missing : "larger than single precision holds; take a smaller scale"));
}

void detail::check_surface(const HeightGrid& grid) {
    check_frame(grid);
    if (grid.heights.size() != std::size_t{grid.columns} * grid.rows)
        throw Error(ErrorCode::invalid_input, fmt::format("a height grid of {} columns and {} rows with {} heights",
                                                          grid.columns, grid.rows, grid.heights.size()));
    check_heights(grid, 0, "missing; fill_missing_heights() gives it one");
}

}  // namespace tetrakis
