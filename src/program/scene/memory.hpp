#pragma once

namespace tanor::scene {

/// Returns how many bytes this process may have: the least of the installed memory, the limits of its control groups,
/// and its limit on addresses (ulimit -v). Memory used by other processes is not subtracted.
double measure_memory();

}  // namespace tanor::scene
