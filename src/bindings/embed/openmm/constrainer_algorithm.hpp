#pragma once

#include <openmm/reference/ReferenceConstraintAlgorithm.h>

#include <optional>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "embed/openmm/tanor_openmm.hpp"

namespace tanor::embed {

/// The constraint algorithm that OpenMM calls in place of CCMA.
class ConstrainerAlgorithm : public OpenMM::ReferenceConstraintAlgorithm {
 public:
  /// Takes all constraints of the system and the `added` ones, except those between two particles without mass. Throws
  /// OpenMM::OpenMMException.
  ConstrainerAlgorithm(const OpenMM::System& system, const std::vector<DistanceConstraint>& added, int threads);

  /// Applies SHAKE along K of the old positions. If both arrays are one (Context::applyConstraints), finds the nearest
  /// positions.
  void apply(std::vector<OpenMM::Vec3>& old_positions, std::vector<OpenMM::Vec3>& positions,
             std::vector<double>& inverse_masses, double tolerance) override;
  void applyToVelocities(std::vector<OpenMM::Vec3>& positions, std::vector<OpenMM::Vec3>& velocities,
                         std::vector<double>& inverse_masses, double tolerance) override;

 private:
  void add(const OpenMM::System& system, const DistanceConstraint& constraint);
  Index point_of(const OpenMM::System& system, int particle);
  Constrainer& constrainer_at(std::vector<OpenMM::Vec3>& positions);
  PointArray points(std::vector<OpenMM::Vec3>& particles) const;
  void require_numbers(const std::vector<OpenMM::Vec3>& particles, const char* what) const;
  [[noreturn]] void refuse(const ConstraintReport& report) const;

  std::vector<DistanceConstraint> constraints_;  // [row]
  std::vector<std::array<Index, 2>> pairs_;      // [row] its points
  std::vector<Index> particle_;                  // [point] its number in OpenMM
  std::vector<Index> point_;                     // [particle] its point, or -1
  std::vector<double> masses_;                   // [point]; a particle without mass is a support
  int threads_;
  std::optional<Constrainer> constrainer_;  // made from the first positions that are seen
};

}  // namespace tanor::embed
