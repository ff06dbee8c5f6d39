#pragma once

#include <array>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace tanor::detail {

/// Finds where a scalar function g on [0, 1] changes its sign, as a function of a motion does along a step.
///
/// g is sampled at a few irregular places. Each stretch between two samples has the quintic through the six samples
/// around it, in Bernstein's basis, and the error with which quintics predict the samples there from their neighbours.
/// By Descartes' rule a polynomial has no more roots in a stretch than its coefficients change their sign. A stretch is
/// settled if the coefficients that are larger than the error tell at most one change (Collins & Akritas, SYMSAC 1976).
/// Any other is divided, where the quintic comes nearest to 0 if it is known well, or else in the middle. So smooth
/// functions far from 0 cost no more than the first samples, and an extreme near 0 some more around it.
///
/// A function that oscillates between samples disagrees with quintics, unless it is 0 or constant at all of them. A few
/// probes verify the first quintics. One that is farther from its quintic than the error tells becomes a sample as
/// well, and is doubtful, since more of that kind may lie between others. A bump that is so narrow that neither samples
/// nor probes see it is missed.
///
/// Allocates nothing unless the number of samples grows.
class RootIsolation {
 public:
  /// The first samples, and among them the probes. Their distances have no common part, so that no oscillation looks
  /// slow at all of them.
  static constexpr std::array<double, 12> places{0.0,       0.0413729, 0.1517342, 0.2291336, 0.3171573, 0.4203178,
                                                 0.5081947, 0.6843061, 0.7631427, 0.8527391, 0.9622718, 1.0};
  static constexpr std::array<std::size_t, 3> probes{3, 5, 8};
  static constexpr std::size_t most_samples = 20000;

  using Function = std::function<double(double s)>;
  struct Accuracy {
    double rounding = 0.0;  ///< absolute error of values of g; they have at least 16 roundings of those around them
    double s = 0.0;         ///< two places that are nearer to each other count as one
  };
  struct Sample {
    double s, value;
    bool is_settled = false;  ///< true if g changes its sign at most once before the next sample
    double size = 0.0;        ///< magnitude of g around it, of which its values are rounded
  };

  /// Samples g until it changes its sign at most once between neighbouring samples. `values` are those at `places`. A
  /// value that is not finite ends the search; it is then among the samples.
  void isolate(std::span<const double> values, const Function& g, const Accuracy& accuracy);

  /// Returns the samples in order.
  std::span<const Sample> samples() const { return samples_; }
  /// Gives the first or the last sample, which is a zero to rounding, the sign that g has inside.
  void leave_zero(double sign, bool is_last);
  /// Returns a place where g may change its sign twice: it touches 0 to rounding, or `most_samples` do not suffice. NaN
  /// if there is none.
  double doubtful_place() const { return doubtful_place_; }
  /// Narrows the root between samples i and i + 1, whose values have different signs, and returns it. A jump through 0
  /// counts as a root. Evaluates to NaN if a value is not finite.
  double find_root(std::size_t i, const Function& g) const;
  /// Returns true if what `find_root` returned is no root but a pole, towards which |g| grows.
  bool is_pole(double root, const Function& g) const;

 private:
  static constexpr std::size_t num_nodes = 6;
  using Coefficients = std::array<double, num_nodes>;

  double predict(std::size_t first, std::size_t without, double s) const;
  double error_at(std::size_t j);
  double error_around(std::size_t i, std::size_t reach);
  double size_around(std::size_t i) const;
  double size_between(std::size_t i) const;
  double rounding_around(std::size_t i) const;
  bool is_known(std::size_t i);
  Coefficients values_between(std::size_t i) const;
  double find_division(std::size_t i);
  bool divide(const Function& g);
  void verify(std::span<const double> values);
  void find_doubts();

  Accuracy accuracy_;
  double largest_ = 0.0;  // magnitude of the first samples
  std::vector<Sample> samples_, next_;
  std::vector<double> errors_;  // [sample] of its prediction from its neighbours; NaN if not computed
  double doubtful_place_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace tanor::detail
