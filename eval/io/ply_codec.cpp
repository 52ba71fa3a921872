#include "../../hier/obj/obj_lines.hpp"
#include "mesh_codecs.hpp"
#include "split_vertices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

namespace tetrakis::detail {

namespace {

struct PlyType {
    std::string_view name, other_name;
    std::size_t size;
    bool is_integer;
    double (*read)(const char* bytes, bool swap);
};

template <class T>
double read_as(const char* bytes, bool swap) {
    char ordered[sizeof(T)];
    std::memcpy(ordered, bytes, sizeof(T));
    if (swap) std::reverse(ordered, ordered + sizeof(T));
    T value;
    std::memcpy(&value, ordered, sizeof(T));
    return static_cast<double>(value);
}

constexpr PlyType k_types[] = {
    {"char", "int8", 1, true, read_as<std::int8_t>},    {"uchar", "uint8", 1, true, read_as<std::uint8_t>},
    {"short", "int16", 2, true, read_as<std::int16_t>}, {"ushort", "uint16", 2, true, read_as<std::uint16_t>},
    {"int", "int32", 4, true, read_as<std::int32_t>},   {"uint", "uint32", 4, true, read_as<std::uint32_t>},
    {"float", "float32", 4, false, read_as<float>},     {"double", "float64", 8, false, read_as<double>}};

/// The type of this name; nullptr if there is none.
const PlyType* type_of(std::string_view word) {
    const auto* const found = std::ranges::find_if(
        k_types, [&](const PlyType& type) { return word == type.name || word == type.other_name; });
    return found == std::end(k_types) ? nullptr : found;
}

struct PlyProperty {
    std::string name;
    const PlyType* type;
    const PlyType* count_type;  // nullptr: no list
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

/// The role of a vertex or face property, by its name.
struct RoleName {
    std::string_view name;
    std::size_t role;
    bool is_list;
};
constexpr std::size_t k_skip = 8;  // role of properties that are not read
// A vertex's position, normal and texture coordinates are numbers 0 to 2, 3 to 5, 6 and 7.
constexpr RoleName k_vertex_roles[] = {{"x", 0, false},  {"y", 1, false},         {"z", 2, false},
                                       {"nx", 3, false}, {"ny", 4, false},        {"nz", 5, false},
                                       {"s", 6, false},  {"t", 7, false},         {"u", 6, false},
                                       {"v", 7, false},  {"texture_u", 6, false}, {"texture_v", 7, false}};
constexpr std::size_t k_corners = 0, k_texcoord = 1, k_material = 2, k_group = 3;
constexpr RoleName k_face_roles[] = {{"vertex_indices", k_corners, true},
                                     {"vertex_index", k_corners, true},
                                     {"texcoord", k_texcoord, true},
                                     {"material_index", k_material, false},
                                     {"group_index", k_group, false}};

std::vector<std::string_view> words_of(std::string_view line) {
    ObjWords rest(line);
    std::vector<std::string_view> words;
    for (std::string_view word = rest.next(); !word.empty(); word = rest.next()) words.push_back(word);
    return words;
}

class PlyDecoder {
  public:
    PlyDecoder(std::string_view bytes, const std::filesystem::path& path, const RunContext& context)
        : bytes_(bytes), path_(path), context_(context) {}

    TriangleMesh run() {
        read_header();
        for (const PlyElement& element : elements_) {
            check_room(element);
            if (element.name == "vertex")
                vertices(element);
            else if (element.name == "face")
                faces(element);
            else
                for_each_row(element, roles_of(element, {}), 1, 1, [](std::uint64_t, const Row&) {});
        }
        check_corners();
        name_numbers(mesh_.face_material, mesh_.materials, materials_, "material");
        name_numbers(mesh_.face_group, mesh_.groups, groups_, "group");
        if (mesh_.face_uvs.size() != mesh_.face_vertices.size()) {
            mesh_.face_uvs.clear();
            mesh_.uvs.clear();
        }
        TriangleMesh mesh = cut_faces(std::move(mesh_));
        if (!uv_of_vertex_.empty() && mesh.triangle_uvs.empty()) {  // one UV per vertex: the same numbers
            mesh.uvs = std::move(uv_of_vertex_);
            mesh.triangle_uvs = mesh.triangles;
        }
        if (!mesh.normals.empty()) join_split_vertices(mesh);
        return mesh;
    }

