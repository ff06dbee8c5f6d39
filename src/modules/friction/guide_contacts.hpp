#pragma once

#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "friction/contact_modes.hpp"

namespace tanor::detail {

/// The contacts of points with guides: their discrete state, the fixed point (43) at one instant, and their modes.
class GuideContacts final : public Contacts {
 public:
  GuideContacts(Workspace& work, FrictionMethod method, ConstrainedSystem& system)
      : work_(work),
        state_(work, system),
        friction_(work, state_.laws, method, system.response()),
        modes_(state_, friction_) {}

  Outcome find(const ContactPlace& place, const UniquenessCheck& check, const double* lambda, double* w0,
               double* b) override;
  bool improve(const double* lambda, double* w0, double* b) override;
  void measure(const double* lambda) override { (void)friction_.measure(lambda); }
  const FrictionReport& report() const override { return friction_.report(); }
  Outcome verify(double t, FrictionReport* report) const override;

  void write_contacts(const double* lambda, std::vector<double>* forces) const override {
    friction_.write_contacts(lambda, forces);
  }
  void write_points(const double* forces, double* tau) const override { friction_.write_points(forces, tau); }
  void write_given(double* tau) const override { friction_.write_given(tau); }
  void write_at(const double* lambda, double* tau) const override { friction_.write_at(lambda, tau); }
  double power(const double* lambda, const double* v) const override { return friction_.power(lambda, v); }
  double held_power(const double* lambda, const double* v) const override { return friction_.held_power(lambda, v); }
  std::string find_undetermined_reaction() const override { return state_.find_undetermined_reaction(); }

  bool depends_on_multipliers() const override { return friction_.depends_on_multipliers(); }
  double change_to(const double* lambda, double s, double* y) override { return friction_.change_to(lambda, s, y); }
  void add_change(double s, double* y) const override { friction_.add_change(s, y); }

  bool shares_loads() const override { return state_.shares_loads; }
  bool have_references() const override { return state_.has_references(); }
  bool begin_sharing() override { return state_.begin_sharing(); }
  void carry_places(double t) override {
    if (state_.num_switches > 0) state_.places.carry(t);
  }
  double largest_violation(const double* rows) const override {
    return state_.places.largest_violation(rows, state_.system.redundancy());
  }

  Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) override;
  Outcome switch_guides(double t, const double* r, double* v, std::span<const std::size_t> which,
                        std::span<const GuideChange> guides, const Request& request,
                        const AccelerationOutput& to) override {
    return modes_.switch_guides(t, r, v, which, guides, request, to);
  }
  void note(Uniqueness uniqueness, const std::string& why) override { state_.verdict.note(uniqueness, why); }
  void accept(double t, const double* r, const double* v) override { modes_.accept(t, r, v); }
  EventFunctions* events() override { return modes_.num_events() > 0 ? &modes_ : nullptr; }
  void exchange_memory(Memory& memory) override { modes_.exchange_memory(memory); }
  const ContactModes& modes() const { return modes_; }

 private:
  Workspace& work_;
  ContactState state_;
  FrictionSolver friction_;
  ContactModes modes_;
};

}  // namespace tanor::detail
