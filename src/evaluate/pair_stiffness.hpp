#pragma once

#include <cstddef>

#include <tanor/system.hpp>

namespace tanor {

/// Whether Forces::evaluate_derivatives knows these pairs: their law is smooth, without a cutoff, and they are few.
bool has_own_derivatives(const System& system, const PairForces& pairs);
/// Without a cutoff each point has a block with each other one.
inline constexpr std::size_t most_points_of_dense_stiffness = 3000;
/// Whether that or Forces::for_each_pair_stiffness does.
bool has_stiffness(const System& system, const PairForces& pairs);
/// Bytes of W and of what is made of it to solve with it, where each point feels each other one.
double bytes_of_dense_stiffness(std::size_t num_points);
/// Points that take part.
std::size_t num_points(const System& system, const PairForces& pairs);

}  // namespace tanor
