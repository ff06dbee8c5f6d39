#pragma once

#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Moves r [3n], however far, to the nearest configuration on xi = 0 in the M-norm. Newton's method reaches some
/// configuration there, and descent along xi = 0 then shortens the distance. If rows contradict each other to first
/// order alone, as those of a straight chain that is longer than its gap, it begins from a configuration bent a little,
/// and goes where the forces draw the points, for a chain the catenary.
class NearestPoint {
 public:
  NearestPoint(Workspace& work, Linearization& linearization, Projector& projector)
      : work_(work),
        model_(work.model()),
        linearization_(linearization),
        projector_(projector),
        rows_(model_.num_rows()) {}

  ProjectionReport find(double t, double* r);

 private:
  ProjectionReport reach_from_bent(double t, double* r, std::vector<double>* wanted);
  ProjectionReport reach_constraints(double t, double* r);
  Outcome bend(double t, int trial, std::vector<double>* fall, double* r);
  Outcome find_slope(const std::vector<double>& wanted, double t, const double* r, double* d);
  bool is_nearest(const double* r, const std::vector<double>& wanted, const double* d) const;
  double product(const double* a, const double* b) const;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Projector& projector_;
  std::vector<double> rows_;  // [d] scratch
};

}  // namespace tanor::detail
