#pragma once

#include "scratch_dir.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

/// Result of a program that has ended: exit code (128 + n if signal n ended it) and output.
struct ProcessResult {
    int code = -1;
    std::string out, err;
};

/// A running program with its own standard output and error.
class Process {
  public:
    /// @param arguments  the program's path, then its arguments
    explicit Process(const std::vector<std::string>& arguments, const std::string& directory = ".") {
        std::vector<char*> argv;
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        const std::string out = (scratch_ / "out").string(), err = (scratch_ / "err").string();
        int starting[2];  // pipe whose writing end execv() closes, so that the parent notices the start
        if (::pipe2(starting, O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe");
        id_ = ::fork();
        if (id_ != 0) ::close(starting[1]);
        if (id_ > 0) {
            // Wait for execv(): before it, the child has the signal handlers of the tests.
            char none;
            while (::read(starting[0], &none, 1) < 0 && errno == EINTR) {
            }
        }
        if (id_ != 0) ::close(starting[0]);
        if (id_ < 0) throw std::runtime_error("cannot fork");
        if (id_ > 0) return;
        std::signal(SIGINT, SIG_DFL);
        const int null = ::open("/dev/null", O_RDONLY);
        const int o = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        const int e = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        if (::dup2(null, 0) < 0 || ::dup2(o, 1) < 0 || ::dup2(e, 2) < 0 || ::chdir(directory.c_str()) != 0)
            ::_exit(126);
        ::execv(argv[0], argv.data());
        ::_exit(127);
    }
    ~Process() {
        if (id_ > 0) {
            ::kill(id_, SIGKILL);
            ::waitpid(id_, nullptr, 0);
        }
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    /// Waits until the program has a handler for the signal. False if it ends before.
    bool wait_for_handler(int signal) const {
        for (;;) {
            std::ifstream status("/proc/" + std::to_string(id_) + "/status");
            bool alive = false;
            for (std::string line; std::getline(status, line);) {
                if (line.starts_with("State:")) alive = line.find('Z') == std::string::npos;
                if (line.starts_with("SigCgt:") && (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0)
                    return true;
            }
            if (!alive) return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    }
    /// Waits until the program has used 0.2 s of CPU time, which does not depend on the load of the machine. False if
    /// it ends before.
    bool wait_for_work() const {
        const long ticks = ::sysconf(_SC_CLK_TCK) / 5;
        for (;;) {
            std::ifstream file("/proc/" + std::to_string(id_) + "/stat");
            std::string text, state, skipped;
            std::getline(file, text);
            std::istringstream words(text.substr(std::min(text.size(), text.rfind(')') + 1)));
            words >> state;
            for (int k = 0; k < 10; ++k) words >> skipped;
            long user = 0, system = 0;
            if (!(words >> user >> system) || state == "Z") return false;
            if (user + system >= ticks) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    }
    void send(int signal) const { ::kill(id_, signal); }

    ProcessResult wait() {
        int status = 0;
        while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
        }
        id_ = -1;
        return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(scratch_ / "out"),
                slurp(scratch_ / "err")};
    }

  private:
    ScratchDir scratch_;
    ::pid_t id_ = -1;
};

inline ProcessResult run_process(const std::vector<std::string>& arguments, const std::string& directory = ".") {
    return Process(arguments, directory).wait();
}

// Runs the program that was built.
namespace cli {

/// Path of the program in the same build tree as this test (which is in its folder tests/).
inline std::string program() {
    return (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "tetrakis").string();
}

using Words = std::vector<std::string>;

/// Concatenation of both lists.
inline Words join(Words first, const Words& then) {
    first.insert(first.end(), then.begin(), then.end());
    return first;
}

inline Words command_line(const Words& arguments) { return join({program()}, arguments); }

inline ProcessResult run(const Words& arguments) { return run_process(command_line(arguments)); }

/// Runs the program and parses its output as JSON. The test fails unless the program succeeds.
inline nlohmann::json run_json(const Words& arguments) {
    const ProcessResult result = run(arguments);
    CAPTURE(result.err);
    REQUIRE(result.code == 0);
    return nlohmann::json::parse(result.out);
}

/// As run_json(), but parses the report that the program writes.
inline nlohmann::json run_report(const Words& arguments) {
    const ScratchDir scratch;
    const ProcessResult result = run(join(arguments, {"--report", (scratch / "report.json").string()}));
    CAPTURE(result.err);
    REQUIRE(result.code == 0);
    return nlohmann::json::parse(slurp(scratch / "report.json"));
}

inline std::string data(const std::string& name) { return std::string(TETRAKIS_SOURCE_DIR) + "/data/" + name; }

/// Runs the program and checks that it prints a message with these words and nothing else, and ends with `code`.
inline std::string check_refused(const Words& arguments, int code, const std::string& words) {
    CAPTURE(arguments);
    const ProcessResult result = run(arguments);
    CAPTURE(result.err);
    CHECK(result.code == code);
    CHECK(result.err.starts_with("tetrakis: error: "));
    CHECK(result.err.find(words) != std::string::npos);
    CHECK(result.out.empty());
    return result.err;
}

}  // namespace cli
