#pragma once

#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>

namespace tanor {

class EquilibriumEquations;

/// The system that is searched, and what was taken out of it.
struct StaticsInput {
  /// Checks options; throws InputError.
  StaticsInput(const System& given, const EquilibriumOptions& options);

  System system;                      ///< at rest, without friction and coordinates
  std::vector<double> prestress;      ///< [equations] lambda that is asked for; 0 elsewhere
  std::vector<std::string> left_out;  ///< by name
};

/// Says where tensions were asked for, multipliers that are not 0, and nothing is free to have them.
void note_useless_prestress(const std::vector<double>& prestress, std::size_t self_stress_states,
                            std::vector<std::string>* left_out);

/// Says where the tensions that were asked for are neither a state of self-stress nor balance the forces, so that the
/// multipliers found, which come nearest to them, are others: which one changes most. `given`, `found` [rows of the
/// model]; the equations were evaluated at the equilibrium.
void note_changed_prestress(const EquilibriumEquations& equations, const std::vector<double>& given,
                            const std::vector<double>& found, std::vector<std::string>* left_out);

/// "3 points from point 7 on: held rigid by prestress …"
std::string describe_rigid_points(const std::vector<Index>& points);

/// With gravity and constant forces times `factor`, at t.
System with_load(const System& system, double factor, double t);

}  // namespace tanor
