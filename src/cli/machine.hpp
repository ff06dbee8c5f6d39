#pragma once

namespace tanor::cli {

/// BLAS at one thread: our own loops use all of them.
void keep_blas_serial();

/// Threads that OpenMP gives a parallel loop.
int count_threads();

}  // namespace tanor::cli
