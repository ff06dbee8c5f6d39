#pragma once

#include <array>

namespace tanor::detail {

/// Nodes and weights of the Gauss rule with eight points on [0, 1], which is exact for polynomials of degree 15.
inline constexpr std::array<std::array<double, 2>, 8> gauss_rule{{{0.0198550717512319, 0.0506142681451882},
                                                                  {0.1016667612931866, 0.1111905172266872},
                                                                  {0.2372337950418355, 0.1568533229389437},
                                                                  {0.4082826787521751, 0.1813418916891809},
                                                                  {0.5917173212478249, 0.1813418916891809},
                                                                  {0.7627662049581645, 0.1568533229389437},
                                                                  {0.8983332387068134, 0.1111905172266872},
                                                                  {0.9801449282487681, 0.0506142681451882}}};

}  // namespace tanor::detail
