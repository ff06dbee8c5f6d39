#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "schur/path_kernels.hpp"
#include "schur/path_rows.hpp"
#include "schur/path_separators.hpp"

namespace tanor::detail {

/// The factor of S of paths, and right sides on the way up and down.
struct PathFactor {
  Packs inverse_mass, l, inverse_pivot, b, y;  ///< [slot]
  std::vector<Separator> separators;

  explicit PathFactor(const PathRows& rows);
  std::span<Separator> of(const PathRows::Cut& cut) {
    return std::span(separators).subspan(cut.first_separator, cut.end_separator - cut.first_separator);
  }
  /// Returns the separator before another one of a path; one of no effect before the first one of an open path.
  const Separator& before(const PathRows::Cut& cut, std::size_t separator) const;
};

/// The arrays of a thread for one block of pieces, [length + 1] or [length].
struct PathWorkspace {
  std::vector<Pack3<>> r, v, w, offset, u;
  Packs changes, spikes, x;
  paths::Found found;
  std::size_t next_point = 0;  ///< the first point of the path that was not brought

  explicit PathWorkspace(std::size_t most_rods);
};

/// One block of pieces of a path in the lanes of a workspace.
class PathBlock {
 public:
  PathBlock(const PathRows& rows, PathFactor* factor, const PathRows::Cut& cut, const PathPieces& of,
            PathWorkspace* work);

  /// Returns the point behind the last piece.
  std::size_t last_point() const { return of_.first_point + of_.num_points(); }

  // ---- up ----
  /// Reads r, and v and w0 if there are any. `change` says which derivative of the lengths counts. The next pieces will
  /// need their part of r, v and of `blocks`, unless that is null.
  paths::Motion read_motion(const FreeMotion& motion, const double* blocks,
                            double MovingScalar::*change = &MovingScalar::second);
  void read_directions(const double* blocks) { rows_.read_directions(of_, blocks, work_.u.data()); }
  void write_directions(double* blocks) const { rows_.write_directions(of_, work_.u.data(), blocks); }
  void read_right_side(const double* b);
  void evaluate(const paths::Motion& motion) { paths::evaluate(arrays_, motion, &work_.found); }
  void evaluate_values(const double* r);
  void evaluate_rates(const double* r, const double* v);
  void find_directions(const paths::Motion& motion) { paths::find_directions(arrays_, motion); }
  void eliminate();
  void evaluate_and_eliminate(const paths::Motion& motion);
  void substitute_forward();

  // ---- down ----
  /// Computes the multipliers once those of the separators are known.
  void substitute_backward();
  void read_multipliers(const double* rows);
  void write_multipliers(double* rows) const;
  void add_multipliers(double* sum) const;
  /// Computes dw = M^-1 K x of all points but the last, and the residual if it is wanted. The next pieces will need
  /// their part of `blocks` and `w`.
  void accelerate(const double* blocks, const double* w, bool wants_residual);
  /// Writes w := w0 + dw, or adds dw to w if `w0` is null.
  void write_accelerations(const Vec3* w0, double* w);

 private:
  const double* next_blocks(const double* blocks) const {
    return blocks != nullptr ? blocks + 3 * rows_.block(of_.first_row + of_.num_points()) : nullptr;
  }
  Sequences rows_of_lanes() const { return of_.sequences(of_.first_row, of_.length); }
  void read_points(const double* from, std::size_t count, std::vector<Pack3<>>* to) const;
  void hand_over_factor(const paths::Border& border);
  void hand_over_right_side(const paths::Border& border);

  const PathRows& rows_;
  const PathPieces& of_;
  PathWorkspace& work_;
  std::span<Separator, num_lanes> separators_;
  const Separator& before_;  // the one before the first piece
  bool is_followed_;         // true if the path has pieces behind these
  paths::Pieces arrays_;
};

}  // namespace tanor::detail
