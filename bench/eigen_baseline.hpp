#pragma once

#include <array>
#include <memory>
#include <vector>

/// The yardstick of the benchmarks, a first program with Eigen: K from triplets, later its values alone; S = K'M^-1K by
/// sparse products, SimplicialLDLT whose analysis is kept, w = M^-1 (f + K lambda). Gravity [3]; a support has an
/// infinite mass. It is compiled at -O3 -march=native whatever tanor is compiled for.
class [[gnu::visibility("default")]] EigenBaseline {
 public:
  using Triple = std::array<double, 3>;
  /// Takes rods between points.
  EigenBaseline(std::vector<std::array<int, 2>> rods, const std::vector<double>& masses, const Triple& gravity);
  /// Takes points, each on its own sphere around the origin or on its own circle around the z axis.
  enum class Guide { Sphere, Circle };
  EigenBaseline(Guide guide, const std::vector<double>& masses, const Triple& gravity);
  ~EigenBaseline();

  /// Returns the accelerations [3n] at (r, v).
  const double* evaluate(const double* r, const double* v);

 private:
  struct Step;
  std::vector<std::array<int, 2>> rods_;
  Guide guide_ = Guide::Sphere;
  std::unique_ptr<Step> step_;
};

/// The yardstick for the tangent form of beads on circles of one radius around parallel axes, one angle each: A from
/// triplets, later its values alone; H = A'MA by sparse products, SimplicialLDLT whose analysis is kept, w = A q_ddot +
/// psi.
class [[gnu::visibility("default")]] EigenTangentBaseline {
 public:
  using Triple = std::array<double, 3>;
  /// Takes circles r - c = radius (cos q e1 + sin q e2).
  EigenTangentBaseline(const Triple& e1, const Triple& e2, double radius, const std::vector<double>& masses,
                       const Triple& gravity);
  ~EigenTangentBaseline();

  /// Returns the accelerations [3n] at (q, q_dot) [n].
  const double* evaluate(const double* q, const double* q_dot);

 private:
  struct Step;
  std::unique_ptr<Step> step_;
};
