#include "embed/openmm/constrainer_algorithm.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <utility>

namespace tanor::embed {

namespace {

using OpenMM::OpenMMException;
using OpenMM::Vec3;

std::string text(double number) {
  std::ostringstream out;
  out << number;
  return out.str();
}

std::string name_of(const DistanceConstraint& constraint) {
  return "the constraint between particles " + std::to_string(constraint.particle1) + " and " +
         std::to_string(constraint.particle2);
}

[[noreturn]] void refuse_constraint(const DistanceConstraint& constraint, const std::string& why) {
  throw OpenMMException("ExactConstraints: " + name_of(constraint) + why);
}

}  // namespace

ConstrainerAlgorithm::ConstrainerAlgorithm(const OpenMM::System& system, const std::vector<DistanceConstraint>& added,
                                           int threads)
    : point_(static_cast<std::size_t>(system.getNumParticles()), -1), threads_(threads) {
  for (int k = 0; k < system.getNumConstraints(); ++k) {
    DistanceConstraint own;
    system.getConstraintParameters(k, own.particle1, own.particle2, own.distance);
    add(system, own);
  }
  for (const DistanceConstraint& one : added) add(system, one);
  if (constraints_.empty()) throw OpenMMException("ExactConstraints: the System has no constraints");

  std::set<std::pair<int, int>> seen;
  for (const DistanceConstraint& one : constraints_) {
    if (!seen.insert(std::minmax(one.particle1, one.particle2)).second) refuse_constraint(one, " is there twice");
  }
}

void ConstrainerAlgorithm::add(const OpenMM::System& system, const DistanceConstraint& constraint) {
  const auto [i, j, distance] = constraint;
  for (const int particle : {i, j}) {
    if (particle < 0 || particle >= system.getNumParticles())
      refuse_constraint(constraint, ": there is no particle " + std::to_string(particle));
    if (system.isVirtualSite(particle))
      refuse_constraint(constraint, ": particle " + std::to_string(particle) + " is a virtual site");
  }
  if (i == j) refuse_constraint(constraint, " joins a particle to itself");
  if (!(distance > 0.0 && std::isfinite(distance)))
    refuse_constraint(constraint, " has the distance " + text(distance) + " nm; it must be positive");
  if (system.getParticleMass(i) == 0.0 && system.getParticleMass(j) == 0.0) return;
  pairs_.push_back({point_of(system, i), point_of(system, j)});
  constraints_.push_back(constraint);
}

Index ConstrainerAlgorithm::point_of(const OpenMM::System& system, int particle) {
  Index& point = point_[static_cast<std::size_t>(particle)];
  if (point < 0) {
    point = static_cast<Index>(particle_.size());
    particle_.push_back(particle);
    const double mass = system.getParticleMass(particle);
    masses_.push_back(mass > 0.0 ? mass : std::numeric_limits<double>::infinity());
  }
  return point;
}

void ConstrainerAlgorithm::apply(std::vector<Vec3>& old_positions, std::vector<Vec3>& positions, std::vector<double>&,
                                 double) {
  Constrainer& constrainer = constrainer_at(old_positions);
  if (&old_positions == &positions) {
    const ConstraintReport report = constrainer.project_positions(points(positions));
    if (report.outcome.ok()) return;
    require_numbers(positions, "position");
    refuse(report);
  }
  // Integrators do not set positions of particles without mass.
  for (std::size_t p = 0; p < masses_.size(); ++p) {
    const auto particle = static_cast<std::size_t>(particle_[p]);
    if (std::isinf(masses_[p])) positions[particle] = old_positions[particle];
  }
  const ConstraintReport report = constrainer.constrain_positions(
      {.step = 1.0, .old_positions = points(old_positions), .positions = points(positions), .measures = false});
  if (report.outcome.ok()) return;
  require_numbers(old_positions, "position");
  require_numbers(positions, "position");
  const ConstraintReport start = constrainer.violation(points(old_positions));
  if (start.violation <= 1e-8) refuse(report);
  refuse_constraint(constraints_[start.worst_row], " is violated by " + text(start.violation) +
                                                       " of its distance where the step begins; call "
                                                       "applyConstraints() of the Context after setPositions()");
}

void ConstrainerAlgorithm::applyToVelocities(std::vector<Vec3>& positions, std::vector<Vec3>& velocities,
                                             std::vector<double>&, double) {
  Constrainer& constrainer = constrainer_at(positions);
  const ConstraintReport report = constrainer.constrain_velocities(
      {.positions = points(positions), .velocities = points(velocities), .measures = false});
  if (report.outcome.ok()) return;
  require_numbers(positions, "position");
  require_numbers(velocities, "velocity");
  refuse(report);
}

Constrainer& ConstrainerAlgorithm::constrainer_at(std::vector<Vec3>& positions) {
  if (constrainer_) return *constrainer_;
  require_numbers(positions, "position");
  std::vector<double> lengths;
  for (const DistanceConstraint& one : constraints_) lengths.push_back(one.distance);
  try {
    constrainer_.emplace(masses_, std::vector<Constraint>{Rods{"constraints", pairs_, std::move(lengths), {}}},
                         points(positions), SolverOptions{.threads = threads_});
  } catch (const InputError& error) {
    throw OpenMMException(std::string("ExactConstraints: ") + error.what());
  }
  return *constrainer_;
}

PointArray ConstrainerAlgorithm::points(std::vector<Vec3>& particles) const {
  return {&particles[0][0], sizeof(Vec3), particle_.data()};
}

void ConstrainerAlgorithm::require_numbers(const std::vector<Vec3>& particles, const char* what) const {
  for (const Index particle : particle_) {
    const Vec3& at = particles[static_cast<std::size_t>(particle)];
    if (!std::isfinite(at[0]) || !std::isfinite(at[1]) || !std::isfinite(at[2]))
      throw OpenMMException("ExactConstraints: the " + std::string(what) + " of particle " + std::to_string(particle) +
                            " is no finite number");
  }
}

void ConstrainerAlgorithm::refuse(const ConstraintReport& report) const {
  if (report.worst_row >= constraints_.size()) throw OpenMMException("ExactConstraints: " + report.outcome.what);
  const DistanceConstraint& worst = constraints_[report.worst_row];
  if (report.outcome.status != Status::NotConverged) refuse_constraint(worst, ": " + report.outcome.what);
  refuse_constraint(worst, " does not converge, and is left violated by " + text(report.violation) +
                               " of its distance: the step is too long");
}

}  // namespace tanor::embed
