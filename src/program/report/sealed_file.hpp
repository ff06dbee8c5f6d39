#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

#include "report/output_file.hpp"

/// \file Sealed files, which are read back: a first line that names the format, the content, and a last line with the
/// checksum of everything before.
namespace tanor::report {

/// Replaces a file; `content` comes in pieces. Binary content must follow a line that ends.
void write_sealed(const std::filesystem::path& path, Wait wait, std::string_view first_line,
                  std::initializer_list<std::string_view> content);

enum class Seal { Sound, OtherFormat, Damaged };

/// Finds the content between the first line and the last, if both are correct.
Seal open_sealed(std::string_view text, std::string_view first_line, std::string_view* content);

}  // namespace tanor::report
