#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor::detail {

/// Expands the motion in a power series in time, of any order, with one factorization a step and one solve an order.
/// The order follows from the tolerance, the step from the last two coefficients (Jorba & Zou 2005). The acceleration
/// at the new state tells how large the first omitted term really is. If the series does not exist (a force that is not
/// analytic at rest), a Runge-Kutta step is made instead.
class Taylor final : public Scheme {
 public:
  Taylor(const IntegrationOptions& options, Mechanics& mechanics);

  /// Velocities have one term less.
  int order() const override { return order_ - 1; }
  bool is_adaptive() const override { return true; }
  /// The series rounds alike from step to step. Rounding of its terms beyond this is part of the estimate.
  RoundingGain rounding_gain() const override { return {.factor = 0.2}; }
  double propose_step(const State& from, double resolution = 0.0) override;
  bool knows_acceleration() const override { return true; }
  bool sees_through(const State& from) override { return propose_step(from) > 0.0; }
  StepResult step(const State& from, double h, State* to) override;
  Outcome prepare_inside(const State& from, const State& to) override;
  void interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                   double* v) const override;
  bool interpolates_at_once() const override { return expansion_.exists || other_->interpolates_at_once(); }
  void forget() override { expansion_.is_known = acceleration_.is_known = false; }
  /// Exchanges what a series was wanted for; the series itself is found again, the same.
  void exchange_memory(Memory& memory) override {
    memory.exchange(expansion_.time, expansion_.wanted, expansion_.reach);
  }

 private:
  void expand(const State& from);
  void expand_for(double h, const State& from);
  std::size_t count_terms(std::size_t begin, std::size_t end) const;
  void choose_terms(const State& from);
  int terms_for(const State& from, double h);
  double longest_step(const State& from, int terms);
  double log_of_longest_step(const State& from, int k);
  void evaluate(double h, double* x, double* v, double* a) const;
  Power integrate_power(const State& from, double h);
  void weigh_missing(double* missing) const;
  double measure_error(const State& from, double h, const State& to);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  SeriesExpansion& series_;
  int order_;
  std::vector<std::vector<double>> coefficients_;  // [order + 1][n]
  std::vector<double*> pointers_;
  std::unique_ptr<Scheme> other_;  // scheme used if there is no series
  struct {
    std::vector<double> x, v, a;
  } inside_;                             // state inside the step
  Reactions found_;                      // reactions at the start of the series, if the state does not know them
  std::vector<double> largest_;          // [neighbourhood] scratch
  std::vector<double> nodes_, weights_;  // Gauss quadrature on [0, 1], for works

  /// The last series, and which steps it allows.
  struct Expansion {
    bool is_known = false, exists = false;
    double time = 0.0;
    double wanted = any_length;  // step that it was made for, s
    double reach = any_length;   // like `longest`, whatever functions of time do
    SeriesExtent extent;
    int terms = 0;                      // number of terms, at most `order_`, that allows …
    double longest = 0.0;               // … steps up to this length, s
    std::vector<double> log_of_limits;  // logarithm of the longest h that each term allows; NaN if not computed
  } expansion_;
  // The last step
  int terms_ = 0;  // number of terms that were summed
  // The last step that was too long
  struct Rejected {
    double h = 0.0, missing = 0.0;  // `missing`: largest difference of accelerations at its end
    bool may_be_noise = false;      // true if only a step half as long can tell
  } rejected_;
  struct {
    bool is_known = false;  // true if a step found the acceleration at its end, …
    double time = 0.0;      // … at this instant
  } acceleration_;
};

}  // namespace tanor::detail
