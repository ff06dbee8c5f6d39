#pragma once

/// \file What the machine can do at best, measured where the benchmarks run.

/// Bytes a second of a[k] = b[k] + s c[k] over three arrays of `working_set` bytes together, median: 24 bytes an
/// element (McCalpin's STREAM triad); what the cache reads before it writes is not counted.
[[gnu::visibility("default")]] double measure_bandwidth(double working_set, int threads);

/// Flops a second of the machine's dgemm (OPENBLAS_NUM_THREADS=1: of one thread), the best of several.
[[gnu::visibility("default")]] double measure_dense_product();
