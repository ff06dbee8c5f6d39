#pragma once

#include <array>
#include <span>

#include "motion/rattle.hpp"

namespace tanor::detail {

/// Fractions of the step, some of them negative; symmetric, of sum 1.
std::span<const double> suzuki_fractions();    ///< order 4
std::span<const double> kahan_li_fractions();  ///< order 6

/// Composes RATTLE steps of lengths gamma_1 h, …, gamma_s h (Hairer, Lubich, Wanner, Geometric Numerical Integration,
/// V.3.2). The composition is of higher order than RATTLE and, as RATTLE is, symplectic and symmetric for forces with a
/// potential. Some of its steps go backwards, which friction and drag do not allow, so that these methods are meant for
/// conservative motions.
class Composition final : public Scheme {
 public:
  Composition(int order, std::span<const double> fractions, Mechanics& mechanics);

  int order() const override { return order_; }
  bool is_adaptive() const override { return false; }
  bool knows_acceleration() const override { return rattle_.knows_acceleration(); }
  bool sees_through(const State&) override { return false; }
  KnownFree known_free(double t) const override { return rattle_.known_free(t); }
  StepResult step(const State& from, double h, State* to) override;
  void forget() override { rattle_.forget(); }
  void exchange_memory(Memory& memory) override { rattle_.exchange_memory(memory); }

 private:
  int order_;
  std::span<const double> fractions_;
  Rattle rattle_;
  std::array<State, 2> between_;
};

}  // namespace tanor::detail
