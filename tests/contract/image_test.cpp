#include "../../eval/io/png.hpp"
#include "../../eval/surface/height_image.hpp"
#include "../../hier/base/error.hpp"

#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

using namespace tetrakis;

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
    // Pixel centres: the upper row has v = 3/4.
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

    // 16 bits are kept: a PGM of two samples that 8 bits cannot tell apart.
    spill(dir / "h.pgm", std::string("P5 2 1 65535\n") + std::string("\x80\x00\x80\x01", 4));
    const HeightImage deep = load_height_image(dir / "h.pgm");
    CHECK(deep.values[1] > deep.values[0]);
    CHECK(deep.values[0] == doctest::Approx(0x8000 / 65535.0).epsilon(1e-6));
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
