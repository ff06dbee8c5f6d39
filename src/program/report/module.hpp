#pragma once

#include <string>

namespace tanor::report {

/// Returns the function `symbol` of a module of the program (`tanor_view`, `tanor_h5md`, …), which lies beside the
/// executable (build tree), or where it was installed. Throws InputError with `without` if this tanor was built without
/// that module.
void* load_function(const std::string& module, const char* symbol, const std::string& without);

}  // namespace tanor::report
