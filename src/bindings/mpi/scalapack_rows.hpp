#pragma once

#include <memory>
#include <span>

#include "mpi/tanor_mpi.hpp"

namespace tanor {

/// Makes shared rows whose matrix is spread over the ranks in blocks (ScaLAPACK, pdpotrf). Returns null if tanor_mpi
/// was built without it.
std::unique_ptr<SharedRows> make_scalapack_rows(MpiRanks& ranks, std::size_t num_rows,
                                                std::span<const std::size_t> own);

}  // namespace tanor
