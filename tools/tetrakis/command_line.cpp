#include "command_line.hpp"

#include "console.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/version.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <numeric>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis::cli {

std::optional<double> finite_number(const std::string& text) {
    double x = 0;
    return CLI::detail::lexical_cast(text, x) && std::isfinite(x) ? std::optional(x) : std::nullopt;
}

Option Option::required(bool yes) const { return Option(option_->required(yes)); }
Option Option::shows_default() const { return Option(option_->capture_default_str()); }
Option Option::value_or(const std::string& value) const { return Option(option_->expected(0, 1)->default_str(value)); }
Option Option::needs(const std::string& other) const { return Option(option_->needs(other)); }
Option Option::excludes(const std::string& other) const { return Option(option_->excludes(other)); }

template <class T>
Option Option::range(T least, T most, InHelp shown) const {
    CLI::Validator check = CLI::Range(least, most);
    if (shown == InHelp::no) check.description("");
    return Option(option_->check(std::move(check)));
}
template Option Option::range(int, int, InHelp) const;
template Option Option::range(std::uint32_t, std::uint32_t, InHelp) const;
template Option Option::range(std::uint64_t, std::uint64_t, InHelp) const;

Option Option::number(const std::string& kind, bool (*is_of_kind)(double)) const {
    return Option(option_->check(CLI::Validator(
        [kind, is_of_kind](const std::string& text) {
            const std::optional<double> x = finite_number(text);
            return x && is_of_kind(*x) ? std::string() : text + " is not " + kind;
        },
        "")));
}
Option Option::positive() const {
    return number("a positive number", [](double x) { return x > 0; });
}

template <class T>
Option CommandLine::option(const std::string& names, const std::string& type, T& to, const std::string& help) {
    CLI::Option* const option = app_->add_option(names, to, help)->type_name(type);
    if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>)
        option->check([app = app_](const std::string& text) {
            const bool other = text.starts_with("-") && app->get_option_no_throw(text) != nullptr;
            return other ? "its value is missing: " + text + " is an option" : std::string();
        });
    return Option(option);
}
#define TETRAKIS_OPTION(T) \
    template Option CommandLine::option(const std::string&, const std::string&, T&, const std::string&);
TETRAKIS_OPTION(int)
TETRAKIS_OPTION(std::uint32_t)
TETRAKIS_OPTION(std::uint64_t)
TETRAKIS_OPTION(double)
TETRAKIS_OPTION(std::string)
TETRAKIS_OPTION(std::filesystem::path)
TETRAKIS_OPTION(std::vector<std::filesystem::path>)
TETRAKIS_OPTION(std::optional<int>)
TETRAKIS_OPTION(std::optional<std::uint64_t>)
TETRAKIS_OPTION(std::optional<float>)
TETRAKIS_OPTION(std::optional<double>)
#undef TETRAKIS_OPTION

Option CommandLine::option_function(const std::string& names, const std::string& type,
                                    std::function<std::string(const std::string&)> take, const std::string& help) {
    const auto set = [names, take = std::move(take)](const std::string& text) {
        if (const std::string wrong = take(text); !wrong.empty()) throw CLI::ValidationError(names, wrong);
    };
    return Option(app_->add_option_function<std::string>(names, set, help)->type_name(type));
}
Option CommandLine::flag(const std::string& names, bool& to, const std::string& help) {
    return Option(app_->add_flag(names, to, help));
}
Option CommandLine::flag_function(const std::string& names, std::function<void()> take, const std::string& help) {
    return Option(app_->add_flag_callback(names, std::move(take), help));
}
CommandLine CommandLine::at_most_one(const std::string& name, const std::string& help) {
    CLI::Option_group* group = app_->add_option_group(name, help);
    group->require_option(0, 1);
    return {*group, *chosen_};
}
CommandLine CommandLine::command(const std::string& name, const std::string& help, const std::string& last) {
    app_->require_subcommand(1);
    CLI::App* command = app_->add_subcommand(name, help);
    command->footer(last);
    return {*command, *chosen_};
}
void CommandLine::runs(std::function<ExitCode()> work) {
    app_->callback([work = std::move(work), chosen = chosen_] { *chosen = work; });
}
bool CommandLine::given(const std::string& option) const { return app_->count(option) != 0; }

namespace {

ExitCode exit_code_of(const Error& error) {
    return error.code() == ErrorCode::invalid_input ? ExitCode::bad_input
           : error.code() == ErrorCode::cancelled   ? ExitCode::cancelled
                                                    : ExitCode::failure;
}

ExitCode run_command(const std::function<ExitCode()>& command) {
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

/// Number of insertions, deletions and replacements that turn one text into the other (Levenshtein 1966).
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

/// "; did you mean NAME?" for the nearest name, or an empty text if none is near enough.
std::string suggestion(std::string_view text, const std::vector<std::string>& names) {
    constexpr std::size_t k_telling = 3;  // letters that an abbreviation has at least
    const auto distance = [&](std::string_view name) {
        return text.size() >= k_telling && name.starts_with(text) ? 0 : edit_distance(text, name);
    };
    const auto nearest = std::min_element(names.begin(), names.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    return nearest != names.end() && 3 * distance(*nearest) <= text.size() ? "; did you mean " + *nearest + "?" : "";
}

std::vector<std::string> command_names(CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

/// suggestion() for the first unknown option among the arguments that the parser has left over.
std::string suggested_option(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& text : command.remaining())
        if (text.starts_with("-")) return suggestion(text.substr(0, text.find('=')), names);
    return {};
}

/// Converts the parser's exit codes (0 for help and version, else 100 and above) into the program's.
ExitCode finish_parse(const CLI::App& app, const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
        app.exit(error);
        return flush_output() ? ExitCode::done : ExitCode::failure;
    }
    const auto commands = app.get_subcommands();
    const CLI::App& command = commands.empty() ? app : *commands.front();
    print_error(fmt::format("{}{}; {}{} --help says what there is", error.what(), suggested_option(command),
                            app.get_name(), commands.empty() ? "" : " " + command.get_name()));
    return ExitCode::usage;
}

}  // namespace

Program::Program(const std::string& name, const std::string& description, const std::string& last)
    : app_(std::make_unique<CLI::App>(description, name)) {
    app_->set_version_flag("--version", name + " " + std::string(k_version));
    app_->footer(last);
}
Program::~Program() = default;

int Program::run(int argc, char** argv) {
    const std::vector<std::string> names = command_names(*app_);
    const std::string first = argc > 1 ? argv[1] : "";
    if (argc > 1 && !names.empty() && !first.starts_with('-') && std::ranges::count(names, first) == 0) {
        print_error(first + " is no command" +
                    (first.ends_with(".obj") ? "; did you mean " + app_->get_name() + " tessellate " + first + "?"
                                             : suggestion(first, names)) +
                    "; " + app_->get_name() + " --help says what there is");
        return static_cast<int>(ExitCode::usage);
    }
    try {
        app_->parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return static_cast<int>(finish_parse(*app_, error));
    }
    catch_interrupts();
    ExitCode code = run_command(chosen_);
    if (code != ExitCode::cancelled && !flush_output()) {
        print_error("cannot write to standard output");
        if (code == ExitCode::done) code = ExitCode::failure;
    }
    return static_cast<int>(code);
}

}  // namespace tetrakis::cli
