#pragma once

/// \file What the machine can do at best, measured where the benchmarks run.

/// Bytes a second of a[k] = b[k] + s c[k] over three arrays of `working_set` bytes together, median: 24 bytes an
/// element (McCalpin's STREAM triad); what the cache reads before it writes is not counted.
[[gnu::visibility("default")]] double measure_bandwidth(double working_set, int threads);

/// Seconds of moving the arrays of a linear solver as an evaluation does, 128 members at a time, and computing next to
/// nothing: what is left for the arithmetic when memory has had its time. Median, one thread.
enum class Passes {
  Once,      ///< r v 1/m -> block w lambda: bundles, closed form
  InAndOut,  ///< r v 1/m -> block b y pivot factor, from both ends; back again these -> lambda w: paths
};
[[gnu::visibility("default")]] double measure_passes(Passes passes, double members);

/// Flops a second of the machine's dgemm (OPENBLAS_NUM_THREADS=1: of one thread), the best of several.
[[gnu::visibility("default")]] double measure_dense_product();
