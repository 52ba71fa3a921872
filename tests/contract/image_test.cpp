#include "../../eval/io/animated_png.hpp"
#include "../../eval/io/png.hpp"
#include "../../eval/surface/height_image.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
    std::uint32_t number = 0;
    for (std::size_t i = at; i < at + 4; ++i) number = number << 8 | static_cast<std::uint8_t>(bytes[i]);
    return number;
}

struct Chunk {
    std::string type, data;
};
std::vector<Chunk> chunks_of(const std::string& png) {
    std::vector<Chunk> chunks;
    REQUIRE(png.substr(0, 8) == "\x89PNG\r\n\x1A\n");
    for (std::size_t at = 8; at < png.size();) {
        REQUIRE(at + 12 <= png.size());
        const std::size_t length = number_at(png, at);
        REQUIRE(at + 12 + length <= png.size());
        CHECK(number_at(png, at + 8 + length) == test::png_checksum(png.substr(at + 4, 4 + length)));
        chunks.push_back({png.substr(at + 4, 4), png.substr(at + 8, length)});
        at += 12 + length;
    }
    return chunks;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("height images: PNG round trip, bilinear samples, wrapping") {
    const ScratchDir dir;
    Image picture{3, 2, {}};
    for (const std::uint8_t value : {0, 51, 102, 153, 204, 255})
        for (int channel = 0; channel < 3; ++channel) picture.rgb.push_back(value);
    write_png(dir / "h.png", picture);
    const HeightImage image = load_height_image(dir / "h.png");
    REQUIRE(image.width == 3);
    REQUIRE(image.height == 2);
    for (int i = 0; i < 6; ++i) CHECK(image.values[i] == doctest::Approx(0.2 * i).epsilon(1e-6));
    // At pixel centres; the upper row has v = 3/4.
    CHECK(image.sample({0.5 / 3, 0.75}) == doctest::Approx(0.0));
    CHECK(image.sample({1.5 / 3, 0.25}) == doctest::Approx(0.8));
    CHECK(image.sample({1.0 / 3, 0.75}) == doctest::Approx(0.1));
    CHECK(image.sample({1.5 / 3, 0.5}) == doctest::Approx((0.2 + 0.8) / 2));
    CHECK(image.sample({0.0, 0.75}) == doctest::Approx(0.2));                        // between 0.4 and 0
    CHECK(image.sample({1.0, 0.75}) == doctest::Approx(image.sample({0.0, 0.75})));  // the seam closes
    CHECK(image.sample({7.25, -3.4}) == doctest::Approx(image.sample({0.25, 0.6})));
    CHECK(image.sample({0.0, 0.75}, ImageWrap::clamp) == doctest::Approx(0.0));
    CHECK(image.sample({5.0, -5.0}, ImageWrap::clamp) == doctest::Approx(1.0));
    CHECK(image.sample({1e300, 0.3}) >= 0.0);
    CHECK(image.sample({std::nan(""), 0.3}) == 0.0);
    CHECK(HeightImage{}.sample({0.5, 0.5}) == 0.0);

    // All 16 bits count: two samples of a PGM that are equal in 8 bits.
    spill(dir / "h.pgm", std::string("P5 2 1 65535\n") + std::string("\x80\x00\x80\x01", 4));
    const HeightImage deep = load_height_image(dir / "h.pgm");
    CHECK(deep.values[1] > deep.values[0]);
    CHECK(deep.values[0] == doctest::Approx(0x8000 / 65535.0).epsilon(1e-6));
}

TEST_CASE("animated PNG: the frames have the pixels of their pictures, in order") {
    const ScratchDir dir;
    constexpr int k_width = 50, k_height = 30, k_frames = 5;
    std::vector<Image> images(k_frames, Image{k_width, k_height, {}});
    for (int i = 0; i < k_frames; ++i)
        for (int pixel = 0; pixel < k_width * k_height; ++pixel)
            images[i].rgb.insert(images[i].rgb.end(), 3, static_cast<std::uint8_t>(pixel * (i + 3) / 7));
    AtomicFile file(dir / "a.png");
    write_animated_png(file, images, 12);
    file.commit();
    const std::vector<Chunk> chunks = chunks_of(slurp(dir / "a.png"));
    REQUIRE(chunks.size() == 3 + 2 * k_frames);
    const std::string header = chunks[0].data;
    CHECK(number_at(header, 0) == k_width);
    CHECK(number_at(header, 4) == k_height);
    CHECK(chunks[1].type == "acTL");
    CHECK(number_at(chunks[1].data, 0) == k_frames);
    CHECK(number_at(chunks[1].data, 4) == 0);  // repeats for ever
    CHECK(chunks.back().type == "IEND");
    std::uint32_t sequence = 0;
    for (int i = 0; i < k_frames; ++i) {
        CAPTURE(i);
        const Chunk &control = chunks[2 + 2 * i], &pixels = chunks[3 + 2 * i];
        CHECK(control.type == "fcTL");
        REQUIRE(control.data.size() == 26);
        CHECK(number_at(control.data, 0) == sequence++);
        CHECK(number_at(control.data, 4) == k_width);
        CHECK(number_at(control.data, 8) == k_height);
        CHECK(number_at(control.data, 20) == (1 << 16 | 12));
        CHECK(pixels.type == (i == 0 ? "IDAT" : "fdAT"));
        if (i > 0) CHECK(number_at(pixels.data, 0) == sequence++);
        // The frame as a picture of one frame.
        const std::string body = "IDAT" + pixels.data.substr(i == 0 ? 0 : 4);
        const std::string bytes = slurp(dir / "a.png");
        const std::size_t header_end = 8 + 12 + header.size(), end_mark = 12;
        spill(dir / "frame.png",
              bytes.substr(0, header_end) + test::png_chunk(body) + bytes.substr(bytes.size() - end_mark));
        const HeightImage frame = load_height_image(dir / "frame.png");
        REQUIRE(frame.values.size() == images[i].rgb.size() / 3);
        for (std::size_t pixel = 0; pixel < frame.values.size(); ++pixel)
            REQUIRE(frame.values[pixel] == doctest::Approx(images[i].rgb[3 * pixel] / 255.0).epsilon(1e-6));
    }
}

TEST_CASE("[bad-input] animations that are none") {
    const ScratchDir dir;
    AtomicFile file(dir / "a.png");
    const Image small{1, 1, std::vector<std::uint8_t>(3)}, wide{2, 1, std::vector<std::uint8_t>(6)};
    CHECK_THROWS_AS(write_animated_png(file, {}, 12), Error);
    CHECK_THROWS_AS(write_animated_png(file, std::vector{small, wide}, 12), Error);
    CHECK_THROWS_AS(write_animated_png(file, std::vector{small}, 0), Error);
    CHECK_THROWS_AS(write_animated_png(file, std::vector{Image{}}, 12), Error);
    CHECK(dir.file_count() == 1);  // the temporary file of `file`
}

TEST_CASE("[bad-input] pictures that are none") {
    const ScratchDir dir;
    spill(dir / "x.png", "no picture");
    CHECK_THROWS_AS(load_height_image(dir / "x.png"), Error);
    CHECK_THROWS_AS(load_height_image(dir / "none.png"), Error);
    Image picture{3, 2, std::vector<std::uint8_t>(18)};
    write_png(dir / "h.png", picture);
    const std::string bytes = slurp(dir / "h.png");
    for (std::size_t length = 0; length + 12 < bytes.size(); ++length) {  // the last 12 bytes are the end mark
        spill(dir / "x.png", bytes.substr(0, length));
        CHECK_THROWS_AS(load_height_image(dir / "x.png"), Error);
    }
    CHECK_THROWS_AS(write_png(dir / "e.png", Image{}), Error);
    CHECK_THROWS_AS(write_png(dir / "no/e.png", picture), Error);
}

TEST_SUITE_END();
