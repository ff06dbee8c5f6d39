#pragma once

/// \file The highest speeds of the machine, measured where the benchmarks run.

/// Returns the median of bytes a second of a[k] = b[k] + s c[k] over three arrays of `working_set` bytes together: 24
/// bytes
/// an element (McCalpin's STREAM triad). The bytes that the cache reads before it writes are not counted.
[[gnu::visibility("default")]] double measure_bandwidth(double working_set, int threads);

/// Ways in which a linear solver moves its arrays through memory. `measure_passes` returns the median seconds of moving
/// them as an evaluation does, 128 members at a time on one thread, and computing next to nothing.
enum class Passes {
  Once,      ///< r v 1/m -> block w lambda: batches, closed form
  InAndOut,  ///< r v 1/m -> block b y pivot factor, from both ends; back again these -> lambda w: paths
};
[[gnu::visibility("default")]] double measure_passes(Passes passes, double members);

/// Returns flops a second of the machine's dgemm (OPENBLAS_NUM_THREADS=1 for one thread), the best of several.
[[gnu::visibility("default")]] double measure_dense_product();
