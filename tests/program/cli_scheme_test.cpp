#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/surface/height_image.hpp"
#include "../kit/cli.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

TEST_SUITE_BEGIN("cli");

TEST_CASE("schemes lists every scheme with its classification") {
    const nlohmann::json list = cli::run_json({"schemes", "--json"});
    const std::string text = cli::run({"schemes"}).out;
    std::set<std::string> names;
    for (const auto& scheme : list) {
        const std::string name = scheme.at("name");
        names.insert(name);
        CHECK(text.find("\n" + name + " ") != std::string::npos);
        CHECK(std::set<std::string>{"face split", "vertex split", "bisection", "sqrt3", "honeycomb"}.contains(
            scheme.at("refinement")));
        CHECK(scheme.at("interpolating").is_boolean());
    }
    for (const char* name : {"loop", "catmull-clark", "modified-butterfly", "kobbelt", "doo-sabin", "midedge",
                             "biquartic", "sqrt3", "4-8"})
        CHECK(names.contains(name));
    CHECK(names.size() == list.size());
}

TEST_CASE(
    "scheme explains every scheme, and what it prints as limit and tangents are left eigenvectors of its matrix") {
    for (const auto& listed : cli::run_json({"schemes", "--json"})) {
        const std::string name = listed.at("name");
        CAPTURE(name);
        CHECK(cli::run({"scheme", name}).code == 0);
        const nlohmann::json scheme = cli::run_json({"scheme", name, "--valence", "5", "--matrix", "--json"});
        const auto& matrix = scheme.at("matrix");
        const std::size_t size = matrix.size();
        CHECK(scheme.at("points").size() == size);
        CHECK(scheme.at("valence") == 5);
        const auto check = [&](const nlohmann::json& mask, double lambda) {
            if (mask.is_null()) return;
            const auto& weights = mask.at("weights");
            REQUIRE(weights.size() == size);
            double most = 0;
            for (std::size_t j = 0; j < size; ++j) {
                double sum = -lambda * weights[j].get<double>();
                for (std::size_t i = 0; i < size; ++i) sum += weights[i].get<double>() * matrix[i][j].get<double>();
                most = std::max(most, std::abs(sum));
            }
            CHECK(most < 1e-9);
        };
        check(scheme.at("limit"), 1);
        for (int i = 0; i < 2; ++i) check(scheme.at("tangents")[i], scheme.at("subdominant")[i]);
    }
    // The two-ring matrix of Loop's scheme has 3 v + 1 rows.
    CHECK(cli::run_json({"scheme", "loop", "--valence", "11", "--matrix", "--json"}).at("matrix").size() == 34);
    const nlohmann::json boundary = cli::run_json({"scheme", "loop", "--boundary", "--json"});
    CHECK(boundary.at("valence") == 4);
    CHECK(boundary.at("subdominant")[0].get<double>() == doctest::Approx(0.5));
    const nlohmann::json pentagons = cli::run_json({"scheme", "honeycomb", "--boundary", "--matrix", "--json"});
    CHECK(pentagons.at("matrix").size() == 9);
    CHECK(pentagons.at("limit").at("weights")[0].get<double>() == doctest::Approx(2.0 / 3));
    CHECK(pentagons.at("subdominant")[0].get<double>() == doctest::Approx(0.5));
    CHECK(cli::run({"scheme", "catmull-clark", "--valence", "7", "--matrix"}).out.find("unbounded") !=
          std::string::npos);
}

