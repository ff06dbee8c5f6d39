#pragma once

#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>

#include "statics/steady_frame.hpp"

namespace tanor::detail {

class EquilibriumEquations;

/// The system whose equilibrium is sought, and what was taken out of it.
struct StaticsInput {
  /// Checks the options; throws InputError.
  StaticsInput(const System& given, const EquilibriumOptions& options);

  System system;                      ///< at rest, without friction and coordinates, with the inertia of the frame
  SteadyFrame frame;                  ///< in which it rests
  std::vector<double> prestress;      ///< [equations] requested lambda; 0 elsewhere
  std::vector<std::string> left_out;  ///< by name

 private:
  void enter_frame(const EquilibriumOptions& options);
};

/// Notes requested tensions, multipliers that are not 0, in a system without states of self-stress.
void note_useless_prestress(const std::vector<double>& prestress, std::size_t self_stress_states,
                            std::vector<std::string>* left_out);

/// Notes requested tensions that are neither a state of self-stress nor balance the forces. The multipliers found are
/// then the ones nearest to them, and the note names the one that differs most. `given` and `found` are [rows of the
/// model]; the equations must have been evaluated at the equilibrium.
void note_changed_prestress(const EquilibriumEquations& equations, const std::vector<double>& given,
                            const std::vector<double>& found, std::vector<std::string>* left_out);

/// Returns "3 points from point 7 on: held rigid by prestress …".
std::string describe_rigid_points(const std::vector<Index>& points);

/// Returns "a, b, c and 9 more" of many names.
std::string name_some(const std::vector<std::string>& all, const char* separator = ", ", const char* rest = " and ");

/// Returns the system with gravity and constant forces at t multiplied by `factor`.
System with_load(const System& system, double factor, double t);

}  // namespace tanor::detail
