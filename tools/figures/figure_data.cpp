// What tools/figures.py draws, computed by the library: meshes refined by any scheme, and curves.
//   figure_data refine IN.obj SCHEME LEVELS OUT [STEPS_OR_TUNING]   prints {"faces": , "vertices": , "volume": }
//   figure_data picture MESH CONTROL.obj OUT.png WIDTH HEIGHT AZIMUTH ELEVATION [edges]
//                                            the mesh in the control mesh's outline, dashed where it is hidden;
//                                            "edges": not drawn there, for the edges of the mesh's own polygons
//   figure_data curves                       prints the curves as JSON
//   figure_data adaptive, zoom, factored, simplify: figure_commands.hpp
#include "../tetrakis/schemes/canvas.hpp"
#include "figure_commands.hpp"

#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/render/render.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/curves/curve.hpp"

#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <exception>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace tetrakis;
using Json = nlohmann::json;

/// Enclosed by a closed mesh; polygons as fans.
double volume(const PolygonMesh& mesh) {
    double six = 0;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        const std::uint32_t begin = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
        for (std::uint32_t i = begin + 2; i < end; ++i)
            six +=
                glm::dot(mesh.positions[mesh.face_vertices[begin]],
                         glm::cross(mesh.positions[mesh.face_vertices[i - 1]], mesh.positions[mesh.face_vertices[i]]));
    }
    return six / 6;
}

int refine(const std::vector<std::string>& arguments) {
    if (arguments.size() < 4) throw std::invalid_argument("refine: IN.obj SCHEME LEVELS OUT [STEPS_OR_TUNING]");
    const SchemeInfo* const scheme = find_scheme(arguments[1]);
    if (scheme == nullptr) throw std::invalid_argument("refine: no scheme is called " + arguments[1]);
    ControlMesh mesh = load_control_mesh(arguments[0]);
    if (scheme->family == MeshFamily::triangles && !mesh.all_triangles()) mesh = triangulate(mesh);
    RuleOptions rules;
    if (arguments.size() > 4 && arguments[1] == "averaging") rules.averaging_steps = std::stoi(arguments[4]);
    if (arguments.size() > 4 && arguments[1] == "tuned-loop") rules.tuning = std::stod(arguments[4]);
    const PolygonMesh result = tetrakis::refine(mesh, *scheme, std::stoi(arguments[2]), {.rules = rules});
    write_mesh(arguments[3], result);
    std::cout << Json{{"faces", result.face_count()}, {"vertices", result.positions.size()}, {"volume", volume(result)}}
              << '\n';
    return 0;
}

/// Whether a triangle lies between two points (Moller, Trumbore 1997).
bool between(const Vec3d& from, const Vec3d& to, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    constexpr double k_touching = 1e-4;  // the far point may lie on the surface itself
    const Vec3d along = to - from, e1 = b - a, e2 = c - a, p = glm::cross(along, e2);
    const double determinant = glm::dot(e1, p);
    if (determinant == 0) return false;
    const Vec3d s = (from - a) / determinant, q = glm::cross(s, e1);
    const double u = glm::dot(s, p), v = glm::dot(along, q), t = glm::dot(e2, q);
    return u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < 1 - k_touching;
}

