#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/surface/height_image.hpp"
#include "../../hier/base/version.hpp"

#include "../kit/cli.hpp"
#include "../kit/input_helpers.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <iterator>
#include <set>
#include <sstream>

using namespace tetrakis;

TEST_SUITE_BEGIN("cli");

namespace {

constexpr const char* k_square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

/// The command lines of this program in a text, as words.
std::vector<std::vector<std::string>> examples(const std::string& text) {
    std::vector<std::vector<std::string>> result;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::vector<std::string> example;
        for (std::string word; words >> word;) example.push_back(word);
        if (!example.empty() && example.front() == "tetrakis") result.push_back(example);
    }
    return result;
}

void run_all(const std::vector<std::vector<std::string>>& lines, const std::string& directory) {
    for (auto words : lines) {
        CAPTURE(words);
        words.front() = cli::program();
        const ProcessResult result = run_process(words, directory);
        CAPTURE(result.err);
        CHECK(result.code == 0);
    }
}

std::set<std::string> word_set(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), {}};
}

std::set<std::string> keys_of(const nlohmann::json& object) {
    std::set<std::string> keys;
    for (const auto& item : object.items()) keys.insert(item.key());
    return keys;
}

}  // namespace

TEST_CASE("it says its version, and helps: the example in each command's help works as it stands") {
    CHECK(cli::run({"--version"}).out == "tetrakis " + std::string(k_version) + "\n");
    const std::string commands = cli::run({"--help"}).out;
    const ScratchDir scratch;
    std::filesystem::create_directory_symlink(cli::data(""), scratch / "data");
    for (const std::string command : {"info", "tessellate", "refine", "terrain", "tiles", "lod", "compare", "render"}) {
        CAPTURE(command);
        CHECK(commands.find(command) != std::string::npos);
        const ProcessResult help = cli::run({command, "--help"});
        CHECK(help.code == 0);
        const auto found = examples(help.out.substr(std::min(help.out.size(), help.out.find("Example:"))));
        REQUIRE(!found.empty());
        run_all(found, scratch.path().string());
    }
}

TEST_CASE("[slow] the command lines of the two READMEs run, in their order") {
    const ScratchDir scratch;
    std::filesystem::create_directory_symlink(cli::data(""), scratch / "data");
    std::istringstream readme(slurp(TETRAKIS_SOURCE_DIR "/README.md") +
                              slurp(TETRAKIS_SOURCE_DIR "/tools/tetrakis/README.md"));
    bool shell = false;  // in a block of them
    int count = 0;
    for (std::string line; std::getline(readme, line);) {
        if (line.starts_with("```")) shell = line == "```sh";
        if (!shell || !line.starts_with("tetrakis ")) continue;
        CAPTURE(line);
        const ProcessResult result = run_process(
            {"/bin/sh", "-c", "exec \"$0\" " + line.substr(std::string("tetrakis ").size()), cli::program()},
            scratch.path().string());
        CAPTURE(result.err);
        CHECK(result.code == 0);
        ++count;
    }
    CHECK(count >= 5);
}

TEST_CASE("reports have the keys that tools/tetrakis/README.md lists, and no others") {
    const auto common = word_set(
        "input scheme version threads faces vertices triangles tolerance tolerance_absolute certified_error "
        "measured_error levels seconds peak_memory_bytes warnings");
    struct Case {
        std::vector<std::string> words;
        std::set<std::string> more;
    };
    const std::vector<Case> cases = {
        {{"tessellate", cli::data("cube.obj"), "--tolerance", "1e-2", "--samples", "5000"},
         {"estimator", "tolerance_reached", "samples", "peak_memory_before_measure_bytes"}},
        {{"refine", cli::data("cube.obj"), "--levels", "2"}, {"output_faces", "limit"}},
        {{"refine", cli::data("cube.obj"), "--factored", "--steps", "2"},
         {"output_faces", "half_steps", "active", "inactive_vertices"}},
        {{"refine", cli::data("cube.obj"), "--factored", "--steps", "5", "--near", "1,1,1", "--radius", "0.5"},
         {"output_faces", "half_steps", "active", "inactive_vertices"}},
        {{"refine", cli::data("cube.obj"), "--factored", "--steps", "5", "--near", "9,9,9", "--radius", "0.5"},
         {"output_faces", "half_steps", "active", "inactive_vertices"}},
    };
    const std::string readme = slurp(TETRAKIS_SOURCE_DIR "/tools/tetrakis/README.md");
    for (const Case& c : cases) {
        CAPTURE(c.words);
        const ScratchDir scratch;
        const nlohmann::json report =
            cli::run_report(cli::join(c.words, {"-o", (scratch / "a.ply").string(), "--threads", "2"}));
        std::set<std::string> expected = common;
        expected.insert(c.more.begin(), c.more.end());
        CHECK(keys_of(report) == expected);
        CHECK(keys_of(report.at("seconds")) == word_set("load build refine estimate measure write"));
        for (const std::string& key : expected) {
            CAPTURE(key);
            CHECK(readme.find("`" + key + "`") != std::string::npos);
        }
        for (const nlohmann::json& seconds : report.at("seconds")) CHECK(seconds.get<double>() >= 0);
        CHECK(report.at("warnings").is_array());
        if (std::ranges::count(c.words, "9,9,9") != 0) {
            // A sphere that meets nothing.
            CHECK(report.at("half_steps") == 1);
            CHECK(report.at("warnings").size() == 1);
        }
        CHECK(report.at("peak_memory_bytes").get<std::uint64_t>() > 1'000'000);
        CHECK(report.at("input") == cli::data("cube.obj"));
        CHECK(report.at("faces") == 6);
        CHECK(report.at("threads") == 2);
        if (c.words[0] != "tessellate") continue;
        const TriangleMesh mesh = read_triangle_mesh(scratch / "a.ply");
        CHECK(report.at("triangles") == mesh.triangles.size());
        CHECK(report.at("vertices") == mesh.positions.size());
        CHECK(keys_of(report.at("measured_error")) == word_set("forward backward hausdorff mean rms"));
        CHECK(report.at("measured_error").at("hausdorff") <= report.at("certified_error"));
        CHECK(report.at("tolerance") == 1e-2);
        CHECK(report.at("tolerance_reached") == true);
    }
}

