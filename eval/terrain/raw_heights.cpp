#include "height_files.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/files.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <regex>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

namespace tetrakis::detail {

namespace {

class RawSource final : public HeightSource {
  public:
    RawSource(const std::filesystem::path& path, const HeightReadOptions& options, HeightFormat format)
        : path_(path),
          options_(options),
          format_(format),
          number_bytes_(format == HeightFormat::raw_float ? 4 : 2),
          is_big_endian_(format == HeightFormat::hgt || options.big_endian) {
        // Other files, like pipes, are read at once; read_file() also throws the error of a file that cannot be opened.
        std::error_code none;
        if (std::filesystem::is_regular_file(path, none))
            bytes_ = std::make_unique<std::ifstream>(path, std::ios::binary);
        if (!bytes_ || !*bytes_) bytes_ = std::make_unique<std::istringstream>(read_file(path, options.context));
        const auto size = static_cast<std::uint64_t>(bytes_->seekg(0, std::ios::end).tellg());
        if (size == 0) refuse("the file is empty");
        if (size % number_bytes_ != 0)
            refuse(
                fmt::format("{} bytes are no whole number of heights of {} bytes: the file is cut off or has another "
                            "format",
                            size, number_bytes_));
        set_size(size / number_bytes_);
        if (format == HeightFormat::hgt) set_hgt_spacing();
        if (options.spacing) frame_.spacing = *options.spacing;
    }

    const HeightGrid& frame() const override { return frame_; }

    void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) override {
        const std::size_t row_bytes = frame_.columns * number_bytes_;
        buffer_.resize(count * row_bytes);
        bytes_->clear();
        bytes_->seekg(static_cast<std::streamoff>(first_row * row_bytes));
        if (!bytes_->read(buffer_.data(), static_cast<std::streamsize>(buffer_.size())))
            throw Error(ErrorCode::io, fmt::format("rows from {} on cannot be read", first_row), path_);
        const auto* next = reinterpret_cast<const unsigned char*>(buffer_.data());
        for (float& height : heights.first(std::size_t{count} * frame_.columns)) {
            std::uint32_t bits = 0;
            for (std::size_t i = 0; i < number_bytes_; ++i)
                bits |= std::uint32_t{next[is_big_endian_ ? number_bytes_ - 1 - i : i]} << (8 * i);
            height = height_of(number(bits), options_);
            next += number_bytes_;
        }
    }

  private:
    [[noreturn]] void refuse(const std::string& text) const { throw Error(ErrorCode::invalid_input, text, path_); }

    double number(std::uint32_t bits) const {
        if (format_ == HeightFormat::raw16) return bits;
        if (format_ == HeightFormat::raw_float) return double{std::bit_cast<float>(bits)};
        const auto height = static_cast<std::int16_t>(bits);
        return height == std::numeric_limits<std::int16_t>::min() ? std::numeric_limits<double>::quiet_NaN()
                                                                  : static_cast<double>(height);
    }

    void set_size(std::uint64_t count) {
        const bool is_hgt = format_ == HeightFormat::hgt;
        std::uint64_t columns = is_hgt ? 0 : options_.columns, rows = is_hgt ? 0 : options_.rows;
        if (columns == 0 && rows == 0) {
            columns = rows = static_cast<std::uint64_t>(std::llround(std::sqrt(static_cast<double>(count))));
            if (columns * columns != count)
                refuse(fmt::format("the file has {} heights, which are not a square; {}", count,
                                   is_hgt ? "that of an HGT is one" : "say how many columns there are"));
        }
        if (columns == 0) columns = count / rows;
        if (rows == 0) rows = count / columns;
        if (columns * rows != count)
            refuse(fmt::format("the file has {} heights, not {} columns times {} rows", count, columns, rows));
        frame_ = empty_frame(columns, rows, path_);
    }

    /// Sets the spacing in metres of a square of one degree, whose south-west corner is in the file's name.
    void set_hgt_spacing() {
        const std::string name = path_.stem().string();
        if (!std::regex_search(name, std::regex("^[NnSs][0-9][0-9]"))) return;
        const double south = (name[0] == 'S' || name[0] == 's' ? -1 : 1) * std::stoi(name.substr(1, 2));
        const double along = k_metres_a_degree / (frame_.rows - 1);
        frame_.spacing = {along * std::cos((south + 0.5) * std::numbers::pi / 180), along};
    }

    std::filesystem::path path_;
    HeightReadOptions options_;
    HeightFormat format_;
    std::size_t number_bytes_;
    bool is_big_endian_;
    HeightGrid frame_;
    std::unique_ptr<std::istream> bytes_;
    std::vector<char> buffer_;
};

}  // namespace

HeightFormat format_of(const std::filesystem::path& path, const HeightReadOptions& options) {
    if (options.format != HeightFormat::automatic) return options.format;
    const std::string extension = lower_extension(path);
    if (extension == ".png") return HeightFormat::png;
    if (extension == ".hgt") return HeightFormat::hgt;
    if (extension == ".r16" || extension == ".raw") return HeightFormat::raw16;
    if (extension == ".r32" || extension == ".f32") return HeightFormat::raw_float;
    return HeightFormat::gdal;
}

float height_of(double number, const HeightReadOptions& options) {
    // Compared in single precision, as in files: no float is exactly -9999.9, for example.
    if (!std::isfinite(number) ||
        (options.no_data && static_cast<float>(number) == static_cast<float>(*options.no_data)))
        return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>(options.offset + options.scale * number);
}

std::unique_ptr<HeightSource> open_raw_heights(const std::filesystem::path& path, const HeightReadOptions& options,
                                               HeightFormat format) {
    return std::make_unique<RawSource>(path, options, format);
}

}  // namespace tetrakis::detail
