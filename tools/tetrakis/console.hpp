#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::cli {

/// One line on standard error: "tetrakis: error: ..." and "tetrakis: warning: ...".
void print_error(std::string_view text);
void print_warning(std::string_view text);
/// Each warning once; of many, the first few and how many more there are.
void print_warnings(const std::vector<std::string>& warnings);

/// A list of named values on standard output, the values one below the other. An empty name continues the value above.
class Table {
  public:
    void row(std::string name, std::string value) { rows_.emplace_back(std::move(name), std::move(value)); }
    void print() const;

  private:
    std::vector<std::pair<std::string, std::string>> rows_;
};

/// Whether everything printed has reached standard output.
bool flush_output();

/// "1 234 567", "12.3 MB", "0.42 s" and lengths as people read them.
std::string format_count(unsigned long long n);
std::string format_bytes(unsigned long long bytes);
std::string format_seconds(double seconds);
std::string format_length(double length);

}  // namespace tetrakis::cli
