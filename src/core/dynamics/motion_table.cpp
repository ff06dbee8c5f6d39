#include <tanor/inverse_dynamics.hpp>

#include <utility>

#include "base/live.hpp"
#include "system/spline.hpp"

namespace tanor {
using namespace detail;

struct MotionTable::Implementation {
  std::vector<double> times;
  std::vector<Spline> columns;
};

MotionTable::MotionTable(std::vector<double> times, std::vector<double> values, std::size_t columns)
    : implementation_(std::make_unique<Implementation>()) {
  if (columns == 0 || values.size() != times.size() * columns) {
    throw InputError("", "motion: " + std::to_string(values.size()) + " numbers for " + std::to_string(times.size()) +
                             " times of " + std::to_string(columns) + " columns");
  }
  std::vector<double> column(times.size());
  for (std::size_t j = 0; j < columns; ++j) {
    for (std::size_t k = 0; k < times.size(); ++k) column[k] = values[k * columns + j];
    implementation_->columns.emplace_back(times, column);
  }
  implementation_->times = std::move(times);
}
MotionTable::MotionTable(MotionTable&&) noexcept = default;
MotionTable& MotionTable::operator=(MotionTable&&) noexcept = default;
MotionTable::~MotionTable() = default;

std::span<const double> MotionTable::times() const {
  return live(implementation_, "MotionTable").times;
}
std::size_t MotionTable::num_columns() const {
  return live(implementation_, "MotionTable").columns.size();
}

MotionState MotionTable::at(double t) const {
  MotionState result;
  for (const Spline& column : live(implementation_, "MotionTable").columns) {
    const Jet<2> x = column.evaluate(t);
    result.value.push_back(x.value());
    result.rate.push_back(x.derivative(1));
    result.acceleration.push_back(x.derivative(2));
  }
  return result;
}

}  // namespace tanor
