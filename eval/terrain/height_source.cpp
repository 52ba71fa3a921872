#include "height_source.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"
#include "height_files.hpp"

#include <algorithm>
#include <utility>

namespace tetrakis {

namespace {

class GridSource final : public HeightSource {
  public:
    explicit GridSource(std::shared_ptr<const HeightGrid> grid) : grid_(std::move(grid)) {
        frame_.columns = grid_->columns;
        frame_.rows = grid_->rows;
        frame_.spacing = grid_->spacing;
        frame_.origin = grid_->origin;
    }
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

}  // namespace tetrakis
