#include "../commands.hpp"
#include "../report.hpp"

#include "../../../schemes/core/scheme_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

namespace tetrakis::cli {
namespace {

ExitCode print_json() {
    Json list = Json::array();
    for (const SchemeInfo& s : scheme_table())
        list.push_back({{"name", s.name},
                        {"title", s.title},
                        {"refinement", name(s.refinement)},
                        {"faces", name(s.family)},
                        {"interpolating", s.interpolating},
                        {"smoothness", s.smoothness},
                        {"reproduction_degree", s.reproduction},
                        {"generation_degree", s.generation},
                        {"notes", s.notes}});
    fmt::print("{}", dump(list));
    return ExitCode::done;
}

ExitCode print_table() {
    std::size_t width = 0;
    for (const SchemeInfo& s : scheme_table()) width = std::max(width, s.name.size());
    fmt::print("{:<{}}  {:<12}  {:<8}  {:<13}  {:<10}  what it takes\n", "name", width, "refinement", "faces", "",
               "smoothness");
    for (const SchemeInfo& s : scheme_table())
        fmt::print("{:<{}}  {:<12}  {:<8}  {:<13}  {:<10}  {}\n", s.name, width, name(s.refinement), name(s.family),
                   s.interpolating ? "interpolating" : "approximating", s.smoothness.substr(0, s.smoothness.find(' ')),
                   s.notes);
    fmt::print("\nSmoothness: on regular meshes. \"tetrakis scheme NAME\" explains one.\n");
    return ExitCode::done;
}

}  // namespace

void add_schemes_command(CLI::App& app, Command& chosen) {
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand("schemes", "Lists the subdivision schemes");
    command->add_flag("--json", *json, "Print JSON");
    command->footer("Example:\n  tetrakis schemes");
    command->callback([json, &chosen] { chosen = [json] { return *json ? print_json() : print_table(); }; });
}

}  // namespace tetrakis::cli