TEST_CASE("scheme answers at vertices of hundreds of edges, and says what would take too much memory") {
    for (const bool boundary : {false, true}) {
        CAPTURE(boundary);
        // The eigenvalues of a boundary take as many operations as the third power of the edges.
        std::vector<std::string> arguments{"scheme", "loop", "--valence", boundary ? "400" : "1000"};
        if (boundary) arguments.push_back("--boundary");
        CHECK(cli::run(arguments).code == 0);
        arguments.push_back("--json");
        const nlohmann::json scheme = cli::run_json(arguments);
        double sum = 0;
        for (const double w : scheme.at("limit").at("weights")) sum += w;
        CHECK(sum == doctest::Approx(1).epsilon(1e-12));
        int multiplicity = 0;
        for (const auto& e : scheme.at("eigenvalues")) multiplicity += e.at("multiplicity").get<int>();
        CHECK(static_cast<std::size_t>(multiplicity) == scheme.at("points").size());
    }
    cli::check_refused({"scheme", "loop", "--valence", "100000", "--matrix", "--json"}, 2,
                       "--matrix, 300001 x 300001 numbers as JSON, takes about 4.32e+03 GB");  // of 4 TB
    const std::string all = cli::check_refused({"scheme", "doo-sabin", "--valence", "2000000000"}, 2, "GB of memory");
    CHECK(all.find("ask for a lower --valence") != std::string::npos);
}

TEST_CASE("scheme classifies averaging by its number of steps, and says which options do nothing here") {
    for (const int m : {0, 1, 2}) {
        const nlohmann::json scheme = cli::run_json({"scheme", "averaging", "--steps", std::to_string(m), "--json"});
        CHECK(scheme.at("refinement") == (m % 2 == 0 ? "face split" : "vertex split"));
        CHECK(scheme.at("interpolating") == (m == 0));
    }
    const auto warned = [](const cli::Words& arguments, const char* option) {
        const ProcessResult result = cli::run(cli::join({"scheme"}, arguments));
        CHECK(result.code == 0);
        return result.err.find(std::string(option) + " has no effect") != std::string::npos;
    };
    CHECK(warned({"catmull-clark", "--beta", "0.3"}, "--beta"));
    CHECK_FALSE(warned({"catmull-clark", "--beta", "0.3", "--valence", "5"}, "--beta"));
    CHECK(warned({"loop", "--hoppe"}, "--hoppe"));
    CHECK_FALSE(warned({"loop", "--hoppe", "--boundary", "--valence", "6"}, "--hoppe"));
    CHECK(warned({"loop", "--edge-rule", "cosine"}, "--edge-rule"));
}

TEST_CASE("scheme explains corners, with the angle that they get, and darts") {
    const auto corner = [](const char* name, const cli::Words& more) {
        return cli::run_json(cli::join({"scheme", name, "--corner", "--json"}, more));
    };
    for (const char* name : {"loop", "catmull-clark"}) {
        CAPTURE(name);
        const nlohmann::json found = corner(name, {"--valence", "4", "--corner-angle", "270"});
        CHECK(found.at("corner") == true);
        // It stays, and its two sharp edges span the plane.
        const std::vector<double> limit = found.at("limit").at("weights");
        CHECK(limit[0] == 1);
        CHECK(std::count(limit.begin(), limit.end(), 0.0) == static_cast<std::ptrdiff_t>(limit.size()) - 1);
        for (const double value : found.at("subdominant")) CHECK(value == doctest::Approx(0.5));
        CHECK(found.at("tangent_plane") == true);
        const nlohmann::json dart = cli::run_json({"scheme", name, "--dart", "--json"});
        CHECK(dart.at("dart") == true);
        CHECK(dart.at("tangent_plane") == true);
    }
    // Without an angle the sector is not smaller than the tangents.
    CHECK(corner("loop", {"--valence", "5"}).at("tangent_plane") == false);
    CHECK(cli::run_json({"scheme", "loop", "--dart", "--json"}).at("curvature") == "unbounded");
    CHECK(cli::run_json({"scheme", "doo-sabin", "--corner", "--json"}).at("limit").at("weights").at(0) == 1);
    CHECK(cli::run({"scheme", "doo-sabin", "--dart"}).code == 2);
    CHECK(cli::run({"scheme", "loop", "--dart", "--corner"}).code == 2);
    CHECK(cli::run({"scheme", "loop", "--corner-angle", "90"}).err.find("no vertex but a --corner") !=
          std::string::npos);
}