TEST_CASE("info reads every model of data/ and agrees with Euler") {
    int models = 0;
    for (const auto& entry : std::filesystem::directory_iterator(cli::data(""))) {
        if (entry.path().extension() != ".obj") continue;
        const std::string model = entry.path().string();
        CAPTURE(model);
        ++models;
        const nlohmann::json info = cli::run_json({"info", model, "--json"});
        // A surface in one piece: 2, less its boundary loops, less 2 for each handle. The knot is a closed tube, the
        // bracket has two holes drilled through.
        const int handles = model.find("knot") != std::string::npos      ? 1
                            : model.find("bracket") != std::string::npos ? 2
                                                                         : 0;
        CHECK(info["pieces"] == 1);
        CHECK(info["euler_characteristic"].get<int>() == 2 - 2 * handles - info["boundary_loops"].get<int>());
        CHECK(info["warnings"].empty());
        const ProcessResult text = cli::run({"info", model});
        CHECK(text.code == 0);
        CHECK(text.err.empty());
        CHECK(text.out.find(model) != std::string::npos);
    }
    CHECK(models >= 8);
}

TEST_CASE("refine --factored writes the 4-8 mesh after so many half-steps, or the scheme's own faces") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out.ply").string();
    struct Row {
        const char* scheme;
        int steps;
        bool active;
        std::size_t faces;
        const char* averaging_steps = nullptr;
        int levels = steps / 2;
    };
    // The cube has 24 half-edges: as many triangles after one half-step, twice as many after each further one;
    // averaging takes one more to cut each quad of a level, and none after that.
    for (const Row& row :
         {Row{"catmull-clark", 1, false, 24}, Row{"catmull-clark", 4, false, 192}, Row{"catmull-clark", 4, true, 96},
          Row{"doo-sabin", 0, false, 24}, Row{"doo-sabin", 2, false, 96}, Row{"doo-sabin", 2, true, 26},
          Row{"biquartic", 5, true, 26, nullptr, 1}, Row{"averaging", 4, false, 96, nullptr, 0},
          Row{"averaging", 4, true, 24, "2", 1}, Row{"averaging", 4, true, 96, "0", 2}}) {
        CAPTURE(row.scheme);
        CAPTURE(row.steps);
        std::vector<std::string> line = {"refine",  cli::data("cube.obj"),     "--factored", "--scheme", row.scheme,
                                         "--steps", std::to_string(row.steps), "-o",         out};
        if (row.active) line.push_back("--active");
        if (row.averaging_steps != nullptr) line.insert(line.end(), {"--averaging-steps", row.averaging_steps});
        const nlohmann::json json = cli::run_report(line);
        CHECK(json.at("scheme") == row.scheme);
        CHECK(json.at("output_faces") == row.faces);
        CHECK(json.at("half_steps") == row.steps);
        CHECK(json.at("levels") == row.levels);
        const auto inactive = json.at("inactive_vertices").get<std::vector<std::size_t>>();
        const auto vertices = json.at("vertices").get<std::size_t>(), active = json.at("active").get<std::size_t>();
        CHECK(inactive.size() == (row.active ? 0 : vertices - active));
    }
    // What half-steps do not keep is said.
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvt 0 0\ng left\nf 1/1 2/1 3/1 4/1\n"
        "g right\nf 2/1 5/1 6/1 3/1\nt hole 1/0/0 1\n";
    const std::string in = (scratch / "in.obj").string();
    spill(in, text);
    const auto said = [&](const char* scheme) {
        return cli::run({"refine", in, "--factored", "--scheme", scheme, "--steps", "2", "-o", out}).err;
    };
    const std::string dual = said("doo-sabin"), primal = said("catmull-clark");
    for (const char* words : {"texture coordinates were dropped", "groups and materials were dropped", "holes were"})
        CHECK(test::contains(dual, words));
    CHECK(test::contains(primal, "texture coordinates were dropped"));
    CHECK(!test::contains(primal, "groups"));
    CHECK(!test::contains(primal, "holes"));
}

