#include "run_options.hpp"

#include "../../eval/tessellate/tessellate.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/rule_options.hpp"
#include "console.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

void add_bytes_option(CommandLine command, const std::string& name, std::uint64_t& bytes, const std::string& help) {
    const auto take = [&bytes](const std::string& text) {
        constexpr double k_binary_thousand = 1024;
        const auto size = parse_size(text, k_binary_thousand);
        if (size) bytes = *size;
        return size ? "" : text + " is no size such as 500M or 2G";
    };
    command.option_function(name, "BYTES", take, help);
}

void RunOptions::add(CommandLine command) {
    command.option("--threads", "N", threads, "How many threads to use; default: one for each processor")
        .range(1, 1024, Option::InHelp::yes);
    add_bytes_option(command, "--max-memory", max_memory_bytes,
                     "Stop with an error rather than use more than this (500M, 2G); default: 80 % of what is free");
}

int RunOptions::thread_count() const { return threads > 0 ? threads : oneapi::tbb::this_task_arena::max_concurrency(); }

Run::Run(const RunOptions& options)
    : threads_(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.thread_count())) {
    context_.threads = options.threads;
    if (options.max_memory_bytes != 0 && options.max_memory_bytes >> 20 == 0)
        throw UsageError("--max-memory: 1M is the least");
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

namespace {

/// Parses numbers with one separator between them; nothing if the text is anything else.
template <class T>
std::optional<std::vector<T>> split_numbers(std::string_view text, char separator) {
    std::vector<T> numbers;
    for (const char *at = text.data(), *const end = at + text.size();; ++at) {
        T number{};
        const auto [rest, error] = std::from_chars(at, end, number);
        if (error != std::errc{}) return std::nullopt;
        numbers.push_back(number);
        if (rest == end) return numbers;
        if (*rest != separator) return std::nullopt;
        at = rest;
    }
}

}  // namespace

std::optional<std::vector<double>> finite_numbers(std::string_view text, std::size_t count) {
    auto numbers = split_numbers<double>(text, ',');
    if (!numbers || numbers->size() != count) return std::nullopt;
    for (const double number : *numbers)
        if (!std::isfinite(number)) return std::nullopt;
    return numbers;
}

std::optional<std::array<int, 2>> parse_counts(std::string_view text, int most) {
    const auto counts = split_numbers<int>(text, 'x');
    if (!counts || counts->size() != 2) return std::nullopt;
    for (const int count : *counts)
        if (count < 1 || count > most) return std::nullopt;
    return std::array{(*counts)[0], (*counts)[1]};
}

void add_size_option(CommandLine command, RenderOptions& render) {
    const auto take = [&render](const std::string& text) -> std::string {
        constexpr int k_largest_side = 16384;
        const auto sides = parse_counts(text, k_largest_side);
        if (!sides) return text + " is no size such as 1200x900";
        render.width = (*sides)[0];
        render.height = (*sides)[1];
        return {};
    };
    command.option_function(
        "--size", "WxH", take,
        fmt::format("Width and height of the picture in pixels; default: {}x{}", render.width, render.height));
}

void add_view_options(CommandLine command, RenderOptions& render) {
    add_size_option(command, render);
    const auto take_camera = [&render](const std::string& text) -> std::string {
        const auto angles = finite_numbers(text, 2);
        if (!angles || std::abs((*angles)[1]) > 90)
            return text + " is no pair of degrees such as 32,20 (elevation -90 to 90)";
        render.view.azimuth_degrees = std::remainder((*angles)[0], 360.0);
        render.view.elevation_degrees = (*angles)[1];
        return {};
    };
    command.option_function(
        "--camera", "AZIMUTH,ELEVATION", take_camera,
        "Where to look from, in degrees: turned about the model from its front, then raised; default: 32,20");
    const auto take_up = [&render](const std::string& axis) {
        render.view.up = axis == "z" ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
        return axis == "y" || axis == "z" ? "" : axis + " not in {y,z}";
    };
    command.option_function("--up", "AXIS", take_up, "The model's axis that points upwards: y (default) or z");
}

std::string given_view_option(const CommandLine& command) {
    for (const char* name : {"--size", "--camera", "--up"})
        if (command.given(name)) return name;
    return {};
}

namespace {

/// Parses a finite number from `low` to `high` into `to`. Returns an error message, or an empty text.
template <class Number>
std::string set_number(Number& to, const std::string& text, double low = -HUGE_VAL, double high = HUGE_VAL) {
    const std::optional<double> x = finite_number(text);
    if (!x || *x < low || *x > high)
        return text + (std::isfinite(low) ? fmt::format(" is not a number from {} to {}", low, high)
                                          : std::string(" is not a finite number"));
    to = *x;
    return {};
}

std::string set_edge_rule(RuleOptions& rules, const std::string& text) {
    if (text == "plain")
        rules.edge_beside_crease = EdgeBesideCrease::plain;
    else if (text == "cosine")
        rules.edge_beside_crease = EdgeBesideCrease::cosine;
    else if (text == "brief")
        rules.edge_beside_crease = EdgeBesideCrease::brief;
    else
        return text + " is none of plain, cosine and brief";
    return {};
}

std::string set_corner_angle(RuleOptions& rules, const std::string& text) {
    rules.measure_corner_angles = text == "measured";
    if (rules.measure_corner_angles) return {};
    const double degrees = finite_number(text).value_or(0);
    if (!(degrees >= 1 && degrees <= 359 && degrees != 180))
        return text + " is neither measured nor a number of degrees from 1 to 359 other than 180";
    rules.corner_angle = degrees * std::numbers::pi / 180;
    return {};
}

std::string set_steps(RuleOptions& rules, const std::string& text) {
    const double steps = finite_number(text).value_or(-1);
    if (steps != std::floor(steps) || steps < 0 || steps > k_most_averaging_steps)
        return fmt::format("{}: averaging takes 0 to {}", text, k_most_averaging_steps);
    rules.averaging_steps = static_cast<int>(steps);
    return {};
}

using Text = std::string;
const RuleOptions k_plain;

constexpr RuleOption k_rule_options[] = {
    {k_steps_option, "averaging", "number of steps (3)", "M", set_steps,
     [](RuleOptions& o) { o.averaging_steps = k_plain.averaging_steps; }},
    {"--tuning", "tuned-loop", "0 (loop) to 1 (the default)", "T",
     [](RuleOptions& o, const Text& text) { return set_number(o.tuning, text, 0, 1); },
     [](RuleOptions& o) { o.tuning = k_plain.tuning; }},
    {"--edge-rule", "loop, tuned-loop, catmull-clark", "edges beside creases: plain, cosine or brief", "R",
     set_edge_rule, [](RuleOptions& o) { o.edge_beside_crease = EdgeBesideCrease::plain; }},
    {"--beta", "catmull-clark", "total weight of the edge neighbours at extraordinary vertices between quads", "B",
     [](RuleOptions& o, const Text& text) { return set_number(o.catmull_clark_beta, text); },
     [](RuleOptions& o) { o.catmull_clark_beta.reset(); }},
    {"--gamma", "catmull-clark", "that of the opposite corners", "G",
     [](RuleOptions& o, const Text& text) { return set_number(o.catmull_clark_gamma, text); },
     [](RuleOptions& o) { o.catmull_clark_gamma.reset(); }},
    {"--corner-angle", "loop, tuned-loop, catmull-clark",
     "interior angle at corners without a tag of their own, in degrees, or measured: in the control mesh", "A",
     set_corner_angle,
     [](RuleOptions& o) {
         o.corner_angle = 0;
         o.measure_corner_angles = false;
     }},
    {"--warren", "loop", "Warren's weights", "",
     [](RuleOptions& o, const Text&) { return o.loop_weights = LoopWeights::warren, Text(); },
     [](RuleOptions& o) { o.loop_weights = LoopWeights::loop; }},
    {"--hoppe", "loop", "Hoppe's crease rule", "",
     [](RuleOptions& o, const Text&) { return o.hoppe_crease = true, Text(); },
     [](RuleOptions& o) { o.hoppe_crease = false; }},
    {"--reflect", "modified-butterfly", "points beyond the boundary by reflection", "",
     [](RuleOptions& o, const Text&) { return o.reflect_at_boundary = true, Text(); },
     [](RuleOptions& o) { o.reflect_at_boundary = false; }},
    {"--ten-point", "butterfly, modified-butterfly",
     "tension w of the ten-point rule at regular edges, -0.06 to 0.04 (0: eight points)", "W",
     [](RuleOptions& o, const Text& text) { return set_number(o.butterfly_w, text, -0.06, 0.04); },
     [](RuleOptions& o) { o.butterfly_w = k_plain.butterfly_w; }},
    {k_recede_option, "biquartic, averaging", "use up the outer ring of an open mesh instead of copying it", "",
     [](RuleOptions& o, const Text&) { return o.averaging_boundary = AveragingBoundary::recede, Text(); },
     [](RuleOptions& o) { o.averaging_boundary = AveragingBoundary::replicate; }},
};

}  // namespace

std::span<const RuleOption> rule_options() { return k_rule_options; }

void add_rule_options(CommandLine command, RuleOptions& rules, StepsOption steps) {
    for (const RuleOption& option : rule_options()) {
        if (option.flag == k_steps_option && steps == StepsOption::leave_out) continue;
        const std::string flag(option.flag), help = fmt::format("{}: {}", option.users, option.help);
        if (option.type_name.empty())
            command.flag_function(
                flag, [&rules, &option] { option.set(rules, {}); }, help);
        else
            command.option_function(
                flag, std::string(option.type_name),
                [&rules, &option](const std::string& text) { return option.set(rules, text); }, help);
    }
}

std::vector<std::string> unused_rule_options(const RuleOptions& rules, const SchemeInfo& scheme,
                                             std::string_view steps_option) {
    std::vector<std::string> warnings;
    for (const RuleOption& option : rule_options()) {
        RuleOptions without = rules;
        option.reset(without);
        const bool used = fmt::format(", {},", option.users).find(fmt::format(", {},", scheme.name)) != Text::npos;
        if (!used && rule_choices(without) != rule_choices(rules))
            warnings.push_back(fmt::format("{} has no effect on {}",
                                           option.flag == k_steps_option ? steps_option : option.flag, scheme.name));
    }
    return warnings;
}

std::string certified_scheme_names() {
    std::string names;
    for (const SchemeInfo& scheme : scheme_table()) {
        const bool plain = scheme_support(scheme.name).certified;
        if (!plain && !scheme_support(scheme.name, {.averaging_steps = 2}).certified) continue;
        names +=
            fmt::format("{}{}{}", names.empty() ? "" : ", ", scheme.name, plain ? "" : " (even --steps from 2 on)");
    }
    return names;
}

const SchemeInfo& chosen_scheme(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    try {
        return scheme_named(text);
    } catch (const Error& error) {
        throw UsageError(error.what());
    }
}

}  // namespace tetrakis::cli
