#pragma once

#include <tuple>
#include <type_traits>
#include <utility>

#include <tanor/kinds.hpp>

#include "kinds/angle_kernel.hpp"
#include "kinds/circle_kernel.hpp"
#include "kinds/jet_kernel.hpp"
#include "kinds/line_kernel.hpp"
#include "kinds/plane_kernel.hpp"
#include "kinds/pulley_kernel.hpp"
#include "kinds/rod_kernel.hpp"
#include "kinds/sphere_kernel.hpp"
#include "kinds/tuple_kernels.hpp"

/// \file The kernels that evaluate the constraints of a kind.
namespace tanor::detail {

/// The kernels written by hand, in the order of the kinds. A kind that has none here runs on its definition.
using KernelsByHand = std::tuple<RodKernel<false, false>, RodKernel<false, true>, RodKernel<true, false>,
                                 RodKernel<true, true>, PlaneKernel, SphereKernel, LineKernel, CircleKernel,
                                 AngleKernel, PulleyKernel, LinearKernel, RopeKernel, UserKernels>;

/// The types in a list that serve a group, or `Other` if there are none.
template <class Group, class Other, class List>
struct ChosenOf;
template <class Group, class Other, class... Listed>
struct ChosenOf<Group, Other, std::tuple<Listed...>> {
  using Own = decltype(std::tuple_cat(
      std::declval<
          std::conditional_t<std::is_same_v<typename Listed::Group, Group>, std::tuple<Listed>, std::tuple<>>>()...));
  using List = std::conditional_t<std::tuple_size_v<Own> == 0, std::tuple<Other>, Own>;
};

template <class Group>
using KernelsOf = ChosenOf<Group, JetKernel<Group>, KernelsByHand>;

}  // namespace tanor::detail
