#pragma once

#include <array>
#include <vector>

/// The yardstick for rods in paths: the plainest program that can do the job, one scalar elimination that evaluates K
/// and phi on the way up, and finds lambda, w and the residual on the way down. A path's points and rods follow one
/// another; supports have infinite masses. It is compiled at -O3 -march=native whatever tanor is compiled for.
class [[gnu::visibility("default")]] PathBaseline {
 public:
  using Triple = std::array<double, 3>;
  /// Returns true if the rods are paths, each with its points and rods in order and one rod behind the other.
  static bool serves(const std::vector<std::array<int, 2>>& rods);
  PathBaseline(const std::vector<std::array<int, 2>>& rods, const std::vector<double>& masses, const Triple& gravity);

  /// Returns the accelerations [3n] at (r, v).
  const double* evaluate(const double* r, const double* v);
  /// The same evaluation's lambda [d], the largest |K'w + phi|, and the smallest pivot over its diagonal element.
  const std::vector<double>& lambda() const {
    return lambda_;
  }
  double residual() const {
    return residual_;
  }
  double smallest_pivot() const {
    return smallest_pivot_;
  }

 private:
  struct Path {
    std::size_t first_rod, first_point, num_rods;
  };
  void go_up(const Path& path, const double* r, const double* v);
  void go_down(const Path& path);

  std::vector<Path> paths_;
  std::vector<double> inverse_masses_, w_;                     // [n], [3n]
  std::vector<double> units_, phi_, lambda_, pivots_, below_;  // [3d], [d] …: 1/pivot, and L below the diagonal
  Triple gravity_;
  double residual_ = 0.0, smallest_pivot_ = 1.0;
};