TEST_CASE("scheme and refine take the tension of the ten-point rule, and refuse a word in its place") {
    const nlohmann::json masks = cli::run_json({"scheme", "butterfly", "--ten-point", "0.01", "--json"}).at("masks");
    CHECK(masks.dump().find("0.49") != std::string::npos);  // 1/2 - w
    CHECK(cli::run({"scheme", "loop", "--ten-point", "0.01"}).err.find("--ten-point has no effect") !=
          std::string::npos);
    for (const char* bad : {"nan", "2", "-0.1", "x"})
        CHECK(cli::run({"scheme", "tuned-loop", "--tuning", bad}).code == 2);
    for (const char* bad : {"nan", "inf", "x", "0.05"})
        CHECK(cli::run({"scheme", "butterfly", "--ten-point", bad}).code == 2);
    const ScratchDir scratch;
    CHECK(cli::run({"refine", cli::data("cube.obj"), "--scheme", "averaging", "--steps", "64", "--levels", "1", "-o",
                    (scratch / "many.obj").string()})
              .code == 0);
}

TEST_CASE("scheme says how far a mesh is from its limit, where mask norms do") {
    for (const auto& [name, known] : {std::pair{"modified-butterfly", true},
                                      {"kobbelt", true},
                                      {"loop", true},
                                      {"sqrt3", false},
                                      {"doo-sabin", false}}) {
        CAPTURE(name);
        const nlohmann::json regular = cli::run_json({"scheme", name, "--json"}).at("mask_norm");
        const nlohmann::json five = cli::run_json({"scheme", name, "--valence", "5", "--json"}).at("mask_norm");
        CHECK(regular.is_null() != known);
        CHECK(five.is_null() != known);
        if (!known) continue;
        CHECK(regular.at("linear") == true);
        CHECK(five.at("linear") == false);
        CHECK(regular.at("sum").get<double>() > 0.5);
        CHECK(regular.at("sum").get<double>() < five.at("sum").get<double>());
    }
    // Around many edges, where what most points of a ring have in common is kept once: as with whole rows.
    const auto sum_of = [&](const char* name) {
        return cli::run_json({"scheme", name, "--valence", "40", "--json"}).at("mask_norm").at("sum").get<double>();
    };
    CHECK(sum_of("loop") == doctest::Approx(3.5002340400360943).epsilon(1e-6));
    CHECK(sum_of("4-8") == doctest::Approx(7.93493747416608).epsilon(1e-6));
    // Loop's basis functions are positive and sum to one: over a face those of other points than its corners have no
    // more than all.
    CHECK(cli::run_json({"scheme", "loop", "--json"}).at("mask_norm").at("sum").get<double>() < 1);
}

TEST_CASE("[inv10] refine takes every scheme and format, with the same bytes for one and two threads") {
    const ScratchDir scratch;
    const std::string extensions[] = {".obj", ".ply", ".glb"};
    std::size_t number = 0;
    for (const auto& listed : cli::run_json({"schemes", "--json"})) {
        const std::string name = listed.at("name"), extension = extensions[number++ % 3];
        CAPTURE(name);
        CAPTURE(extension);
        std::vector<std::string> bytes;
        for (const std::string threads : {"1", "2"}) {
            const std::string out = (scratch / ("out" + extension)).string();
            const nlohmann::json json = cli::run_report({"refine", cli::data("cube.obj"), "--scheme", name, "--levels",
                                                         "2", "--limit", "-o", out, "--threads", threads});
            bytes.push_back(slurp(out));
            CHECK(json["scheme"] == name);
            CHECK(json["threads"] == std::stoi(threads));
            CHECK(json["levels"] == 2);
            CHECK(json["measured_error"].is_null());
            const tetrakis::TriangleMesh mesh = tetrakis::read_triangle_mesh(out);
            CHECK(mesh.positions.size() >= json["vertices"].get<std::size_t>());
            CHECK(mesh.triangles.size() >= json["output_faces"].get<std::size_t>());
            CHECK((json["triangles"].is_null() || json["triangles"] == mesh.triangles.size()));
            // The cube reaches from -1 to 1; nothing overshoots by more than the interpolating schemes do.
            for (const auto& p : mesh.positions) CHECK(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 1.7);
        }
        CHECK(bytes[0] == bytes[1]);
    }
    // Of a surface that recedes there is less: nothing, where it uses up the whole mesh.
    std::ofstream(scratch / "quad.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    const auto receding = [&](const std::string& in, const std::string& name) {
        return cli::run({"refine", in, "--scheme", "biquartic", "--levels", "1", "--recede", "--limit", "-o",
                         (scratch / name).string()});
    };
    CHECK(receding(cli::data("pipe3.obj"), "some.obj").code == 0);
    CHECK(!tetrakis::read_triangle_mesh(scratch / "some.obj").triangles.empty());
    const ProcessResult nothing = receding((scratch / "quad.obj").string(), "no.obj");
    CHECK(nothing.code != 0);
    CHECK(nothing.err.find("whole mesh") != std::string::npos);
    CHECK(!std::filesystem::exists(scratch / "no.obj"));
}

