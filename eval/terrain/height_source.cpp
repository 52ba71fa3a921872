#include "height_source.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "gdal_heights.hpp"
#include "raw_heights.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis {

namespace {

class GridSource final : public HeightSource {
  public:
    explicit GridSource(const HeightGrid& grid) : grid_(grid) {
        frame_.columns = grid.columns;
        frame_.rows = grid.rows;
        frame_.spacing = grid.spacing;
        frame_.origin = grid.origin;
    }
    const HeightGrid& frame() const override { return frame_; }
    void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) override {
        std::copy_n(grid_.heights.data() + std::size_t{first_row} * grid_.columns, std::size_t{count} * grid_.columns,
                    heights.data());
    }

  private:
    const HeightGrid& grid_;
    HeightGrid frame_;
};

/// One that owns its grid.
class PictureSource final : public HeightSource {
  public:
    explicit PictureSource(HeightGrid grid) : grid_(std::move(grid)), source_(grid_) {}
    const HeightGrid& frame() const override { return source_.frame(); }
    void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) override {
        source_.read(first_row, count, heights);
    }

  private:
    HeightGrid grid_;
    GridSource source_;
};

}  // namespace

std::unique_ptr<HeightSource> make_height_source(const HeightGrid& grid) { return std::make_unique<GridSource>(grid); }

std::unique_ptr<HeightSource> open_height_source(const std::filesystem::path& path, const HeightReadOptions& options) {
    switch (const HeightFormat format = detail::format_of(path, options); format) {
        case HeightFormat::raw16:
        case HeightFormat::raw_float:
        case HeightFormat::hgt:
            return detail::open_raw_heights(path, options, format);
        case HeightFormat::gdal:
            return detail::open_with_gdal(path, options);
        default:
            return std::make_unique<PictureSource>(load_height_grid(path, options));
    }
}

}  // namespace tetrakis
