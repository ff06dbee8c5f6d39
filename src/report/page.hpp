#pragma once

#include <string>

#include "report/summary.hpp"

namespace tanor::report {

/// Describes a run on one page of text: what it was, what it did, where the time went, and how good it is.
std::string format_page(const RunFacts& facts, const Simulation& simulation);

}  // namespace tanor::report
