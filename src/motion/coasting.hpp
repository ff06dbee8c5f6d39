#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor {

/// When the motion meets a place where K loses rank, foreseen from the steps before. The smallest singular value of K
/// goes through 0 there as a straight line, and the reciprocal condition of S is its square.
class SingularForecast {
 public:
  /// A step ended at t on the constraints; S had this reciprocal condition there, and `regular` far from such places.
  void add(double t, double reciprocal_condition, double regular) {
    const double size = std::sqrt(std::max(0.0, reciprocal_condition));
    const bool falls = t > time_ && size < size_ && reciprocal_condition < suspicious_below * regular;
    zero_ = falls ? t + (t - time_) * size / (size_ - size) : never;
    time_ = t;
    size_ = size;
  }
  void forget() { *this = {}; }

  /// So near to it that stages of the step, or its end, would see a K that says little.
  bool disturbs(double t, double h) const { return zero_ >= t - margin * h && zero_ <= t + (1.0 + margin) * h; }
  bool lies_near(double t, double h) const { return std::abs(t - zero_) < margin * h; }
  /// s; infinite: none is foreseen.
  double time() const { return zero_; }
  /// Smallest met before it, as a reciprocal condition.
  double reciprocal_condition() const { return size_ * size_; }

  /// visit(number) for all that it knows, to keep it and to bring it back.
  template <class Visit>
  void for_each_number(const Visit& visit) const {
    for (const double* number : {&time_, &size_, &zero_}) visit(*number);
  }
  template <class Visit>
  void for_each_number(const Visit& visit) {
    for (double* number : {&time_, &size_, &zero_}) visit(*number);
  }

 private:
  static constexpr double margin = 0.25, suspicious_below = 1e-2;
  static constexpr double never = std::numeric_limits<double>::infinity();
  double time_ = never, size_ = 0.0;  // of the last step
  double zero_ = never;
};

/// Steps that follow the polynomial through the last two states instead of accelerations: past a place where K loses
/// rank and no longer says on which branch the motion goes on, its velocity does. The end is put onto the constraints,
/// unless it `ends_there`: then its positions alone are, with the K of `from`.
///
/// Error: of order 5 (3 by the cubic), estimated by the polynomial of one degree less. Workspaces are kept.
class Coasting {
 public:
  struct How {
    /// Through x, v and a of both states; else the cubic without x and a of the first one: they are not known, or as
    /// coarse as a scheme of order 2, where the quintic's differences would multiply what they miss.
    bool follows_quintic = true;
    bool ends_there = false;
  };
  StepResult step(Mechanics& mechanics, const IntegrationOptions& options, const State& before, const State& from,
                  const How& how, State* to);

 private:
  void follow(const State& before, const State& from, bool follows_quintic, State* to);
  bool turns_away(const std::vector<double>& found) const;

  std::vector<double> x_error_, v_error_;
  std::vector<double> kept_;  // positions that a projection may lose, or the velocity that was expected
};

}  // namespace tanor
