#pragma once

// Private to eval/io: one decoder per format, from the bytes of a whole file; mesh_reader picks.

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tetrakis::detail {

/// Elements of a kind that 32-bit indices can tell apart, with one number left for none.
inline constexpr std::uint32_t k_most_elements = 0xFFFF'FFFEu;

TriangleMesh decode_obj(std::string_view text, const std::filesystem::path& path, const RunContext& context);
TriangleMesh decode_ply(std::string_view bytes, const std::filesystem::path& path, const RunContext& context);
TriangleMesh decode_gltf(std::string_view bytes, const std::filesystem::path& path);

/// A number at the front of `text`, which moves past it; an optional '+' is taken. False where there is none. Numbers
/// too large for a double become infinite, too small ones zero.
bool take_number(std::string_view& text, double& value);
bool take_integer(std::string_view& text, long long& value);

}  // namespace tetrakis::detail
