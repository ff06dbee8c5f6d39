#pragma once

/// \file Friction-contact problems of others: Siconos' text files of local and global problems, and FCLIB's HDF5.

#include <filesystem>

#include "contact/cone_problem.hpp"

namespace tanor::bench {

/// Reads a problem. Global ones, M v = H r + f and u = H'v + w, become W = H'M^-1H; contacts of the plane get a second
/// tangent that nothing is coupled with. Throws std::runtime_error with the file.
detail::ConeProblem read_contact_problem(const std::filesystem::path& file);

/// Writes a problem with W and q over the scale of W as Siconos' text of blocks.
void write_contact_problem(const detail::ConeProblem& problem, const std::filesystem::path& file);

}  // namespace tanor::bench
