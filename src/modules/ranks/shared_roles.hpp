#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ranks/share.hpp"
#include "ranks/shared_implicit_equations.hpp"
#include "ranks/shared_mechanics.hpp"

/// \file The roles of SharedMechanics. Where `own` is a pointer, it is null on a rank whose part does not have the
/// role.
namespace tanor::detail {

class SharedMechanics::Projector final : public StepProjector {
 public:
  Projector(StepProjector& own, SharedMechanics& mechanics)
      : own_(own),
        mechanics_(mechanics),
        depends_on_velocity_(mechanics.agreement_.any(own.depends_on_velocity())),
        is_constant_(mechanics.agreement_.all(own.is_constant())),
        is_uniform_(mechanics.agreement_.all(own.uniform_acceleration() != nullptr)) {}

  bool depends_on_velocity() const override { return depends_on_velocity_; }
  bool is_constant() const override { return is_constant_; }
  const Vec3* uniform_acceleration() const override { return is_uniform_ ? own_.uniform_acceleration() : nullptr; }
  std::size_t num_moving() const override { return own_.num_moving(); }
  Outcome free_accelerations(const Kinematics& at, const Request& request, double* a) override {
    return mechanics_.together([&] { return own_.free_accelerations(at, request, a); });
  }
  ProjectionReport project_step(double t, double h, const PointSource& source, double* x,
                                double* step_velocity) override {
    return mechanics_.conclude_projection([&] { return own_.project_step(t, h, source, x, step_velocity); });
  }
  ProjectionReport project_step_velocities(double t, double h, const double* x, double* v) override {
    return mechanics_.conclude_projection([&] { return own_.project_step_velocities(t, h, x, v); });
  }

 private:
  StepProjector& own_;
  SharedMechanics& mechanics_;
  bool depends_on_velocity_, is_constant_, is_uniform_;
};

class SharedMechanics::Series final : public SeriesExpansion {
 public:
  Series(SeriesExpansion& own, SharedMechanics& mechanics)
      : own_(own),
        mechanics_(mechanics),
        has_cheap_terms_(mechanics.agreement_.all(own.has_cheap_terms())),
        leaves_out_terms_(mechanics.agreement_.any(own.leaves_out_terms()) && has_cheap_terms_) {}

  Outcome expand(const Kinematics& at, const double* a, const Reactions& found, const SeriesDemand& wanted,
                 std::span<double* const> coefficients, SeriesExtent* extent) override {
    std::array<double, 2> earliest{};
    Outcome outcome = mechanics_.agreement_.together(
        [&] {
          Outcome own = own_.expand(at, a, found, wanted, coefficients, extent);
          earliest = {-extent->smooth_until, -extent->longest};
          return own;
        },
        earliest);
    extent->smooth_until = -earliest[0];
    extent->longest = -earliest[1];
    return outcome;
  }
  bool has_cheap_terms() const override { return has_cheap_terms_; }
  bool leaves_out_terms() const override { return leaves_out_terms_; }
  Power power_along(const Kinematics& at, int terms) override {
    Power own;
    (void)mechanics_.together([&] {
      own = own_.power_along(at, terms);
      return Outcome{};
    });
    return sum_powers(mechanics_.ranks_, own);
  }
  std::span<const Index> neighbourhoods() const override { return own_.neighbourhoods(); }
  void find_largest(std::span<double> of_neighbourhoods) override { own_.find_largest(of_neighbourhoods); }

 private:
  SeriesExpansion& own_;
  SharedMechanics& mechanics_;
  bool has_cheap_terms_, leaves_out_terms_;
};

class SharedMechanics::Drives final : public DriveMonitor {
 public:
  Drives(DriveMonitor* own, SharedMechanics& mechanics) : own_(own), mechanics_(mechanics) {}

