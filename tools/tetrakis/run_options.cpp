#include "run_options.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace tetrakis::cli {

std::optional<std::uint64_t> parse_size(std::string_view text, double thousand) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
    if (error != std::errc{} || !(number >= 0)) return std::nullopt;
    std::string unit(end, text.data() + text.size());
    for (char& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (unit.ends_with("IB"))
        unit.resize(unit.size() - 2);
    else if (unit.ends_with("B"))
        unit.pop_back();
    constexpr std::string_view k_units = "KMGT";
    const std::size_t power = unit.empty() ? 0 : k_units.find(unit) + 1;
    if (unit.size() > 1 || (!unit.empty() && power == 0)) return std::nullopt;
    const double size = std::floor(number * std::pow(thousand, power));
    if (size < 1 || size >= 0x1p63) return std::nullopt;
    return static_cast<std::uint64_t>(size);
}

CLI::Validator number_check(const std::string& kind, bool (*is_of_kind)(double)) {
    return CLI::Validator(
        [kind, is_of_kind](const std::string& text) {
            double x = 0;
            return CLI::detail::lexical_cast(text, x) && std::isfinite(x) && is_of_kind(x) ? std::string()
                                                                                           : text + " is not " + kind;
        },
        "");
}

void RunOptions::add_threads(CLI::App& command) {
    constexpr int k_most_threads = 1024;
    command.add_option("--threads", threads, "How many threads to use; default: one for each processor")
        ->type_name("N")
        ->check(CLI::Range(1, k_most_threads));
}

void RunOptions::add_max_memory(CLI::App& command) {
    command
        .add_option_function<std::string>(
            "--max-memory",
            [this](const std::string& text) {
                const auto bytes = parse_size(text, k_binary_thousand);
                if (!bytes) throw CLI::ValidationError("--max-memory", text + " is no size such as 500M or 2G");
                max_memory_bytes = *bytes;
            },
            "Stop with an error rather than use more than this (500M, 2G); default: 80 % of what is free")
        ->type_name("BYTES");
}

int RunOptions::thread_count() const { return threads > 0 ? threads : oneapi::tbb::this_task_arena::max_concurrency(); }

Run::Run(const RunOptions& options)
    : threads_(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.thread_count())) {
    context_.threads = options.threads;
    constexpr std::uint64_t k_default_percent = 80;
    context_.max_memory_bytes =
        options.max_memory_bytes != 0 ? options.max_memory_bytes : free_memory_bytes() / 100 * k_default_percent;
    context_.progress = [this](std::string_view stage, double fraction) {
        stop_above_limit();
        return progress_.update(stage, fraction);
    };
}

void Run::stop_above_limit() {
    constexpr auto k_between_looks = std::chrono::milliseconds(5);
    const auto now = std::chrono::steady_clock::now();
    if (context_.max_memory_bytes == 0 || now - last_look_ < k_between_looks) return;
    last_look_ = now;
    const std::uint64_t bytes = memory_bytes();
    if (bytes > context_.max_memory_bytes)
        throw Error(ErrorCode::memory_limit,
                    fmt::format("{} MiB of memory are in use, and the limit is {} MiB; raise --max-memory, or ask for "
                                "less (a larger tolerance, fewer levels)",
                                bytes >> 20, context_.max_memory_bytes >> 20));
}

std::uint64_t memory_bytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t all = 0, resident = 0;
    if (!(file >> all >> resident)) return 0;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::uint64_t free_memory_bytes() {
    std::ifstream file("/proc/meminfo");
    constexpr std::uint64_t k_unit = 1024;  // the file counts in KiB
    std::string key;
    for (std::uint64_t number = 0; file >> key >> number;
         file.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
        if (key == "MemAvailable:") return number * k_unit;
    return 0;
}

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    constexpr std::uint64_t k_unit = 1024;  // Linux counts it in KiB
    return static_cast<std::uint64_t>(usage.ru_maxrss) * k_unit;
}

}  // namespace tetrakis::cli
