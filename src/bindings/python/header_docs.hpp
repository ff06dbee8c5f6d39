#pragma once

#include <string>
#include <string_view>

namespace tanor::python {

/// Returns what the public headers say of "Rods" or "Rods.length" (their `///` comments, by write_header_docs.py), or
/// an empty text.
std::string header_doc(std::string_view name);

}  // namespace tanor::python