TEST_CASE("refine --stencils: its rows, applied to the control vertices, are the vertices of the mesh") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out.obj").string(), table = (scratch / "out.txt").string();
    for (const std::string scheme : {"catmull-clark", "doo-sabin", "kobbelt"}) {
        CAPTURE(scheme);
        const std::string input = cli::data("extruded_pentagon.obj");
        const ProcessResult result =
            cli::run({"refine", input, "--scheme", scheme, "--levels", "2", "--limit", "-o", out, "--stencils", table});
        CAPTURE(result.err);
        REQUIRE(result.code == 0);
        const auto control = tetrakis::read_triangle_mesh(input).positions,
                   fine = tetrakis::read_triangle_mesh(out).positions;
        std::istringstream text(slurp(table));
        std::string magic;
        std::size_t version = 0, rows = 0, controls = 0, terms = 0;
        text >> magic >> version >> rows >> controls >> terms;
        CHECK(magic == "tetrakis-stencils");
        CHECK(version == 2);
        REQUIRE(rows == fine.size());
        REQUIRE(controls == control.size());
        const auto numbers = [&](auto kind, std::size_t count) {
            std::vector<decltype(kind)> array(count);
            for (auto& x : array) text >> x;
            return array;
        };
        const std::vector<std::size_t> begin = numbers(std::size_t{0}, rows + 1), from = numbers(std::size_t{0}, terms);
        const std::vector<double> weight = numbers(0.0, terms);
        REQUIRE(text.good());
        std::string more;
        CHECK(!static_cast<bool>(text >> more));
        REQUIRE(begin.front() == 0);
        REQUIRE(begin.back() == terms);
        double most = 0;
        for (std::size_t r = 0; r < rows; ++r) {
            REQUIRE(begin[r] < begin[r + 1]);
            tetrakis::Vec3d p(0);
            for (std::size_t i = begin[r]; i < begin[r + 1]; ++i) {
                REQUIRE(from[i] < controls);
                p += weight[i] * control[from[i]];
            }
            most = std::max(most, glm::length(p - fine[r]));
        }
        CHECK(most < 1e-12);
    }
}

TEST_CASE("[bad-input] an unknown scheme is answered with the nearest name and all names") {
    const std::string wrong = cli::check_refused({"scheme", "catmul-clark"}, 2, "did you mean catmull-clark?");
    CHECK(wrong.find("modified-butterfly") != std::string::npos);
    cli::check_refused({"scheme"}, 2, "");
    cli::check_refused({"scheme", "loop", "--valence", "x"}, 2, "");
    for (const char* name : {"honeycomb", "doo-sabin"})
        cli::check_refused({"scheme", name, "--boundary", "--valence", "4"}, 2, "");
    cli::check_refused({"scheme", "honeycomb", "--boundary", "--image", "no.png"}, 2, "no picture of the boundary");
    CHECK(!std::filesystem::exists("no.png"));
}

