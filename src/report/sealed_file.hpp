#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

#include "report/output_file.hpp"

/// \file Files of ours that are read back: a first line that names the format, what they hold, and a last line with the
/// checksum of everything before.
namespace tanor::report {

/// Replaces a file; `content` comes in pieces. A file that holds bytes puts them behind a line that ends.
void write_sealed(const std::filesystem::path& path, Wait wait, std::string_view first_line,
                  std::initializer_list<std::string_view> content);

enum class Seal { Sound, OtherFormat, Damaged };

/// What a file holds between its first line and its last, if these are what was written.
Seal open_sealed(std::string_view text, std::string_view first_line, std::string_view* content);

}  // namespace tanor::report
