#pragma once

#include <string>

namespace tanor::cli {

/// Returns the function `symbol` of a module of the program (`tanor_view`, `tanor_picture`), which lies beside this
/// one. Throws InputError with `without` if this tanor was built without that module.
void* load_function(const std::string& module, const char* symbol, const std::string& without);

}  // namespace tanor::cli
