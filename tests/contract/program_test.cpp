#include "../kit/process.hpp"
#include "../kit/scratch_dir.hpp"

#include "../../eval/io/mesh_reader.hpp"

#include <doctest/doctest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

using namespace tetrakis;

// The program as scripts use it: exit codes, reports, files. What it says in words is no part of this.

namespace {

using Words = std::vector<std::string>;

/// What users read of the program.
std::string documentation() {
    return slurp(TETRAKIS_SOURCE_DIR "/README.md") + slurp(TETRAKIS_SOURCE_DIR "/tools/tetrakis/README.md");
}

std::string data(const std::string& name) { return TETRAKIS_SOURCE_DIR "/data/" + name; }

ProcessResult run(Words words, const std::string& directory = ".") {
    words.insert(words.begin(), TETRAKIS_CLI);
    return run_process(words, directory);
}

std::string line_of(const Words& words) {
    std::string line;
    for (const std::string& word : words) line += word + ' ';
    return line;
}

std::set<std::string> keys_of(const nlohmann::json& object) {
    std::set<std::string> keys;
    for (const auto& item : object.items()) keys.insert(item.key());
    return keys;
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("the exit code says what happened, and only 0 and 4 leave files") {
    const ScratchDir scratch, inputs;
    const std::string cube = data("cube.obj"), out = (scratch / "out.ply").string();
    const std::string report = (scratch / "report.json").string();
    const std::string broken = (inputs / "broken.obj").string(), missing = (inputs / "missing.obj").string();
    spill(broken, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    struct Case {
        int code;
        Words words;
    };
    const std::vector<Case> cases = {
        {0, {"tessellate", cube, "--tolerance", "1e-2", "-o", out, "--report", report}},
        {0, {"tessellate", cube, "--max-triangles", "200", "-o", out, "--report", report}},
        {0, {"refine", cube, "--levels", "2", "-o", out, "--report", report}},
        {0, {"info", cube}},
        {0, {"compare", cube, cube}},
        {0, {"schemes"}},
        {0, {"scheme", "loop"}},
        {0, {"--help"}},
        {0, {"--version"}},
        {1, {"tessellate", cube, "--tolerance", "1e-2", "-o", (scratch / "no/out.ply").string()}},
        {1, {"tessellate", cube, "--tolerance", "1e-2", "-o", out, "--report", (scratch / "no/r.json").string()}},
        {1, {"tessellate", cube, "--tolerance", "1e-8", "-o", out, "--report", report, "--max-memory", "20M"}},
        {1, {"tessellate", cube, "--max-triangles", "3", "-o", out, "--report", report}},
        {2, {}},
        {2, {"polish", cube}},
        {2, {"tessellate", cube, "-o", out}},
        {2, {"tessellate", cube, "--tolerance", "-1", "-o", out}},
        {2, {"tessellate", cube, "--tolerance", "1e-2", "-o", (scratch / "out.stl").string()}},
        {2, {"tessellate", cube, "--tolerance", "1e-2", "-o", out, "--scheme", "nosuch"}},
        {2, {"tessellate", cube, "--tolerance", "1e-2", "-o", out, "--report", out}},
        {2, {"refine", cube, "--levels", "2", "-o", out, "--polish"}},
        {3, {"info", missing}},
        {3, {"info", broken}},
        {3, {"tessellate", missing, "--tolerance", "1e-2", "-o", out, "--report", report}},
        {3, {"tessellate", broken, "--tolerance", "1e-2", "-o", out, "--report", report}},
        {3, {"compare", cube, missing}},
        {4, {"tessellate", cube, "--tolerance", "1e-5", "--max-level", "1", "-o", out, "--report", report}},
        {4, {"tessellate", cube, "--tolerance", "1e-5", "--max-triangles", "300", "-o", out, "--report", report}},
    };
    for (const Case& c : cases) {
        CAPTURE(line_of(c.words));
        const ProcessResult result = run(c.words);
        CAPTURE(result.err);
        CHECK(result.code == c.code);
        const bool writes = std::ranges::find(c.words, "-o") != c.words.end();
        CHECK(scratch.file_count() == (writes && (c.code == 0 || c.code == 4) ? 2 : 0));
        if (c.code == 0 || c.code == 4) {
            if (writes) CHECK(!read_triangle_mesh(out).triangles.empty());
        } else {
            CHECK(result.out.empty());
            CHECK(result.err.size() > 10);
            // Names what is to blame.
            if (c.code == 3) CHECK(result.err.find(c.words[c.words[0] == "compare" ? 2 : 1]) != std::string::npos);
        }
        for (const auto& file : {out, report}) std::filesystem::remove(file);
    }
}

TEST_CASE("interrupted, it ends with 130 and leaves nothing") {
    const ScratchDir scratch;
    Process process({TETRAKIS_CLI, "tessellate", data("knot.obj"), "--tolerance", "1e-7", "-o",
                     (scratch / "out.ply").string(), "--report", (scratch / "r.json").string()});
    REQUIRE(process.wait_for_handler(SIGINT));
    process.send(SIGINT);
    CHECK(process.wait().code == 130);
    CHECK(scratch.file_count() == 0);
}

TEST_CASE("a file that cannot be written whole takes those that belong to it with it") {
    const ScratchDir scratch;
    // A limit of 8 KiB for each file, which the report keeps to and the mesh does not.
    const ProcessResult result = run_process(
        {"/bin/sh", "-c", "ulimit -f 16; exec \"$0\" tessellate \"$1\" --tolerance 1e-3 -o out.ply --report r.json",
         TETRAKIS_CLI, data("cube.obj")},
        scratch.path().string());
    CAPTURE(result.err);
    CHECK(result.code == 1);
    CHECK(scratch.file_count() == 0);
}

TEST_CASE("reports have the keys that tools/tetrakis/README.md lists, and no others") {
    const std::set<std::string> common = {"input",
                                          "scheme",
                                          "version",
                                          "threads",
                                          "faces",
                                          "vertices",
                                          "triangles",
                                          "tolerance",
                                          "tolerance_absolute",
                                          "certified_error",
                                          "measured_error",
                                          "levels",
                                          "seconds",
                                          "peak_memory_bytes",
                                          "warnings"};
    const std::set<std::string> distances = {"forward", "backward", "hausdorff", "mean", "rms"};
    const std::set<std::string> stages = {"load", "build", "refine", "estimate", "measure", "write"};
    struct Case {
        Words words;
        std::set<std::string> more;
    };
    const std::vector<Case> cases = {
        {{"tessellate", data("cube.obj"), "--tolerance", "1e-2", "--samples", "5000"},
         {"estimator", "tolerance_reached", "samples", "peak_memory_before_measure_bytes"}},
        {{"refine", data("cube.obj"), "--levels", "2"}, {"output_faces", "limit"}},
        {{"refine", data("cube.obj"), "--factored", "--steps", "2"},
         {"output_faces", "half_steps", "active", "inactive_vertices"}},
        {{"refine", data("cube.obj"), "--factored", "--steps", "5", "--near", "1,1,1", "--radius", "0.5"},
         {"output_faces", "half_steps", "active", "inactive_vertices"}},
    };
    const std::string readme = slurp(TETRAKIS_SOURCE_DIR "/tools/tetrakis/README.md");
    for (const Case& c : cases) {
        CAPTURE(line_of(c.words));
        const ScratchDir scratch;
        Words words = c.words;
        words.insert(words.end(),
                     {"-o", (scratch / "a.ply").string(), "--report", (scratch / "r.json").string(), "--threads", "2"});
        REQUIRE(run(words).code == 0);
        const nlohmann::json report = nlohmann::json::parse(slurp(scratch / "r.json"));
        std::set<std::string> expected = common;
        expected.insert(c.more.begin(), c.more.end());
        CHECK(keys_of(report) == expected);
        CHECK(keys_of(report.at("seconds")) == stages);
        for (const std::string& key : expected) {
            CAPTURE(key);
            CHECK(readme.find("`" + key + "`") != std::string::npos);
        }
        CHECK(report.at("input") == data("cube.obj"));
        CHECK(report.at("faces") == 6);
        CHECK(report.at("threads") == 2);
        if (words[0] != "tessellate") continue;
        const TriangleMesh mesh = read_triangle_mesh(scratch / "a.ply");
        CHECK(report.at("triangles") == mesh.triangles.size());
        CHECK(report.at("vertices") == mesh.positions.size());
        CHECK(keys_of(report.at("measured_error")) == distances);
        CHECK(report.at("measured_error").at("hausdorff") <= report.at("certified_error"));
        CHECK(report.at("tolerance") == 1e-2);
        CHECK(report.at("tolerance_reached") == true);
    }
}

TEST_CASE("[slow] the command lines of the two READMEs run, in their order") {
    const ScratchDir scratch;
    std::filesystem::create_directory_symlink(data(""), scratch / "data");
    std::istringstream readme(documentation());
    bool shell = false;  // in a block of them
    int count = 0;
    for (std::string line; std::getline(readme, line);) {
        if (line.starts_with("```")) shell = line == "```sh";
        if (!shell || !line.starts_with("tetrakis ")) continue;
        CAPTURE(line);
        const ProcessResult result =
            run_process({"/bin/sh", "-c", "exec \"$0\" " + line.substr(std::string("tetrakis ").size()), TETRAKIS_CLI},
                        scratch.path().string());
        CAPTURE(result.err);
        CHECK(result.code == 0);
        ++count;
    }
    CHECK(count >= 5);
}

TEST_SUITE_END();
