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

/// What the program's exit code says. The numbers are documented in the README and do not change.
enum class ExitCode {
    done = 0,
    failure = 1,                ///< at run time: disk full, out of memory, ...
    usage = 2,                  ///< the command line makes no sense
    bad_input = 3,              ///< an input file is missing or wrong
    tolerance_not_reached = 4,  ///< the best result is written all the same
    cancelled = 130,            ///< 128 + SIGINT
};

/// The command line makes no sense, in a way that the option parser cannot see.
class UsageError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An input file is missing, unreadable or wrong.
class InputError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The number that a text is; nothing where it is none, or not finite.
std::optional<double> finite_number(const std::string& text);

/// One option of a command.
class Option {
  public:
    explicit Option(CLI::Option* option) : option_(option) {}

    Option required(bool yes = true) const;
    /// The default value stands in the help text.
    Option shows_default() const;
    /// It may stand without its value, which is this one then.
    Option value_or(const std::string& value) const;
    enum class InHelp { no, yes };
    template <class T>
    Option range(T least, T most, InHelp shown = InHelp::no) const;
    /// It is a finite number of some kind (the parser itself takes "nan").
    /// @param kind  how the refusal calls it, with its article
    Option number(const std::string& kind, bool (*is_of_kind)(double)) const;
    Option positive() const;
    /// Another option, by its name, must be or must not be there, too. It is one that the command has already.
    Option needs(const std::string& other) const;
    Option excludes(const std::string& other) const;

  private:
    CLI::Option* option_;
};

/// The options of a program or of one of its commands. A copy is the same command line.
class CommandLine {
  public:
    CommandLine(CLI::App& app, std::function<ExitCode()>& chosen) : app_(&app), chosen_(&chosen) {}

    /// An option with a value. @param type  how the help text calls the value; empty: the first value without a name
    template <class T>
    Option option(const std::string& names, const std::string& type, T& to, const std::string& help);
    /// @param take  reads the value; returns why it is refused, or an empty text
    Option option_function(const std::string& names, const std::string& type,
                           std::function<std::string(const std::string&)> take, const std::string& help);
    Option flag(const std::string& names, bool& to, const std::string& help);
    Option flag_function(const std::string& names, std::function<void()> take, const std::string& help);
    /// A group of options of which at most one may be there.
    CommandLine at_most_one(const std::string& name, const std::string& help);
    /// A command of the program. @param last  the end of its help text
    CommandLine command(const std::string& name, const std::string& help, const std::string& last);
    /// The work to do after the command line has been parsed.
    void runs(std::function<ExitCode()> work);

    bool given(const std::string& option) const;

  private:
    CLI::App* app_;
    std::function<ExitCode()>* chosen_;
};

/// A whole program.
class Program {
  public:
    /// @param last  the end of its help text
    Program(const std::string& name, const std::string& description, const std::string& last);
    ~Program();
    CommandLine line() { return {*app_, chosen_}; }
    /// Parses the command line and runs what it asks for, its errors said. @returns the exit code
    int run(int argc, char** argv);

  private:
    std::unique_ptr<CLI::App> app_;
    std::function<ExitCode()> chosen_;
};

}  // namespace tetrakis::cli
