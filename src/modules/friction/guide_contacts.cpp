#include "friction/guide_contacts.hpp"

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor::detail {

Outcome GuideContacts::find(const ContactPlace& place, const UniquenessCheck& check, const double* lambda, double* w0,
                            double* b) {
  state_.restore_slip_directions(place.r, place.v);
  state_.set_sliding_speeds();
  friction_.set_accelerations(state_.system.acceleration_scales());
  Outcome outcome = friction_.find(place, b, check, lambda);
  if (outcome.ok()) friction_.add(1.0, w0, b);
  return outcome;
}

bool GuideContacts::improve(const double* lambda, double* w0, double* b) {
  constexpr double converged = 1e-12;
  if (friction_.measure(lambda) <= converged) return false;
  const Stopwatch watch(&work_.times.friction);
  friction_.add(-1.0, w0, b);
  friction_.refine(b, lambda);
  friction_.add(1.0, w0, b);
  return true;
}

/// Wrongly chosen modes leave friction that misses its law, which no iteration brings to it.
Outcome GuideContacts::verify(double t, FrictionReport* report) const {
  state_.add_verdict(report);
  constexpr double largest_miss = 1e-4;
  if (report->uniqueness != Uniqueness::Proven || report->residual <= largest_miss) return {};
  return fail_friction(Status::NotConverged, t,
                       "what was found misses the law by " + text(report->residual) + " of the largest friction");
}

Outcome GuideContacts::begin(double t, const double* r, double* v, const Request& request,
                             const AccelerationOutput& to) {
  if (state_.laws.depend_on_reactions()) return modes_.begin(t, r, v, request, to);
  return state_.system.accelerations({t, r, v}, request.evaluated_anew(), {}, to);
}

std::unique_ptr<Contacts> make_contacts(Workspace& work, FrictionMethod method, ConstrainedSystem& system) {
  return std::make_unique<GuideContacts>(work, method, system);
}

Outcome fail_friction(Status status, double t, const std::string& why) {
  return {status, "friction at t = " + text(t) + ": " + why};
}

}  // namespace tanor::detail
