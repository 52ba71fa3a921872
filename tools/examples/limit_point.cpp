// Any point of the limit surface with its derivatives, and the curvature there.
#include <tetrakis/tetrakis.hpp>

#include <iostream>

int main() {
    const auto cage = tetrakis::load_control_mesh("data/cube.obj");
    const tetrakis::LimitSurface surface(cage, tetrakis::SchemeKind::catmull_clark);  // or loop

    // Each corner of a face (half-edge) has its own cell: (0, 0) is the vertex, (1, 1) the centre of the face.
    const tetrakis::HalfedgeId corner = cage.face_halfedge(tetrakis::FaceId(0));
    const tetrakis::SurfacePoint p = surface.evaluate(corner, 0.25, 0.5);
    const double e = glm::dot(p.du, p.du), f = glm::dot(p.du, p.dv), g = glm::dot(p.dv, p.dv);
    const double l = glm::dot(p.duu, p.normal), m = glm::dot(p.duv, p.normal), n = glm::dot(p.dvv, p.normal);
    std::cout << "position " << p.position.x << ' ' << p.position.y << ' ' << p.position.z << ", normal " << p.normal.x
              << ' ' << p.normal.y << ' ' << p.normal.z << '\n';
    std::cout << "Gaussian curvature " << (l * n - m * m) / (e * g - f * f) << '\n';

    // At the cube's vertices (valence 3) there are tangents, but no second derivatives.
    const tetrakis::SurfacePoint tip = surface.evaluate(corner, 0, 0);
    std::cout << "second derivatives at the vertex: " << (tip.has_second ? "yes" : "none") << '\n';
}
