#pragma once

#include <string>
#include <vector>

#include <tanor/export.hpp>
#include <tanor/system.hpp>

namespace tanor {

/// What is allowed and does nothing, so that something else may have been meant, a sentence each: bonds along rods
/// whose lengths stand. Everything that solves a system says it in `left_out`.
TANOR_API std::vector<std::string> find_warnings(const System& system);

}  // namespace tanor
