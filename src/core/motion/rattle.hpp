#pragma once

#include <array>
#include <cstddef>

#include "motion/scheme.hpp"

namespace tanor::detail {

/// RATTLE (Andersen 1983; Hairer, Lubich, Wanner, Geometric Numerical Integration, VII.1.4) has order 2 and is
/// symplectic and symmetric if forces have a potential. A step computes the acceleration at its end only if works or
/// events need it.
///
///   v1/2 = v + h/2 M^-1 (f + K(r0) lambda),  r1 = r0 + h v1/2,  xi(r1, t1) = 0
///   v1   = v1/2 + h/2 M^-1 (f1 + K(r1) mu),  K(r1)'v1 + xi_t = 0
class Rattle final : public Scheme {
 public:
  /// Numbers that take their accelerations from one list, if these are the same for all points.
  static constexpr std::size_t tile = 96;

  /// The second half finds v1 in so many `passes` if forces depend on v. Each pass gains one order.
  explicit Rattle(Mechanics& mechanics, int passes = 2);

  int order() const override { return 2; }
  bool is_adaptive() const override { return false; }
  bool knows_acceleration() const override { return knows_acceleration_; }
  bool sees_through(const State&) override { return false; }
  KnownFree known_free(double t) const override {
    // Forces that are the same for all points are no dearer to evaluate.
    const bool are_known = knows_free_ && free_time_ == t && !depends_on_velocity_ && !is_uniform_;
    return {are_known ? free_.data() : nullptr, largest_free_};
  }
  StepResult step(const State& from, double h, State* to) override;
  void forget() override { knows_free_ = false; }
  void exchange_memory(Memory& memory) override {
    memory.exchange(knows_free_, free_time_, free_, largest_free_);
    if (memory.reads()) has_constant_ = false;
  }

 private:
  Outcome find_free(const Kinematics& at, const Request& request);

  Mechanics& mechanics_;
  StepProjector& projector_;
  int passes_;
  const bool has_work_, knows_acceleration_, depends_on_velocity_, is_constant_;
  std::vector<double> free_;                // M^-1 f at the last configuration
  std::vector<double> middle_;              // v1/2 if forces depend on v; otherwise v1/2 stands where v1 will
  std::array<double, tile + 3> uniform_{};  // M^-1 f if it is the same for all points, x y z x y z …
  bool is_uniform_ = false;
  double free_time_ = 0.0, largest_free_ = 0.0;
  bool knows_free_ = false;
  bool has_constant_ = false;  // true if `free_` is the same everywhere and always
};

}  // namespace tanor::detail
