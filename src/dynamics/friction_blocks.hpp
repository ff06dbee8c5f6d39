#pragma once

#include <vector>

#include "dynamics/multiplier_form.hpp"

namespace tanor {

/// Where the normal form stands.
struct FrictionPlace {
  double t;
  const std::vector<double>&r, &v;  // [3n]
};

/// Plain iterations of (43) in its three blocks; Gamma gets a factor of its own. Contacts that stick count as held.
Outcome iterate_friction_blocks(MultiplierForm& normal, Workspace& work, const FrictionPlace& place,
                                int most_iterations, FrictionBlocks* result);

}  // namespace tanor
