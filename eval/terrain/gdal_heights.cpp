#include "height_files.hpp"

#include "../../hier/base/error.hpp"

#include <fmt/format.h>

#ifdef TETRAKIS_GDAL
#    include <cpl_error.h>
#    include <gdal.h>
#    include <ogr_srs_api.h>

#    include <algorithm>
#    include <cctype>
#    include <cmath>
#    include <limits>
#    include <memory>
#    include <numbers>
#    include <optional>
#    include <string>
#    include <string_view>
#endif

namespace tetrakis::detail {

#ifdef TETRAKIS_GDAL

namespace {

constexpr double k_degree = std::numbers::pi / 180;

/// Keeps GDAL's messages from the terminal while it lives; errors quote them.
struct QuietErrors {
    QuietErrors() { CPLPushErrorHandler(CPLQuietErrorHandler); }
    ~QuietErrors() { CPLPopErrorHandler(); }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;
};

/// Metres in a band's unit of length; 1 if the unit is not given, nothing if it is unknown.
std::optional<double> metres_in(std::string_view text) {
    std::string unit(text);
    std::ranges::transform(unit, unit.begin(), [](unsigned char c) { return std::tolower(c); });
    if (unit.empty() || unit == "m" || unit == "metre" || unit == "meter" || unit == "metres" || unit == "meters")
        return 1;
    if (unit == "km" || unit == "kilometre" || unit == "kilometer") return 1000;
    if (unit == "cm") return 0.01;
    if (unit == "mm") return 0.001;
    if (unit == "ft" || unit == "foot" || unit == "feet") return 0.3048;
    if (unit == "us-ft" || unit == "us survey foot" || unit == "foot_us" || unit == "ftus") return 1200.0 / 3937;
    return {};
}

class GdalSource final : public HeightSource {
  public:
    GdalSource(const std::filesystem::path& path, const HeightReadOptions& options) : path_(path), options_(options) {
        GDALAllRegister();
        const QuietErrors quiet;
        raster_.reset(GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
        if (!raster_) refuse("cannot be read as a raster");
        if (GDALGetRasterCount(raster_.get()) < 1) refuse("the raster has no band");
        frame_ = empty_frame(static_cast<std::uint64_t>(GDALGetRasterXSize(raster_.get())),
                             static_cast<std::uint64_t>(GDALGetRasterYSize(raster_.get())), path);
        band_ = GDALGetRasterBand(raster_.get(), 1);
        int has_none = 0, ignored = 0;
        const double none = GDALGetRasterNoDataValue(band_, &has_none);
        if (has_none != 0) none_ = static_cast<float>(none);
        const char* const unit_name = GDALGetRasterUnitType(band_);
        const std::optional<double> unit = metres_in(unit_name);
        if (!unit)
            throw Error(
                ErrorCode::unsupported,
                fmt::format("heights in \"{}\", which is no length known here; gdal_edit.py -units sets another",
                            unit_name),
                path);
        options_.scale = GDALGetRasterScale(band_, &ignored) * *unit * options.scale;
        options_.offset = GDALGetRasterOffset(band_, &ignored) * *unit * options.scale + options.offset;
        place();
        if (options.spacing) frame_.spacing = *options.spacing;
    }

    const HeightGrid& frame() const override { return frame_; }

    void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) override {
        const QuietErrors quiet;
        const auto columns = static_cast<int>(frame_.columns), rows = static_cast<int>(count);
        const std::uint32_t first = is_from_south_ ? frame_.rows - first_row - count : first_row;
        if (GDALRasterIO(band_, GF_Read, 0, static_cast<int>(first), columns, rows, heights.data(), columns, rows,
                         GDT_Float32, 0, 0) != CE_None)
            refuse(fmt::format("{} rows from row {} on cannot be read", count, first));
        const auto row = [&](std::uint32_t r) { return heights.begin() + std::ptrdiff_t{r} * frame_.columns; };
        if (is_from_south_)
            for (std::uint32_t r = 0; r < count / 2; ++r) std::swap_ranges(row(r), row(r + 1), row(count - 1 - r));
        for (float& height : heights.first(std::size_t{count} * frame_.columns))
            height = none_ && height == *none_ ? std::numeric_limits<float>::quiet_NaN()
                                               : height_of(double{height}, options_);
    }

  private:
    [[noreturn]] void refuse(const std::string& text) const {
        throw Error(ErrorCode::invalid_input, fmt::format("{} (GDAL: {})", text, CPLGetLastErrorMsg()), path_);
    }

    /// Sets spacing and origin by the raster's geotransform.
    void place() {
        double to_ground[6];
        if (GDALGetGeoTransform(raster_.get(), to_ground) != CE_None) return;
        if (to_ground[2] != 0 || to_ground[4] != 0 || !(to_ground[1] > 0) || to_ground[5] == 0)
            throw Error(ErrorCode::unsupported,
                        "the raster's rows do not run from west to east; turn it with gdalwarp first", path_);
        frame_.spacing = {to_ground[1], std::abs(to_ground[5])};
        double north = to_ground[3] + to_ground[5] / 2;
        is_from_south_ = to_ground[5] > 0;
        if (is_from_south_) north += to_ground[5] * (frame_.rows - 1);
        frame_.origin = {to_ground[0] + to_ground[1] / 2, north};
        const OGRSpatialReferenceH reference = GDALGetSpatialRef(raster_.get());
        if (reference == nullptr) return;
        if (OSRIsProjected(reference) != 0) {
            const double metres = OSRGetLinearUnits(reference, nullptr);
            frame_.spacing *= metres;
            frame_.origin *= metres;
        }
        if (OSRIsGeographic(reference) == 0) return;
        const double middle = north - frame_.spacing.y * (frame_.rows - 1) / 2;
        frame_.spacing *= Vec2d(k_metres_a_degree * std::cos(middle * k_degree), k_metres_a_degree);
        frame_.origin = {0, 0};
    }

    std::filesystem::path path_;
    HeightReadOptions options_;
    std::unique_ptr<void, void (*)(void*)> raster_{nullptr, [](void* open) { GDALClose(open); }};
    GDALRasterBandH band_ = nullptr;
    std::optional<float> none_;
    bool is_from_south_ = false;
    HeightGrid frame_;
};

}  // namespace

std::unique_ptr<HeightSource> open_with_gdal(const std::filesystem::path& path, const HeightReadOptions& options) {
    return std::make_unique<GdalSource>(path, options);
}

#else

std::unique_ptr<HeightSource> open_with_gdal(const std::filesystem::path& path, const HeightReadOptions&) {
    throw Error(ErrorCode::unsupported,
                fmt::format("the extension {} is read with GDAL, and this build has none: install libgdal-dev and "
                            "configure with -DTETRAKIS_GDAL=ON; .png, .hgt, .r16, .raw, .r32 and .f32 are read without",
                            path.extension().empty() ? "(none)" : path.extension().string()),
                path);
}

#endif

}  // namespace tetrakis::detail
