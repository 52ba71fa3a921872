#include "obj_reader.hpp"

#include "../base/error.hpp"
#include "../base/files.hpp"
#include "../mesh/mesh_repair.hpp"
#include "obj_prescan.hpp"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <istream>
#include <streambuf>
#include <type_traits>

namespace tetrakis {

namespace {

static_assert(std::is_same_v<tinyobj::real_t, double>, "link tinyobjloader's double target");

// A stream over memory that somebody else keeps.
class MemoryBuffer : public std::streambuf {
  public:
    explicit MemoryBuffer(std::string& text) { setg(text.data(), text.data(), text.data() + text.size()); }
};

// Takes what tinyobjloader reads. Its callbacks are used because its shapes count corners in 8 bits.
struct Receiver {
    ControlMeshData& data;
    const std::vector<std::uint32_t>& face_sizes;
    std::vector<std::uint32_t> face_uvs, face_normals;
    std::size_t faces = 0;
    bool agrees = true;
    std::uint64_t bare_uvs = 0, bare_normals = 0;  ///< corners without

    static Receiver& self(void* user) { return *static_cast<Receiver*>(user); }

    static void uv(void* user, double u, double v, double) { self(user).data.uvs.emplace_back(u, v); }
    static void normal(void* user, double x, double y, double z) { self(user).data.normals.emplace_back(x, y, z); }
    static void face(void* user, tinyobj::index_t* indices, int count) {
        self(user).add_face(indices, static_cast<std::uint32_t>(count));
    }

    static constexpr std::uint32_t k_absent = 0xFFFF'FFFFu;

    static std::uint32_t vertex_number(int index) {
        return index == detail::ObjScan::k_no_element ? VertexId::none : static_cast<std::uint32_t>(index - 1);
    }
    // What is not there (k_no_element) stays a number beyond all arrays, which is not the same as absent.
    static std::uint32_t layer_number(int index) {
        return index == 0 ? k_absent : static_cast<std::uint32_t>(index - 1);
    }

    void skip_empty_faces() {
        for (; faces < face_sizes.size() && face_sizes[faces] == 0; ++faces)
            data.face_offsets.push_back(data.face_offsets.back());
    }

