#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/drive_samples.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/scales.hpp"
#include "evaluate/series_program.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The functions of time of a system: accelerations (forces over the smallest mass that they act on), velocities (of
/// guides along themselves) and positions (lengths, directions, displacements of supports). Formulas of state and time
/// are functions of time at the state where a step begins.
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

  bool empty() const { return functions_.empty() && programs_.empty(); }

  /// The state where a step begins: r and v [3n] in the inner order, q [s] in the user's order, null where positions
  /// step.
  struct Place {
    const double *r, *v, *q;
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
  /// An expression of time and of the positions of some points (and their velocities, for forces), or of coordinates.
  struct Program {
    enum class As { AForce, AnEnergy, AConstraint, SomeCoordinates } as;
    SeriesProgram program;
    std::vector<Index> points;     // inner
    std::size_t first_coordinate;  // in the user's order, for coordinates
    double scale;                  // 1/mass of forces, else 1
    bool is_of_time_alone;
    std::size_t name;

    bool is_force() const { return as == As::AForce || as == As::AnEnergy; }
    /// The number of functions of time in the program; an energy has one for each component of its gradient.
    std::size_t num_values() const { return as == As::AnEnergy ? 3 * points.size() : program.num_results(); }
  };

  void add(const ScalarFunction& function, DriveLevel level, double scale, std::span<const Index> users_points);
  void add(const VectorFunction& function, DriveLevel level, double scale, std::span<const Index> users_points);
  template <class Group>
  void add(const Parameter& parameter, double scale, const Group& group);
  void add(const Expression& expression, Program::As as, double scale, std::size_t first_coordinate,
           std::span<const Index> users_points);
  template <class Group>
  void add_fields(const Group& group, double t);
  void add_force(const Force& force, std::span<const double> inverse_mass);
  void add_constraint(const Constraint& constraint, double t);
  void add_coordinates(const Coordinates& coordinates, double t, std::size_t first_coordinate);
  /// Returns how far a turning direction moves the points that it guides, per unit of its change, m.
  double lever(const VectorFunction& direction, double t) const;

  double run(const Program& program, const Place& place);
  void load_state(const Program& program, const Place& place, SeriesLane* lanes) const;
  void assess(const DrivenStep& step, const Place& place, std::span<const Index> points, DriveLevel level, double scale,
              const double* values, std::size_t name, DriveReport* report);

  const Numbering& numbering_;
  const double scene_size_;
  double reach_ = 0.0;  // m, the largest |r|
  std::vector<Function> functions_;
  std::vector<Program> programs_;
  std::vector<std::string> names_;

  DriveSamples samples_;        // of the present step
  std::vector<double> values_;  // [value][instant]
  std::vector<double> lanes_;   // scratch of programs
};

}  // namespace tanor::detail
