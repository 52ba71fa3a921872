#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/tessellate/tessellate.hpp"

#include "../kit/cli.hpp"
#include "../kit/meshes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string_view>

using namespace tetrakis;

TEST_SUITE_BEGIN("cli");

namespace {

/// Runs `tetrakis tessellate` in a folder of its own and reads what it wrote.
struct Run {
    ScratchDir scratch;
    ProcessResult result;
    nlohmann::json report;
    std::string bytes;
    TriangleMesh mesh;

    /// Measured by few samples, which is what takes longest, unless `more` says how many.
    explicit Run(const std::string& model, const std::vector<std::string>& more,
                 const std::string& extension = ".ply") {
        const std::string out = (scratch / ("out" + extension)).string();
        std::vector<std::string> arguments = {"tessellate", model,      "-o",
                                              out,          "--report", (scratch / "report.json").string()};
        if (std::ranges::find(more, "--samples") == more.end() && std::ranges::find(more, "--no-measure") == more.end())
            arguments.insert(arguments.end(), {"--samples", "50000"});
        result = cli::run(cli::join(arguments, more));
        if (!std::filesystem::exists(out)) return;
        bytes = slurp(out);
        mesh = read_triangle_mesh(out);
        report = nlohmann::json::parse(slurp(scratch / "report.json"));
    }
};

}  // namespace

TEST_CASE("a tolerance is a share of the diagonal unless --absolute is given") {
    const Run relative(cli::data("pawn.obj"), {"--tolerance", "1e-2", "--no-measure"});
    REQUIRE(relative.result.code == 0);
    const Run absolute(cli::data("pawn.obj"),
                       {"--tolerance", relative.report["tolerance_absolute"].dump(), "--absolute", "--no-measure"});
    REQUIRE(absolute.result.code == 0);
    CHECK(absolute.bytes == relative.bytes);
    CHECK(absolute.report["tolerance"].get<double>() == doctest::Approx(1e-2).epsilon(1e-12));
}

TEST_CASE("exit code 4: what stopped the refinement, and the best result all the same") {
    const std::string rook = cli::data("rook.obj");
    const Run shallow(rook, {"--tolerance", "1e-5", "--max-level", "2", "--no-measure"});
    CHECK(shallow.result.code == 4);
    CHECK(shallow.result.err.find("--max-level") != std::string::npos);
    CHECK(shallow.report["tolerance_reached"] == false);
    CHECK(shallow.mesh.triangles.size() == shallow.report["triangles"]);

    const Run both(rook, {"--tolerance", "1e-5", "--max-triangles", "3000", "--no-measure"});
    CHECK(both.result.code == 4);
    CHECK(both.result.err.find("--max-triangles") != std::string::npos);
    CHECK(both.mesh.triangles.size() <= 3000);
    CHECK(both.mesh.triangles.size() > 2000);

    const Run budget(rook, {"--max-triangles", "3000"});  // no tolerance, so none is missed
    CHECK(budget.result.code == 0);
    CHECK(budget.mesh.triangles.size() <= 3000);
    CHECK(budget.mesh.triangles.size() > 2000);
    CHECK(budget.report["tolerance"].is_null());
    CHECK(budget.report["tolerance_absolute"].is_null());
    CHECK(budget.report["tolerance_reached"].is_null());
}

