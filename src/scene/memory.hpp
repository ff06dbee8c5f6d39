#pragma once

namespace tanor::scene {

/// How many bytes this process may have: the least of what is installed, what its control groups allow, and its limit
/// on addresses (ulimit -v). It does not count what other processes use.
double measure_memory();

}  // namespace tanor::scene
