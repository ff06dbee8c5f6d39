#pragma once

namespace tanor::cli {

/// Throws std::runtime_error if the machine does not give that many threads (0: as many as OpenMP wants), since OpenMP
/// would end the program without a word of ours.
void require_threads(int count);

/// Returns the number of threads that OpenMP gives a parallel loop.
int count_threads();

}  // namespace tanor::cli
