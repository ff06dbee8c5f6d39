#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace tanor::report {

/// Whether this program was built with zlib.
bool has_compression();

/// A complete gzip member (RFC 1952). Members one behind the other are one .gz file. Throws std::runtime_error where
/// there is no zlib.
std::string gzip(std::string_view bytes);

/// An array as `compressor="vtkZLibDataCompressor"` of VTK's XML files has it: UInt64 numbers that tell the sizes of
/// the blocks, then the blocks.
std::string compress_for_vtk(std::string_view bytes);
/// Takes that back from the beginning of `bytes`; nothing where they are no such array of `size` bytes.
std::optional<std::string> decompress_for_vtk(std::string_view bytes, std::size_t size);

}  // namespace tanor::report