TEST_CASE("[bad-input] scheme says why there is nothing to print for a boundary that is used up") {
    for (const cli::Words& scheme :
         {cli::Words{"biquartic"}, {"averaging", "--steps", "1"}, {"averaging", "--steps", "4"}})
        cli::check_refused(cli::join({"scheme", "--boundary", "--recede"}, scheme), 2, "uses up the boundary");
}

TEST_CASE("refine and tessellate say which options a scheme has no use for, and which tags") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out.obj").string(), pawn = cli::data("pawn.obj");
    const auto warned = [&](const cli::Words& arguments, const char* text) {
        const auto result = cli::run(cli::join(arguments, {"-o", out}));
        CHECK(result.code == 0);
        return (result.out + result.err).find(text) != std::string::npos;
    };
    CHECK(warned({"refine", pawn, "--levels", "1", "--scheme", "modified-butterfly", "--warren"},
                 "--warren has no effect on modified-butterfly"));
    CHECK(warned({"refine", pawn, "--levels", "1", "--smoothing", "2"}, "--smoothing is for interpolating schemes"));
    CHECK(warned({"refine", pawn, "--levels", "1", "--scheme", "kobbelt", "--edge-rule", "cosine"}, "--edge-rule has"));
    CHECK(
        warned({"tessellate", pawn, "--tolerance", "1e-2", "--scheme", "kobbelt", "--hoppe"}, "--hoppe has no effect"));
    CHECK(warned({"refine", pawn, "--levels", "1", "--scheme", "biquartic"}, "the creases were ignored"));
    CHECK_FALSE(warned({"refine", pawn, "--levels", "1", "--scheme", "doo-sabin"}, "ignored"));
    const auto half_steps = [&](const cli::Words& more, const char* text) {
        return warned(cli::join({"refine", pawn, "--factored", "--steps", "3"}, more), text);
    };
    CHECK(half_steps({"--scheme", "biquartic"}, "the creases were ignored"));
    CHECK_FALSE(half_steps({"--scheme", "averaging", "--averaging-steps", "2"}, "ignored"));
    CHECK(half_steps({"--scheme", "doo-sabin", "--recede"}, "--recede has no effect on doo-sabin"));
    CHECK(half_steps({"--scheme", "biquartic", "--averaging-steps", "2"}, "--averaging-steps has no effect"));
    CHECK(warned({"refine", pawn, "--levels", "1", "--scheme", "kobbelt", "--beta", "0.6"}, "--beta has no effect"));
    cli::check_refused({"refine", cli::data("cube.obj"), "--levels", "1", "--beta", "5", "-o", out}, 3,
                       "they must lie inside the triangle");
    CHECK_FALSE(warned({"refine", pawn, "--levels", "1", "--scheme", "loop", "--warren"}, "no effect"));
}

TEST_CASE("refine and tessellate take the angles of corners from tags, from one number or from the control mesh") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out.obj").string(), in = (scratch / "in.obj").string();
    // A roof over a corner with three faces.
    const std::string mesh =
        "v 0 0 1\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv -2 2 0\nv -2 0 0\nv -2 -2 0\nv 0 -2 0\nf 1 2 3 4\nf 1 4 5 6\n"
        "f 1 6 7 8\n";
    const auto refined = [&](const std::string& tags, const cli::Words& more) {
        std::ofstream(in) << mesh << "t corner 1/1/0 0 10\n" << tags;
        const auto result = cli::run(cli::join({"refine", in, "--levels", "2", "-o", out}, more));
        CAPTURE(result.err);
        CHECK(result.code == 0);
        return slurp(out);
    };
    const std::string plain = refined("", {}), by_number = refined("", {"--corner-angle", "250"}),
                      measured = refined("", {"--corner-angle", "measured"});
    CHECK(plain != by_number);
    CHECK(plain != measured);
    CHECK(by_number != measured);
    CHECK(refined("t cornerangle 2/1/0 0 1 250\n", {}) == by_number);
    CHECK(refined("t cornerangle 2/1/0 0 1 250\n", {"--corner-angle", "measured"}) == by_number);
    for (const char* angle : {"180", "0", "360", "90x", "flat"})
        cli::check_refused({"refine", in, "--levels", "1", "--corner-angle", angle, "-o", out}, 2,
                           "neither measured nor a number of degrees");
    const auto ignored = cli::run({"refine", in, "--levels", "1", "--scheme", "kobbelt", "-o", out});
    CHECK((ignored.out + ignored.err).find("corner angles were ignored: kobbelt") != std::string::npos);
    cli::check_refused({"tessellate", in, "--tolerance", "1e-2", "--target", in, "-o", out}, 1,
                       "without corner angles");
    CHECK(cli::run({"tessellate", in, "--tolerance", "1e-2", "-o", out}).code == 0);
}

