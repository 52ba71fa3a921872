#include "commands.hpp"
#include "console.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/version.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#if defined(__GLIBC__)
#    include <malloc.h>
#endif

namespace tetrakis::cli {
namespace {

/// As keep_freed_memory(), for what malloc() gives: by default it returns pages again and again, and touches new ones.
void keep_freed_heap() {
#if defined(__GLIBC__)
    constexpr int k_own_mapping = 4 << 20;  // bytes of a block that is none of the heap's
    mallopt(M_MMAP_THRESHOLD, k_own_mapping);
    mallopt(M_TRIM_THRESHOLD, static_cast<int>(default_freed_memory()));
#endif
}

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

/// Insertions, deletions and replacements that make one text of the other (Levenshtein 1966).
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j)
            diagonal =
                std::exchange(row[j + 1], std::min({row[j + 1] + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)}));
    }
    return row.back();
}

/// "; did you mean NAME?" for the nearest of the names that is near enough, or nothing.
std::string suggestion(std::string_view text, const std::vector<std::string>& names) {
    constexpr std::size_t k_telling = 3;  // so many first letters are an abbreviation
    const auto distance = [&](std::string_view name) {
        return text.size() >= k_telling && name.starts_with(text) ? 0 : edit_distance(text, name);
    };
    const auto nearest = std::min_element(names.begin(), names.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    return nearest != names.end() && 3 * distance(*nearest) <= text.size() ? "; did you mean " + *nearest + "?" : "";
}

std::string suggested_command(CLI::App& app, const std::string& text) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
        names.push_back(command->get_name());
    if (text.ends_with(".obj")) return "; did you mean tetrakis tessellate " + text + "?";
    return suggestion(text, names);
}

/// For the first unknown option among the arguments that the parser has left over.
std::string suggested_option(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& text : command.remaining())
        if (text.starts_with("-")) return suggestion(text.substr(0, text.find('=')), names);
    return {};
}

/// Puts the parser's own exit codes (0 for help and version, else 100 and above) into ours.
ExitCode finish_parse(const CLI::App& app, const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
        app.exit(error);
        return flush_output() ? ExitCode::done : ExitCode::failure;
    }
    const auto commands = app.get_subcommands();
    const std::string command = commands.empty() ? "tetrakis" : "tetrakis " + commands.front()->get_name();
    const std::string advice = commands.empty() ? "" : suggested_option(*commands.front());
    print_error(error.what() + advice + "; " + command + " --help says what there is");
    return ExitCode::usage;
}

}  // namespace
}  // namespace tetrakis::cli

int main(int argc, char** argv) {
    using namespace tetrakis::cli;
    keep_freed_heap();
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
    add_terrain_command(app, chosen);
    add_tiles_command(app, chosen);
    add_lod_command(app, chosen);
    add_compare_command(app, chosen);
    add_render_command(app, chosen);
    add_scheme_command(app, chosen);
    add_schemes_command(app, chosen);
    if (argc > 1 && argv[1][0] != '-' &&
        app.get_subcommands([&](CLI::App* command) { return command->check_name(argv[1]); }).empty()) {
        print_error(std::string(argv[1]) + " is no command" + suggested_command(app, argv[1]) +
                    "; tetrakis --help says what there is");
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