  DriveReport look_at_drives(const DrivenStep& step) override {
    DriveReport own;
    std::array<double, 3> numbers{};
    (void)mechanics_.agreement_.together(
        [&] {
          if (own_ != nullptr) own = own_->look_at_drives(step);
          numbers = {own.error, own.velocity, static_cast<double>(own.pieces)};
          return Outcome{};
        },
        numbers);
    if (numbers[1] > most_) {
      most_ = numbers[1];
      has_worst_ = own.velocity == most_;
    }
    return {numbers[0], numbers[1], static_cast<int>(numbers[2]), own.drive};
  }
  std::string name_drive(std::size_t drive) const override {
    return mechanics_.agreement_.first_text(has_worst_ && own_ != nullptr ? own_->name_drive(drive) : "");
  }

 private:
  DriveMonitor* own_;
  SharedMechanics& mechanics_;
  double most_ = 0.0;  // largest unseen velocity so far
  bool has_worst_ = false;
};

/// The event functions of all ranks one after the other, on every rank.
class SharedMechanics::Events final : public EventFunctions {
 public:
  Events(EventFunctions* own, SharedMechanics& mechanics) : own_(own), mechanics_(mechanics) { count(); }

  std::size_t num_events() const override { return share_.all(); }
  void evaluate_events(const Kinematics& at, const Reactions& found, double* values) override {
    fill(values, [&](double* here) { own_->evaluate_events(at, found, here); });
  }
  void shape_events(const Reactions& found, const double* values, double* shapes) const override {
    fill(shapes, [&](double* here) { own_->shape_events(found, values + share_.first, here); });
  }
  Outcome switch_equations(double t, const double* x, double* v, std::span<const std::size_t> which,
                           const Request& request, const AccelerationOutput& to) override {
    std::vector<std::size_t> here;
    for (const std::size_t event : which)
      if (event >= share_.first && event < share_.first + num_own_) here.push_back(event - share_.first);
    has_switched_ = !here.empty();
    Outcome outcome = mechanics_.conclude(
        [&] {
          return has_switched_ ? own_->switch_equations(t, x, v, here, request, to)
                               : mechanics_.own_.accelerations({t, x, v}, request.evaluated_anew(), to);
        },
        to);
    count();
    return outcome;
  }
  Power work_of_switch() const override {
    return sum_powers(mechanics_.ranks_, has_switched_ ? own_->work_of_switch() : Power{});
  }
  std::vector<int> discrete_state() const override {
    return own_ != nullptr ? own_->discrete_state() : std::vector<int>{};
  }
  void restore_discrete_state(std::span<const int> state) override {
    if (own_ != nullptr) own_->restore_discrete_state(state);
    count();
  }

 private:
  void count() {
    num_own_ = own_ != nullptr ? own_->num_events() : 0;
    share_ = Share(mechanics_.ranks_, num_own_);
  }
  template <class Evaluate>
  void fill(double* values, const Evaluate& evaluate) const {
    std::vector<double> all(share_.all(), 0.0);
    if (num_own_ > 0) evaluate(all.data() + share_.first);
    mechanics_.ranks_.sum(all);
    std::copy(all.begin(), all.end(), values);
  }

  EventFunctions* own_;
  SharedMechanics& mechanics_;
  std::size_t num_own_ = 0;
  Share share_;  // share of the events of all ranks
  bool has_switched_ = false;
};

class SharedMechanics::Implicit final : public ImplicitFormulation {
 public:
  Implicit(ImplicitFormulation& own, SharedMechanics& mechanics)
      : own_(own),
        mechanics_(mechanics),
        matrix_knows_all_forces_(mechanics.agreement_.all(own.matrix_knows_all_forces())) {}

  std::unique_ptr<ImplicitEquations> make_implicit_equations() override {
    std::unique_ptr<ImplicitEquations> own;
    (void)mechanics_.agreement_.together([&] {
      own = own_.make_implicit_equations();
      return Outcome{};
    });
    return std::make_unique<SharedImplicitEquations>(std::move(own), mechanics_.ranks_);
  }
  bool matrix_knows_all_forces() const override { return matrix_knows_all_forces_; }

 private:
  ImplicitFormulation& own_;
  SharedMechanics& mechanics_;
  const bool matrix_knows_all_forces_;
};

}  // namespace tanor::detail