TEST_CASE("the summary says what was measured, what is proven and how to prove more") {
    const auto has = [](const Run& run, const std::string& words) {
        return run.result.out.find(words) != std::string::npos;
    };
    const std::string advice = "; --estimator certified proves 1.0";
    const Run measured(cli::data("pawn.obj"), {"--tolerance", "1e-2", "--samples", "5000"});
    CAPTURE(measured.result.out);
    REQUIRE(measured.result.code == 0);
    CHECK(measured.report["estimator"] == "measured");
    CHECK(has(measured, " of the tolerance (kept)\n"));
    CHECK(has(measured, "proven error    at most "));
    CHECK((measured.report["certified_error"] > measured.report["tolerance_absolute"]) == has(measured, advice));
    CHECK(has(measured, advice));
    const Run unmeasured(cli::data("pawn.obj"), {"--tolerance", "1e-2", "--no-measure", "--estimator", "measured"});
    CAPTURE(unmeasured.result.out);
    CHECK(has(unmeasured, "left out (--no-measure)"));
    CHECK(has(unmeasured, advice));
    CHECK(unmeasured.report["measured_error"].is_null());
    CHECK(unmeasured.report["samples"].is_null());
    CHECK(unmeasured.report["certified_error"].is_number_float());
    const Run certified(cli::data("pawn.obj"), {"--tolerance", "1e-2", "--no-measure", "--estimator", "certified"});
    CHECK(has(certified, "proven error  at most "));
    CHECK_FALSE(has(certified, advice));
    const Run missed(cli::data("pawn.obj"), {"--tolerance", "1e-4", "--max-level", "1", "--samples", "5000"});
    CAPTURE(missed.result.out);
    CHECK(missed.result.code == 4);
    CHECK(has(missed, " of the tolerance (missed)\n"));
    CHECK_FALSE(has(missed, advice));
    const Run unknown(cli::data("pawn.obj"), {"--tolerance", "1e-2", "--estimator", "embree"});
    CHECK(unknown.result.code == 2);
    CHECK(unknown.result.err.find("certified") != std::string::npos);
}

namespace {
bool warns_of(const Run& run, std::string_view text) {
    for (const nlohmann::json& warning : run.report["warnings"])
        if (warning.get<std::string>().find(text) != std::string::npos) return true;
    return false;
}
}  // namespace

TEST_CASE("Catmull-Clark on triangles alone: a hint at loop, unless the scheme is given") {
    const std::string knot = cli::data("knot_tri.obj");
    CHECK(warns_of(Run(knot, {"--tolerance", "1e-2", "--no-measure"}), "--scheme loop"));
    for (const std::string scheme : {"catmull-clark", "loop"})
        CHECK(!warns_of(Run(knot, {"--tolerance", "1e-2", "--no-measure", "--scheme", scheme}), "--scheme loop"));
    CHECK(!warns_of(Run(cli::data("rook.obj"), {"--tolerance", "1e-2", "--no-measure"}), "--scheme loop"));
}

TEST_CASE("a control mesh whose own faces are within the tolerance is named") {
    const std::string knot = cli::data("knot_tri.obj");
    for (const std::string scheme : {"catmull-clark", "loop", "sqrt3"}) {
        CAPTURE(scheme);
        const Run fine(knot, {"--tolerance", "1e-2", "--no-measure", "--scheme", scheme});
        CHECK(warns_of(fine, "nothing was refined") == (scheme != "sqrt3"));
        CHECK(!warns_of(Run(knot, {"--tolerance", "1e-3", "--no-measure", "--scheme", scheme}), "nothing was refined"));
    }
}

TEST_CASE("options that a scheme has no use for change nothing: patches serve as without them") {
    const std::string pawn = cli::data("pawn.obj"), knot = cli::data("knot_tri.obj");
    const Run quads(pawn, {"--tolerance", "1e-2", "--no-measure"});
    for (const std::string option : {"--warren", "--hoppe", "--ten-point=0.01"}) {
        CAPTURE(option);
        CHECK(Run(pawn, {"--tolerance", "1e-2", "--no-measure", option}).mesh.positions == quads.mesh.positions);
    }
    const std::vector<std::string> loop = {"--scheme", "loop", "--tolerance", "1e-2", "--no-measure"};
    const Run triangles(knot, loop);
    for (const std::string option : {"--beta=1.2", "--gamma=0.2"}) {
        CAPTURE(option);
        CHECK(Run(knot, cli::join(loop, {option})).mesh.positions == triangles.mesh.positions);
    }
}

