#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../hier/base/vec.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

namespace tetrakis::cli {
namespace {

struct InfoOptions {
    std::filesystem::path input;
    ReadOptions read;
    bool json = false;
};

/// Summary of a control mesh.
struct MeshStatistics {
    std::map<std::uint32_t, std::uint64_t> faces_by_size;
    std::map<std::uint32_t, std::uint64_t> interior_vertices_by_valence;
    std::uint64_t boundary_edges = 0, boundary_loops = 0;
    std::uint64_t pieces = 0;  ///< connected components
    std::int64_t euler_characteristic = 0;
    std::uint64_t sharp_edges = 0, semi_sharp_edges = 0;        ///< inside the surface; the boundary is not counted
    std::uint64_t sharp_vertices = 0, semi_sharp_vertices = 0;  ///< tagged as corners
    std::uint64_t holes = 0, isolated_vertices = 0;
};

/// Follows each boundary loop once: from a half-edge without a twin to the one that starts at its target.
std::uint64_t count_boundary_loops(const ControlMesh& mesh) {
    std::vector<bool> seen(mesh.halfedge_count(), false);
    std::uint64_t loops = 0;
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        HalfedgeId h(i);
        if (seen[i] || mesh.twin(h).valid()) continue;
        ++loops;
        while (!seen[h.value]) {
            seen[h.value] = true;
            h = mesh.vertex_halfedge(mesh.target(h));  // at a boundary vertex: the outgoing half-edge without a twin
        }
    }
    return loops;
}

std::uint64_t count_pieces(const ControlMesh& mesh) {
    std::vector<std::uint32_t> parent(mesh.face_count());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t f) {
        while (parent[f] != f) f = parent[f] = parent[parent[f]];
        return f;
    };
    std::uint64_t pieces = mesh.face_count();
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i), t = mesh.twin(h);
        if (!t.valid() || t.value < i) continue;
        const std::uint32_t a = root(mesh.face(h).value), b = root(mesh.face(t).value);
        if (a == b) continue;
        parent[b] = a;
        --pieces;
    }
    return pieces;
}

MeshStatistics statistics(const ControlMesh& mesh) {
    MeshStatistics s;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        ++s.faces_by_size[mesh.face_size(FaceId(f))];
        if (mesh.is_hole(FaceId(f))) ++s.holes;
    }
    for (std::uint32_t i = 0; i < mesh.edge_count(); ++i) {
        const EdgeId e(i);
        if (mesh.is_boundary(e))
            ++s.boundary_edges;
        else if (mesh.sharpness(e) == k_sharpness_infinity)
            ++s.sharp_edges;
        else if (mesh.sharpness(e) > 0)
            ++s.semi_sharp_edges;
    }
    for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
        const VertexId v(i);
        if (mesh.is_isolated(v))
            ++s.isolated_vertices;
        else if (!mesh.is_boundary(v))
            ++s.interior_vertices_by_valence[mesh.valence(v)];
    }
    // Only tags of the input: corners that the boundary rule adds are no tags.
    for (const ControlMeshData::VertexTag& tag : mesh.data().corners) {
        if (tag.sharpness >= k_infinite_sharpness)
            ++s.sharp_vertices;
        else if (tag.sharpness > 0)
            ++s.semi_sharp_vertices;
    }
    s.boundary_loops = count_boundary_loops(mesh);
    s.pieces = count_pieces(mesh);
    s.euler_characteristic =
        static_cast<std::int64_t>(mesh.vertex_count() - s.isolated_vertices) - mesh.edge_count() + mesh.face_count();
    return s;
}

/// Names of the rules, by the values of their enums.
constexpr std::string_view k_boundary_rules[] = {"none", "edge-and-corner", "edge-only"},
                           k_face_varying_rules[] = {"smooth-all",     "corners-only", "corners-plus-1",
                                                     "corners-plus-2", "boundaries",   "linear-all"};
std::string_view name_of(BoundaryRule rule) { return k_boundary_rules[static_cast<int>(rule)]; }
std::string_view name_of(FaceVaryingRule rule) { return k_face_varying_rules[static_cast<int>(rule)]; }

/// "128 of 4, 2 of 5"
std::string list_counts(const std::map<std::uint32_t, std::uint64_t>& counts) {
    constexpr std::size_t k_most = 8;
    std::string text;
    std::size_t listed = 0;
    for (const auto& [key, count] : counts) {
        if (listed == k_most) return text + fmt::format(", ... ({} kinds)", counts.size());
        text += fmt::format("{}{} of {}", listed++ == 0 ? "" : ", ", format_count(count), key);
    }
    return text.empty() ? "none" : text;
}

Json json_of_counts(const std::map<std::uint32_t, std::uint64_t>& counts) {
    Json json = Json::object();
    for (const auto& [key, count] : counts) json[std::to_string(key)] = count;
    return json;
}

