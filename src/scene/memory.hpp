#pragma once

namespace tanor::scene {

/// Bytes that this process may have: the least of what is installed, of what its control groups allow, and of its limit
/// on addresses (ulimit -v). How much of it others use is not looked at.
double measure_memory();

}  // namespace tanor::scene
