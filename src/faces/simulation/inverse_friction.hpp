#pragma once

#include <vector>

#include "dynamics/split.hpp"
#include "friction/fixed_point.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// Finds the friction of a given motion from lambda = Gamma^-1 K'(Mw - f - tau(lambda)), one nonlinear solve with the
/// factor of Gamma (docs/theory.md). Contacts with an exact Coulomb law have none at rest, since the law gives only a
/// bound there.
class InverseFriction final : private Response {
 public:
  /// Both arguments must outlive the object.
  InverseFriction(Workspace& work, NormalSpace& normal);

  /// Finds tau [3n] at (t, r, v) for `force` = Mw - f [3n]; `normal` and K in `blocks` must be current there.
  Outcome find(double t, const std::vector<double>& r, const std::vector<double>& v, const std::vector<double>& blocks,
               const std::vector<double>& force, std::vector<double>* tau);

 private:
  void find_multipliers(const double* x, double* lambda) override;
  void find_change(const double* x, double* lambda) override;
  void add(double sign, const double* x, std::vector<double>* points);

  Workspace& work_;
  const Model& model_;
  NormalSpace& normal_;
  FrictionLaws laws_;
  FrictionScales scales_;
  FixedPoint fixed_point_;
  const std::vector<double>* force_ = nullptr;
  std::vector<double> lambda_;         // [rows]
  std::vector<double> forces_;         // [3 contacts]
  std::vector<double> points_, part_;  // [3n] scratch
};

}  // namespace tanor::detail
