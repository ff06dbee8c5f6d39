#pragma once

#include <string>
#include <vector>

#include <tanor/export.hpp>
#include <tanor/system.hpp>

namespace tanor {

/// Returns what is allowed but has no effect, so that something else may have been meant, one sentence each: bonds
/// along rods of constant length, supports of one name. Everything that solves a system reports it in `left_out`.
TANOR_API std::vector<std::string> find_warnings(const System& system);

}  // namespace tanor