TEST_CASE("terrain: the report says what the mesh is, GLB included") {
    const ScratchDir scratch;
    spill(scratch / "steps.r16", std::string("\0\0\1\0\2\0\3\0\4\0\7\0\6\0\7\0\x8\0", 18));
    for (const std::string name : {"a.obj", "a.ply", "a.glb"}) {
        const std::string out = (scratch / name).string();
        const nlohmann::json json = cli::run_report(
            {"terrain", (scratch / "steps.r16").string(), "--max-error", "1", "--spacing", "10", "-o", out});
        CHECK(json["columns"] == 3);
        CHECK(json["rows"] == 3);
        CHECK(json["spacing"][0] == 10);
        CHECK(json["heights"][1] == 8);
        CHECK(json["largest_error"] <= 1);
        CHECK(read_triangle_mesh(out).triangles.size() == json["triangles"].get<std::size_t>());
    }
    // No error at all is more than the floats of a GLB can promise.
    for (const auto& [name, code] : {std::pair("b.ply", 0), std::pair("b.glb", 4)})
        CHECK(
            cli::run({"terrain", (scratch / "steps.r16").string(), "--max-error", "0", "-o", (scratch / name).string()})
                .code == code);
    // Heights about 1e9 are floats 64 apart.
    for (const auto& [offset, warns] : {std::pair("1000", false), std::pair("1e9", true)}) {
        const ProcessResult result = cli::run({"terrain", (scratch / "steps.r16").string(), "--max-error", "1",
                                               "--offset", offset, "-o", (scratch / "c.ply").string()});
        CHECK(result.code == 0);
        CHECK(test::contains(result.err, "kept as floats") == warns);
    }
}

TEST_CASE("[bad-input] terrain") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out.glb").string(), raw = (scratch / "h.r16").string(),
                      cut = (scratch / "cut.png").string();
    spill(raw, std::string(12, '\1'));
    spill(cut, slurp(cli::data("island.png")).substr(0, 9000));
    cli::check_refused({"terrain", raw, "--max-error", "1", "-o", out}, 3, "h.r16: the file has 6 heights");
    cli::check_refused({"terrain", cut, "--max-error", "1", "-o", out}, 3, "cut.png: this picture is cut off");
    cli::check_refused({"terrain", cli::data("cube.obj"), "--max-error", "1", "-o", out}, 3, "cube.obj");
    cli::check_refused({"terrain", raw, "--max-error", "-1", "-o", out}, 2, "--max-error");
    cli::check_refused({"terrain", raw, "--max-error", "1", "--spacing", "0", "-o", out}, 2, "--spacing");
    cli::check_refused({"terrain", raw, "--columns", "3", "--max-error", "1e-9", "-o", out}, 2, "floats of a GLB");
    CHECK(scratch.file_count() == 2);
}

TEST_CASE("lod: frames along a path of cameras, with figures that agree") {
    const ScratchDir scratch;
    spill(
        scratch / "path.json",
        R"([{"eye": [640, -1500, 300], "target": [640, -640, 0]}, {"eye": [900, -1200, 250], "target": [640, -640, 0]}])");
    const std::string out = (scratch / "out").string();
    const nlohmann::json json = cli::run_report(
        {"lod", cli::data("island.png"), "--scale", "0.1", "--spacing", "10", "--pixels", "1", "--frames", "5",
         "--path", (scratch / "path.json").string(), "--images", "3", "--size", "64x48", "-o", out});
    CHECK(json["frames"] == 5);
    CHECK(json["measured_pixels"] > 0.2);
    CHECK(json["measured_pixels"] <= 1);
    CHECK(json["promised_pixels"] == 1);
    CHECK(read_triangle_mesh(out + "/last.glb").triangles.size() == json["leaves"].get<std::size_t>());
    CHECK(std::filesystem::exists(out + "/frame_00004.png"));
    CHECK(std::filesystem::exists(out + "/sheet.png"));
    CHECK(slurp(out + "/flight.png").find(std::string("acTL\0\0\0\3", 8)) != std::string::npos);  // three frames
    const std::string csv = slurp(out + "/frames.csv");
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 6);
    // Too few triangles: said, and everything is written.
    CHECK(cli::run({"lod", cli::data("island.png"), "--scale", "0.1", "--spacing", "10", "--pixels", "0.1", "--budget",
                    "500", "--frames", "2", "-o", out})
              .code == 4);
    // No more triangles than the memory allowed has room for.
    const auto little = cli::run({"lod", "--fractal", "1", "--pixels", "0.05", "--budget", "100000000", "--max-memory",
                                  "60M", "--frames", "1", "-o", out});
    CHECK(little.code == 4);
    CHECK(little.err.find("--max-memory has room for 1") != std::string::npos);
}

