#include "../../eval/terrain/height_grid.hpp"
#include "../../eval/io/png.hpp"
#include "../../hier/base/error.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

/// A PNG of these lines, each of which is a zero byte and its pixels.
/// @param kind  bits of a sample, colour type and three zeros
std::string png_of_lines(std::uint32_t columns, std::uint32_t rows, const std::string& lines, const std::string& kind) {
    uLongf size = compressBound(static_cast<uLong>(lines.size()));
    std::string packed(size, ' ');
    compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(lines.data()),
             static_cast<uLong>(lines.size()));
    packed.resize(size);
    const std::string header = test::big_endian(columns) + test::big_endian(rows) + kind;
    return "\x89PNG\r\n\x1a\n" + test::png_chunk("IHDR" + header) + test::png_chunk("IDAT" + packed) +
           test::png_chunk("IEND");
}

/// A grey PNG of 16 bits.
std::string png_of(std::uint32_t columns, std::uint32_t rows, const std::vector<std::uint16_t>& values) {
    std::string lines;
    for (std::uint32_t r = 0; r < rows; ++r) {
        lines += '\0';
        for (std::uint32_t c = 0; c < columns; ++c) {
            const unsigned value = values[r * std::size_t{columns} + c];
            lines += {static_cast<char>(value >> 8), static_cast<char>(value & 0xFF)};
        }
    }
    return png_of_lines(columns, rows, lines, std::string("\x10\0\0\0\0", 5));
}

