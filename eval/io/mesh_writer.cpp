#include "mesh_writer.hpp"

#include "../../hier/base/files.hpp"
#include "../../hier/base/parallel.hpp"
#include "mesh_codecs.hpp"

namespace tetrakis {

MeshFormat mesh_format(const std::filesystem::path& path) {
    const std::string extension = detail::lower_extension(path);
    if (extension == ".obj") return MeshFormat::obj;
    if (extension == ".ply") return MeshFormat::ply;
    if (extension == ".glb") return MeshFormat::glb;
    throw Error(ErrorCode::unsupported,
                (extension.empty() ? "a mesh file needs an extension" : "meshes are not written as " + extension) +
                    std::string("; use .obj, .ply or .glb"),
                path);
}

namespace {

void encode(AtomicFile& file, const detail::MeshView& view, const Box3d& whole, const RunContext& context) {
    const MeshFormat format = mesh_format(file.path());
    view.check();
    with_threads(context, [&] {
        if (format == MeshFormat::glb)
            detail::encode_glb(view, whole, file, context);
        else
            (format == MeshFormat::obj ? detail::encode_obj : detail::encode_ply)(view, file, context);
    });
}

template <class Mesh>
void write_whole(const std::filesystem::path& path, const Mesh& mesh, const RunContext& context) {
    mesh_format(path);  // throws before anything is written
    AtomicFile file(path);
    write_mesh(file, mesh, context);
    file.commit();
}

}  // namespace

void write_mesh(AtomicFile& file, const TriangleMesh& mesh, const RunContext& context) {
    encode(file, detail::MeshView(mesh), bounding_box(mesh.positions), context);
}

void write_mesh(AtomicFile& file, const PolygonMesh& mesh, const RunContext& context) {
    encode(file, detail::MeshView(mesh), bounding_box(mesh.positions), context);
}

void write_mesh_part(AtomicFile& file, const TriangleMesh& mesh, const Box3d& whole, const RunContext& context) {
    encode(file, detail::MeshView(mesh), whole, context);
}

void write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh, const RunContext& context) {
    write_whole(path, mesh, context);
}

void write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh, const RunContext& context) {
    write_whole(path, mesh, context);
}

}  // namespace tetrakis
