#include "../kit/cli.hpp"

#include <doctest/doctest.h>

TEST_SUITE_BEGIN("cli");

namespace {

/// A name in the folder that can be opened for writing and takes no byte.
std::string full_device(const ScratchDir& scratch, const std::string& name) {
    std::filesystem::create_symlink("/dev/full", scratch / name);
    return (scratch / name).string();
}

using cli::Words;

}  // namespace

TEST_CASE("[bad-input] the files of a run appear together: one that cannot be written leaves none of the others") {
    if (!std::filesystem::exists("/dev/full")) {
        MESSAGE("no /dev/full here: skipped");
        return;
    }
    const Words tessellate = {"tessellate", cli::data("cube.obj"), "--tolerance", "1e-2", "--size", "16x16"};
    const Words refine = {"refine", cli::data("cube.obj"), "--levels", "1"};
    const Words factored = {"refine", cli::data("cube.obj"), "--factored", "--steps", "2"};
    struct Case {
        Words command;
        std::string option, name;  // of the output that fails
    };
    const std::vector<Case> cases = {
        {tessellate, "--image", "i.png"}, {tessellate, "--image-heat", "h.png"}, {tessellate, "-o", "m.ply"},
        {refine, "--report", "r.json"},   {refine, "--stencils", "t.txt"},       {factored, "-o", "m.ply"},
    };
    for (const Case& c : cases) {
        CAPTURE(c.command);
        CAPTURE(c.option);
        const ScratchDir scratch;
        const std::string before = "what was there before";
        spill(scratch / "out.ply", before);
        const std::string full = full_device(scratch, c.name);
        Words line = cli::join(c.command, {c.option, full});
        // All others work.
        const auto add = [&](const std::string& option, const std::string& name) {
            if (option != c.option) line.insert(line.end(), {option, (scratch / name).string()});
        };
        add("-o", "out.ply");
        add("--report", "report.json");
        if (c.command == tessellate) add("--image", "image.png"), add("--image-heat", "heat.png");
        const ProcessResult result = cli::run(line);
        CAPTURE(result.err);
        CHECK(result.code == 1);
        CHECK(result.err.find(full) != std::string::npos);
        CHECK(result.err.find("No space left") != std::string::npos);
        CHECK(slurp(scratch / "out.ply") == before);
        CHECK(scratch.file_count() == 2);  // that and the link
        CHECK(std::filesystem::is_symlink(full));
    }
}

TEST_CASE("[bad-input] every error names the file that it is about") {
    const ScratchDir scratch;
    const auto file = [&](const std::string& name, const std::string& text) {
        spill(scratch / name, text);
        return (scratch / name).string();
    };
    const std::string head = cli::data("head.obj"), cube = cli::data("cube.obj");
    const std::string point = file("point.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
    const std::string far = file("far.obj", "v 1e15 0 0\nv 1000000000000001 0 0\nv 1000000000000001 1 0\nf 1 2 3\n");
    const std::string broken_ply = file("broken.ply", "ply\nformat ascii 1.0\nelement vertex 1\nend_header\n");
    const std::string words = file("words.png", "these are words"), empty = file("empty.obj", "");
    const std::string lost = file("lost.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 1 2\nf 2 3 9\n");
    struct Case {
        Words line;
        int code;
        std::string named;
    };
    const std::vector<Case> cases = {
        {{"tessellate", point, "--tolerance", "1e-2"}, 3, point},
        {{"tessellate", far, "--tolerance", "1e-2"}, 3, far},
        {{"tessellate", head, "--tolerance", "1e-17"}, 3, head},
        {{"tessellate", empty, "--tolerance", "1e-2"}, 3, empty},
        {{"tessellate", head, "--tolerance", "1e-2", "--displacement", words, "--amplitude", "1"}, 3, words},
        {{"tessellate", cube, "--tolerance", "1e-2", "--displacement", words, "--amplitude", "1"}, 3, cube},
        {{"tessellate", head, "--tolerance", "1e-2", "--target", broken_ply}, 3, broken_ply},
        {{"tessellate", head, "--tolerance", "1e-2", "--target", empty}, 3, empty},
        {{"tessellate", head, "--tolerance", "1e-2", "--target", point}, 3, point},
        {{"tessellate", head, "--tolerance", "1e-5", "--max-memory", "25M"}, 1, head},
        {{"tessellate", lost, "--tolerance", "1e-2", "--repair"}, 3, lost},
        {{"refine", head, "--levels", "12"}, 1, head},
        {{"refine", head, "--levels", "9", "--max-memory", "25M"}, 1, head},
        {{"refine", head, "--factored", "--steps", "20", "--max-memory", "25M"}, 1, head},
        {{"refine", lost, "--levels", "2", "--repair"}, 3, lost},
    };
    const std::size_t files = scratch.file_count();
    for (const Case& c : cases) {
        const std::string message = cli::check_refused(cli::join(c.line, {"-o", (scratch / "out.ply").string()}),
                                                       c.code, "error: " + c.named + ":");
        CHECK(message.find(c.named) == message.rfind(c.named));  // once
        CHECK(scratch.file_count() == files);
    }
}

TEST_CASE("[bad-input] a repair that leaves no face says what it dropped") {
    const ScratchDir scratch;
    std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    for (int i = 0; i < 50; ++i) text += "f 1 1 2\nf 2 3 9\n";
    spill(scratch / "lost.obj", text + "t crease 2/1/0 0 1 2\n");
    for (const Words& command : {Words{"info"}, Words{"refine", "--levels", "1", "-o", (scratch / "o.ply").string()}}) {
        const Words lost = {(scratch / "lost.obj").string(), "--repair"};
        const std::string message = cli::check_refused(cli::join(command, lost), 3, "no face is left");
        for (const char* dropped :
             {"dropped 50 faces with a vertex that is not there or not finite (the first is face 2 (line 5))",
              "dropped 50 faces with fewer than three distinct vertices (the first is face 1 (line 4))"})
            CHECK(message.find(dropped) != std::string::npos);
        CHECK(scratch.file_count() == 1);
    }
}

TEST_SUITE_END();
