#pragma once

#include <string>

#include "report/summary.hpp"

namespace tanor::report {

inline constexpr const char* page_name = "report.txt";

/// A run on one page of text: what it was, what it did, where the time went, how good it is.
std::string format_page(const RunFacts& facts, Simulation& simulation);

}  // namespace tanor::report
