#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/mechanics.hpp"
#include "dynamics/scales.hpp"
#include "evaluate/series_program.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// The functions of time of a system: accelerations (forces over the smallest mass that they act on), velocities (of
/// guides along themselves) and positions (lengths, directions, displacements of supports). Formulas of state and time
/// are functions of time at the state where a step begins.
///
/// A scheme of order p follows an acceleration g inside a step as a polynomial does. What it does not see of g is
///
///   e = g - (the polynomial of degree p through g at the p + 1 Chebyshev points of the step)
///
/// and velocities and positions miss the integrals of e over the step; for given velocities and positions the
/// polynomial has one degree or two more. Other places are looked at between the Chebyshev points, no further apart
/// than asked: whatever is wider than that is found with certainty.
class Drives {
 public:
  /// `t`: where the system is checked.
  Drives(const System& system, const Numbering& numbering, std::span<const double> inverse_mass, double scene_size,
         double t);

  bool empty() const { return functions_.empty() && programs_.empty(); }

  /// Where a step begins: r and v [3n] in the inner order; q [s] in the user's, null where positions step.
  struct Place {
    const double *r, *v, *q;
    const Scales& scales;
  };
  DriveReport look(const DrivenStep& step, const Place& place);
  /// "wind", "force2" …: of a number in a report.
  const std::string& name(std::size_t drive) const { return names_[drive]; }

 private:
  enum class Level { Acceleration, Velocity, Position };
  /// scale times a number of time.
  struct Function {
    ScalarFunction function;
    Level level;
    double scale;
    std::vector<Index> points;  // that it moves, or some of them; inner
    std::size_t name;
  };
  /// An expression of the positions (of forces: and velocities) of some points, or of coordinates, and of time.
  struct Program {
    enum class As { AForce, AnEnergy, AConstraint, SomeCoordinates } as;
    SeriesProgram program;
    std::vector<Index> points;     // inner
    std::size_t first_coordinate;  // of the user's, where it is one of those
    double scale;                  // 1/mass of forces, else 1
    bool is_of_time_alone;
    std::size_t name;

    bool is_force() const { return as == As::AForce || as == As::AnEnergy; }
    /// What is looked at: of an energy its gradient.
    std::size_t num_values() const { return as == As::AnEnergy ? 3 * points.size() : program.num_results(); }
  };

  void add(const ScalarFunction& function, Level level, double scale, std::span<const Index> users_points);
  void add(const VectorFunction& function, Level level, double scale, std::span<const Index> users_points);
  template <class Group>
  void add(const Parameter& parameter, double scale, const Group& group);
  void add(const Expression& expression, Program::As as, double scale, std::size_t first_coordinate,
           std::span<const Index> users_points);
  template <class Group>
  void add_fields(const Group& group, double t);
  void add_force(const Force& force, std::span<const double> inverse_mass);
  void add_constraint(const Constraint& constraint, double t);
  void add_coordinates(const Coordinates& coordinates, double t, std::size_t first_coordinate);
  /// How far a turning direction moves what it guides, over its change; m.
  double lever(const VectorFunction& direction, double t) const;

  void place_samples(const DrivenStep& step, Level level, const ScalarFunction* function);
  double run(const Program& program, const Place& place);
  void load_state(const Program& program, const Place& place, SeriesLane* lanes) const;
  void silence_rounding(const DrivenStep& step, const double* samples, double largest);
  /// Of x and v; and how far the function moves them.
  struct Misses {
    double x = 0.0, v = 0.0, x_done = 0.0, v_done = 0.0;
  };
  Misses measure_misses(const DrivenStep& step, Level level, const double* samples, double range) const;
  int count_pieces(Level level, const double* samples, double range, double largest) const;
  void judge(const DrivenStep& step, const Place& place, std::span<const Index> points, Level level, double scale,
             const double* values, std::size_t name, DriveReport* report);
  void deviate(const double* values);
  void deviate_by_weights(const double* values);
  void choose_weights();

  const Numbering& numbering_;
  const double scene_size_;
  double reach_ = 0.0;  // m, the largest |r|
  std::vector<Function> functions_;
  std::vector<Program> programs_;
  std::vector<std::string> names_;

  // Of one look: the Chebyshev points, then the samples, in units of the step and of time; the widths of the samples'
  // pieces.
  std::size_t num_nodes_ = 0, num_samples_ = 0;
  bool has_equal_pieces_ = false;
  std::vector<double> fractions_, widths_, times_, values_, lanes_, knots_;
  std::vector<double> cosines_, chebyshev_, next_, after_next_;  // for polynomials at all samples
  std::vector<double> missed_;                                   // e at the samples
  // Where as many samples as nodes lie evenly, p at each sample from the values at the nodes: of each number of nodes
  // [sample][node]; and those of this look, or null.
  std::vector<std::vector<double>> all_weights_;
  const std::vector<double>* weights_ = nullptr;
};

}  // namespace tanor
