#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

// CLI11 reads the command line. It takes long to compile, so command_line.cpp alone includes it.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tetrakis::cli {

/// Exit codes of the program. The numbers are documented in the README and must not change.
enum class ExitCode {
    done = 0,
    failure = 1,                ///< at run time: disk full, out of memory, ...
    usage = 2,                  ///< the command line is wrong
    bad_input = 3,              ///< an input file is missing or wrong
    tolerance_not_reached = 4,  ///< the best result is still written
    cancelled = 130,            ///< 128 + SIGINT
};

/// The command line is wrong in a way that the option parser cannot detect.
class UsageError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An input file is missing, unreadable or wrong.
class InputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Parses a number. Nothing if the text is no number or not a finite one.
std::optional<double> finite_number(const std::string& text);

/// One option of a command.
class Option {
  public:
    explicit Option(CLI::Option* option) : option_(option) {}

    Option required(bool yes = true) const;
    /// The help text shows the default value.
    Option shows_default() const;
    /// The option may be given without a value, which then means `value`.
    Option value_or(const std::string& value) const;
    enum class InHelp { no, yes };
    template <class T>
    Option range(T least, T most, InHelp shown = InHelp::no) const;
    /// The value must be a finite number for which `is_of_kind` holds (the parser itself accepts "nan").
    /// @param kind  name of such numbers in the error message, with its article
    Option number(const std::string& kind, bool (*is_of_kind)(double)) const;
    Option positive() const;
    /// With this option, the option named `other` must (or must not) be given. The command must have it already.
    Option needs(const std::string& other) const;
    Option excludes(const std::string& other) const;

  private:
    CLI::Option* option_;
};

/// Options of a program or of one of its commands. Copies refer to the same command line.
class CommandLine {
  public:
    CommandLine(CLI::App& app, std::function<ExitCode()>& chosen) : app_(&app), chosen_(&chosen) {}

    /// An option with a value. @param type  name of the value in the help text; empty for positional arguments
    template <class T>
    Option option(const std::string& names, const std::string& type, T& to, const std::string& help);
    /// @param take  parses the value; returns an error message, or an empty text
    Option option_function(const std::string& names, const std::string& type,
                           std::function<std::string(const std::string&)> take, const std::string& help);
    Option flag(const std::string& names, bool& to, const std::string& help);
    Option flag_function(const std::string& names, std::function<void()> take, const std::string& help);
    /// A group of options of which at most one may be given.
    CommandLine at_most_one(const std::string& name, const std::string& help);
    /// Adds a command to the program. @param last  the end of its help text
    CommandLine command(const std::string& name, const std::string& help, const std::string& last);
    /// Sets the work of this command, which Program::run() does after parsing.
    void runs(std::function<ExitCode()> work);

    bool given(const std::string& option) const;

  private:
    CLI::App* app_;
    std::function<ExitCode()>* chosen_;
};

/// A program with its command line.
class Program {
  public:
    /// @param last  the end of its help text
    Program(const std::string& name, const std::string& description, const std::string& last);
    ~Program();
    CommandLine line() { return {*app_, chosen_}; }
    /// Parses the command line, runs the chosen command and prints its errors. @returns the exit code
    int run(int argc, char** argv);

  private:
    std::unique_ptr<CLI::App> app_;
    std::function<ExitCode()> chosen_;
};

}  // namespace tetrakis::cli
