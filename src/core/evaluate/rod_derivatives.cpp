#include <type_traits>

#include "evaluate/constraints.hpp"

namespace tanor::detail {

namespace {

template <class Family>
constexpr bool is_rods = is_rod_kernel<decltype(Family::kernel)>;

}  // namespace

std::vector<Coupling> Constraints::list_rods() const {
  std::vector<Coupling> result;
  for_each_family([&](const auto& family) {
    if constexpr (is_rods<std::decay_t<decltype(family)>>) {
      for (const auto& [i, j] : family.kernel.points) result.push_back({i, j});
    }
  });
  return result;
}

void Constraints::evaluate_rod_derivatives(const Parallel& parallel, const double* r, const double* lambda,
                                           Block3* to) const {
  for_each_family([&](const auto& family) {
    if constexpr (is_rods<std::decay_t<decltype(family)>>) {
      parallel.for_ranges(family.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto local = family.kernel(k, r, r);
          const double length = local.xi[0] + family.kernel.scale(k);
          const double tension = -lambda[family.rows[k]];
          Block3 block;
          block.add_identity(-tension / length);
          block.add_product(tension / length, local.gradient[0], local.gradient[0]);
          to[k] = block;
        }
      });
      to += family.size();
    }
  });
}

}  // namespace tanor::detail
