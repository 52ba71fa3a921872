#include "gdal_heights.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"

#include <fmt/format.h>

#ifdef TETRAKIS_GDAL
#    include <cpl_error.h>
#    include <gdal.h>
#    include <ogr_srs_api.h>

#    include <algorithm>
#    include <cmath>
#    include <cstdlib>
#    include <limits>
#    include <memory>
#    include <numbers>
#    include <string>
#    include <string_view>
#endif

namespace tetrakis::detail {

#ifdef TETRAKIS_GDAL

namespace {

constexpr double k_degree = std::numbers::pi / 180;
constexpr double k_metres_a_degree = 6371008.8 * k_degree;  // of a sphere with Earth's mean radius

/// What GDAL says goes into our own errors, not to the terminal.
struct QuietErrors {
    QuietErrors() { CPLPushErrorHandler(CPLQuietErrorHandler); }
    ~QuietErrors() { CPLPopErrorHandler(); }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;
};

/// Metres in a band's unit.
double metres_in(std::string_view unit) {
    if (unit == "ft" || unit == "foot" || unit == "feet") return 0.3048;
    if (unit == "us-ft" || unit == "US survey foot") return 1200.0 / 3937;
    return 1;
}

/// Spacing and origin by the raster's geotransform.
void place(HeightGrid& grid, GDALDatasetH raster, const std::filesystem::path& path) {
    double to_ground[6];
    if (GDALGetGeoTransform(raster, to_ground) != CE_None) return;
    if (to_ground[2] != 0 || to_ground[4] != 0 || !(to_ground[1] > 0) || to_ground[5] == 0)
        throw Error(ErrorCode::unsupported,
                    "the raster's rows do not run from west to east; turn it with gdalwarp first", path);
    grid.spacing = {to_ground[1], std::abs(to_ground[5])};
    double north = to_ground[3] + to_ground[5] / 2;
    if (to_ground[5] > 0) {  // from the south: the other way round
        for (std::uint32_t r = 0; r < grid.rows / 2; ++r)
            std::swap_ranges(grid.heights.begin() + std::ptrdiff_t{r} * grid.columns,
                             grid.heights.begin() + std::ptrdiff_t{r + 1} * grid.columns,
                             grid.heights.end() - std::ptrdiff_t{r + 1} * grid.columns);
        north += to_ground[5] * (grid.rows - 1);
    }
    grid.origin = {to_ground[0] + to_ground[1] / 2, north};
    const OGRSpatialReferenceH reference = GDALGetSpatialRef(raster);
    if (reference == nullptr || OSRIsGeographic(reference) == 0) return;
    const double middle = north - grid.spacing.y * (grid.rows - 1) / 2;
    grid.spacing *= Vec2d(k_metres_a_degree * std::cos(middle * k_degree), k_metres_a_degree);
    grid.origin = {0, 0};
}

}  // namespace

HeightGrid read_with_gdal(const std::filesystem::path& path, const HeightReadOptions& options) {
    GDALAllRegister();
    const QuietErrors quiet;
    const std::unique_ptr<void, void (*)(void*)> raster(
        GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr),
        [](void* open) { GDALClose(open); });
    const auto refuse = [&](const std::string& text) {
        throw Error(ErrorCode::invalid_input, fmt::format("{} (GDAL: {})", text, CPLGetLastErrorMsg()), path);
    };
    if (!raster) refuse("cannot be read as a raster");
    if (GDALGetRasterCount(raster.get()) < 1) refuse("the raster has no band");
    HeightGrid grid = empty_grid(static_cast<std::uint64_t>(GDALGetRasterXSize(raster.get())),
                                 static_cast<std::uint64_t>(GDALGetRasterYSize(raster.get())), path, options.context);
    const GDALRasterBandH band = GDALGetRasterBand(raster.get(), 1);
    int has_none = 0, ignored = 0;
    const double none = GDALGetRasterNoDataValue(band, &has_none);
    const double unit = metres_in(GDALGetRasterUnitType(band)),
                 scale = GDALGetRasterScale(band, &ignored) * unit * options.scale,
                 offset = GDALGetRasterOffset(band, &ignored) * unit * options.scale + options.offset;
    const auto columns = static_cast<int>(grid.columns);
    for (std::uint32_t r = 0; r < grid.rows; ++r) {
        float* const row = grid.heights.data() + std::size_t{r} * grid.columns;
        if (GDALRasterIO(band, GF_Read, 0, static_cast<int>(r), columns, 1, row, columns, 1, GDT_Float32, 0, 0) !=
            CE_None)
            refuse(fmt::format("row {} cannot be read", r));
        std::for_each(row, row + columns, [&](float& height) {
            const bool known = std::isfinite(height) && !(has_none != 0 && height == static_cast<float>(none)) &&
                               !(options.no_data && height == static_cast<float>(*options.no_data));
            height =
                known ? static_cast<float>(offset + scale * double{height}) : std::numeric_limits<float>::quiet_NaN();
        });
        if (r % 256 == 0) options.context.report("load", static_cast<double>(r) / grid.rows);
    }
    place(grid, raster.get(), path);
    return grid;
}

#else

HeightGrid read_with_gdal(const std::filesystem::path& path, const HeightReadOptions&) {
    throw Error(ErrorCode::unsupported,
                fmt::format("the extension {} is read with GDAL, and this build has none: install libgdal-dev and "
                            "configure with -DTETRAKIS_GDAL=ON; .png, .hgt, .r16, .raw, .r32 and .f32 are read without",
                            path.extension().empty() ? "(none)" : path.extension().string()),
                path);
}

#endif

}  // namespace tetrakis::detail
