#pragma once

#include <functional>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "motion/dense_output.hpp"

namespace tanor {

/// Finds where functions of a motion pass through 0. Each function keeps its last sign. In a step it is evaluated at
/// the ends and at three places between, and a change of sign is narrowed to rounding on the scheme's dense output. Two
/// passages between neighbouring places are missed. A function that begins at 0 does not pass there.
class Watch {
 public:
  /// A function in the variables of the mechanics.
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

  /// Forgets the signs; call this if the next step does not start where the last one ended.
  void forget() { knows_signs_ = false; }

  /// Looks for passages in a good step, up to the first one that stops, whose time is written to `stop` (infinite if
  /// none stops). `ends` interpolates where passages are looked for, `dense` where one is narrowed. The mechanics is at
  /// `to` again afterwards.
  Outcome look(const State& from, State* to, DenseOutput ends, DenseOutput dense, double* stop);
  /// Accepts the step, so that its passages count.
  void accept();

 private:
  struct Crossing {
    Passage passage;
    bool is_reported;
  };

  Outcome evaluate_inside(DenseOutput* output, double fraction, const State& from, const State& to);
  /// Returns the failure "event "vertical" is not finite at t = 1.5", with the event's number if it has no name.
  Outcome report_not_finite(std::size_t k, double t) const;
  Outcome sample(DenseOutput* output, const State& from, const State& to);
  bool changes_sign() const;
  Outcome find_crossings(DenseOutput* dense, const State& from, const State& to);
  Outcome narrow(DenseOutput* dense, const State& from, const State& to, std::size_t k, std::size_t place, double sign,
                 double* fraction);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  std::vector<Function> functions_;
  std::vector<double> signs_;  // +1, -1; 0 if not known yet
  bool knows_signs_ = false;
  std::vector<std::vector<double>> samples_;  // [place][function] values in the step
  std::vector<double> x_, v_;                 // state inside the step
  std::vector<Crossing> pending_;             // passages of the last step that was examined
  std::vector<Passage> passages_;
};

}  // namespace tanor