  private:
    enum class Format { text, little_endian, big_endian };

    /// Throws an Error with the position: line of a text file, byte offset of a binary one.
    [[noreturn]] void reject(const std::string& text) const {
        if (format_ == Format::text) throw Error(ErrorCode::invalid_input, text, path_, line_);
        throw Error(ErrorCode::invalid_input, fmt::format("at byte {}: {}", at_, text), path_);
    }

    void read_header() {
        if (next_line() != "ply") reject("this is no PLY file: its first line is not 'ply'");
        std::optional<Format> format;
        for (;;) {
            if (at_ >= bytes_.size()) reject("the header has no end_header; the file may be cut short");
            const std::string_view line = next_line();
            const std::vector<std::string_view> words = words_of(line);
            if (words.empty() || words[0] == "obj_info") continue;
            if (words[0] == "comment")
                take_name(line, words);
            else if (words[0] == "format")
                format = format_of(words);
            else if (words[0] == "element")
                add_element(words);
            else if (words[0] == "property")
                add_property(words);
            else if (words[0] == "end_header")
                break;
            else
                reject(fmt::format("unknown word '{:.40}' in the header", words[0]));
        }
        if (bytes_[at_ - 1] != '\n') reject("the header ends with the file; the file may be cut short");
        if (!format) reject("the header has no format line");
        format_ = *format;
        ++line_;
    }

    std::string_view next_line() {
        ++line_;
        const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
        std::string_view line = bytes_.substr(at_, end - at_);
        at_ = std::min(end + 1, bytes_.size());
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }

    /// Reads a name from a comment: `comment material 3 brass` sets materials_[3] = "brass". Numbers must be in order.
    void take_name(std::string_view line, const std::vector<std::string_view>& words) {
        if (words.size() < 3 || (words[1] != "material" && words[1] != "group")) return;
        std::vector<std::string>& names = words[1] == "material" ? materials_ : groups_;
        if (obj_integer(words[2]) != std::ssize(names)) return;
        line.remove_prefix(static_cast<std::size_t>(words[2].data() - line.data()) + words[2].size());
        names.emplace_back(line.substr(std::min(line.find_first_not_of(' '), line.size())));
    }

    Format format_of(const std::vector<std::string_view>& words) const {
        const std::string_view name = words.size() > 1 ? words[1] : std::string_view{};
        if (name == "ascii") return Format::text;
        if (name == "binary_little_endian") return Format::little_endian;
        if (name == "binary_big_endian") return Format::big_endian;
        reject("the format is none of ascii, binary_little_endian, binary_big_endian");
    }

    void add_element(const std::vector<std::string_view>& words) {
        const std::optional<std::int64_t> count = words.size() == 3 ? obj_integer(words[2]) : std::nullopt;
        constexpr std::int64_t k_clamped = std::int64_t{1} << 62;
        if (!count || *count < 0 || *count >= k_clamped) reject("an element line has a name and a count");
        for (const PlyElement& other : elements_)
            if (other.name == words[1]) reject(fmt::format("element '{:.40}' is declared twice", words[1]));
        elements_.push_back({std::string(words[1]), static_cast<std::uint64_t>(*count), {}});
    }

    void add_property(const std::vector<std::string_view>& words) {
        if (elements_.empty()) reject("a property comes before the first element");
        const bool is_list = words.size() > 1 && words[1] == "list";
        if (words.size() != (is_list ? 5 : 3)) reject("a property line has a type and a name");
        const PlyType *const type = type_of(words[is_list ? 3 : 1]), *const count_type =
                                                                         is_list ? type_of(words[2]) : type;
        if (type == nullptr || count_type == nullptr) reject("a property has an unknown type");
        if (is_list && !count_type->is_integer) reject("the count of a list is not an integer type");
        elements_.back().properties.push_back({std::string(words.back()), type, is_list ? count_type : nullptr});
    }

