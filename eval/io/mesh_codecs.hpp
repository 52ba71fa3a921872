#pragma once

// Private to eval: for each format, an encoder and a decoder for the bytes of a whole file. mesh_writer and mesh_reader
// choose among them. And cut_faces(), which whole levels use, too.

#include "../../hier/base/files.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/face_cutter.hpp"
#include "mesh_view.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Maximum number of elements of one kind: counts are 32-bit numbers below 0xFFFFFFFF, which means "none".
inline constexpr std::uint32_t k_most_elements = 0xFFFF'FFFEu;

TriangleMesh decode_obj(std::string_view text, const std::filesystem::path& path, const RunContext& context);
TriangleMesh decode_ply(std::string_view bytes, const std::filesystem::path& path, const RunContext& context);
TriangleMesh decode_gltf(std::string_view bytes, const std::filesystem::path& path);

/// Triangles by cut_faces(), with their numbers alone.
TriangleMesh cut_corners(const MeshView& faces);
/// Cuts faces into triangles by their shapes: in a concave face, a simple fan may leave the face. Takes over the
/// values.
template <class Polygons>
TriangleMesh cut_faces(Polygons&& polygons) {
    TriangleMesh mesh = cut_corners(MeshView(polygons));
    mesh.positions = std::move(polygons.positions);
    mesh.normals = std::move(polygons.normals);
    mesh.uvs = std::move(polygons.uvs);
    mesh.materials = std::move(polygons.materials);
    mesh.groups = std::move(polygons.groups);
    return mesh;
}
/// Calls visit(face, corners of a triangle) for these triangles, face by face.
template <class Visit>
void for_each_triangle(const MeshView& mesh, const Visit& visit) {
    FaceCutter cutter;
    std::vector<Vec3d> points;
    for (std::uint64_t f = 0; f < mesh.face_count(); ++f) {
        const std::uint64_t begin = mesh.face_begin(f);
        points.clear();
        for (std::uint64_t c = begin; c < mesh.face_end(f); ++c) points.push_back(mesh.positions[mesh.corners[c]]);
        cutter.cut(
            points, [](std::uint32_t, std::uint32_t) { return true; },
            [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
                visit(f, std::array{begin + a, begin + tip, begin + b});
            });
    }
}

void encode_obj(const MeshView& mesh, AtomicFile& file, const RunContext& context);
void encode_ply(const MeshView& mesh, AtomicFile& file, const RunContext& context);
/// @param whole  box that determines the local origin: of the mesh, or of the whole model if the mesh is a part
void encode_glb(const MeshView& mesh, const Box3d& whole, AtomicFile& file, const RunContext& context);

static_assert(std::endian::native == std::endian::little, "PLY and GLB are written as the machine's own bytes");

/// Writes elements [0, count) in order; append(text, element) adds the bytes of one element to a string. A few pieces
/// at a time are made in parallel, so little memory is needed, and the bytes do not depend on the threads.
template <class Append>
void write_in_pieces(AtomicFile& file, std::uint64_t count, const RunContext& context, double from, double to,
                     Append&& append) {
    constexpr std::uint64_t k_piece = 16 * 1024;  // elements: about a megabyte of text
    constexpr std::uint64_t k_pieces_at_once = 32;
    std::vector<std::string> pieces(k_pieces_at_once);
    for (std::uint64_t begin = 0; begin < count; begin += k_piece * k_pieces_at_once) {
        context.report("write", from + (to - from) * static_cast<double>(begin) / static_cast<double>(count));
        const std::uint64_t end = std::min(count, begin + k_piece * k_pieces_at_once);
        const auto pieces_now = static_cast<std::uint32_t>((end - begin + k_piece - 1) / k_piece);
        for_each_index(
            pieces_now,
            [&](std::uint32_t i) {
                pieces[i].clear();
                const std::uint64_t last = std::min(end, begin + (i + 1) * k_piece);
                for (std::uint64_t e = begin + i * k_piece; e < last; ++e) append(pieces[i], e);
            },
            1);
        for (std::uint32_t i = 0; i < pieces_now; ++i) file.write(pieces[i]);
    }
}

/// Appends the bytes of a value, as in memory.
template <class T>
void append_bytes(std::string& out, const T& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

/// A name that is safe in a line-based format: control characters and a final '\' become '_', and the empty name
/// becomes a word.
std::string printable_name(std::string_view name);

}  // namespace tetrakis::detail
