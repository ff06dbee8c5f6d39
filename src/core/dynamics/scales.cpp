#include "dynamics/scales.hpp"

#include <limits>

namespace tanor::detail {

Scales::Scales(const Neighbourhoods& neighbourhoods, const Numbering& numbering, std::span<const Incidence> incidences,
               double scene_size)
    : num_points_(numbering.num_points()),
      of_point_(numbering.num_moving),
      of_row_(numbering.num_rows(), -1),
      length_(neighbourhoods.length) {
  for (std::size_t i = 0; i < of_point_.size(); ++i)
    of_point_[i] = neighbourhoods.of_point[static_cast<std::size_t>(numbering.user_point[i])];
  for (const Incidence& incidence : incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    if (point < of_point_.size()) of_row_[static_cast<std::size_t>(incidence.row)] = of_point_[point];
  }
  has_rows_.assign(length_.size() + 1, 0);
  for (Index& own : of_row_) {
    if (own >= 0)
      has_rows_[static_cast<std::size_t>(own)] = 1;
    else
      own = static_cast<Index>(length_.size());
  }
  of_all_points_ = of_point_;
  of_all_points_.resize(num_points_, static_cast<Index>(length_.size()));
  length_.push_back(scene_size);
  set_speeds(std::vector<double>(size(), 0.0));
}

void Scales::set_speeds(std::span<const double> speeds) {
  speed_.assign(speeds.begin(), speeds.end());
  derive_from_speeds();
}

void Scales::exchange_memory(Memory& memory) {
  memory.exchange(speed_);
  if (memory.reads()) derive_from_speeds();
  if (!are_all_) memory.exchange(least_speed_, least_acceleration_);
}

void Scales::derive_from_speeds() {
  least_speed_ = least_acceleration_ = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < size(); ++k) {
    if (!(speed_[k] > 0.0)) speed_[k] = 1.0;
    if (has_rows_[k] == 0) continue;
    least_speed_ = std::min(least_speed_, speed_[k]);
    least_acceleration_ = std::min(least_acceleration_, speed_[k] * speed_[k] / length_[k]);
  }
  constexpr double part = 1e-10;
  const std::size_t last = size() - 1;
  const auto tolerances = [&](const std::vector<double>& scale, std::vector<double>* result) {
    result->clear();
    for (const Index own : of_point_) result->push_back(part * scale[static_cast<std::size_t>(own)]);
    result->resize(num_points_, part * scale[last]);
  };
  tolerances(length_, &position_tolerance_);
  tolerances(speed_, &velocity_tolerance_);
  acceleration_.resize(num_points_);
  for (std::size_t i = 0; i < num_points_; ++i)
    acceleration_[i] = velocity_tolerance_[i] * velocity_tolerance_[i] / (part * position_tolerance_[i]);
}

}  // namespace tanor::detail
