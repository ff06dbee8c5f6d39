#pragma once

#include <memory>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor {

/// The motion as a power series in time, of any order: one factorization a step, one solve an order. The order follows
/// from the tolerance, the step from the last two coefficients (Jorba & Zou 2005); the acceleration that is found at
/// the new state says how large the first omitted term really is. Where the series does not exist (a force that is not
/// analytic at rest) a Runge-Kutta step goes on.
class Taylor final : public Scheme {
 public:
  Taylor(const IntegrationOptions& options, Mechanics& mechanics);

  /// Velocities lose one term.
  int order() const override { return order_ - 1; }
  bool is_adaptive() const override { return true; }
  /// The series rounds alike from step to step. What its terms know less of than this is in the estimate.
  RoundingGain rounding_gain() const override { return {.factor = 0.2}; }
  double propose_step(const State& from) override;
  bool knows_acceleration() const override { return true; }
  bool sees_through(const State& from) override { return propose_step(from) > 0.0; }
  StepResult step(const State& from, double h, State* to) override;
  Outcome prepare_inside(const State& from, const State& to) override;
  void interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                   double* v) const override;
  bool interpolates_at_once() const override { return expansion_.exists || other_->interpolates_at_once(); }
  void forget() override { expansion_.is_known = acceleration_.is_known = false; }
  void exchange_memory(Memory&) override {}  // what is known of a series is found again, the same

 private:
  void expand(const State& from);
  void choose_terms(const State& from);
  int terms_for(const State& from, double h);
  double longest_step(const State& from, int terms);
  double log_of_longest_step(const State& from, int k);
  void evaluate(double h, double* x, double* v, double* a) const;
  Power integrate_power(const State& from, double h);
  double measure_error(const State& from, double h, const State& to);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  SeriesExpansion& series_;
  int order_;
  std::vector<std::vector<double>> coefficients_;  // [order + 1][n]
  std::vector<double*> pointers_;
  std::unique_ptr<Scheme> other_;  // where there is no series
  struct {
    std::vector<double> x, v, a;
  } inside_;                             // of the step
  Reactions found_;                      // where the series begins, if the state does not know them
  std::vector<double> largest_;          // [neighbourhood] scratch
  std::vector<double> nodes_, weights_;  // of Gauss's quadrature on [0, 1], for works

  /// What is known of the series that was expanded last, and which steps it allows.
  struct Expansion {
    bool is_known = false, exists = false;
    double time = 0.0;
    int terms = 0;                      // at most `order_`, that allow …
    double longest = 0.0;               // … steps up to this one, s
    std::vector<double> log_of_limits;  // of the longest h that each term allows; NaN: not measured
  } expansion_;
  // Of the last step
  int terms_ = 0;  // that were summed
  // Of the last one that was too long
  struct Rejected {
    double h = 0.0, missing = 0.0;  // in the acceleration at its end
    bool may_be_noise = false;      // a step half as long will tell
  } rejected_;
  struct {
    bool is_known = false;  // a step found them at its end, …
    double time = 0.0;      // … at this instant
  } acceleration_;
};

}  // namespace tanor
