#include "scheme_option.hpp"

#include "tetrakis/hier/triangulate.hpp"

#include <string>
#include <vector>

namespace tetrakis::cli {

void add_scheme_option(CLI::App& command, SchemeKind& scheme) {
    std::vector<std::string> names;
    for (const SchemeKind kind : {SchemeKind::catmull_clark, SchemeKind::loop}) names.emplace_back(name(kind));
    command
        .add_option_function<std::string>(
            "--scheme", [&scheme](const std::string& text) { scheme = scheme_from_name(text).value(); },
            "Subdivision scheme: catmull-clark (any polygons; the default) or loop (triangles)")
        ->type_name("S")
        ->check(CLI::IsMember(names).description(""));
}

void prepare_for(SchemeKind scheme, ControlMesh& mesh, const RunContext& context) {
    if (scheme == SchemeKind::loop && !mesh.all_triangles()) mesh = triangulate(mesh, context);
}

}  // namespace tetrakis::cli
