#include <cmath>

#include "cli/known_problems.hpp"

namespace tanor::cli {

namespace {

/// Solves the car axis of the IVP test set, Release 2.4, part II-1 (M = 10, eps = 0.01). The support at (xb, yb) is the
/// road under the right wheel.
///
///   left 2 ----axle---- 3 right
///        |spring        |spring
///      0 origin       1 (xb, yb),   yb = sin(10 t)/10, xb = sqrt(1 - yb^2)
Finding drive_car_axis() {
  System system;
  const Index origin = add_point({0, 0, 0}, {}, 1.0, &system), road = add_point({1, 0, 0}, {}, 1.0, &system);
  const Index left = add_point({0, 0.5, 0}, {-0.5, 0, 0}, 5e-4, &system);
  const Index right = add_point({1, 0.5, 0}, {-0.5, 0, 0}, 5e-4, &system);
  const VectorFunction wavy{ScalarFunction::formula("sqrt(1 - (0.1*sin(10*t))^2) - 1"),
                            ScalarFunction::formula("0.1*sin(10*t)"), 0.0};
  system.supports = {{"origin", {origin}, {}}, {"road", {road}, wavy}};
  system.constraints = {Angles{"right angle", {{left, origin, road}}, 0.0}, Rods{"axle", {{left, right}}, 1.0, {}}};
  system.forces = {Springs{"springs", {{origin, left}, {road, right}}, 1.0, 0.0, 0.5}, Gravity{"", {0, -1, 0}}};
  return follow(system, tightly(Method::Taylor), 3.0, left,
                {0.0493455784275402809, 0.496989460230171154, 0.0, 1.04174252488542152, 0.373911027265361257, 0.0});
}

/// Solves IFToMM benchmark A02: a row of 40 four-bar linkages of uniform bars, 1 m and 1 kg each, upright, sent off at
/// 1 m/s. A uniform bar has a sixth of its mass at each end and two thirds in the middle.
///
///   B0 --o-- B1 --o-- B2 …       all cranks turn alike: (41/3 + 40) angle'' = -(41/2 + 40) g cos(angle),
///   o        o        o          and wherever they lie flat, 40 equations depend on the others
///   A0       A1       A2 …
///
/// Near a flat configuration S is worse conditioned, and rounding counts that much more. After 20 of them 7.7 to 9.7
/// digits are left, depending on where steps happen to end.
Finding turn_four_bars(Method method) {
  constexpr Index loops = 40, cranks = loops + 1;
  System system;
  Support ground{"ground", {}, {}};
  Rods bars{"bars", {}, 1.0, {}};
  Planes sheet{"sheet", {}, Vector3{0, 0, 1}, 0.0};
  std::vector<std::vector<Index>> middles;
  const auto add_bar = [&](Index from, Index to, const Vector3& middle, const Vector3& velocity) {
    bars.pairs.push_back({from, to});
    middles.push_back({from, to, add_point(middle, velocity, 2.0 / 3.0, &system)});
  };
  for (Index k = 0; k < cranks; ++k) ground.points.push_back(add_point({1.0 * k, 0, 0}, {}, 1.0, &system));
  for (Index k = 0; k < cranks; ++k) {
    const double bars_there = k == 0 || k == loops ? 2.0 : 3.0;
    sheet.points.push_back(add_point({1.0 * k, 1, 0}, {1, 0, 0}, bars_there / 6.0, &system));
  }
  for (Index k = 0; k < cranks; ++k) {
    add_bar(ground.points[k], sheet.points[k], {1.0 * k, 0.5, 0}, {0.5, 0, 0});
    if (k > 0) add_bar(sheet.points[k - 1], sheet.points[k], {k - 0.5, 1, 0}, {1, 0, 0});
  }
  system.supports = {ground};
  system.constraints = {bars, sheet};
  for (const Vector3& axis : {Vector3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {  // middle - (from + to)/2
    const Vector3 half{-0.5 * axis[0], -0.5 * axis[1], -0.5 * axis[2]};
    system.constraints.push_back(Linears{"", middles, {half, half, axis}, 0.0});
  }
  system.forces = {Gravity{"", {0, -g, 0}}};
  return follow(system, {.method = method, .rtol = 1e-11, .atol = 1e-13}, 20.0, sheet.points[0],
                {0.410901153762945, 0.911679900971981, 0.0});
}

/// Solves three parallel cranks of 1 m whose tips are coupled by one rod too many.
Finding swing_parallelogram() {
  constexpr double x[] = {0.0, 1.0, 2.5};
  System system;
  for (const double pivot : x) add_point({pivot, 0, 0}, {}, 1.0, &system);
  for (int k = 0; k < 3; ++k) add_point({x[k] + std::sin(0.7), -std::cos(0.7), 0}, {}, 1.0 + k, &system);
  system.supports = {{"pivots", {0, 1, 2}, {}}};
  system.constraints = {Rods{"cranks", {{0, 3}, {1, 4}, {2, 5}}, 1.0, {}},
                        Rods{"couplers", {{3, 4}, {4, 5}, {3, 5}}, std::vector{1.0, 1.5, 2.5}, {}}};
  system.forces = {Gravity{"", {0, -g, 0}}};
  return follow(system, tightly(Method::Dop853), 5.0, 3, {-0.5703965679671275, -0.8213694389562604, 0.0});
}

}  // namespace

std::vector<KnownProblem> list_known_mechanisms() {
  return {{"car axis, 3 s", "IVP test set", "taylor", 11.0, drive_car_axis},
          {"40 four-bar linkages, 20 s (IFToMM A02)", "published; one angle", "dop853", 7.5,
           [] { return turn_four_bars(Method::Dop853); }},
          {"40 four-bar linkages, 20 s (IFToMM A02)", "published; one angle", "taylor", 7.5,
           [] { return turn_four_bars(Method::Taylor); }},
          {"redundant parallelogram, 5 s", "quadruple precision, two ways", "dop853", 11.5, swing_parallelogram}};
}

}  // namespace tanor::cli
