#pragma once

#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <string_view>

namespace tetrakis {

/// A scheme of scheme_table(), given by its kind, its name or its entry there.
class SchemeChoice {
  public:
    SchemeChoice(SchemeKind kind) : info_(find_scheme(name(kind))) {}
    SchemeChoice(const SchemeInfo& info) : info_(&info) {}
    /// @throws Error  invalid_input: no such name; the message has the nearest one
    SchemeChoice(std::string_view name) : info_(&scheme_named(name)) {}
    SchemeChoice(const char* name) : SchemeChoice(std::string_view(name)) {}

    const SchemeInfo& info() const { return *info_; }
    std::string_view name() const { return info_->name; }

  private:
    static std::string_view name(SchemeKind kind) { return tetrakis::name(kind); }
    const SchemeInfo* info_;
};

}  // namespace tetrakis