    double next(const PlyType& type) {
        if (format_ == Format::text) return next_word();
        if (bytes_.size() - at_ < type.size) reject("the file ends in the middle of its data");
        at_ += type.size;
        return type.read(bytes_.data() + at_ - type.size, format_ == Format::big_endian);
    }

    double next_word() {
        constexpr std::string_view k_blanks = " \t\r\n";
        for (; at_ < bytes_.size() && k_blanks.find(bytes_[at_]) != std::string_view::npos; ++at_)
            if (bytes_[at_] == '\n') ++line_;
        if (at_ >= bytes_.size()) reject("the file ends in the middle of its data");
        const std::size_t end = std::min(bytes_.find_first_of(k_blanks, at_), bytes_.size());
        const std::optional<double> value = obj_number(bytes_.substr(at_, end - at_));
        if (!value) reject("this is not a number");
        at_ = end;
        return *value;
    }

    /// Least number of bytes of a number; in text, a digit and a blank.
    std::uint64_t least_bytes(const PlyType& type) const { return format_ == Format::text ? 2 : type.size; }

    /// Reads the length of a list, and rejects a list longer than the rest of the file.
    std::uint64_t list_count(const PlyProperty& property) {
        const double number = next(*property.count_type);
        if (!(number >= 0) || number != std::floor(number)) reject("the count of a list is no count");
        if (number * static_cast<double>(least_bytes(*property.type)) > static_cast<double>(bytes_.size() - at_ + 1))
            reject("a list is longer than the rest of the file");
        return static_cast<std::uint64_t>(number);
    }

    /// Rejects an element that is longer than the rest of the file, before memory for it is allocated.
    void check_room(const PlyElement& element) const {
        if (element.count == 0) return;
        if (element.properties.empty()) reject(fmt::format("element '{:.40}' has no properties", element.name));
        std::uint64_t each = 0;
        for (const PlyProperty& property : element.properties)
            each += least_bytes(property.count_type != nullptr ? *property.count_type : *property.type);
        // The last number of a text file needs no blank after it.
        if (element.count > (bytes_.size() - at_ + 1) / each)
            reject(fmt::format("{} elements '{:.40}' do not fit into the {} bytes left; the file may be cut short",
                               element.count, element.name, bytes_.size() - at_));
    }

    /// Roles of the element's properties.
    std::vector<std::size_t> roles_of(const PlyElement& element, std::span<const RoleName> names) const {
        if (element.count > k_most_elements)
            throw Error(ErrorCode::unsupported, fmt::format("{} {} elements are too many", element.count, element.name),
                        path_);
        std::vector<std::size_t> roles;
        for (const PlyProperty& property : element.properties) {
            const auto known = std::ranges::find_if(names, [&](const RoleName& role) {
                return role.name == property.name && role.is_list == (property.count_type != nullptr);
            });
            const std::size_t role = known == names.end() ? k_skip : known->role;
            if (role != k_skip && std::ranges::count(roles, role) != 0)
                throw Error(ErrorCode::invalid_input,
                            fmt::format("the element {} has a second property for what {} says; remove one",
                                        element.name, property.name),
                            path_);
            roles.push_back(role);
        }
        return roles;
    }

    /// The values of one element (such as a vertex or a face), by role.
    using Row = std::array<std::vector<double>, k_skip + 1>;
    /// Calls use(i, row) for each element in order.
    template <class Use>
    void for_each_row(const PlyElement& element, const std::vector<std::size_t>& roles, double from, double to,
                      const Use& use) {
        constexpr std::uint64_t k_per_report = 1 << 18;
        Row row;
        for (std::uint64_t i = 0; i < element.count; ++i) {
            if (i % k_per_report == 0)
                context_.report("load",
                                from + (to - from) * static_cast<double>(i) / static_cast<double>(element.count));
            for (std::vector<double>& numbers : row) numbers.clear();
            for (std::size_t p = 0; p < roles.size(); ++p) {
                const PlyProperty& property = element.properties[p];
                std::vector<double>& numbers = row[roles[p]];
                for (std::uint64_t left = property.count_type != nullptr ? list_count(property) : 1; left > 0; --left) {
                    const double number = next(*property.type);
                    if (roles[p] == k_skip) continue;
                    numbers.push_back(number);
                    if (!std::isfinite(number))
                        reject(fmt::format("{} of {} {} is not finite", property.name, element.name, i));
                }
            }
            use(i, row);
        }
    }

