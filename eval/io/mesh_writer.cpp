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

void write_mesh_part(AtomicFile& file, const MeshView& mesh, const Box3d& whole, const RunContext& context) {
    const MeshFormat format = mesh_format(file.path());
    mesh.check();
    with_threads(context, [&] {
        if (format == MeshFormat::glb)
            detail::encode_glb(mesh, whole, file, context);
        else
            (format == MeshFormat::obj ? detail::encode_obj : detail::encode_ply)(mesh, file, context);
    });
}

void write_mesh(AtomicFile& file, const MeshView& mesh, const RunContext& context) {
    write_mesh_part(file, mesh, bounding_box(mesh.positions), context);
}

void write_mesh(const std::filesystem::path& path, const MeshView& mesh, const RunContext& context) {
    mesh_format(path);  // throws before anything is written
    AtomicFile file(path);
    write_mesh(file, mesh, context);
    file.commit();
}

}  // namespace tetrakis