TEST_CASE("[slow] scheme draws a sheet with masks, characteristic map and basis function") {
    const ScratchDir dir;
    const auto draw = [&](const std::string& name, const cli::Words& arguments) {
        const ProcessResult result = cli::run(cli::join({"scheme", "--image", (dir / name).string()}, arguments));
        CAPTURE(result.err);
        REQUIRE(result.code == 0);
        return tetrakis::load_height_image(dir / name);
    };
    // The share of a window, given in shares of the sheet's sides, that is darker than a picture's background.
    const auto ink = [](const tetrakis::HeightImage& sheet, double left, double top, double right, double bottom) {
        long dark = 0, all = 0;
        for (int y = static_cast<int>(top * sheet.height); y < static_cast<int>(bottom * sheet.height); ++y)
            for (int x = static_cast<int>(left * sheet.width); x < static_cast<int>(right * sheet.width); ++x, ++all)
                dark += sheet.values[std::size_t(y) * sheet.width + x] < 0.78f;
        return static_cast<double>(dark) / static_cast<double>(all);
    };
    const tetrakis::HeightImage loop = draw("loop.png", {"loop", "--valence", "5"});
    CHECK(loop.width > 1000);
    CHECK(ink(loop, 0, 0, 1, 0.05) > 0.005);  // titles
    // Lines all over a window, and no more than lines; or a surface.
    const auto lines = [&](const tetrakis::HeightImage& sheet, double left, double top, double right, double bottom) {
        const double share = ink(sheet, left, top, right, bottom);
        CHECK(share > 0.003);
        CHECK(share < 0.2);
    };
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"honeycomb"}, {"sqrt3", "--valence", "2"}}) {
        CAPTURE(arguments[0]);
        const tetrakis::HeightImage sheet = draw("other.png", arguments);
        CHECK(sheet.width == loop.width);
        CHECK(sheet.values != loop.values);
        lines(sheet, 0, 0.06, 1, 0.53);                // masks
        lines(sheet, 0, 0.58, 0.48, 0.98);             // isoparametric lines
        CHECK(ink(sheet, 0.6, 0.8, 0.9, 0.85) > 0.8);  // surface
    }
    // Of nearly a hundred weights each different one is written once: 0.11 of the window, mostly the lattice; with all
    // of them it was 0.18.
    const tetrakis::HeightImage many = draw("many.png", {"averaging", "--steps", "9"});
    const double limit_ink = ink(many, 24.0 / many.width, 550.0 / many.height, 404.0 / many.width, 910.0 / many.height);
    CHECK(limit_ink > 0.05);
    CHECK(limit_ink < 0.14);

    CHECK(cli::run({"scheme", "loop", "--image", (dir / "loop.obj").string()}).code == 2);
    // At a boundary: one side of it, from the middle of the left half's height (the boundary) up.
    const tetrakis::HeightImage boundary = draw("boundary.png", {"doo-sabin", "--boundary"});
    CHECK(boundary.width == loop.width);
    lines(boundary, 0, 0.06, 1, 0.4);
    lines(boundary, 0, 0.5, 0.48, 0.98);
    CHECK(ink(boundary, 0.5, 0.5, 1, 0.98) > 0.1);
}

TEST_SUITE_END();
