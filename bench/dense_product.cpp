// Measures flops a second of OpenBLAS's dgemm with the kernels that the environment chooses (OPENBLAS_CORETYPE).
// scripts/bench measures with the fastest of them.
#include <cstdio>

#include "machine.hpp"

int main() {
  std::printf("%.4g\n", measure_dense_product());
}
