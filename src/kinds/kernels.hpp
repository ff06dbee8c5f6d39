#pragma once

#include <tuple>
#include <type_traits>
#include <utility>

#include <tanor/kinds.hpp>

#include "kinds/angle_kernel.hpp"
#include "kinds/circle_kernel.hpp"
#include "kinds/jet_kernel.hpp"
#include "kinds/line_kernel.hpp"
#include "kinds/linear_kernel.hpp"
#include "kinds/plane_kernel.hpp"
#include "kinds/pulley_kernel.hpp"
#include "kinds/rod_kernel.hpp"
#include "kinds/sphere_kernel.hpp"
#include "kinds/user_kernels.hpp"

/// \file Which kernels evaluate the constraints of a kind.
namespace tanor {

/// The kernels written by hand, in the order of the kinds. A kind that has none here runs on its definition.
using KernelsByHand = std::tuple<RodKernel<false, false>, RodKernel<false, true>, RodKernel<true, false>,
                                 RodKernel<true, true>, PlaneKernel, SphereKernel, LineKernel, CircleKernel,
                                 AngleKernel, PulleyKernel, LinearKernel, UserKernels>;

template <class Group, class... Kernels>
auto choose_kernels(const std::tuple<Kernels...>*) {
  using Own = decltype(std::tuple_cat(
      std::declval<
          std::conditional_t<std::is_same_v<typename Kernels::Group, Group>, std::tuple<Kernels>, std::tuple<>>>()...));
  if constexpr (std::tuple_size_v<Own> == 0)
    return std::tuple<JetKernel<Group>>{};
  else
    return Own{};
}

template <class Group>
struct KernelsOf {
  using List = decltype(choose_kernels<Group>(static_cast<const KernelsByHand*>(nullptr)));
};

}  // namespace tanor