TEST_CASE("lod: the CSV's figures agree, and a jump across an earth-sized ball does not look like pops") {
    // Two metres above the ground: a step, a stop, a jump by a quarter of the circumference.
    nlohmann::json path;
    for (int i = 0; i < 4; ++i) {
        const double step = i % 3 == 0 ? 0 : 0.5, out = 6371000 + (i < 3 ? -14046.928 : -4331.398);
        const Vec3d eye = i < 3 ? Vec3d(out, step, 0) : Vec3d(step, out, 0),
                    target = eye + (i < 3 ? Vec3d(-3, -1, 1) : Vec3d(-1, -3, 1));
        path.push_back({{"eye", {eye.x, eye.y, eye.z}}, {"target", {target.x, target.y, target.z}}});
    }
    const ScratchDir scratch;
    spill(scratch / "path.json", path.dump());
    const std::string out = (scratch / "out").string();
    cli::run_report({"lod", "--fractal", "7", "--planet", "6371000", "--spacing", "0.05", "--pixels", "16", "--budget",
                     "15500", "--path", (scratch / "path.json").string(), "--frames", "4", "-o", out});
    std::istringstream csv(slurp(out + "/frames.csv"));
    std::string line;
    std::getline(csv, line);
    CHECK(line == "frame,splits,merges,leaves,upload_bytes,milliseconds,promised_pixels,measured_pixels,pop_pixels");
    double leaves_before = 0, vertices_before = 0;
    for (int i = 0; i < 4; ++i) {
        CAPTURE(i);
        std::array<double, 9> row;
        for (double& number : row) {
            csv >> number;
            csv.get();
        }
        const auto [frame, splits, merges, leaves, upload, milliseconds, promised, measured, pop] = row;
        CHECK(frame == i);
        CHECK(leaves <= 15500);
        CHECK(promised == 16);
        CHECK(measured > 1);
        CHECK(measured <= promised);
        CHECK(pop <= promised);
        // A split makes two triangles and a vertex, of 12 and 40 bytes. After a jump it begins with the 24 roots, and
        // the vertices before it are written once more, because the origin moves.
        const bool jumps = i % 3 == 0, stops = i % 3 == 2;
        CHECK(leaves == (jumps ? 24 : leaves_before) + 2 * (splits - merges));
        const double vertices = leaves / 2 + 2;
        CHECK(upload >= (jumps ? 12 * leaves + 40 * (vertices + vertices_before) : 40 * splits));
        CHECK(upload <=
              (jumps ? 1.01 * (12 * leaves + 40 * (vertices + vertices_before)) : 64 * 4 * (splits + merges)));
        CHECK((upload == 0) == stops);
        CHECK((milliseconds > 0 || stops));
        CHECK((merges == 0) == (jumps || stops));
        leaves_before = leaves;
        vertices_before = vertices;
    }
    // The camera sees but a few metres of a square of 100 kilometres.
    spill(scratch / "path.json", R"([{"eye": [1000, 2000, -130.383], "target": [1000, 2001, -135]}])");
    const nlohmann::json near = cli::run_report({"lod", "--fractal", "7", "--pixels", "16", "--path",
                                                 (scratch / "path.json").string(), "--frames", "1", "-o", out});
    CHECK(near["measured_pixels"] > 0.3);
}

TEST_CASE("lod: a planet and control meshes keep what they promise") {
    const ScratchDir scratch;
    std::string heights;
    for (int i = 0; i < 64 * 32; ++i) {
        const auto height = static_cast<float>(0.1 * std::sin(0.3 * i));
        heights.append(reinterpret_cast<const char*>(&height), sizeof height);
    }
    spill(scratch / "planet.r32", heights);
    spill(scratch / "face.r32", heights.substr(heights.size() / 2));
    const std::string planet = (scratch / "planet.r32").string(), face = (scratch / "face.r32").string(),
                      out = (scratch / "out").string(), report = (scratch / "r.json").string();
    for (const std::vector<std::string>& input :
         {std::vector<std::string>{planet, "--columns", "64", "--rows", "32", "--planet", "3"},
          {face, face, face, face, face, face, "--planet", "3"},
          {"--fractal", "7", "--spacing", "20"},
          {"--fractal", "7", "--planet", "6e6", "--orbit"},
          {cli::data("pawn.obj"), "--level", "2"},
          {cli::data("knot_tri.obj"), "--scheme", "loop", "--level", "1", "--orbit"}}) {
        const cli::Words start{"lod"},
            more{"--frames", "4", "--pixels", "2", "--images", "1", "--size", "64x48", "-o", out, "--report", report};
        const ProcessResult result = cli::run(cli::join(cli::join(start, input), more));
        CAPTURE(input.front());
        CAPTURE(result.err);
        CHECK((result.code == 0 || result.code == 4));  // finest triangles may be too large
        const nlohmann::json json = nlohmann::json::parse(slurp(report));
        CHECK(json["measured_pixels"] > 0.1);
        CHECK(json["measured_pixels"] <= json["promised_pixels"]);
    }
    // Pictures that are smaller than what is shown in their corner.
    const ProcessResult small = cli::run(
        {"lod", cli::data("pawn.obj"), "--level", "2", "--frames", "2", "--images", "2", "--size", "5x3", "-o", out});
    CHECK((small.code == 0 || small.code == 4));
}