#if !defined(__SANITIZE_ADDRESS__)
TEST_CASE("Catmull-Clark on many triangles takes little memory") {
    // As many as a scanned model has: 4 KB a face, where patch trees of all would take 90.
    constexpr int n = 184, k_faces = 2 * n * n;
    const ScratchDir scratch;
    const auto torus = scratch / "torus.obj";
    TriangleMesh mesh;
    const ControlMeshData data = test::triangle_torus(n);
    mesh.positions = data.positions;
    for (std::size_t c = 0; c < data.face_vertices.size(); c += 3)
        mesh.triangles.push_back({data.face_vertices[c], data.face_vertices[c + 1], data.face_vertices[c + 2]});
    write_mesh(torus, mesh);
    const Run run(torus.string(),
                  {"--tolerance", "1e-3", "--no-measure", "--max-memory", std::to_string(4 * k_faces) + "K"});
    CHECK(run.result.code == 0);
    CHECK(run.mesh.triangles.size() == k_faces);
}
#endif

TEST_CASE("[bad-input] the refusal of a certified bound and the help name all schemes that have one") {
    const std::string refused = cli::check_refused({"tessellate", "missing.obj", "--tolerance", "1e-2", "--scheme",
                                                    "biquartic", "--estimator", "certified", "-o", "no.obj"},
                                                   2, "--estimator measured");
    const ProcessResult help = cli::run({"tessellate", "--help"});
    const std::size_t list = help.out.find("certified_error is null:");
    REQUIRE(list != std::string::npos);
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        if (!scheme_support(scheme.name).certified) continue;
        CHECK(refused.find(scheme.name, refused.find("--scheme")) != std::string::npos);
        CHECK(help.out.substr(list, 400).find(scheme.name) != std::string::npos);
    }
}

TEST_CASE("a displacement by a white picture moves the surface by its amplitude") {
    const ScratchDir scratch;
    const std::string white = (scratch / "white.pgm").string();
    spill(white, "P5\n2 2\n255\n\xff\xff\xff\xff");
    const Run flat(cli::data("head.obj"), {"--tolerance", "4e-3", "--no-measure"});
    const Run raised(cli::data("head.obj"),
                     {"--tolerance", "4e-3", "--no-measure", "--displacement", white, "--amplitude", "0.05"});
    CAPTURE(raised.result.err);
    REQUIRE(raised.result.code == 0);
    CHECK(raised.report["certified_error"].is_null());
    const nlohmann::json apart = cli::run_json({"compare", (flat.scratch / "out.ply").string(),
                                                (raised.scratch / "out.ply").string(), "--json", "--samples", "20000"});
    const double both = 2 * flat.report["tolerance_absolute"].get<double>();
    CHECK(apart["hausdorff"].get<double>() == doctest::Approx(0.05).epsilon(both / 0.05));
    CHECK(apart["mean"].get<double>() == doctest::Approx(0.05).epsilon(both / 0.05));
}

TEST_CASE("heights that differ across a UV seam are named") {
    const ScratchDir scratch;
    // All of the picture meets at the crown.
    const std::string torn = (scratch / "torn.pgm").string(), even = (scratch / "even.pgm").string();
    spill(torn, std::string("P5\n2 1\n255\n\0\xff", 13));
    spill(even, "P5\n2 1\n255\n\xff\xff");
    for (const std::string& image : {torn, even}) {
        const Run run(cli::data("head.obj"),
                      {"--tolerance", "1e-2", "--no-measure", "--displacement", image, "--amplitude", "0.1"});
        CAPTURE(run.result.err);
        CHECK((run.result.err.find("UV seam") != std::string::npos) == (image == torn));
    }
}

TEST_CASE("a target takes the vertices onto itself") {
    const ScratchDir scratch;
    const std::string target = (scratch / "target.ply").string();
    // The limit surface itself, finely: a stand-in for a scan.
    REQUIRE(cli::run({"refine", cli::data("pawn.obj"), "--levels", "4", "--limit", "-o", target}).code == 0);
    const Run run(cli::data("pawn.obj"), {"--tolerance", "5e-3", "--target", target});
    CAPTURE(run.result.err);
    REQUIRE(run.result.code == 0);
    CHECK(run.report["certified_error"].is_null());
    const nlohmann::json apart =
        cli::run_json({"compare", target, (run.scratch / "out.ply").string(), "--json", "--samples", "50000"});
    CHECK(apart["hausdorff"].get<double>() <= run.report["tolerance_absolute"].get<double>());
}

