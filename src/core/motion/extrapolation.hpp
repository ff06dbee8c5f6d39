#pragma once

#include <vector>

#include "motion/scheme.hpp"

namespace tanor::detail {

/// Steps past a singular configuration. K no longer tells there on which branch the motion continues, but the velocity
/// does: such a step follows the polynomial through the last two states instead of accelerations. The end of the step
/// is projected onto the constraints. A step that ends at the singular configuration projects only its positions, with
/// the K of `from`.
///
/// The error is of order 5 (3 for the cubic) and is estimated by the polynomial of one degree less. Workspaces are
/// kept.
class Extrapolation {
 public:
  struct How {
    /// The quintic goes through x, v and a of both states. The cubic leaves out x and a of the first state. They may be
    /// unknown, or as coarse as those of a scheme of order 2, whose errors the quintic's differences would amplify.
    bool follows_quintic = true;
    bool ends_at_singularity = false;
  };
  StepResult step(Mechanics& mechanics, const IntegrationOptions& options, const State& before, const State& from,
                  const How& how, State* to);

 private:
  void follow(const State& before, const State& from, bool follows_quintic, State* to);
  StepResult stabilize_end(Mechanics& mechanics, const IntegrationOptions& options, const State& from, State* to);
  bool turns_away(Mechanics& mechanics, const std::vector<double>& found) const;

  std::vector<double> x_error_, v_error_;
  std::vector<double> kept_;  // positions before a projection that may fail, or the expected velocity
};

}  // namespace tanor::detail
