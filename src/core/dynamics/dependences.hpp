#pragma once

#include <string>
#include <vector>

#include "dynamics/workspace.hpp"
#include "schur/redundancy.hpp"

namespace tanor::detail {

/// The rows of K that depend on others by the last decision, with what they say of residuals, and their names.
class Dependences : public Redundancy {
 public:
  explicit Dependences(const Workspace& work);
  virtual ~Dependences() = default;

  /// Notes that the dependent rows have changed with K in `blocks`.
  void note_change(const std::vector<double>& blocks);

  virtual bool is_found() const { return Redundancy::is_found(); }
  virtual bool is_dependent(std::size_t row) const { return Redundancy::is_dependent(row); }
  virtual void minimize_norm(double* lambda) const { Redundancy::minimize_norm(lambda); }

  /// Return the largest |row|/|gradient|/unit of rows that do not depend on others, and of those that do; `units`
  /// [neighbourhood].
  double largest_active(const std::vector<double>& rows, const std::vector<double>& units) const;
  double largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const;
  /// Names a dependent row that contradicts the others by more than `allowed`, if there is one. `rows` are xi,
  /// K'v + xi_t or phi + K'w0, and `sizes` their scale for unit gradients in each neighbourhood. `unit` is e.g. " m/s".
  virtual Outcome explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                        double allowed, const char* unit) const;
  /// Returns e.g. "rods[5] depends on rods[0], rods[3], …".
  std::string describe(const Found& found, const char* verb) const;

 private:
  const Workspace& work_;
  std::vector<double> gradient_norms_;  // [d] when the dependent rows changed last; empty before
};

}  // namespace tanor::detail
