#pragma once

namespace tanor::cli {

/// Throws std::runtime_error if the machine does not give that many threads (0: as many as OpenMP wants), since OpenMP
/// would end the program without a word of ours.
void require_threads(int count);

/// Makes the first call of BLAS, if SuiteSparseQR is to call it, with one thread. OpenBLAS maps its work space (128
/// MiB) in that call, keeps it, and asks for it forever if the system refuses it. Throws std::runtime_error where it
/// would.
void require_work_space_of_blas();

/// Returns the number of threads that OpenMP gives a parallel loop.
int count_threads();

}  // namespace tanor::cli