TEST_CASE("tiles: a raw file is cut, and lod flies over it, waiting for what has to be loaded") {
    const ScratchDir scratch;
    std::string numbers;
    for (int r = 0; r < 700; ++r)
        for (int c = 0; c < 600; ++c) {
            const auto height = static_cast<unsigned>(2000 + 900 * std::sin(0.05 * c) * std::cos(0.04 * r) + r * c % 8);
            numbers += {static_cast<char>(height & 255), static_cast<char>(height >> 8)};
        }
    spill(scratch / "h.r16", numbers);
    const std::string raw = (scratch / "h.r16").string(), tiles = (scratch / "h.tiles").string(),
                      out = (scratch / "out").string();
    const ProcessResult cut = cli::run({"tiles", raw, "--columns", "600", "--scale", "0.02", "-o", tiles});
    CAPTURE(cut.err);
    REQUIRE(cut.code == 0);
    const nlohmann::json json = cli::run_report({"lod", tiles, "--frames", "5", "--wait", "--cache", "16M", "-o", out});
    CHECK(json["promised_pixels"] == 1);
    CHECK(json["measured_pixels"] > 0.1);
    CHECK(json["measured_pixels"] <= json["promised_pixels"]);
    CHECK(json["tiles"]["loads"] > 0);
    CHECK(json["tiles"]["failures"] == 0);
    CHECK(json["tiles"]["waiting_frames"] == 0);
    CHECK(json["tiles"]["cached_bytes"] <= 16 << 20);
    CHECK(read_triangle_mesh(out + "/last.glb").triangles.size() == json["leaves"].get<std::size_t>());
    cli::check_refused({"lod", tiles, "--frames", "1", "-o", out, "--report", out + "/frames.csv"}, 1, "this name");
    // Tiles that are damaged never come.
    const std::string good = slurp(tiles);
    std::string damaged = good;
    for (std::size_t i = good.size() / 2000; i < good.size() / 10; i += 500)
        damaged[i] = static_cast<char>(~damaged[i]);
    spill(tiles, damaged);
    const ProcessResult without = cli::run({"lod", tiles, "--frames", "2", "--wait", "-o", out});
    CHECK((without.code == 0 || without.code == 4));
    CHECK(without.err.find("could not be loaded") != std::string::npos);
    spill(tiles, good);
    cli::check_refused({"lod", tiles, "--cache", "much", "-o", out}, 2, "--cache");
    cli::check_refused({"lod", tiles, "--cache", "1M", "-o", out}, 1, "too small");
    cli::check_refused({"lod", tiles, "--scale", "2", "-o", out}, 2, "--scale");
    cli::check_refused({"lod", cli::data("pawn.obj"), "--wait", "-o", out}, 2, "--wait");
    spill(tiles, slurp(tiles).substr(0, 9000));
    cli::check_refused({"lod", tiles, "-o", out}, 3, "cut off");
    cli::check_refused({"tiles", raw, "-o", tiles}, 3, "not a square");
    cli::check_refused({"tiles", raw, "--columns", "600", "-o", out + ".png"}, 2, "written as .tiles");
}