Json json_of_point(const Vec3d& p) { return Json::array({p.x, p.y, p.z}); }

Json json_of_mesh(const ControlMesh& mesh, const MeshStatistics& s, const Box3d& box, const std::string& input) {
    const ControlMeshData& data = mesh.data();
    return {{"input", input},
            {"vertices", mesh.vertex_count()},
            {"edges", mesh.edge_count()},
            {"faces", mesh.face_count()},
            {"faces_by_size", json_of_counts(s.faces_by_size)},
            {"interior_vertices_by_valence", json_of_counts(s.interior_vertices_by_valence)},
            {"pieces", s.pieces},
            {"euler_characteristic", s.euler_characteristic},
            {"boundary_edges", s.boundary_edges},
            {"boundary_loops", s.boundary_loops},
            {"isolated_vertices", s.isolated_vertices},
            {"sharp_edges", s.sharp_edges},
            {"semi_sharp_edges", s.semi_sharp_edges},
            {"sharp_vertices", s.sharp_vertices},
            {"semi_sharp_vertices", s.semi_sharp_vertices},
            {"corner_angles", data.corner_angles.size()},
            {"holes", s.holes},
            {"boundary_rule", std::string(name_of(mesh.boundary_rule()))},
            {"face_varying_rule", std::string(name_of(mesh.face_varying_rule()))},
            {"crease_method", mesh.crease_method() == CreaseMethod::chaikin ? "chaikin" : "uniform"},
            {"uvs", data.uvs.size()},
            {"materials", data.materials},
            {"groups", data.groups},
            {"bounding_box", {{"lower", json_of_point(box.lower)}, {"upper", json_of_point(box.upper)}}},
            {"diagonal", box.diagonal()},
            {"warnings", mesh.warnings()}};
}

void print_summary(const ControlMesh& mesh, const MeshStatistics& s, const Box3d& box, const std::string& input) {
    const ControlMeshData& data = mesh.data();
    Table table;
    table.row("input", input);
    table.row("vertices", format_count(mesh.vertex_count()));
    table.row("edges", format_count(mesh.edge_count()));
    table.row("faces", fmt::format("{} (corners: {})", format_count(mesh.face_count()), list_counts(s.faces_by_size)));
    table.row("valences", list_counts(s.interior_vertices_by_valence) + " (interior vertices)");
    table.row("pieces", fmt::format("{}, Euler characteristic {}", format_count(s.pieces), s.euler_characteristic));
    table.row("boundary", s.boundary_edges == 0 ? std::string("none: the surface is closed")
                                                : fmt::format("{} edges in {} loops, rule {}", s.boundary_edges,
                                                              s.boundary_loops, name_of(mesh.boundary_rule())));
    table.row("creases", fmt::format("{} sharp and {} semi-sharp edges, {} sharp and {} semi-sharp vertices",
                                     s.sharp_edges, s.semi_sharp_edges, s.sharp_vertices, s.semi_sharp_vertices));
    if (!data.corner_angles.empty())
        table.row("angles", fmt::format("{} corner angle tags", format_count(data.corner_angles.size())));
    if (s.holes > 0) table.row("holes", fmt::format("{} faces", format_count(s.holes)));
    table.row("texture", mesh.has_uvs() ? fmt::format("{} coordinates, rule {}", format_count(data.uvs.size()),
                                                      name_of(mesh.face_varying_rule()))
                                        : std::string("none"));
    if (!data.materials.empty()) table.row("materials", format_count(data.materials.size()));
    if (!data.groups.empty()) table.row("groups", format_count(data.groups.size()));
    table.row("box", fmt::format("{} x {} x {}, diagonal {}", format_length(box.upper.x - box.lower.x),
                                 format_length(box.upper.y - box.lower.y), format_length(box.upper.z - box.lower.z),
                                 format_length(box.diagonal())));
    table.print();
}

ExitCode run(const InfoOptions& options) {
    Run process({});
    const LoadedModel model = load_model(options.input, options.read, process.context());
    process.end_progress();
    print_warnings(model.mesh.warnings());
    const MeshStatistics s = statistics(model.mesh);
    const Box3d box = model.mesh.bounding_box();
    if (options.json)
        fmt::print("{}", dump(json_of_mesh(model.mesh, s, box, options.input.string())));
    else
        print_summary(model.mesh, s, box, options.input.string());
    return ExitCode::done;
}

}  // namespace

void add_info_command(CommandLine program) {
    auto options = std::make_shared<InfoOptions>();
    CommandLine command = program.command("info", "Checks a control mesh and says what is in it",
                                          "Example:\n  tetrakis info data/rook.obj");
    command.option("IN", "", options->input, "Control mesh (.obj)").required();
    command.flag("--json", options->json, "Print JSON");
    add_read_options(command, options->read);
    command.runs([options] { return run(*options); });
}

}  // namespace tetrakis::cli
