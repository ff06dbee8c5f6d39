#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "dynamics/workspace.hpp"
#include "statics/steady_frame.hpp"

namespace tanor::detail {

/// Configurations are disturbed, so that no rate vanishes by accident.
struct Disturbance {
  std::size_t number;  // each is another configuration
  double part;         // of the scene's size
};

/// The supports, constraints and forces of a system that depend on time, and how they move at an instant.
class MovingParts {
 public:
  MovingParts(const System& system, double t);

  double size() const { return model_.scene_size; }
  Vec3 centre() const { return centre_; }

  /// A configuration at one instant: supports where they are, all other points where the frame has carried them from a
  /// disturbed start. Arrays are in the inner order, [3 points].
  struct Configuration {
    double tau;
    std::vector<double> r, prescribed;
  };
  Configuration place(const SteadyFrame& frame, double tau, const Disturbance& by);

  /// Returns the rates, m/s, at which points that move with the frame leave what is prescribed: each member of a
  /// constraint, of which the distance |xi| from all its rows counts, each number of a support, each number of a given
  /// force, over the size of the force, and the energy of each tuple of a potential, over its gradient. They are linear
  /// in the velocities of the frame.
  Eigen::VectorXd find_rates(const SteadyFrame& frame, const Configuration& at);

 private:
  void add_members(const Configuration& at, const std::vector<double>& v, std::vector<double>* rates);
  void add_forces(const SteadyFrame& frame, const Configuration& at, const std::vector<double>& v,
                  std::vector<double>* rates) const;
  double find_rate_of_level(const Potential& potential, std::size_t tuple, double t, const std::vector<double>& at,
                            const std::vector<double>& velocities) const;

  const System& system_;
  double t_;
  Workspace work_;
  const Model& model_;
  std::vector<double> r_;
  Vec3 centre_{};
  std::vector<std::vector<int>> members_;  // inner rows
};

}  // namespace tanor::detail