TEST_CASE("[bad-input] lod") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out").string(), path = (scratch / "path.json").string(),
                      island = cli::data("island.png");
    spill(path, "[{\"eye\": [1, 2]}]");
    cli::check_refused({"lod", island, "--path", path, "-o", out}, 3, "path.json: camera 0");
    spill(path, R"({"eye": [1, 2, 3], "target": [1, 2, 4]})");
    cli::check_refused({"lod", island, "--path", path, "-o", out}, 3, "path.json: a camera path is a list");
    spill(path, R"([{"eye": [0, 0, 0], "target": [1, 0, 0]}, {"eye": [2, 0, 0], "target": [1, 0, 0]}])");
    cli::check_refused({"lod", island, "--frames", "3", "--path", path, "-o", out}, 3, "path.json: in frame 1");
    spill(path, "[]");
    cli::check_refused({"lod", island, "--path", path, "-o", out}, 3, "without cameras");
    spill(path, R"([{"eye": [1, 2, 3], "target": [1, 2, 3]}])");
    cli::check_refused({"lod", island, "--path", path, "-o", out}, 3, "camera 0: its target is at its eye");
    for (const auto& [camera, message] :
         {std::pair(R"("eye": [1e60, 0, 0], "target": [0, 0, 0])", "camera 1: its eye or target has a coordinate"),
          std::pair(R"("eye": [0, 0, 0], "target": [0, 0, 2e30])", "camera 1: its eye or target has a coordinate"),
          std::pair(R"("eye": [0, 0, null], "target": [0, 0, 1])", "camera 1: type must be number"),
          std::pair(R"("eye": [0, 0, 9], "target": [0, 0, 1], "fov_degrees": 0)", "camera 1: its fov_degrees"),
          std::pair(R"("eye": [0, 0, NaN], "target": [0, 0, 1])", "path.json: parse error"),
          std::pair(R"("eye": [0, 0, 1e999], "target": [0, 0, 1])", "path.json: number overflow")}) {
        spill(path, std::string(R"([{"eye": [1, 2, 3], "target": [0, 0, 0]}, {)") + camera + "}]");
        cli::check_refused({"lod", island, "--path", path, "-o", out}, 3, message);
    }
    cli::check_refused({"lod", "--fractal", "1", "--planet", "1e35", "-o", out}, 3, "it reaches beyond 1e30");
    cli::check_refused({"lod", cli::data("cube.obj"), "--planet", "3", "-o", out}, 2, "--planet");
    cli::check_refused({"lod", cli::data("cube.obj"), "--scheme", "biquartic", "-o", out}, 2, "biquartic");
    cli::check_refused({"lod", island, "--scheme", "loop", "-o", out}, 2, "--scheme");
    cli::check_refused({"lod", island, "--level", "3", "-o", out}, 2, "--level");
    cli::check_refused({"lod", island, "--planet", "0.1", "--offset", "-1", "-o", out}, 3, "as deep as the planet");
    cli::check_refused({"lod", island, "--fly", "--orbit", "-o", out}, 2, "--");
    cli::check_refused({"lod", "-o", out}, 2, "IN is required");
    cli::check_refused({"lod", island, island, "-o", out}, 2, "2 files");
    cli::check_refused({"lod", island, island, island, "--planet", "9", "-o", out}, 2, "six faces of a cube");
    cli::check_refused({"lod", island, "--fractal", "1", "-o", out}, 2, "no IN");
    cli::check_refused({"lod", "--fractal", "1", "--level", "3", "-o", out}, 2, "--level");
    cli::check_refused({"lod", "--fractal", "x", "-o", out}, 2, "--fractal");
    cli::check_refused({"lod", "--fractal", "1", "--spacing", "1e9", "-o", out}, 2, "--spacing: finest triangles");
    cli::check_refused({"lod", "--fractal", "1", "--planet", "1e300", "-o", out}, 2, "from 1e-37 to 1e37");
    cli::check_refused({"lod", "--fractal", "1", "--planet", "1e-300", "-o", out}, 2, "from 1e-37 to 1e37");
    cli::check_refused({"lod", cli::data("island.png"), "--cache", "1M", "-o", out}, 2, "--cache is for .tiles");
    cli::check_refused({"lod", cli::data("island.png"), "--weld", "-o", out}, 2, "take a control mesh");
    cli::check_refused({"lod", cli::data("cube.obj"), "--scale", "2", "-o", out}, 2, "take heights");
    cli::check_refused({"lod", "--fractal", "1", "--spacing", "1e-9", "-o", out}, 2, "--spacing: triangles");
    cli::check_refused({"lod", "missing.png", island, island, island, island, island, "--planet", "9", "-o", out}, 3,
                       "missing.png");
    cli::check_refused({"lod", island, "--pixels", "0", "-o", out}, 2, "--pixels");
    cli::check_refused({"lod", island, "--frames", "0", "-o", out}, 2, "--frames");
    cli::check_refused({"lod", island, "-o", path}, 2, "is a file");
    CHECK(scratch.file_count() == 1);
}

