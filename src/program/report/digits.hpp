#pragma once

#include <string>
#include <vector>

#include <tanor/error.hpp>

#include "report/json_text.hpp"

namespace tanor::report {

/// A problem whose answer is known, and the answer that was found.
struct DigitsRow {
  std::string name;
  std::string known;      ///< the source: a closed form, published digits
  std::string method;     ///< the method that found the answer
  double promised = 0.0;  ///< digits
  double error = 0.0;     ///< relative
  double wall_s = 0.0;
  Outcome outcome{};  ///< why there is no answer

  /// Returns the digits of the answer, -log10 of the relative error within 0 … 16, and 0 if there is no answer.
  double won() const;
  bool keeps_promise() const { return outcome.ok() && won() >= promised; }
};

/// Returns the table as text, one line for each problem.
std::string format_digits(const std::vector<DigitsRow>& rows);

/// Returns the same as JSON.
Json describe_digits(const std::vector<DigitsRow>& rows);

/// Returns Ok, or names the problems that miss what they promise, with the reasons.
Outcome verify_digits(const std::vector<DigitsRow>& rows);

}  // namespace tanor::report
