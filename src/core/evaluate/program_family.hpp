#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/vec3.hpp"
#include "evaluate/series_program.hpp"
#include "evaluate/time_series.hpp"

namespace tanor::detail {

/// The source of a variable of a program: a coordinate or a velocity of one of a member's points, or a function of time
/// that the member has.
struct SeriesVariable {
  enum class Source { Position, Velocity, Time } source;
  int point = 0, component = 0;  ///< for Position and Velocity: point within the member
  int function = 0;              ///< for Time: number within the member
};

/// Lists the coordinates of the points, then their velocities if these are read, then functions of time.
inline std::vector<SeriesVariable> list_variables(int num_points, bool with_velocities, int num_functions) {
  using Source = SeriesVariable::Source;
  std::vector<SeriesVariable> variables;
  for (const Source source : {Source::Position, Source::Velocity}) {
    if (source == Source::Velocity && !with_velocities) continue;
    for (int i = 0; i < 3 * num_points; ++i) variables.push_back({source, i / 3, i % 3, 0});
  }
  for (int i = 0; i < num_functions; ++i) variables.push_back({Source::Time, 0, 0, i});
  return variables;
}

/// Members that share one expression, as series in time. `coefficients[k]` [3n] are those of the points.
class ProgramFamily {
 public:
  ProgramFamily(SeriesProgram program, std::vector<SeriesVariable> variables, int points_per_member,
                int functions_per_member)
      : program_(std::move(program)),
        variables_(std::move(variables)),
        points_per_member_(static_cast<std::size_t>(points_per_member)),
        functions_per_member_(static_cast<std::size_t>(functions_per_member)) {}

  /// Appends a member. `functions` are slots in a TimeSeriesTable.
  template <class Points>
  void append_member(const Points& points, std::span<const std::size_t> functions) {
    points_.insert(points_.end(), points.begin(), points.end());
    functions_.insert(functions_.end(), functions.begin(), functions.end());
    ++size_;
  }

  std::size_t size() const { return size_; }
  std::size_t num_chunks() const { return (size_ + series_width - 1) / series_width; }
  std::size_t points_per_member() const { return points_per_member_; }
  const SeriesProgram& program() const { return program_; }

  /// Makes room for series up to this order.
  void resize(int order) {
    order_ = order;
    lanes_per_chunk_ = program_.num_lanes(order);
    lanes_.resize(num_chunks() * lanes_per_chunk_ * (is_alone() ? 1 : series_width));
  }

  int order() const { return order_; }
  /// Calls body(chunk, lanes) with the lanes of each chunk. A member that is alone has plain numbers, which take an
  /// eighth of the memory.
  template <class Body>
  void for_each_chunk(const Parallel& parallel, const Body& body) {
    if (is_alone()) return body(0, lanes_.data());
    const auto run = [&](std::size_t begin, std::size_t end) {
      for (std::size_t chunk = begin; chunk < end; ++chunk)
        body(chunk, reinterpret_cast<SeriesLane*>(lanes_.data()) + chunk * lanes_per_chunk_);
    };
    parallel.for_ranges(num_chunks(), run, 16);
  }
  /// Returns the member in a lane. The last chunk repeats the last member.
  std::size_t member(std::size_t chunk, std::size_t lane) const {
    return std::min(chunk * series_width + lane, size_ - 1);
  }

  /// Loads coefficient k of the variables of a chunk into its lanes. If `points_known` is false, that of the points is
  /// taken as 0.
  template <class Lane>
  void load(Lane* base, std::size_t chunk, int k, std::span<double* const> coefficients, const TimeSeriesTable& table,
            bool points_known = true) {
    const std::size_t count = std::min(series_width, size_ - chunk * series_width);
    for (std::size_t i = 0; i < variables_.size(); ++i) {
      const SeriesVariable& variable = variables_[i];
      Lane& values = program_.variable(base, order_, i)[k];
      if (variable.source != SeriesVariable::Source::Time && !points_known) {
        values = Lane{};
        continue;
      }
      for (std::size_t lane = 0; lane < count; ++lane) {
        const std::size_t m = member(chunk, lane);
        if (variable.source == SeriesVariable::Source::Time) {
          const std::size_t slot = functions_[m * functions_per_member_ + static_cast<std::size_t>(variable.function)];
          member_of(values, lane) = table[slot][k];
          continue;
        }
        // v = r' gives v_k = (k + 1) r_{k+1}.
        const bool is_position = variable.source == SeriesVariable::Source::Position;
        const double* const from = coefficients[static_cast<std::size_t>(is_position ? k : k + 1)];
        const std::size_t place = 3 * point(m, variable.point) + static_cast<std::size_t>(variable.component);
        member_of(values, lane) = is_position ? from[place] : (k + 1) * from[place];
      }
      for (std::size_t lane = count; lane < width_of<Lane>; ++lane)
        member_of(values, lane) = member_of(values, count - 1);
    }
  }

  std::size_t point(std::size_t m, int p) const {
    return static_cast<std::size_t>(points_[m * points_per_member_ + static_cast<std::size_t>(p)]);
  }
  const std::vector<SeriesVariable>& variables() const { return variables_; }

 private:
  bool is_alone() const { return size_ == 1; }

  SeriesProgram program_;
  std::vector<SeriesVariable> variables_;
  std::size_t points_per_member_, functions_per_member_, size_ = 0;
  std::vector<int> points_;             // [member][point], inner
  std::vector<std::size_t> functions_;  // [member][function]
  std::vector<double> lanes_;           // [chunk][…][series_width or 1]
  std::size_t lanes_per_chunk_ = 0;
  int order_ = 0;
};

}  // namespace tanor::detail
