#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "base/root_isolation.hpp"
#include "motion/dense_output.hpp"

namespace tanor::detail {

/// Finds where functions of a motion pass through 0, on the scheme's dense output (`RootIsolation`). Each function
/// keeps its last sign from step to step. At the beginning, unless it says otherwise, and after a passage at the end of
/// a step, a function is at 0: it does not pass there again, but may right behind.
class Watch {
 public:
  /// A function in the variables of the mechanics.
  struct Function {
    std::function<double(double t, const double* x, const double* v)> value;
    Event::Direction direction;
    bool stops;
    std::string name{};
    bool solves = false;           ///< it leaves the mechanics linearised elsewhere
    bool passes_at_start = false;  ///< where it is 0 before it has a sign and rises from there, it passes
  };

  Watch(const IntegrationOptions& options, Mechanics& mechanics) : options_(options), mechanics_(mechanics) {}

  void add(Function function);
  bool is_empty() const { return functions_.empty(); }
  const std::vector<Passage>& passages() const { return passages_; }

  /// Begins at t, which need not be where the last step ended. Later passages are forgotten.
  void begin(double t);
  /// Notes that a function passed where the motion begins, so that it does not pass there again by rounding.
  void note_passed(std::size_t k, bool rises);

  /// Looks for passages in a good step. The time of the first one that stops is written to `stop` (infinite if none
  /// stops). It lies behind the beginning of the step, so that a step can end there. The mechanics is at `to` again
  /// afterwards.
  Outcome look(const State& from, State* to, DenseOutput dense, double* stop);
  /// Tells that the step is made again, to end at `stop`. What lies beyond is forgotten.
  void end_at(double stop);
  /// Accepts a step that ends at t, so that its passages count if it was examined.
  void accept(double t);
  /// Returns which event may have been missed first, and when; empty if none.
  const std::string& explain_missed() const { return may_be_missed_; }

 private:
  struct Crossing {
    Passage passage;
    bool is_reported;
  };
  /// A step that is examined.
  struct Step {
    const State &from, &to;
    DenseOutput* dense;
    double h() const { return to.t - from.t; }
    double time(double fraction) const { return fraction == 1.0 ? to.t : dense->time(fraction); }
  };

  std::string name_of(std::size_t k) const;
  Outcome go_to(const Step& step, double fraction);
  enum class Infinite { Fails, IsLarge };
  double evaluate(std::size_t k, double t, Infinite infinite = Infinite::Fails);
  Outcome sample(const Step& step);
  void measure_rounding(const Step& step);
  Outcome find_crossings(const Step& step, std::size_t k);
  Outcome follow_sign(const Step& step, std::size_t k, const RootIsolation::Function& g);
  double slope_at_zero(const Step& step, bool is_last, const RootIsolation::Function& g) const;
  void add_crossing(const Step& step, std::size_t k, double t, bool rises, bool is_pole = false);
  double find_stop(const Step& step) const;
  Outcome leave(const DenseOutput& dense, State* to);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  std::vector<Function> functions_;
  std::vector<double> signs_;  // +1, -1; halves and 0 at 0, before it has them; NaN if not known
  // The last step that was examined.
  std::vector<double> first_signs_;                        // the same, where functions that were at 0 have left it
  std::vector<std::vector<double>> samples_;               // [function][place] values
  std::vector<double> rounding_;                           // [function] of its values
  std::vector<Crossing> pending_;                          // its passages
  double end_ = std::numeric_limits<double>::quiet_NaN();  // s; NaN if there is none
  Outcome failure_;                                        // of a function inside it
  std::string doubt_;
  RootIsolation isolation_;
  std::vector<double> x_, v_;  // state inside the step
  std::vector<Passage> passages_;
  std::string may_be_missed_;
};

}  // namespace tanor::detail
