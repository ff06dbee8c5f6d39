/// Takes the text of a formula of time, as a force, a potential and a constraint, with all derivatives that are asked
/// for.

#include <array>
#include <string>

#include <tanor/dynamics.hpp>

#include "target.hpp"

namespace {

using namespace tanor;

const Constants constants{{"omega", 3.0}};

void evaluate_in_time(std::string_view text) {
  const ScalarFunction f = ScalarFunction::formula(text, constants);
  for (const double t : {0.0, 0.7, -1e9}) f(t);
  std::array<double, ScalarFunction::largest_order + 1> coefficients;
  f.expand(0.3, coefficients);
}

/// Computes the accelerations of two points; `add` puts the formula in, as a force or a constraint.
template <class Add>
void solve_with(const Add& add) {
  System system;
  system.positions = {0.1, 0.2, 0.3, 1.1, 0.4, -0.2};
  system.velocities = {0.0, 1.0, 0.0, 0.5, 0.0, 0.0};
  system.masses = {1.0, 2.0};
  fuzz::takes([&] {
    add(&system);
    SolverOptions options;
    options.threads = 1;
    Dynamics dynamics(system, options);
    (void)dynamics.solve({.time = 0.5, .positions = system.positions, .velocities = system.velocities});
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(fuzz::text_of(data, size));
  fuzz::takes([&] { evaluate_in_time(text); });
  solve_with([&](System* system) {
    system->constraints.emplace_back(UserConstraints{"c", {{0, 1}}, formula_constraint(text, 2, constants)});
  });
  solve_with([&](System* system) {
    system->forces.emplace_back(FormulaForce{"f", {0, 1}, formula_force({text, text, text}, constants)});
  });
  return 0;
}
