#include "dynamics/mechanics.hpp"

#include <array>

namespace tanor::detail {

Outcome Mechanics::agree_on_accelerations(const AccelerationOutput& to, const std::function<Outcome()>& work) {
  double residual = 0.0;
  Outcome outcome = together(
      [&] {
        Outcome own = work();
        if (to.report != nullptr) residual = to.report->residual;
        return own;
      },
      {&residual, 1});
  if (to.report != nullptr) {
    to.report->residual = residual;
    to.report->reciprocal_condition = reciprocal_condition();
  }
  if (outcome.ok() && to.power != nullptr) *to.power = sum(*to.power);
  return outcome;
}

ProjectionReport Mechanics::agree_on_projection(const std::function<ProjectionReport()>& work) {
  ProjectionReport report;
  std::array<double, 3> numbers{};
  report.outcome = together(
      [&] {
        ProjectionReport own = work();
        numbers = {own.violation, own.correction, static_cast<double>(own.iterations)};
        return own.outcome;
      },
      numbers);
  report.violation = numbers[0];
  report.correction = numbers[1];
  report.iterations = static_cast<int>(numbers[2]);
  return report;
}

}  // namespace tanor::detail
