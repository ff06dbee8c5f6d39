#include "statics/damping_matrix.hpp"

#include <vector>

namespace tanor::detail {

Eigen::SparseMatrix<double> find_damping(Workspace& work, double t, const double* r) {
  const Model& model = work.model();
  const std::vector<Coupling> couplings = work.forces.list_couplings();
  const std::vector<Influence> influences = work.forces.list_influences();
  std::vector<Block3> of_points(model.num_moving()), of_couplings(couplings.size()), of_influences(influences.size());
  std::vector<Block3> places_of_points(of_points.size()), places_of_couplings(of_couplings.size()),
      places_of_influences(of_influences.size());
  const std::vector<double> at_rest(3 * model.num_points(), 0.0);
  work.set_time(t);
  work.forces.evaluate_derivatives(model.parallel, t, r, at_rest.data(), nullptr,
                                   {places_of_points.data(), of_points.data(), places_of_couplings.data(),
                                    of_couplings.data(), places_of_influences.data(), of_influences.data()});

  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int i, int j, double sign, const Block3& block) {
    if (static_cast<std::size_t>(i) >= of_points.size() || static_cast<std::size_t>(j) >= of_points.size()) return;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        entries.emplace_back(3 * i + row, 3 * j + column, sign * block(row, column));
    }
  };
  for (std::size_t i = 0; i < of_points.size(); ++i) add(static_cast<int>(i), static_cast<int>(i), -1.0, of_points[i]);
  for (std::size_t k = 0; k < couplings.size(); ++k) {
    // If B is the derivative of the force on j in v_j, D has -B at (i, i) and (j, j), and B at (i, j) and (j, i).
    const auto [i, j] = couplings[k];
    add(i, i, -1.0, of_couplings[k]);
    add(j, j, -1.0, of_couplings[k]);
    add(i, j, 1.0, of_couplings[k]);
    add(j, i, 1.0, of_couplings[k]);
  }
  for (std::size_t k = 0; k < influences.size(); ++k) add(influences[k].on, influences[k].of, -1.0, of_influences[k]);
  const auto size = static_cast<Eigen::Index>(3 * of_points.size());
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

Eigen::SparseMatrix<double> find_coriolis(const EquilibriumEquations& equations) {
  const Vec3 spin = equations.spin();
  const auto size = static_cast<Eigen::Index>(equations.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < size; i += 3) {
    const double twice = 2.0 * equations.model().mass[static_cast<std::size_t>(i / 3)];
    const auto add = [&](Eigen::Index row, Eigen::Index column, double value) {
      entries.emplace_back(i + row, i + column, twice * value);
      entries.emplace_back(i + column, i + row, -twice * value);
    };
    add(2, 1, spin.x);
    add(0, 2, spin.y);
    add(1, 0, spin.z);
  }
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace tanor::detail
