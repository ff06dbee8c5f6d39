#pragma once

#include <string>
#include <vector>

#include <tanor/error.hpp>

namespace tanor::report {

/// A problem whose answer is known, and what was found.
struct DigitsRow {
  std::string name;
  std::string known;      ///< from where: a closed form, published digits
  std::string method;     ///< that found the answer
  double promised = 0.0;  ///< digits
  double error = 0.0;     ///< relative
  double wall_s = 0.0;
  Outcome outcome{};  ///< why there is no answer

  /// -log10 of the relative error, 0 … 16; 0 where there is no answer.
  double won() const;
  bool keeps_promise() const { return outcome.ok() && won() >= promised; }
};

/// The table as text, a line each.
std::string format_digits(const std::vector<DigitsRow>& rows);

/// Ok, or which problems miss what they promise and why.
Outcome judge_digits(const std::vector<DigitsRow>& rows);

}  // namespace tanor::report
