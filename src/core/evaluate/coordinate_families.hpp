#pragma once

#include <tuple>

#include "evaluate/body_coordinates.hpp"
#include "evaluate/chain_coordinates.hpp"
#include "evaluate/coordinate_kernels.hpp"
#include "evaluate/jet_chart.hpp"
#include "evaluate/user_coordinates.hpp"
#include "kinds/kernels.hpp"

/// \file The families that evaluate the coordinates of a kind.
namespace tanor::detail {

/// The families written by hand, in the order of the kinds. A kind of single points that has none here runs on its
/// definition.
using CoordinateFamiliesByHand =
    std::tuple<PointCoordinates<FreeKernel>, PointCoordinates<LineChartKernel>, PointCoordinates<PlaneChartKernel>,
               PointCoordinates<CircleChartKernel>, PointCoordinates<FixedCircleKernel>,
               PointCoordinates<SphereChartKernel>, ChainCoordinates, BodyCoordinates, UserCoordinateFamily>;

template <class Group>
using FamiliesOfCoordinates =
    typename ChosenOf<Group, PointCoordinates<JetChart<Group>>, CoordinateFamiliesByHand>::List;

}  // namespace tanor::detail
