#include "machine.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include "timing.hpp"

// Computes c := alpha a b + beta c by the machine's BLAS.
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

double measure_passes(Passes passes, double members) {
  constexpr int rounds = 7;
  constexpr double members_a_round = 5e5;
  constexpr std::size_t at_once = 128;
  const auto count = std::max<std::size_t>(static_cast<std::size_t>(members) / (2 * at_once), 1) * 2 * at_once;
  std::vector<double> r(3 * count, 1.0), v(3 * count, 2.0), block(3 * count), w(3 * count);
  std::vector<double> inverse_mass(count, 1.0), b(count), y(count), pivot(count), factor(count);
  const auto move_in = [&](std::size_t first) {
    for (std::size_t i = 3 * first; i < 3 * (first + at_once); ++i) block[i] = r[i] + v[i];
    for (std::size_t k = first; k < first + at_once; ++k) {
      b[k] = y[k] = inverse_mass[k];
      pivot[k] = factor[k] = 2.0 * inverse_mass[k];
    }
  };
  const auto move_out = [&](std::size_t first) {
    for (std::size_t k = first; k < first + at_once; ++k) y[k] = y[k] * pivot[k] - factor[k] + b[k] * inverse_mass[k];
    for (std::size_t i = 3 * first; i < 3 * (first + at_once); ++i) w[i] = 2.0 * block[i];
  };
  const auto move_once = [&](std::size_t first) {
    for (std::size_t i = 3 * first; i < 3 * (first + at_once); ++i) {
      block[i] = r[i] + v[i];
      w[i] = r[i] - v[i];
    }
    for (std::size_t k = first; k < first + at_once; ++k) y[k] = 2.0 * inverse_mass[k];
  };
  const auto sweep = [&] {
    if (passes == Passes::Once) {
      for (std::size_t k = 0; k < count; k += at_once) move_once(k);
    } else {
      const std::size_t middle = count / 2;
      for (std::size_t k = 0; k < middle; k += at_once) {
        move_in(k);
        move_in(count - k - at_once);
      }
      for (std::size_t k = 0; k < middle; k += at_once) {
        move_out(middle - k - at_once);
        move_out(middle + k);
      }
    }
    asm volatile("" : : "r"(w.data()), "r"(y.data()) : "memory");  // every sweep writes
  };
  const int repeats = static_cast<int>(std::max(1.0, members_a_round / static_cast<double>(count)));
  sweep();
  std::vector<double> seconds;
  for (int round = 0; round < rounds; ++round) {
    seconds.push_back(seconds_of([&] {
      for (int repeat = 0; repeat < repeats; ++repeat) sweep();
    }));
  }
  return median(seconds) / repeats * members / static_cast<double>(count);
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