    void add_face(const tinyobj::index_t* indices, std::uint32_t count) {
        skip_empty_faces();
        agrees = agrees && faces < face_sizes.size() && face_sizes[faces] == count;
        ++faces;
        for (std::uint32_t i = 0; i < count; ++i) {
            data.face_vertices.push_back(vertex_number(indices[i].vertex_index));
            face_uvs.push_back(layer_number(indices[i].texcoord_index));
            face_normals.push_back(layer_number(indices[i].normal_index));
            bare_uvs += indices[i].texcoord_index == 0;
            bare_normals += indices[i].normal_index == 0;
        }
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
};

void take_layers(ControlMeshData& data, Receiver& receiver) {
    const std::uint64_t corners = data.face_vertices.size();
    if (receiver.bare_uvs < corners) {
        data.face_uvs = std::move(receiver.face_uvs);
        if (receiver.bare_uvs != 0) {
            const auto origin = static_cast<std::uint32_t>(data.uvs.size());
            const auto is_absent = [](std::uint32_t i) { return i == Receiver::k_absent; };
            // Numbers beyond the file's are ControlMesh::build()'s to refuse: none may fit what is added here.
            const bool all_there =
                std::ranges::all_of(data.face_uvs, [&](std::uint32_t i) { return is_absent(i) || i < origin; });
            std::ranges::replace_if(data.face_uvs, is_absent, all_there ? origin : 0);
            if (all_there) {
                data.uvs.emplace_back(0.0, 0.0);
                data.uv_lines.push_back(0);
                data.warnings.push_back(fmt::format("{} of {} face corners have no texture coordinate; they get (0, 0)",
                                                    receiver.bare_uvs, corners));
            }
        }
    } else {
        data.uvs.clear();
        data.uv_lines.clear();
    }
    if (receiver.bare_normals == 0 && corners != 0) {
        data.face_normals = std::move(receiver.face_normals);
    } else {
        if (receiver.bare_normals < corners)
            data.warnings.push_back(fmt::format("{} of {} face corners have no normal; all normals are left out",
                                                receiver.bare_normals, corners));
        data.normals.clear();
    }
}

void read_with_tinyobj(detail::ObjScan& scan) {
    ControlMeshData& data = scan.data;
    data.uvs.reserve(scan.uv_count);
    data.normals.reserve(scan.normal_count);
    data.face_offsets.reserve(scan.face_sizes.size() + 1);
    data.face_offsets.push_back(0);
    std::size_t corners = 0;
    for (const std::uint32_t size : scan.face_sizes) corners += size;
    Receiver receiver{data, scan.face_sizes, {}, {}};
    data.face_vertices.reserve(corners);
    receiver.face_uvs.reserve(corners);
    receiver.face_normals.reserve(corners);

    tinyobj::callback_t callback;
    callback.texcoord_cb = Receiver::uv;
    callback.normal_cb = Receiver::normal;
    callback.index_cb = Receiver::face;
    MemoryBuffer buffer(scan.normalised);
    std::istream stream(&buffer);
    std::string warning, error;
    const bool read = tinyobj::LoadObjWithCallback(stream, callback, &receiver, nullptr, &warning, &error);
    receiver.skip_empty_faces();
    if (!read || !receiver.agrees || receiver.faces != scan.face_sizes.size() || data.uvs.size() != scan.uv_count ||
        data.normals.size() != scan.normal_count)
        throw Error(ErrorCode::unsupported,
                    fmt::format("tinyobjloader found {} faces, {} texture coordinates and {} normals where there are "
                                "{}, {} and {}; simplify the file's layout. {}",
                                receiver.faces, data.uvs.size(), data.normals.size(), scan.face_sizes.size(),
                                scan.uv_count, scan.normal_count, error),
                    data.source);
    for (const auto& [i, value] : scan.uvs) data.uvs[i] = value;
    for (const auto& [i, value] : scan.normals) data.normals[i] = value;
    take_layers(data, receiver);
}

/// The first few of some sentences in one, and how many more there are.
std::string first_of(const std::vector<std::string>& sentences) {
    constexpr std::size_t k_most = 4;
    std::string text;
    for (std::size_t i = 0; i < std::min(k_most, sentences.size()); ++i) text += (i == 0 ? "" : "; ") + sentences[i];
    if (sentences.size() > k_most) text += fmt::format("; and {} more", sentences.size() - k_most);
    return text;
}

}  // namespace

ControlMeshData parse_obj(std::string_view text, std::string source, const ReadOptions& options) {
    if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
        throw Error(ErrorCode::invalid_input, "the file is empty; give an OBJ file with vertices and faces",
                    std::move(source));
    detail::ObjScan scan = detail::prescan_obj(text, std::move(source));
    read_with_tinyobj(scan);
    ControlMeshData data = std::move(scan.data);
    if (options.weld)
        for (const std::string& report : weld(data, *options.weld)) data.warnings.push_back("welded: " + report);
    if (!options.repair) return data;
    const bool had_faces = !scan.face_sizes.empty();
    const std::vector<std::string> reports = repair(data);
    if (had_faces && data.face_vertices.empty())
        throw Error(ErrorCode::invalid_input, "no face is left to work with; the repair " + first_of(reports),
                    data.source);
    for (const std::string& report : reports) data.warnings.push_back("repaired: " + report);
    return data;
}

ControlMeshData read_obj(const std::filesystem::path& path, const ReadOptions& options) {
    return parse_obj(detail::read_file(path), path.string(), options);
}

ControlMesh load_control_mesh(const std::filesystem::path& path, const ReadOptions& options,
                              const RunContext& context) {
    context.report("load", 0.0);
    ControlMeshData data = read_obj(path, options);
    context.report("load", 1.0);
    return ControlMesh::build(std::move(data), context);
}

}  // namespace tetrakis
