#pragma once

#include <vector>

#include "dynamics/multiplier_form.hpp"

namespace tanor::detail {

/// The state at which the normal form stands.
struct FrictionPlace {
  double t;
  const std::vector<double>&r, &v;  // [3n]
};

/// Iterates (43) in its three blocks without acceleration. Gamma gets a factor of its own. Contacts that stick count as
/// held.
Outcome iterate_friction_blocks(MultiplierForm& normal, Workspace& work, const FrictionPlace& place,
                                int most_iterations, FrictionBlocks* result);

}  // namespace tanor::detail
