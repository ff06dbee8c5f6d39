#pragma once

#include <string>

#include "report/summary.hpp"

namespace tanor::report {

inline constexpr const char* page_name = "report.txt";
inline constexpr std::size_t page_column = 16;  ///< where what a row says begins

/// A run on one page of text: what it was, what it did, where the time went, how good it is.
std::string format_page(const RunFacts& facts, Simulation& simulation);

}  // namespace tanor::report
