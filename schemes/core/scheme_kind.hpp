#pragma once

#include <optional>
#include <string_view>

namespace tetrakis {

/// The schemes a call can ask for.
enum class SchemeKind { catmull_clark, loop };

/// The scheme's name on the command line and in reports: "catmull-clark", "loop".
std::string_view name(SchemeKind kind);
/// The scheme of that name; empty for an unknown one.
std::optional<SchemeKind> scheme_from_name(std::string_view name);

}  // namespace tetrakis
