#include "machine.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "timing.hpp"

// c := alpha a b + beta c by the machine's BLAS
extern "C" void dgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
                       const int* inner, const double* alpha, const double* a, const int* stride_a, const double* b,
                       const int* stride_b, const double* beta, double* c, const int* stride_c);

double measure_bandwidth(double working_set, int threads) {
  constexpr int rounds = 7;
  constexpr double bytes_each = 24.0, bytes_a_round = 4e8;
  const auto size = static_cast<std::size_t>(std::max(working_set / bytes_each, 64.0));
  std::unique_ptr<double[]> a(new double[size]), b(new double[size]), c(new double[size]);
  const auto for_all = [&](const auto& work) {  // the threads that touch a page first use it later
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1)
    for (std::size_t k = 0; k < size; ++k) work(k);
  };
  for_all([&](std::size_t k) {
    a[k] = 0.0;
    b[k] = 1.0;
    c[k] = 2.0;
  });
  const double bytes = bytes_each * static_cast<double>(size);
  const int repeats = static_cast<int>(std::max(1.0, bytes_a_round / bytes));
  std::vector<double> seconds;
  for (int round = 0; round < rounds; ++round) {
    seconds.push_back(seconds_of([&] {
      for (int repeat = 0; repeat < repeats; ++repeat) {
        double* const to = a.get();
        const double *const from = b.get(), *const other = c.get();
        for_all([=](std::size_t k) { to[k] = from[k] + 3.0 * other[k]; });
        asm volatile("" : : "r"(to) : "memory");  // every repeat writes
      }
    }));
  }
  return bytes * repeats / median(seconds);
}

double measure_dense_product() {
  constexpr int size = 1024, rounds = 7;
  constexpr double one = 1.0;
  const std::vector<double> a(size * size, 1.0), b(size * size, 2.0);
  std::vector<double> c(size * size, 0.0);
  double best = 0.0;
  for (int round = 0; round < rounds; ++round) {
    const double seconds = seconds_of(
        [&] { dgemm_("N", "N", &size, &size, &size, &one, a.data(), &size, b.data(), &size, &one, c.data(), &size); });
    best = std::max(best, 2.0 * size * size * size / seconds);
  }
  return best;
}
