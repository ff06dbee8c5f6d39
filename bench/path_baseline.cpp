#include "path_baseline.hpp"

#include <algorithm>
#include <cmath>

bool PathBaseline::serves(const std::vector<std::array<int, 2>>& rods) {
  int last = -1;
  for (const auto& [i, j] : rods) {
    if (j != i + 1 || (i != last && i != last + 1)) return false;
    last = j;
  }
  return !rods.empty();
}

PathBaseline::PathBaseline(const std::vector<std::array<int, 2>>& rods, const std::vector<double>& masses,
                           const Triple& gravity)
    : w_(3 * masses.size(), 0.0), gravity_(gravity) {
  for (std::size_t k = 0; k < rods.size(); ++k) {
    if (k == 0 || rods[k][0] != rods[k - 1][1]) paths_.push_back({k, static_cast<std::size_t>(rods[k][0]), 0});
    ++paths_.back().num_rods;
  }
  for (const double mass : masses) inverse_masses_.push_back(1.0 / mass);
  for (std::size_t i = 0; i < masses.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) w_[3 * i + c] = inverse_masses_[i] > 0.0 ? gravity[c] : 0.0;
  }
  units_.resize(3 * rods.size());
  for (std::vector<double>* array : {&phi_, &lambda_, &pivots_, &below_}) array->resize(rods.size());
}

const double* PathBaseline::evaluate(const double* r, const double* v) {
  residual_ = 0.0;
  smallest_pivot_ = 1.0;
  for (const Path& path : paths_) {
    go_up(path, r, v);
    go_down(path);
  }
  return w_.data();
}

/// Eliminates the rods one after the other. Neighbours i and i + 1 share a point of mass m: S_i,i+1 = -u_i'u_i+1/m. Of
/// gravity only what a support lacks is felt, since all other points fall alike.
void PathBaseline::go_up(const Path& path, const double* r, const double* v) {
  const double *x = r + 3 * path.first_point, *y = v + 3 * path.first_point;
  const double* const inverse_mass = inverse_masses_.data() + path.first_point;
  double *u = units_.data() + 3 * path.first_rod, *phi = phi_.data() + path.first_rod;
  double *f = lambda_.data() + path.first_rod, *pivot = pivots_.data() + path.first_rod;
  double* below = below_.data() + path.first_rod;
  double bx = 0.0, by = 0.0, bz = 0.0, f_before = 0.0, pivot_before = 0.0;  // of the rod before
  for (std::size_t i = 0; i < path.num_rods; ++i) {
    const double ax = x[3 * i + 3] - x[3 * i], ay = x[3 * i + 4] - x[3 * i + 1], az = x[3 * i + 5] - x[3 * i + 2];
    const double inverse = 1.0 / std::sqrt(ax * ax + ay * ay + az * az);
    const double ux = ax * inverse, uy = ay * inverse, uz = az * inverse;
    const double vx = y[3 * i + 3] - y[3 * i], vy = y[3 * i + 4] - y[3 * i + 1], vz = y[3 * i + 5] - y[3 * i + 2];
    const double along = ux * vx + uy * vy + uz * vz;
    const double bias = (vx * vx + vy * vy + vz * vz - along * along) * inverse;
    u[3 * i] = ux, u[3 * i + 1] = uy, u[3 * i + 2] = uz;
    phi[i] = bias;
    const double held = (inverse_mass[i + 1] > 0.0 ? 1.0 : 0.0) - (inverse_mass[i] > 0.0 ? 1.0 : 0.0);
    const double diagonal = inverse_mass[i] + inverse_mass[i + 1];
    const double coupling = -inverse_mass[i] * (bx * ux + by * uy + bz * uz);
    below[i] = coupling * pivot_before;
    const double left = diagonal - below[i] * coupling;
    f_before = -(bias + held * (ux * gravity_[0] + uy * gravity_[1] + uz * gravity_[2])) - below[i] * f_before;
    f[i] = f_before;
    pivot[i] = pivot_before = 1.0 / left;
    smallest_pivot_ = std::min(smallest_pivot_, left / diagonal);
    bx = ux, by = uy, bz = uz;
  }
}

/// Substitutes back, adds M^-1 K lambda to gravity, and measures K'w + phi as soon as both ends of a rod are known.
void PathBaseline::go_down(const Path& path) {
  const double* const inverse_mass = inverse_masses_.data() + path.first_point;
  const double *const u = units_.data() + 3 * path.first_rod, *const phi = phi_.data() + path.first_rod;
  const double *const pivot = pivots_.data() + path.first_rod, *const below = below_.data() + path.first_rod;
  double *const lambda = lambda_.data() + path.first_rod, *const w = w_.data() + 3 * path.first_point;
  double behind = 0.0, hx = 0.0, hy = 0.0, hz = 0.0;  // lambda of the rod behind, and its force on the shared point
  for (std::size_t i = path.num_rods + 1; i-- > 0;) {
    double fx = 0.0, fy = 0.0, fz = 0.0;  // of rod i - 1 on point i
    if (i > 0) {
      const double here = lambda[i - 1] * pivot[i - 1] - (i < path.num_rods ? below[i] * behind : 0.0);
      lambda[i - 1] = behind = here;
      fx = here * u[3 * i - 3], fy = here * u[3 * i - 2], fz = here * u[3 * i - 1];
    }
    const double moves = inverse_mass[i] > 0.0 ? 1.0 : 0.0;
    w[3 * i] = moves * gravity_[0] + inverse_mass[i] * (fx - hx);
    w[3 * i + 1] = moves * gravity_[1] + inverse_mass[i] * (fy - hy);
    w[3 * i + 2] = moves * gravity_[2] + inverse_mass[i] * (fz - hz);
    if (i < path.num_rods) {
      const double left = u[3 * i] * (w[3 * i + 3] - w[3 * i]) + u[3 * i + 1] * (w[3 * i + 4] - w[3 * i + 1]) +
                          u[3 * i + 2] * (w[3 * i + 5] - w[3 * i + 2]) + phi[i];
      residual_ = std::max(residual_, std::abs(left));
    }
    hx = fx, hy = fy, hz = fz;
  }
}