std::string floats(const std::vector<float>& values) {
    std::string bytes(4 * values.size(), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

std::string fault(const std::filesystem::path& path, const HeightReadOptions& options = {}) {
    const Error error = test::error_of([&] { load_height_grid(path, options); });
    CHECK(error.file() == path);
    return error.what();
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("height grids: grey PNG of 16 and of 8 bits, terrain-RGB") {
    const ScratchDir dir;
    spill(dir / "h.png", png_of(3, 2, {0, 1, 2, 65535, 40000, 40001}));
    HeightGrid grid = load_height_grid(dir / "h.png");
    CHECK(grid.columns == 3);
    CHECK(grid.rows == 2);
    CHECK(grid.heights == std::vector<float>{0, 1, 2, 65535, 40000, 40001});
    CHECK(grid.at(1, 1) == 40000);
    CHECK(grid.spacing == Vec2d(1, 1));
    grid = load_height_grid(dir / "h.png", {.scale = 0.5, .offset = -10, .no_data = 2, .spacing = Vec2d(30, 20)});
    CHECK(grid.heights[3] == 32757.5f);
    CHECK(std::isnan(grid.heights[2]));
    CHECK(grid.spacing == Vec2d(30, 20));
    // -9999.9 is not representable as a float.
    const float numbers[] = {1, 2, -9999.9f, 4};
    spill(dir / "h.r32", std::string(reinterpret_cast<const char*>(numbers), sizeof numbers));
    CHECK(std::isnan(load_height_grid(dir / "h.r32", {.no_data = -9999.9}).heights[2]));

    // A picture of four bits a sample; then a grey picture with three channels.
    spill(dir / "4.png", png_of_lines(2, 2, std::string("\0\x0F\0\x23", 4), std::string("\x04\0\0\0\0", 5)));
    CHECK(load_height_grid(dir / "4.png").heights == std::vector<float>{0, 15, 2, 3});
    write_png(dir / "g.png", {2, 2, {7, 7, 7, 255, 255, 255, 0, 0, 0, 30, 30, 30}});
    CHECK(load_height_grid(dir / "g.png").heights == std::vector<float>{7, 255, 0, 30});

    // Apple's variant of PNG: a chunk before the header, and a stream without zlib's header.
    std::string apple = png_of_lines(2, 2, std::string("\0\x05\x06\0\x07\x08", 6), std::string("\x08\0\0\0\0", 5));
    const std::size_t data = apple.find("IDAT"), length = apple.find("IEND") - 8 - data - 4;
    apple = apple.substr(0, data - 4) + test::png_chunk("IDAT" + apple.substr(data + 4 + 2, length - 2)) +
            test::png_chunk("IEND");
    apple.insert(8, test::png_chunk(std::string("CgBI\x50\0\x20\x02", 8)));
    spill(dir / "apple.png", apple);
    CHECK(load_height_grid(dir / "apple.png").heights == std::vector<float>{5, 6, 7, 8});

    // Terrain-RGB: 1 134 160 is 100000 tenths, so 0 m; then 0.1 m; then Everest.
    write_png(dir / "t.png", {2, 2, {1, 134, 160, 1, 134, 161, 2, 224, 64, 0, 0, 0}});
    for (const HeightFormat format : {HeightFormat::automatic, HeightFormat::terrain_rgb})
        CHECK(load_height_grid(dir / "t.png", {.format = format}).heights == std::vector<float>{0, 0.1f, 8848, -10000});
}

TEST_CASE("height grids: raw numbers") {
    const ScratchDir dir;
    spill(dir / "h.r16", std::string("\x01\x00\x02\x00\xFF\xFF\x00\x80\x05\x00\x06\x00", 12));
    const std::vector<float> numbers{1, 2, 65535, 32768, 5, 6};
    for (const auto& [columns, rows] : {std::pair{3u, 2u}, std::pair{3u, 0u}, std::pair{0u, 2u}}) {
        const HeightGrid grid = load_height_grid(dir / "h.r16", {.columns = columns, .rows = rows});
        CHECK(grid.columns == 3);
        CHECK(grid.rows == 2);
        CHECK(grid.heights == numbers);
    }
    CHECK(load_height_grid(dir / "h.r16", {.columns = 2, .big_endian = true}).heights[0] == 256);

    spill(dir / "h.r32", floats({1.5f, -2, std::numeric_limits<float>::infinity(), 4}));
    const HeightGrid grid = load_height_grid(dir / "h.r32");
    CHECK(grid.columns == 2);
    CHECK(grid.heights[1] == -2);
    CHECK(std::isnan(grid.heights[2]));
    spill(dir / "h.dat", floats({1, 2, 3, 4}));
    CHECK(load_height_grid(dir / "h.dat", {.format = HeightFormat::raw_float}).heights[3] == 4);
}

TEST_CASE("height grids: HGT has signs, gaps and its place in its name") {
    const ScratchDir dir;
    const std::string bytes("\x00\x07\xFF\xFE\x80\x00\x0E\xC0\x00\x00\x00\x01\x00\x02\x00\x03\x00\x04", 18);
    spill(dir / "N60E138.hgt", bytes);
    HeightGrid grid = load_height_grid(dir / "N60E138.hgt");
    CHECK(grid.columns == 3);
    CHECK(grid.at(0, 0) == 7);
    CHECK(grid.at(1, 0) == -2);
    CHECK(std::isnan(grid.at(2, 0)));
    CHECK(grid.at(0, 1) == 3776);
    CHECK(grid.spacing.y == doctest::Approx(111195 / 2.0).epsilon(1e-4));
    CHECK(grid.spacing.x == doctest::Approx(grid.spacing.y * 0.49242).epsilon(1e-4));  // cos 60.5 degrees
    spill(dir / "S60E138.hgt", bytes);
    CHECK(load_height_grid(dir / "S60E138.hgt").spacing.x > grid.spacing.x);
    spill(dir / "tile.hgt", bytes);
    CHECK(load_height_grid(dir / "tile.hgt").spacing == Vec2d(1, 1));
}

TEST_CASE("height grids: any raster by GDAL") {
    const ScratchDir dir;
    spill(dir / "h.asc",
          "ncols 3\nnrows 2\nxllcorner 1000\nyllcorner 2000\ncellsize 20\nNODATA_value -9\n1 2.5 -9\n4 5 6\n");
    try {
        const HeightGrid grid = load_height_grid(dir / "h.asc");
        CHECK(grid.columns == 3);
        CHECK(grid.rows == 2);
        CHECK(grid.at(1, 0) == 2.5f);
        CHECK(std::isnan(grid.at(2, 0)));
        CHECK(grid.at(2, 1) == 6);
        CHECK(grid.spacing == Vec2d(20, 20));
        CHECK(grid.origin == Vec2d(1010, 2030));
        // The same heights in another file: in feet on a grid in feet, scaled, from the south.
        const auto other = [&](const std::string& reference, const std::string& transform, const std::string& band) {
            spill(dir / "h.vrt", "<VRTDataset rasterXSize=\"3\" rasterYSize=\"2\"><SRS>" + reference +
                                     "</SRS><GeoTransform>" + transform +
                                     "</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\">" + band +
                                     "<SimpleSource><SourceFilename relativeToVRT=\"1\">h.asc</SourceFilename>"
                                     "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>");
            return load_height_grid(dir / "h.vrt");
        };
        const std::string meters =
            "PROJCS[\"p\",GEOGCS[\"g\",DATUM[\"d\",SPHEROID[\"s\",6378137,298.257]],"
            "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
            "PROJECTION[\"Transverse_Mercator\"],UNIT[\"";
        const HeightGrid feet = other(meters + "foot\",0.3048]]", "0,100,0,0,0,-100",
                                      "<UnitType>ft</UnitType><Scale>2</Scale><Offset>1</Offset>");
        CHECK(feet.spacing.x == doctest::Approx(30.48));
        CHECK(feet.at(0, 1) == doctest::Approx(0.3048 * 9));
        const HeightGrid south = other(meters + "metre\",1]]", "0,10,0,500,0,10", "<UnitType>km</UnitType>");
        CHECK(south.at(0, 0) == 4000);
        CHECK(south.origin.y == doctest::Approx(515));
        const HeightGrid degrees = other(
            "GEOGCS[\"g\",DATUM[\"d\",SPHEROID[\"s\",6378137,298.257]],PRIMEM[\"Greenwich\",0],"
            "UNIT[\"degree\",0.0174532925199433]]",
            "10,0.5,0,60.5,0,-0.5", "");
        CHECK(degrees.spacing.y == doctest::Approx(111195 / 2.0).epsilon(1e-4));
        CHECK(degrees.spacing.x == doctest::Approx(degrees.spacing.y / 2).epsilon(1e-3));
        CHECK_THROWS_WITH_AS(other(meters + "metre\",1]]", "0,10,0,0,0,-10", "<UnitType>K</UnitType>"),
                             doctest::Contains("no length"), Error);
    } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::unsupported);
        MESSAGE("SKIPPED: ", std::string(error.what()));
    }
}

TEST_CASE("height grids: samples without data are filled from those around") {
    const float none = std::numeric_limits<float>::quiet_NaN();
    HeightGrid grid{.columns = 9, .rows = 7, .heights = std::vector<float>(63, 5.0f)};
    for (const std::size_t i : {0, 10, 11, 12, 19, 20, 21, 62}) grid.heights[i] = none;
    CHECK(fill_missing_heights(grid) == 8);
    CHECK(grid.heights == std::vector<float>(63, 5.0f));
    CHECK(fill_missing_heights(grid) == 0);
    // Missing heights between two plains go from one height to the other.
    for (std::uint32_t r = 0; r < 7; ++r)
        for (std::uint32_t c = 0; c < 9; ++c) grid.heights[r * 9 + c] = c == 0 ? 0.0f : c == 8 ? 8.0f : none;
    CHECK(fill_missing_heights(grid) == 49);
    for (std::uint32_t c = 0; c < 8; ++c) CHECK(grid.at(c, 3) <= grid.at(c + 1, 3));
    CHECK(grid.at(4, 3) > 1);
    CHECK(grid.at(4, 3) < 7);
}

TEST_CASE("[bad-input] height grids that are none") {
    const ScratchDir dir;
    const auto refused = [&](const char* name, const std::string& bytes, const char* words,
                             const HeightReadOptions& options = {}) {
        CAPTURE(words);
        spill(dir / name, bytes);
        CHECK(test::contains(fault(dir / name, options), words));
    };
    CHECK(test::contains(fault(dir / "none.png"), "none.png"));
    for (const char* name : {"e.png", "e.r16", "e.r32", "e.hgt"}) refused(name, "", "empty");
    refused("x.png", "no picture", "cut off, damaged or no PNG");
    const std::string whole = png_of(3, 2, {1, 2, 3, 4, 5, 6});
    for (const std::size_t length : {8, 20, 40, 60})
        refused("x.png", whole.substr(0, length), "cut off, damaged or no PNG");
    std::string damaged = whole;
    damaged[damaged.find("IDAT") + 8] ^= 1;  // a byte of the compressed heights
    refused("x.png", damaged, "damaged");
    damaged = whole;
    damaged[damaged.find("IDAT") - 5] ^= 1;  // the header's checksum
    refused("x.png", damaged, "checksum of its part IHDR");
    refused("line.png", png_of(3, 1, {1, 2, 3}), "3 columns and 1 rows");
    refused("grey.png", whole, "grey", {.format = HeightFormat::terrain_rgb});
    refused("h.tif", "no raster", "GDAL");

    const std::string six(12, '\1');
    refused("h.r16", six, "6 heights, which are not a square");
    refused("h.r16", six, "6 heights, not 4 columns", {.columns = 4});
    refused("h.r16", six, "not 3 columns times 4 rows", {.columns = 3, .rows = 4});
    refused("h.r16", six, "6 columns and 1 rows", {.columns = 6});
    refused("h.r32", std::string(15, '\1'), "15 bytes");
    refused("h.hgt", std::string(10, '\1'), "not a square");
    refused("gaps.hgt", std::string("\x80\0\x80\0\x80\0\x80\0", 8), "no sample has data");
    refused("large.r16", std::string(std::size_t{2} << 20, '\1'), "limit is 3 MiB",
            {.context = {.max_memory_bytes = 3 << 20, .progress = {}}});

    std::filesystem::resize_file(dir / "h.r16", std::uintmax_t{1} << 34);  // takes no room on the disk
    CHECK(test::contains(fault(dir / "h.r16", {.columns = 2}), "at most 16777216 of each"));
    CHECK(test::error_of([&] { load_height_grid(std::string(300, 'x') + ".r16"); }).code() == ErrorCode::io);

    HeightGrid grid{.columns = 2, .rows = 2, .heights = std::vector<float>(4, std::nanf(""))};
    CHECK_THROWS_AS(fill_missing_heights(grid), Error);
}

TEST_SUITE_END();
