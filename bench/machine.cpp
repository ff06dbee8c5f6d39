#include "machine.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Dense>

#include "timing.hpp"

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
  constexpr Eigen::Index size = 768;
  constexpr int rounds = 7;
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(size, size), B = Eigen::MatrixXd::Random(size, size);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  double best = 0.0;
  for (int round = 0; round < rounds; ++round) {
    const double seconds = seconds_of([&] { C.noalias() += A * B; });
    best = std::max(best, 2.0 * static_cast<double>(size * size * size) / seconds);
  }
  return best;
}
