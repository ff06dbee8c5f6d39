#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/drive_samples.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/scales.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The functions of time of a system: accelerations (forces over the smallest mass that they act on), velocities (of
/// guides along themselves) and positions (lengths, directions, displacements of supports). Formulas of state and time
/// are looked at along the step (see FormulaFeatures).
///
/// A scheme follows an acceleration inside a step as a polynomial does. The error of that polynomial is found at
/// samples between its nodes (see DriveSamples). The errors of velocities and positions are its integrals over the
/// step. Samples lie no further apart than requested, so every feature wider than their spacing is found with
/// certainty.
class Drives {
 public:
  /// The system is checked at the time `t`.
  Drives(const System& system, const Numbering& numbering, std::span<const double> inverse_mass, double scene_size,
         double t);

  bool empty() const { return functions_.empty(); }

  /// The state where a step begins: r and v [3n] in the inner order.
  struct Place {
    const double *r, *v;
    const Scales& scales;
  };
  DriveReport look(const DrivenStep& step, const Place& place);
  /// Returns the name of a function in a report: "wind", "force2", …
  const std::string& name(std::size_t drive) const { return names_[drive]; }

 private:
  /// A scale times a scalar function of time.
  struct Function {
    ScalarFunction function;
    DriveLevel level;
    double scale;
    std::vector<Index> points;  // points that it moves, or some of them; inner
    std::size_t name;
  };

  void add(const ScalarFunction& function, DriveLevel level, double scale, std::span<const Index> users_points);
  void add(const VectorFunction& function, DriveLevel level, double scale, std::span<const Index> users_points);
  template <class Group>
  void add(const Parameter& parameter, double scale, const Group& group);
  template <class Group>
  void add_fields(const Group& group, double t);
  /// Returns how far a turning direction moves the points that it guides, per unit of its change, m.
  double lever(const VectorFunction& direction, double t) const;

  void assess(const DrivenStep& step, const Place& place, const Function& function, DriveReport* report);

  const Numbering& numbering_;
  const double scene_size_;
  double reach_ = 0.0;  // m, the largest |r|
  std::vector<Function> functions_;
  std::vector<std::string> names_;

  DriveSamples samples_;        // of the present step
  std::vector<double> values_;  // [instant]
};

}  // namespace tanor::detail
