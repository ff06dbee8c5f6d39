#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace tanor::report {

/// Returns true if this program was built with zlib.
bool has_compression();

/// Returns a complete gzip member (RFC 1952). Concatenated members form one .gz file. Throws std::runtime_error if
/// there is no zlib.
std::string gzip(std::string_view bytes);

/// Returns an array in the format of `compressor="vtkZLibDataCompressor"` in VTK's XML files: UInt64 numbers with the
/// sizes of the blocks, then the blocks.
std::string compress_for_vtk(std::string_view bytes);
/// Unpacks such an array from the beginning of `bytes`; returns nothing if there is no array of `size` bytes.
std::optional<std::string> decompress_for_vtk(std::string_view bytes, std::size_t size);

}  // namespace tanor::report
