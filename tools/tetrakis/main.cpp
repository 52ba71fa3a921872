#include "commands.hpp"
#include "console.hpp"
#include "interrupt.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/version.hpp"

#include <cstdio>
#include <exception>
#include <new>
#include <string>

namespace tetrakis::cli {
namespace {

ExitCode exit_code_of(const Error& error) {
    switch (error.code()) {
        case ErrorCode::invalid_input:
            return ExitCode::bad_input;
        case ErrorCode::cancelled:
            return ExitCode::cancelled;
        case ErrorCode::io:
        case ErrorCode::unsupported:
        case ErrorCode::memory_limit:
            break;
    }
    return ExitCode::failure;
}

ExitCode run(const Command& command) {
    try {
        return command();
    } catch (const UsageError& e) {
        print_error(e.what());
        return ExitCode::usage;
    } catch (const InputError& e) {
        print_error(e.what());
        return ExitCode::bad_input;
    } catch (const Error& e) {
        print_error(e.code() == ErrorCode::cancelled ? "cancelled; nothing was written" : e.what());
        return exit_code_of(e);
    } catch (const std::bad_alloc&) {
        print_error("out of memory; ask for less (a larger tolerance, fewer levels, --max-triangles)");
    } catch (const std::exception& e) {
        print_error(e.what());
    }
    return ExitCode::failure;
}

/// Puts the parser's own exit codes (0 for help and version, else 100 and above) into ours.
ExitCode finish_parse(const CLI::App& app, const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
        app.exit(error);
        return flush_output() ? ExitCode::done : ExitCode::failure;
    }
    const auto commands = app.get_subcommands();
    const std::string command = commands.empty() ? "tetrakis" : "tetrakis " + commands.front()->get_name();
    print_error(std::string(error.what()) + "; " + command + " --help says what there is");
    return ExitCode::usage;
}

}  // namespace
}  // namespace tetrakis::cli

int main(int argc, char** argv) {
    using namespace tetrakis::cli;
    CLI::App app("tetrakis: adaptive tessellation of subdivision surfaces to a stated tolerance", "tetrakis");
    app.set_version_flag("--version", "tetrakis " + std::string(tetrakis::k_version));
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 done, 1 failure at run time, 2 usage, 3 bad input, 4 tolerance not reached (the best result is\n"
        "written), 130 cancelled. Each command explains itself: tetrakis tessellate --help");
    Command chosen;
    add_info_command(app, chosen);
    add_tessellate_command(app, chosen);
    add_refine_command(app, chosen);
    add_compare_command(app, chosen);
    add_render_command(app, chosen);
    add_scheme_command(app, chosen);
    add_schemes_command(app, chosen);
    if (argc > 1 && argv[1][0] != '-' &&
        app.get_subcommands([&](CLI::App* command) { return command->check_name(argv[1]); }).empty()) {
        print_error(std::string(argv[1]) + " is no command; tetrakis --help says what there is");
        return static_cast<int>(ExitCode::usage);
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return static_cast<int>(finish_parse(app, error));
    }
    catch_interrupts();
    ExitCode code = run(chosen);
    if (code != ExitCode::cancelled && !flush_output()) {
        print_error("cannot write to standard output");
        if (code == ExitCode::done) code = ExitCode::failure;
    }
    return static_cast<int>(code);
}