TEST_CASE("compare measures what is known") {
    const ScratchDir scratch;
    const std::string low = (scratch / "low.obj").string(), high = (scratch / "high.obj").string();
    spill(low, k_square);
    spill(high, "v 0 0 3\nv 1 0 3\nv 1 1 3\nv 0 1 3\nf 1 2 3 4\n");
    const nlohmann::json apart = cli::run_json({"compare", low, high, "--json", "--samples", "1000"});
    for (const char* key : {"forward", "backward", "hausdorff", "mean", "rms"})
        CHECK(apart[key].get<double>() == doctest::Approx(3).epsilon(1e-12));
    CHECK(apart["diagonal"].get<double>() == doctest::Approx(std::sqrt(2.0)));
    CHECK(apart["a_to_b"]["samples"].get<std::uint64_t>() >= 1000);

    const nlohmann::json same = cli::run_json({"compare", cli::data("pawn.obj"), cli::data("pawn.obj"), "--json"});
    CHECK(same["hausdorff"].get<double>() < 1e-14);

    // Half of a square, and the whole: the far corner is half a diagonal away from the half.
    spill(high, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const nlohmann::json half = cli::run_json({"compare", low, high, "--json"});
    CHECK(half["forward"].get<double>() == doctest::Approx(std::sqrt(0.5)));
    CHECK(half["backward"].get<double>() < 1e-15);
    CHECK(half["hausdorff"] == half["forward"]);
}

TEST_CASE("render draws a picture of the size asked for, wires and heat included") {
    const ScratchDir scratch;
    const std::string out = (scratch / "a.png").string();
    const std::vector<std::string> plain = {"render", cli::data("pawn.obj"), "-o", out, "--size", "64x48"};
    const auto picture = [&](const std::vector<std::string>& more) {
        const ProcessResult result = cli::run(cli::join(plain, more));
        CAPTURE(result.err);
        REQUIRE(result.code == 0);
        const HeightImage image = load_height_image(out);
        CHECK(image.width == 64);
        CHECK(image.height == 48);
        return slurp(out);
    };
    // Each option must make another picture.
    const std::set<std::string> pictures = {picture({}),
                                            picture({"--wireframe"}),
                                            picture({"--flat"}),
                                            picture({"--camera", "-60,40"}),
                                            picture({"--up", "z"}),
                                            picture({"--heat", cli::data("cube.obj")})};
    CHECK(pictures.size() == 6);
}

TEST_CASE("[bad-input] the exit code says whose fault it is, the message what is wrong, and nothing is written") {
    const ScratchDir scratch;
    const std::string cube = cli::data("cube.obj"), out = (scratch / "out.obj").string();
    const auto file = [&](const std::string& name, const std::string& text) {
        spill(scratch / name, text);
        return (scratch / name).string();
    };
    const std::string empty = file("empty.obj", ""),
                      binary = file("binary.obj", std::string("\0\1\2\xff\xfe v f\n", 11));
    const std::string range = file("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    const std::string nan = file("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string three =
        file("three.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
    const std::string mesh = file("mesh.ply", "ply\nformat ascii 1.0\nend_header\n");
    const std::string missing = (scratch / "missing.obj").string();
    const std::size_t files = scratch.file_count();

    struct Case {
        std::vector<std::string> arguments;
        int code;
        std::string message;  // a part of it
    };
    const auto half_steps = [&](const cli::Words& more, const char* message) -> Case {
        return {cli::join({"refine", cube, "--factored", "--steps", "4", "-o", out}, more), 2, message};
    };
    const std::vector<Case> cases = {
        // usage
        {{}, 2, "subcommand"},
        {{"refine"}, 2, "IN is required"},
        {{"tessellate", cube, "--image", "-o", "x.glb"}, 2, "--image: its value is missing: -o is an option"},
        {{"refine", cube, "-o", out}, 2, "--levels"},
        {{"refine", cube, "--levels", "two", "-o", out}, 2, "two"},
        {{"refine", cube, "--levels", "-1", "-o", out}, 2, "-1"},
        {{"refine", cube, "--levels", "2", "-o", out, "--scheme", "buterfly"}, 2, "did you mean butterfly?"},
        {{"refine", cube, "--levels", "2", "-o", out, "--threads", "0"}, 2, "--threads"},
        {{"refine", cube, "--levels", "2", "-o", out, "--max-memory", "2X"}, 2, "500M"},
        {{"refine", cube, "--levels", "2", "-o", out, "--max-memory", "1K"}, 2, "1M is the least"},
        {{"refine", cube, "--levels", "2", "-o", ""}, 2, "-o: the name of the output file is empty"},
        {{"refine", cube, "--steps", "2", "-o", out}, 2, "--factored"},
        {{"refine", cube, "--factored", "-o", out}, 2, "--steps"},
        {{"refine", cube, "--factored", "--steps", "2", "--levels", "1", "-o", out}, 2, "--levels"},
        {{"refine", cube, "--factored", "--steps", "2", "--averaging-steps", "-1", "-o", out}, 2, "--averaging-steps"},
        {{"refine", cube, "--factored", "--steps", "2", "--averaging-steps", "65", "-o", out}, 2, "0 to 64"},
        {{"refine", cube, "--levels", "2", "--averaging-steps", "2", "-o", out}, 2, "--factored"},
        {{"refine", cube, "--factored", "--steps", "2", "--tuning", "0.5", "-o", out}, 2, "--tuning"},
        {{"refine", cube, "--factored", "--steps", "2", "--scheme", "loop", "-o", out}, 2, "midedge-simplest"},
        half_steps({"--near", "1,1,1"}, "--radius"),
        half_steps({"--radius", "1"}, "--near"),
        half_steps({"--near", "1,1", "--radius", "1"}, "three numbers"),
        half_steps({"--near", "1,1,nan", "--radius", "1"}, "three numbers"),
        half_steps({"--near", "", "--radius", "1"}, "three numbers"),
        half_steps({"--near", "1,1,1", "--radius", "0"}, "above 0"),
        half_steps({"--near", "1,1,1", "--radius", "nan"}, "above 0"),
        half_steps({"--near", "1,1,1", "--radius", "1", "--active"}, "--active"),
        half_steps({"--near", "1,1,1", "--radius", "1", "--scheme", "4-8"}, "doo-sabin"),
        {{"refine", cube, "--levels", "2", "--near", "1,1,1", "--radius", "1", "-o", out}, 2, "--factored"},
        {{"refine", missing, "--levels", "2", "-o", (scratch / "out.stl").string()}, 2, ".stl"},  // before any work
        {{"refine", cube, "--levels", "2", "-o", (scratch / "out").string()}, 2, ".obj, .ply or .glb"},
        {{"refine", cube, "--levels", "2", "-o", cube}, 2, "input"},
        {{"refine", cube, "--levels", "2", "-o", out, "--report", out}, 2, "same file"},
        {{"render", cube, "-o", (scratch / "out.jpg").string()}, 2, ".png"},
        {{"render", cube, "-o", (scratch / "out.png").string(), "--size", "0x10"}, 2, "0x10"},
        {{"render", cube, "-o", (scratch / "out.png").string(), "--camera", "1,2,3"}, 2, "1,2,3"},
        {{"compare", cube}, 2, "B is required"},
        // bad input
        {{"info", missing}, 3, "missing.obj"},
        {{"info", scratch.path().string()}, 3, "directory"},
        {{"info", empty}, 3, "empty.obj"},
        {{"info", binary}, 3, "binary.obj"},
        {{"info", range}, 3, "range.obj:4"},
        {{"info", nan}, 3, "nan.obj:1"},
        {{"info", three}, 3, "--repair"},
        {{"info", mesh}, 3, "OBJ"},
        {{"refine", three, "--levels", "1", "-o", out}, 3, "three.obj"},
        {{"compare", mesh, cube}, 3, "mesh.ply"},
        {{"render", empty, "-o", (scratch / "out.png").string()}, 3, "empty.obj"},
        // run time
        {{"refine", cube, "--levels", "2", "-o", (scratch / "no" / "out.obj").string()}, 1, "no"},
        {{"refine", missing, "--levels", "2", "-o", "/proc/out.obj"}, 1, "/proc"},  // seen before any work
        {{"refine", cube, "--factored", "--steps", "20", "--max-memory", "200M", "-o", out}, 1, "half-step"},
        {{"refine", cube, "--factored", "--steps", "62", "--max-memory", "500G", "-o", out}, 1, "of 62"},
        {{"refine", cube, "--levels", "30", "-o", out}, 1, "32-bit"},
        {{"refine", cube, "--levels", "9", "-o", out, "--max-memory", "10M"}, 1, "10 MiB"},
    };
    for (const Case& c : cases) cli::check_refused(c.arguments, c.code, c.message);
    CHECK(scratch.file_count() == files);

    SUBCASE("--repair makes the non-manifold mesh usable, and says so") {
        const ProcessResult result = cli::run({"refine", three, "--levels", "1", "--repair", "-o", out});
        CHECK(result.code == 0);
        CHECK(result.err.find("warning") != std::string::npos);
        CHECK(read_triangle_mesh(out).triangles.size() == 3 * 3 * 2);
    }
}

TEST_CASE("faces that share no vertices and colours that are lost are warnings, and --weld joins the faces") {
    const ScratchDir scratch;
    const std::string model = (scratch / "pieces.obj").string(), out = (scratch / "out.ply").string();
    std::string text;
    for (const char* face : {"000 010 110 100", "001 101 111 011", "000 100 101 001", "010 011 111 110",
                             "000 001 011 010", "100 110 111 101"}) {
        std::istringstream corners(face);
        for (std::string c; corners >> c;) text += std::string("v ") + c[0] + " " + c[1] + " " + c[2] + " 1 0 0\n";
        text += "f -4 -3 -2 -1\n";
    }
    spill(model, text);
    const std::string warning = "between 24 vertices at 8 places";
    using cli::Words;
    for (const Words& line : {Words{"tessellate", model, "-o", out, "--tolerance", "1e-2", "--no-measure"},
                              Words{"refine", model, "-o", out, "--levels", "2"},
                              Words{"refine", model, "-o", out, "--factored", "--steps", "2"}, Words{"info", model}}) {
        CAPTURE(line);
        const ProcessResult pieces = cli::run(line);
        CHECK(pieces.code == 0);
        CHECK((pieces.err + pieces.out).find(warning) != std::string::npos);
        CHECK((pieces.err + pieces.out).find(model + ": vertex colours are not carried over") != std::string::npos);
        for (const Words& weld : {Words{"--weld"}, Words{"--weld", "1e-6"}, Words{"--weld=0"}}) {
            const ProcessResult whole = cli::run(cli::join(line, weld));
            CAPTURE(whole.err);
            CHECK(whole.code == 0);
            CHECK((whole.err + whole.out).find("joined 24 vertices at 8 places") != std::string::npos);
            CHECK((whole.err + whole.out).find(warning) == std::string::npos);
        }
    }
    CHECK(cli::run_json({"info", "--json", "--weld", model})["vertices"] == 8);
    for (const char* bad : {"--weld=-1", "--weld=nan", "--weld=inf", "--weld=x"})
        cli::check_refused({"info", model, bad}, 2, "is not a distance of 0 or more");
    CHECK(cli::run({"info", model, "--weld", "-1"}).code == 2);
}

TEST_CASE("Ctrl-C and SIGTERM end any long run with 130 and leave no file") {
    const ScratchDir scratch;
    const std::string obj = (scratch / "out.obj").string(), png = (scratch / "out.png").string();
    struct Case {
        int signal;
        std::vector<std::string> line;
    };
    // Each far longer than the signal takes, in memory that a desktop has.
    const std::vector<Case> cases = {
        {SIGINT, {"refine", cli::data("head.obj"), "--levels", "8", "--limit", "-o", obj}},
        {SIGTERM, {"tessellate", cli::data("head.obj"), "--tolerance", "1e-6", "-o", obj, "--image", png}},
        {SIGINT, {"scheme", "kobbelt", "--valence", "700", "--boundary", "--image", png}},
    };
    for (const auto& [signal, line] : cases) {
        CAPTURE(line);
        Process process(cli::command_line(line));
        REQUIRE(process.wait_for_handler(signal));
        REQUIRE(process.wait_for_work());
        process.send(signal);
        const ProcessResult result = process.wait();
        CHECK(result.code == 130);
        CHECK(result.out.empty());
        CHECK(scratch.file_count() == 0);
    }
}

TEST_CASE("output that goes nowhere is a failure") {
    const ProcessResult result =
        run_process({"/bin/sh", "-c", "\"$0\" info \"$1\" > /dev/full", cli::program(), cli::data("cube.obj")});
    CHECK(result.code == 1);
    CHECK(result.err.find("standard output") != std::string::npos);
}

TEST_SUITE_END();
