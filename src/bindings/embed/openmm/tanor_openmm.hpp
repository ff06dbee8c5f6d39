#pragma once

#include <OpenMM.h>

#include <vector>

#include <tanor/export.hpp>

/// \file
/// Exact constraints for OpenMM.
namespace tanor::embed {

/// A distance between two particles that is kept, nm.
struct DistanceConstraint {
  int particle1 = 0, particle2 = 0;
  double distance = 0.0;
};

/// A Force that exerts none. In each Context of a System that contains it, a tanor::Constrainer takes the place of CCMA
/// and SETTLE, with every integrator that applies constraints. All constraints of the System, and those added here,
/// then hold to rounding, whatever tolerance the integrator has, and in any graph: rings, rigid nets, more distances
/// than independent ones. It works on the platforms Reference and CPU.
///
/// Creating a Context throws an OpenMMException for any other platform, if there are no constraints, or if one cannot
/// be kept. A step throws one that names the particles, and leaves the positions as they were.
class TANOR_API ExactConstraints : public OpenMM::Force {
 public:
  /// Takes the number of OpenMP threads; 0 for as many as OpenMP gives.
  explicit ExactConstraints(int threads = 1) : threads_(threads) {}

  /// Adds a constraint that the System itself does not have, and returns its number. Unlike the System's own it may
  /// join a particle to one without mass, which then holds it. But OpenMM counts no degree of freedom for it, and
  /// LocalEnergyMinimizer keeps it only where it ends.
  int addConstraint(int particle1, int particle2, double distance);
  int getNumConstraints() const { return static_cast<int>(added_.size()); }
  /// Throws an OpenMMException if there is no such number.
  void getConstraintParameters(int index, int& particle1, int& particle2, double& distance) const;
  bool usesPeriodicBoundaryConditions() const override { return false; }

  const std::vector<DistanceConstraint>& added() const { return added_; }
  int threads() const { return threads_; }

 protected:
  OpenMM::ForceImpl* createImpl() const override;

 private:
  std::vector<DistanceConstraint> added_;
  int threads_;
};

}  // namespace tanor::embed

/// Adds ExactConstraints to the OpenMM::System at this address, which is `int(system.this)` in Python.
extern "C" TANOR_API void tanor_openmm_add_exact_constraints(void* system);
