#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "evaluate/distance_series.hpp"
#include "evaluate/family.hpp"
#include "evaluate/program_family.hpp"
#include "evaluate/time_series.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// All constraints of a system as series in time. Distances are hand-written, every other kind runs on its definition.
class ConstraintSeries {
 public:
  /// `incidences` of K; `t0`: where "initial" values stand.
  ConstraintSeries(const System& system, const Numbering& numbering, std::span<const Incidence> incidences, double t0);

  /// Why there are no series: names the constraint; empty: there are.
  const std::string& obstacle() const { return obstacle_; }

  /// Begins at t with series up to `order`.
  void begin(double t, int order);
  /// Those incidences whose blocks `advance` writes. What the others add to K lambda is K_0 lambda_k alone: their
  /// gradients do not turn.
  std::vector<Incidence> turning(std::span<const Incidence> incidences) const;
  /// s: the series of the functions of time hold up to there.
  double smooth_until() const { return table_.smooth_until(); }

  /// For order k = 0, 1, …: coefficient k of K lambda without K_0 lambda_k, into `blocks`, whose places are those of K
  /// (a row's blocks hold the share of all rows of its member); coefficient k + 2 of xi without K_0'r_{k+2}, into
  /// `rows` [d]. `coefficients` [3n] of the points are known up to k + 1, lambda [d] up to k - 1, which is `last`.
  void advance(const Parallel& parallel, int k, std::span<double* const> coefficients, const double* last,
               double* blocks, double* rows);

  /// Rates of the constraints [d] to those of the functions that the multipliers of the series belong to, at the time s
  /// behind the beginning, by the first `terms` coefficients: distances are others there (DistanceSeries).
  void scale_rates(double s, int terms, double* rates) const { distances_.scale_rates(s, terms, rates); }

 private:
  /// A line's direction, as functions in the table, and the axis that its two unit vectors come from.
  struct Turning {
    std::array<std::size_t, 3> direction;
    LineAxis axis;
  };
  struct Group {
    ProgramFamily family;
    bool is_linear = false;
    std::vector<Index> rows{};         // [member] its first inner row
    std::vector<Index> blocks{};       // [member][point] of its first row
    std::optional<Turning> turning{};  // of lines that turn
    bool takes_part = true;            // else its axis is another one's than the rule's
  };
  struct Source;
  void add_group(const Source& source, std::size_t g, const Rods& rods, std::size_t first_member);
  void add_group(const Source& source, std::size_t g, const Spheres& spheres, std::size_t first_member);
  template <class G>
  void add_group(const Source& source, std::size_t g, const G& given, std::size_t first_member);
  template <class G>
  void add_recorded(const Source& source, std::size_t g, const G& given, std::size_t first_member,
                    std::optional<Turning> turning);
  template <class Lane>
  void advance_chunk(Group& group, Lane* lanes, std::size_t chunk, int k, std::span<double* const> coefficients,
                     const double* last, double* blocks, double* rows);

  TimeSeriesTable table_;
  DistanceSeries distances_;
  std::vector<Group> groups_;
  std::vector<Index> still_rows_;  // linear, and nothing in them depends on time: no coefficient but K_0'r_{k+2}
  std::string obstacle_;
};

}  // namespace tanor