    void vertices(const PlyElement& element) {
        const std::vector<std::size_t> roles = roles_of(element, k_vertex_roles);
        const auto has = [&](std::size_t first, std::size_t last) {
            for (std::size_t role = first; role <= last; ++role)
                if (std::ranges::count(roles, role) == 0) return false;
            return true;
        };
        if (!has(0, 2)) throw Error(ErrorCode::invalid_input, "the vertices have no x, y and z", path_);
        const bool normals = has(3, 5), uvs = has(6, 7);
        mesh_.positions.reserve(element.count);
        for_each_row(element, roles, 0.3, 0.6, [&](std::uint64_t, const Row& row) {
            mesh_.positions.emplace_back(row[0][0], row[1][0], row[2][0]);
            if (normals) mesh_.normals.emplace_back(row[3][0], row[4][0], row[5][0]);
            if (uvs) uv_of_vertex_.emplace_back(row[6][0], row[7][0]);
        });
    }

    void faces(const PlyElement& element) {
        const std::vector<std::size_t> roles = roles_of(element, k_face_roles);
        if (std::ranges::count(roles, k_corners) == 0)
            throw Error(ErrorCode::invalid_input, "the faces have no list vertex_indices", path_);
        mesh_.face_offsets = {0};
        for_each_row(element, roles, 0.6, 1.0, [&](std::uint64_t f, const Row& row) {
            const auto add = [&](std::vector<std::uint32_t>& indices, std::size_t role, const char* what) {
                for (const double number : row[role]) {
                    if (!(number >= 0 && number <= double{k_most_elements}) || number != std::floor(number))
                        reject(fmt::format("a {} index of face {} is no index", what, f));
                    indices.push_back(static_cast<std::uint32_t>(number));
                }
            };
            const std::size_t size = row[k_corners].size();
            if (size < 3) reject(fmt::format("face {} has {} corners; it needs three", f, size));
            add(mesh_.face_vertices, k_corners, "vertex");
            add(mesh_.face_material, k_material, "material");
            add(mesh_.face_group, k_group, "group");
            if (mesh_.face_vertices.size() > k_most_elements || mesh_.uvs.size() > k_most_elements)
                throw Error(ErrorCode::unsupported, "too many corners of faces", path_);
            mesh_.face_offsets.push_back(static_cast<std::uint32_t>(mesh_.face_vertices.size()));
            const std::vector<double>& texcoords = row[k_texcoord];
            for (std::size_t i = 0; texcoords.size() == 2 * size && i < 2 * size; i += 2) {
                mesh_.face_uvs.push_back(static_cast<std::uint32_t>(mesh_.uvs.size()));
                mesh_.uvs.emplace_back(texcoords[i], texcoords[i + 1]);
            }
        });
    }

    // Called at the end of the file, as faces may come before the vertices.
    void check_corners() const {
        const auto& v = mesh_.face_vertices;
        const std::size_t count = mesh_.positions.size();
        const auto bad = std::ranges::find_if(v, [&](std::uint32_t number) { return number >= count; }) - v.begin();
        if (bad == std::ssize(v)) return;
        const auto face = std::ranges::upper_bound(mesh_.face_offsets, bad) - mesh_.face_offsets.begin() - 1;
        throw Error(
            ErrorCode::invalid_input,
            fmt::format("face {} uses vertex {}, but there are {} vertices (numbers start at 0); check the export",
                        face, v[static_cast<std::size_t>(bad)], count),
            path_);
    }

    // Names come from comments of the header; numbers without a name get one, such as "material_3".
    void name_numbers(const std::vector<std::uint32_t>& numbers, std::vector<std::string>& names,
                      const std::vector<std::string>& given, const char* what) const {
        if (numbers.empty()) return;
        constexpr std::uint32_t k_most_names = 1 << 20;
        const std::uint32_t largest = *std::max_element(numbers.begin(), numbers.end());
        if (largest >= std::max<std::size_t>(given.size(), k_most_names))
            throw Error(ErrorCode::invalid_input, fmt::format("{} number {} is absurd", what, largest), path_);
        names = given;
        while (names.size() <= largest) names.push_back(fmt::format("{}_{}", what, names.size()));
    }

