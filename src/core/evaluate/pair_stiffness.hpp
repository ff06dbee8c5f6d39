#pragma once

#include <cstddef>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Returns true if Forces::evaluate_derivatives knows these pairs: their law is smooth, without a cutoff, and they are
/// few.
bool has_own_derivatives(const System& system, const PairForces& pairs);
/// The largest number of points without a cutoff, where each point has a block with each other one.
inline constexpr std::size_t most_points_of_dense_stiffness = 3000;
/// Returns true if that or Forces::for_each_pair_stiffness knows these pairs.
bool has_stiffness(const System& system, const PairForces& pairs);
/// Returns the bytes of W and of what is made of it to solve with it, if each point interacts with each other one.
double bytes_of_dense_stiffness(std::size_t num_points);
/// Returns the number of points that take part.
std::size_t num_points(const System& system, const PairForces& pairs);

}  // namespace tanor::detail
