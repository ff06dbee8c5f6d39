#pragma once

#include <string>

#include "report/summary.hpp"

namespace tanor::report {

inline constexpr const char* page_name = "report.txt";
inline constexpr std::size_t page_column = 16;  ///< column at which the text of a row begins

/// Describes a run on one page of text: what it was, what it did, where the time went, and how accurate it is.
std::string format_page(const RunFacts& facts, Simulation& simulation);

}  // namespace tanor::report