int picture(const std::vector<std::string>& arguments) {
    if (arguments.size() < 7)
        throw std::invalid_argument("picture: MESH CONTROL.obj OUT.png WIDTH HEIGHT AZIMUTH ELEVATION [edges]");
    const bool own_edges = arguments.size() > 7 && arguments[7] == "edges";
    const TriangleMesh mesh = read_triangle_mesh(arguments[0]);
    const ControlMesh control = load_control_mesh(arguments[1]);
    const std::vector<Vec3d>& corners = control.data().positions;
    RenderOptions options;
    if (own_edges) options.shading = Shading::flat;
    options.width = std::stoi(arguments[3]);
    options.height = std::stoi(arguments[4]);
    options.view.azimuth_degrees = std::stod(arguments[5]);
    options.view.elevation_degrees = std::stod(arguments[6]);
    std::vector<Vec3d> all = mesh.positions;
    all.insert(all.end(), corners.begin(), corners.end());
    const double aspect = static_cast<double>(options.width) / options.height;
    const Camera camera = fit_camera(all, aspect, options.view);
    options.camera = camera;

    cli::Canvas canvas(options.width, options.height);
    canvas.paste(0, 0, render(mesh, options));
    const Vec3d forward = glm::normalize(camera.target - camera.eye);
    const Vec3d right = glm::normalize(glm::cross(forward, camera.up)), above = glm::cross(right, forward);
    const double scale = options.height / (2 * std::tan(glm::radians(camera.vertical_fov_degrees) / 2));
    const auto project = [&](const Vec3d& p) {
        const Vec3d d = p - camera.eye;
        const double z = glm::dot(d, forward);
        return Vec2d(0.5 * options.width + scale * glm::dot(d, right) / z,
                     0.5 * options.height - scale * glm::dot(d, above) / z);
    };
    // What is behind the surface is dashed, or left out.
    constexpr int k_dash = 3;
    const int pieces = own_edges ? 8 : 80;
    const Vec3f ink(0.12f, 0.20f, 0.36f), faint(0.36f, 0.38f, 0.42f);
    const RuleMesh edges = rule_mesh(control);
    for (int e = 0; e < edges.edge_count(); ++e) {
        const Vec3d from = corners[edges.origin(edges.edge_halfedge(e))],
                    to = corners[edges.target(edges.edge_halfedge(e))];
        const auto at = [&](double t) { return from + t / pieces * (to - from); };
        for (int i = 0; i < pieces; ++i) {
            bool hidden = false;
            for (const auto& [a, b, c] : mesh.triangles)
                if (between(camera.eye, at(i + 0.5), mesh.positions[a], mesh.positions[b], mesh.positions[c])) {
                    hidden = true;
                    break;
                }
            if (!hidden || (!own_edges && i / k_dash % 2 == 0))
                canvas.line(project(at(i)), project(at(i + 1)),
                            own_edges ? 0.6
                            : hidden  ? 0.9
                                      : 1.7,
                            hidden ? faint : ink);
        }
    }
    write_png(arguments[2], canvas.image());
    return 0;
}

Json points(const CurvePoints& p) {
    Json list = Json::array();
    for (const glm::dvec3& x : p) list.push_back({x.x, x.y});
    return list;
}

int curves() {
    constexpr double k_tolerance = 1e-4;
    Json json;
    const CurvePoints bezier{{0, 0, 0}, {0.6, 1.9, 0}, {2.4, 2.1, 0}, {3, 0.2, 0}};
    const BezierHalves halves = split_bezier(bezier);
    const BezierHalves quarters = split_bezier(halves.first);
    json["bezier"] = {{"control", points(bezier)},
                      {"first", points(halves.first)},
                      {"second", points(halves.second)},
                      {"first_first", points(quarters.first)},
                      {"first_second", points(quarters.second)},
                      {"curve", points(adaptive_bezier(bezier, k_tolerance).points)}};
    const CurvePoints control{{0, 0, 0}, {0.3, 1.6, 0}, {1.3, 1.9, 0}, {1.6, 0.3, 0}, {2.7, 0.1, 0}, {3, 1.8, 0}};
    for (int degree = 1; degree <= 4; ++degree) {
        json["bspline"].push_back(
            {{"degree", degree},
             {"control", points(control)},
             {"step", points(bspline_step(control, degree, CurveTopology::open))},
             {"curve",
              points(adaptive_bspline(control, degree, CurveTopology::open, CurveEnds::plain, k_tolerance).points)},
             {"closed",
              points(adaptive_bspline(control, degree, CurveTopology::closed, CurveEnds::plain, k_tolerance).points)}});
    }
    json["four_point"] = {
        {"control", points(control)},
        {"step", points(four_point_step(control, CurveTopology::open))},
        {"curve", points(adaptive_four_point(control, CurveTopology::open, FourPointEnds::cubic, k_tolerance).points)},
        {"closed",
         points(adaptive_four_point(control, CurveTopology::closed, FourPointEnds::cubic, k_tolerance).points)}};
    std::cout << json << '\n';
    return 0;
}

}  // namespace

int main(int count, char** values) {
    try {
        const std::string command = count > 1 ? values[1] : "";
        if (command == "refine") return refine({values + 2, values + count});
        if (command == "picture") return picture({values + 2, values + count});
        if (command == "curves") return curves();
        const std::map<std::string, Json (*)(const figures::Arguments&)> more{{"adaptive", figures::adaptive},
                                                                              {"zoom", figures::zoom},
                                                                              {"factored", figures::factored},
                                                                              {"simplify", figures::simplify}};
        if (const auto found = more.find(command); found != more.end()) {
            std::cout << found->second({values + 2, values + count}) << '\n';
            return 0;
        }
        std::cerr << "figure_data: refine, picture, curves, adaptive, zoom, factored or simplify\n";
        return 2;
    } catch (const std::exception& e) {
        std::cerr << "figure_data: " << e.what() << '\n';
        return 1;
    }
}
