#pragma once

#include <complex>
#include <memory>
#include <span>
#include <vector>

#include "assembly/newton_plan.hpp"
#include "dynamics/implicit_equations.hpp"
#include "dynamics/viscous_friction.hpp"
#include "dynamics/workspace.hpp"
#include "factor/sparse_lu.hpp"

namespace tanor::detail {

/// The equations with multipliers for implicit schemes. Friction, if there is any, is viscous.
class ImplicitForm final : public ImplicitEquations {
 public:
  explicit ImplicitForm(Workspace& work);

  std::size_t num_constraints() const override { return model_.num_rows(); }
  std::size_t num_rows() const override { return model_.num_rows() + compliances_.size(); }
  void write_multipliers(const Reactions& found, const double* r, const double* v, double* lambda) override;

  Outcome evaluate(double t, const double* r, const double* v, const double* lambda, double* w, double* rows,
                   Power* power) override;
  double evaluate_positions(double t, const double* r, double* xi) override;

  void linearise(double t, const double* r, const double* v, const double* lambda) override;
  void add_stiffness(const double* dr, double* w, double* rows) override;
  Outcome factorize(const NewtonWeights<double>& weights) override { return factorize(weights, &real_); }
  Outcome factorize(const NewtonWeights<std::complex<double>>& weights) override {
    return factorize(weights, &complex_);
  }
  void solve(double* w, double* rows) override { solve(&real_, w, rows); }
  void solve(std::complex<double>* w, std::complex<double>* rows) override { solve(&complex_, w, rows); }

  /// Restores factors by making them again where they were made: first the one that chose the pivots, then the present
  /// one with these pivots.
  void exchange_memory(Memory& memory) override;

 private:
  /// The state at which Newton's matrix was evaluated.
  struct Place {
    double t = 0.0;
    std::vector<double> r, v, lambda;
  };
  /// A factor of Newton's matrix, made by the first factorization, since a scheme may not need both.
  template <class T>
  struct Factor {
    std::unique_ptr<SparseLu<T>> lu;
    std::vector<T> unknowns;
    NewtonWeights<T> weights{};  // 0 if there is no factor
    Place pivoted_at;
    NewtonWeights<T> pivoted_with{};
  };
  void linearise(const Place& place) { linearise(place.t, place.r.data(), place.v.data(), place.lambda.data()); }
  void exchange_memory(Memory& memory, Place* place) const;
  template <class T>
  void exchange_memory(Memory& memory, const Place& at, Factor<T>* factor);
  template <class T>
  Outcome factorize(const NewtonWeights<T>& weights, Factor<T>* factor);
  template <class T>
  void solve(Factor<T>* factor, T* w, T* rows);
  NewtonPlan make_plan() const;
  NewtonPlan::Values values() const;
  /// Rows that join supports alone have no unknowns.
  std::size_t num_active_rows() const { return model_.numbering.first_idle_row(); }

  Workspace& work_;
  const Model& model_;
  std::vector<Spring> springs_;
  std::vector<Compliance> compliances_;  // [compliant spring]
  std::size_t num_springs_;              // including those that are not compliant
  NewtonPlan plan_;
  ViscousFriction friction_;
  std::vector<double> blocks_, units_;       // K of constraints and of springs, at the last `evaluate`
  std::vector<double> linearised_blocks_;    // both, at the last `linearise`
  std::vector<double> reactions_, product_;  // [3n] M^-1 K lambda of constraints; scratch
  std::vector<double> spring_residuals_;     // scratch
  DerivativeBlocks derivatives_;             // of forces and of rods, at the last `linearise`
  Place linearised_at_;
  Factor<double> real_;
  Factor<std::complex<double>> complex_;
};

/// The implicit role of equations with multipliers.
class ImplicitMultiplierForm final : public ImplicitFormulation {
 public:
  explicit ImplicitMultiplierForm(Workspace& work) : work_(work) {}

  std::unique_ptr<ImplicitEquations> make_implicit_equations() override {
    return std::make_unique<ImplicitForm>(work_);
  }
  /// Pair forces are not part of the matrix.
  bool matrix_knows_all_forces() const override { return !work_.forces.has_pairs(); }

 private:
  Workspace& work_;
};

}  // namespace tanor::detail
