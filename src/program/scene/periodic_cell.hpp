#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <tanor/cell.hpp>

namespace tanor::scene {

/// Returns n_a a + n_b b + n_c c.
Vector3 shift_of(const Cell& cell, const std::array<std::int64_t, 3>& images);
/// Returns the images n that make |d - shift_of(n)| smallest, for distances below half the cell.
std::array<std::int64_t, 3> nearest_images(const Cell& cell, Vector3 d);

/// Returns r_j - r_i.
Vector3 between(const std::vector<Vector3>& positions, std::int32_t i, std::int32_t j);
/// Returns true if r_j is the image nearest to r_i.
bool are_side_by_side(const Cell& cell, const std::vector<Vector3>& positions, std::int32_t i, std::int32_t j);

/// Moves atoms by whole cells until the bonds are short: each molecule grows from its first atom along its bonds.
/// Returns the shift that each bond still needs to make r_j - r_i + offset short; it is 0 except for bonds that close a
/// loop through a periodic face.
std::vector<Vector3> join_molecules(const Cell& cell, const std::vector<std::array<std::int32_t, 2>>& bonds,
                                    std::vector<Vector3>* positions);

}  // namespace tanor::scene
