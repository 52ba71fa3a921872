#include "scheme_kind.hpp"

namespace tetrakis {

std::string_view name(SchemeKind kind) { return kind == SchemeKind::loop ? "loop" : "catmull-clark"; }

std::optional<SchemeKind> scheme_from_name(std::string_view text) {
    for (SchemeKind kind : {SchemeKind::catmull_clark, SchemeKind::loop})
        if (name(kind) == text) return kind;
    return std::nullopt;
}

}  // namespace tetrakis
