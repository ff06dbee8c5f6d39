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

namespace tanor::detail {

/// All constraints of a system as series in time. Distances are hand-written; every other kind runs on its definition.
class ConstraintSeries {
 public:
  /// `incidences` are those of K. `t0` is the instant of "initial" values. Rods with a `takes_part` [row] of 0 are left
  /// out; if it is empty, all take part.
  ConstraintSeries(const System& system, const Numbering& numbering, std::span<const Incidence> incidences, double t0,
                   std::span<const char> takes_part = {});

  /// Names the constraint that has no series, and why. Returns an empty string if all have one.
  const std::string& obstacle() const { return obstacle_; }

  /// Begins at t with series up to `order`.
  void begin(double t, int order);
  /// Returns the incidences whose blocks `advance` writes. The gradients of the others do not turn, so that these add
  /// K_0 lambda_k alone to K lambda.
  std::vector<Incidence> turning(std::span<const Incidence> incidences) const;
  /// Returns the time up to which the series of the functions of time hold, s.
  double smooth_until() const { return table_.smooth_until(); }

  /// Advances to order k = 0, 1, …. Writes coefficient k of K lambda without K_0 lambda_k into `blocks`, which stand as
  /// those of K (the blocks of a member's first row hold the share of all its rows), and coefficient k + 2 of xi
  /// without K_0'r_{k+2} into `rows` [d]. The points' `coefficients` [3n] are known up to k + 1, those of lambda [d] up
  /// to k - 1, which is `last`.
  void advance(const Parallel& parallel, int k, std::span<double* const> coefficients, const double* last,
               double* blocks, double* rows);

  /// Converts rates of the constraints [d] to rates of the functions that the multipliers of the series belong to, at
  /// the time s behind the beginning. Only distances differ (see DistanceSeries); their first `terms` coefficients are
  /// read.
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
    std::vector<Index> blocks{};       // [member][point] block of its first row
    std::optional<Turning> turning{};  // set for lines that turn
    bool takes_part = true;            // false if the rule chooses another axis
  };
  struct Source;
  void add_group(const Source& source, std::size_t g, const Rods& rods, std::size_t first_member);
  void add_group(const Source& source, std::size_t g, const Spheres& spheres, std::size_t first_member);
  template <class G>
  void add_group(const Source& source, std::size_t g, const G& given, std::size_t first_member);
  template <class G>
  void add_recorded(const Source& source, std::size_t g, const G& given, std::size_t first_member,
                    std::optional<Turning> turning);
  template <class G>
  void add_members_like(const Source& source, std::size_t g, const G& given, std::size_t first_member,
                        std::optional<Turning> turning, std::size_t member);
  template <class Lane>
  void advance_chunk(Group& group, Lane* lanes, std::size_t chunk, int k, std::span<double* const> coefficients,
                     const double* last, double* blocks, double* rows);

  TimeSeriesTable table_;
  DistanceSeries distances_;
  std::vector<Group> groups_;
  std::vector<Index> still_rows_;  // linear and independent of time: K_0'r_{k+2} is their only coefficient
  std::string obstacle_;
};

}  // namespace tanor::detail
