#pragma once

#include "car_axis.hpp"
#include "normal_form.hpp"
#include "stabilised_form.hpp"

namespace rivals {

constexpr double projection_share = 0.01;  // of the tolerance
constexpr long most_steps = 10'000'000;

inline void require(int flag) {
  if (flag < 0) throw std::runtime_error("SUNDIALS: flag " + std::to_string(flag));
}

/// Data for the callbacks of SUNDIALS: the problem in normal form, and the order of its state.
struct Motion {
  Motion(const Problem& given, const std::string& method, double wanted)
      : problem(given),
        form(given),
        tolerance(wanted),
        size(given.is_car_axis ? CarAxis::size : 3 * given.size()),
        is_stiff(given.is_car_axis || given.is_stiff()),
        is_bead_by_bead(!given.springs.empty() && (method.starts_with("bdf") || method == "sdirk")),
        state(static_cast<std::size_t>(2 * size)),
        rates(state) {}

  const Problem& problem;
  NormalForm form;
  CarAxis axis{};
  double tolerance;
  int size;                          // of r
  bool is_stiff;                     // Newton's iteration, with a linear solver
  bool is_bead_by_bead;              // y = (r_1, v_1, r_2, …), which makes Newton's matrix a band; else (r, v)
  std::vector<double> state, rates;  // (r, v), workspaces

  /// Returns (r, v) of y.
  double* read(const double* y) {
    for (int i = 0; i < 2 * size; ++i) state[static_cast<std::size_t>(i)] = y[place_of(i)];
    return state.data();
  }
  void write(const double* from, double* y) const {
    for (int i = 0; i < 2 * size; ++i) y[place_of(i)] = from[i];
  }

  void accelerations(double t, const double* r, const double* v, double* w) {
    if (problem.is_car_axis) return axis.accelerations(t, r, v, w);
    form.accelerations(r, v, w);
  }
  void project(double t, double* y, double share) {
    if (problem.is_car_axis) return axis.project(t, y, y + size, share);
    form.project(y, y + size, share);
  }
  void remove_normal_part(double t, const double* r, double* u) {
    if (problem.is_car_axis) return axis.remove_normal_part(t, r, u);
    form.remove_normal_part(u);
  }

  std::vector<double> start() const {
    if (problem.is_car_axis) return {CarAxis::start.begin(), CarAxis::start.end()};
    std::vector<double> result(problem.places);
    result.resize(static_cast<std::size_t>(2 * size));
    return result;
  }
  std::vector<double> places(const double* r) const {
    if (problem.is_car_axis) return {r[0], r[1], 0.0, r[2], r[3], 0.0};
    return {r, r + size};
  }

 private:
  int place_of(int i) const {
    if (!is_bead_by_bead) return i;
    const int of_r = i % size;
    return 6 * (of_r / 3) + of_r % 3 + (i < size ? 0 : 3);
  }
};

}  // namespace rivals
