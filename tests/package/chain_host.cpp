// A host program owns the arrays, the time loop and the scheme; tanor gives accelerations, multipliers and the way back
// onto the constraints. A chain of 10 rods is released horizontally; the exit code is 1 if any answer is wrong.
//
//     o----o----o-- … --o      rods 0.1 m, beads 0.1 kg, gravity along -y
//   (0,0)             (1,0)

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <vector>

#include <tanor/dynamics.hpp>
#include <tanor/version.hpp>

namespace {

constexpr std::size_t num_rods = 10;
constexpr double rod_length = 0.1;  // m
constexpr double mass = 0.1;        // kg
constexpr double gravity = 9.81;    // m/s^2

using Array = std::vector<double>;  // 3n numbers, point by point

tanor::System make_chain() {
  tanor::System chain;
  chain.masses.assign(num_rods + 1, mass);
  for (std::size_t i = 0; i <= num_rods; ++i)
    chain.positions.insert(chain.positions.end(), {rod_length * static_cast<double>(i), 0.0, 0.0});
  chain.supports.push_back({.name = "anchor", .points = {0}, .displacement = {}});
  tanor::Rods rods;
  for (tanor::Index i = 0; i < static_cast<tanor::Index>(num_rods); ++i) rods.pairs.push_back({i, i + 1});
  chain.constraints.push_back(rods);
  chain.forces.push_back(tanor::Gravity{.name = "", .acceleration = {0.0, -gravity, 0.0}});
  return chain;
}

// Returns x + h d.
Array moved(const Array& x, double h, const Array& d) {
  Array result = x;
  for (std::size_t k = 0; k < x.size(); ++k) result[k] += h * d[k];
  return result;
}

// Adds h/6 (d1 + 2 d2 + 2 d3 + d4) to x.
void add_weighted(double h, const Array& d1, const Array& d2, const Array& d3, const Array& d4, Array* x) {
  for (std::size_t k = 0; k < x->size(); ++k) (*x)[k] += h / 6.0 * (d1[k] + 2.0 * d2[k] + 2.0 * d3[k] + d4[k]);
}

// Returns the kinetic and potential energy of the beads, J; 0 at the start.
double energy(const Array& r, const Array& v) {
  double sum = 0.0;
  for (std::size_t k = 3; k < r.size(); k += 3)
    sum += mass * (0.5 * (v[k] * v[k] + v[k + 1] * v[k + 1] + v[k + 2] * v[k + 2]) + gravity * r[k + 1]);
  return sum;
}

// Returns the largest ||r_j - r_i| - length|/length.
double violation(const Array& r) {
  double largest = 0.0;
  for (std::size_t k = 3; k < r.size(); k += 3)
    largest = std::max(
        largest, std::abs(std::hypot(r[k] - r[k - 3], r[k + 1] - r[k - 2], r[k + 2] - r[k - 1]) / rod_length - 1.0));
  return largest;
}

struct Answer {
  double tip_x = 0.0, tip_y = 0.0;
  double tension = 0.0;       // of the first rod, N
  double energy_drift = 0.0;  // largest on the way, J
  double violation = 0.0;     // largest on the way
  bool ok = true;             // every call said so
};

// The host's own loop takes classical Runge-Kutta steps and then projects back onto the constraints.
Answer simulate(double t_end, int num_steps) {
  tanor::Dynamics dynamics(make_chain());
  Array r = dynamics.system().positions;
  Array v(r.size(), 0.0);
  Array w1(r.size()), w2(r.size()), w3(r.size()), w4(r.size());
  Array multipliers(dynamics.num_equations());
  Answer answer;

  const double h = t_end / num_steps;
  const auto accelerations = [&](double t, const Array& positions, const Array& velocities, Array* w) {
    answer.ok = answer.ok &&
                dynamics.solve({.time = t, .positions = positions, .velocities = velocities}, {.accelerations = *w})
                    .outcome.ok();
  };
  for (int step = 0; step < num_steps; ++step) {
    const double t = step * h;
    accelerations(t, r, v, &w1);
    const Array v2 = moved(v, h / 2, w1);
    accelerations(t + h / 2, moved(r, h / 2, v), v2, &w2);
    const Array v3 = moved(v, h / 2, w2);
    accelerations(t + h / 2, moved(r, h / 2, v2), v3, &w3);
    const Array v4 = moved(v, h, w3);
    accelerations(t + h, moved(r, h, v3), v4, &w4);
    add_weighted(h, v, v2, v3, v4, &r);
    add_weighted(h, w1, w2, w3, w4, &v);

    answer.ok = answer.ok && dynamics.project_positions({.time = t + h, .positions = r}).outcome.ok();
    answer.ok = answer.ok && dynamics.project_velocities({.time = t + h, .positions = r, .velocities = v}).outcome.ok();
    answer.energy_drift = std::max(answer.energy_drift, std::abs(energy(r, v)));
    answer.violation = std::max(answer.violation, violation(r));
  }
  answer.ok = answer.ok && dynamics
                               .solve({.time = t_end, .positions = r, .velocities = v},
                                      {.accelerations = w1, .multipliers = multipliers})
                               .outcome.ok();
  answer.tip_x = r[r.size() - 3];
  answer.tip_y = r[r.size() - 2];
  answer.tension = -multipliers.front();
  return answer;
}

// The reference at t = 0.25 s is a quadruple-precision extrapolation, checked with angles as coordinates.
constexpr double reference_tip_x = 0.8824586693622908;
constexpr double reference_tip_y = -0.3065624997245702;
constexpr double reference_tension = 10.412212941464175;

double tip_error(const Answer& answer) {
  return std::hypot(answer.tip_x - reference_tip_x, answer.tip_y - reference_tip_y);
}

bool expect(bool condition, const char* what) {
  if (!condition) std::printf("WRONG: %s\n", what);
  return condition;
}

// The exception's type must be one and the same here and in the library.
bool bad_input_is_caught() {
  tanor::System chain = make_chain();
  chain.masses[3] = -1.0;
  try {
    tanor::Dynamics dynamics(chain);
  } catch (const tanor::InputError& error) {
    std::printf("bad mass: %s: %s\n", error.where().c_str(), error.what());
    return true;
  }
  return false;
}

}  // namespace

int main() {
  const Answer coarse = simulate(0.25, 250);
  const Answer fine = simulate(0.25, 500);

  std::printf("tanor %s\n", TANOR_VERSION);
  for (const Answer& a : {coarse, fine})
    std::printf("tip error %.2e m, tension error %.2e N, energy drift %.2e J, violation %.2e\n", tip_error(a),
                std::abs(a.tension - reference_tension), a.energy_drift, a.violation);
  bool right = expect(coarse.ok && fine.ok, "every solve and projection succeeds");
  right &= expect(tip_error(fine) < 1e-10, "tip within 1e-10 m of the reference");
  right &= expect(tip_error(coarse) > 10.0 * tip_error(fine), "half the step, a tenth of the error: order 4");
  right &= expect(std::abs(fine.tension - reference_tension) < 1e-7, "tension of the first rod within 1e-7 N");
  right &= expect(fine.energy_drift < 1e-9, "energy is kept to 1e-9 J");
  right &= expect(coarse.violation < 1e-12 && fine.violation < 1e-12, "rods keep their length to 1e-12");
  right &= expect(bad_input_is_caught(), "a negative mass throws tanor::InputError");
  return right ? 0 : 1;
}