    std::string_view bytes_;
    const std::filesystem::path& path_;
    const RunContext& context_;
    std::size_t at_ = 0;            // position in bytes_
    std::uint64_t line_ = 0;        // line in the header and in text files
    Format format_ = Format::text;  // of the current part: the header is text
    std::vector<PlyElement> elements_;
    std::vector<std::string> materials_, groups_;  // from comments that encode_ply() writes
    PolygonMesh mesh_;
    std::vector<Vec2d> uv_of_vertex_;
};

}  // namespace

TriangleMesh decode_ply(std::string_view bytes, const std::filesystem::path& path, const RunContext& context) {
    return PlyDecoder(bytes, path, context).run();
}

void encode_ply(const MeshView& mesh, AtomicFile& file, const RunContext& context) {
    const SplitVertices split(mesh, false);
    const auto& vertices = split.vertices();
    std::uint64_t largest_face = 3;
    for (std::uint64_t f = 0; f + 1 < mesh.face_offsets.size(); ++f)
        largest_face = std::max(largest_face, mesh.face_end(f) - mesh.face_begin(f));
    // Texture coordinates of a face are one list, two numbers a corner; most readers expect counts in one byte.
    const bool short_lists = 2 * largest_face <= 255;
    const char* count_type = short_lists ? "uchar" : "uint";
    // Readers expect signed indices; unsigned ones are written only if necessary.
    const char* index_type = vertices.size() <= 0x7FFF'FFFFu ? "int" : "uint";

    std::string header = "ply\nformat binary_little_endian 1.0\ncomment tetrakis\n";
    for (std::size_t i = 0; i < mesh.materials.size(); ++i)
        header += fmt::format("comment material {} {}\n", i, printable_name(mesh.materials[i]));
    for (std::size_t i = 0; i < mesh.groups.size(); ++i)
        header += fmt::format("comment group {} {}\n", i, printable_name(mesh.groups[i]));
    header +=
        fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n", vertices.size());
    if (mesh.has_normals()) header += "property double nx\nproperty double ny\nproperty double nz\n";
    header +=
        fmt::format("element face {}\nproperty list {} {} vertex_indices\n", mesh.face_count(), count_type, index_type);
    if (mesh.has_uvs()) header += fmt::format("property list {} double texcoord\n", count_type);
    if (!mesh.face_material.empty()) header += "property int material_index\n";
    if (!mesh.face_group.empty()) header += "property int group_index\n";
    file.write(header + "end_header\n");

    write_in_pieces(file, vertices.size(), context, 0.0, 0.5, [&](std::string& out, std::uint64_t v) {
        append_bytes(out, mesh.positions[vertices[v].position]);
        if (mesh.has_normals()) append_bytes(out, mesh.normals[vertices[v].normal]);
    });
    const auto append_count = [&](std::string& out, std::uint64_t count) {
        if (short_lists)
            append_bytes(out, static_cast<std::uint8_t>(count));
        else
            append_bytes(out, static_cast<std::uint32_t>(count));
    };
    write_in_pieces(file, mesh.face_count(), context, 0.5, 1.0, [&](std::string& out, std::uint64_t f) {
        const std::uint64_t begin = mesh.face_begin(f), end = mesh.face_end(f);
        append_count(out, end - begin);
        for (std::uint64_t c = begin; c < end; ++c) append_bytes(out, split.corners()[c]);
        if (mesh.has_uvs()) {
            append_count(out, 2 * (end - begin));
            for (std::uint64_t c = begin; c < end; ++c) append_bytes(out, mesh.uvs[mesh.corner_uvs[c]]);
        }
        if (!mesh.face_material.empty()) append_bytes(out, mesh.face_material[f]);
        if (!mesh.face_group.empty()) append_bytes(out, mesh.face_group[f]);
    });
}

}  // namespace tetrakis::detail
