#pragma once

#include <functional>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "motion/dense_output.hpp"

namespace tanor {

/// Finds where functions of a motion pass through 0. Each keeps the sign that it had last; in a step it is evaluated at
/// its ends and at three places between, and a change of sign is narrowed on the scheme's dense output to rounding. Two
/// passages between neighbouring places are missed. A function that begins at 0 does not pass there.
class Watch {
 public:
  /// The function in the variables of the mechanics.
  struct Function {
    std::function<double(double t, const double* x, const double* v)> value;
    Event::Direction direction;
    bool stops;
    std::string name{};
  };

  Watch(const IntegrationOptions& options, Mechanics& mechanics) : options_(options), mechanics_(mechanics) {}

  void add(Function function);
  bool is_empty() const { return functions_.empty(); }
  const std::vector<Passage>& passages() const { return passages_; }

  /// The next step does not start where the last one ended: signs are found anew.
  void forget() { knows_signs_ = false; }

  /// Of a step from `from` to `to` that is good: those on the way, up to the first one that stops, whose time is
  /// written (infinite: none does). `dense` answers where a passage is narrowed, `ends` where one is looked for; the
  /// mechanics is at `to` again.
  Outcome look(const State& from, State* to, DenseOutput ends, DenseOutput dense, double* stop);
  /// The step was accepted: what it passed counts.
  void accept();

 private:
  struct Crossing {
    Passage passage;
    bool is_reported;
  };

  Outcome evaluate_inside(DenseOutput* output, double fraction, const State& from, const State& to);
  /// "event "vertical" is not finite at t = 1.5"; without a name its number.
  Outcome report_not_finite(std::size_t k, double t) const;
  Outcome sample(DenseOutput* output, const State& from, const State& to);
  bool changes_sign() const;
  Outcome find_crossings(DenseOutput* dense, const State& from, const State& to);
  Outcome narrow(DenseOutput* dense, const State& from, const State& to, std::size_t k, std::size_t place, double sign,
                 double* fraction);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  std::vector<Function> functions_;
  std::vector<double> signs_;  // +1, -1; 0: not known yet
  bool knows_signs_ = false;
  std::vector<std::vector<double>> samples_;  // of each place inside the step: a value a function
  std::vector<double> x_, v_;                 // inside the step
  std::vector<Crossing> pending_;             // of the step that was looked at
  std::vector<Passage> passages_;
};

}  // namespace tanor