TEST_CASE("pictures come with the mesh") {
    const ScratchDir pictures;
    const Run run(cli::data("pawn.obj"),
                  {"--tolerance", "1e-2", "--size", "48x64", "--image", (pictures / "a.png").string(), "--image-heat",
                   (pictures / "b.png").string()});
    CAPTURE(run.result.err);
    REQUIRE(run.result.code == 0);
    const std::string wires = slurp(pictures / "a.png"), heat = slurp(pictures / "b.png");
    CHECK(wires.starts_with("\x89PNG"));
    CHECK(heat.starts_with("\x89PNG"));
    CHECK(wires != heat);
    CHECK(pictures.file_count() == 2);
}

TEST_CASE("[bad-input] tessellate refuses options that make no sense before any work") {
    const ScratchDir scratch;
    const std::string out = (scratch / "out.obj").string(), cube = cli::data("cube.obj");
    const std::string missing = (scratch / "missing.obj").string();
    struct Case {
        std::vector<std::string> options;
        int code;
        std::string message;
    };
    const std::vector<Case> cases = {
        {{missing}, 2, "--tolerance"},
        {{missing, "--tolerance", "0"}, 2, "--tolerance"},
        {{missing, "--tolerance", "-1e-3"}, 2, "--tolerance"},
        {{missing, "--tolerance", "nan"}, 2, "--tolerance"},
        {{missing, "--tolerance", "inf"}, 2, "--tolerance"},
        {{missing, "--tolerance", "1e-3", "--max-triangles", "0"}, 2, "--max-triangles"},
        {{missing, "--max-triangles", "100", "--absolute"}, 2, "--absolute"},
        {{missing, "--tolerance", "1e-3", "--amplitude", "1"}, 2, "--displacement"},
        {{missing, "--tolerance", "1e-3", "--displacement", "a.png"}, 2, "--amplitude"},
        {{missing, "--tolerance", "1e-3", "--estimator", "guess"}, 2, "guess"},
        {{missing, "--tolerance", "1e-3", "--estimator", "certified", "--target", cube}, 2, "certified"},
        {{missing, "--tolerance", "1e-3", "--min-level", "5", "--max-level", "3"}, 2, "--min-level"},
        {{missing, "--tolerance", "1e-3", "--image", "a.jpg"}, 2, "--image"},
        {{missing, "--tolerance", "1e-3", "--size", "90x90"}, 2, "--size"},
        {{missing, "--tolerance", "1e-3", "--samples", "900", "--no-measure"}, 2, "--samples"},
        {{missing, "--tolerance", "1e-2", "--scheme", "buterfly"}, 2, "did you mean butterfly?"},
        {{missing, "--tolerance", "1e-2", "--scheme", "sqrt3", "--estimator", "certified"}, 2, "modified-butterfly"},
        {{missing, "--tolerance", "1e-2", "--scheme", "4-8", "--target", "x.obj"}, 2, "--scheme catmull-clark or loop"},
        {{missing, "--tolerance", "1e-3"}, 3, "missing.obj"},
        {{cube, "--tolerance", "1e-3", "--target", missing}, 3, "missing.obj"},
        {{cube, "--tolerance", "1e-3", "--displacement", "a.png", "--amplitude", "1"}, 3, "texture coordinates"},
        {{cli::data("head.obj"), "--tolerance", "1e-3", "--displacement", cube, "--amplitude", "1"}, 3, "cube.obj"},
        {{missing, "--tolerance", "1e-3", "--report", (scratch / "no" / "r.json").string()}, 1, "no"},
        {{cli::data("knot.obj"), "--tolerance", "1e-8", "--max-memory", "20M"}, 1, "20 MiB"},
    };
    for (const Case& c : cases) cli::check_refused(cli::join({"tessellate", "-o", out}, c.options), c.code, c.message);
    CHECK(scratch.file_count() == 0);
}

TEST_SUITE_END();
