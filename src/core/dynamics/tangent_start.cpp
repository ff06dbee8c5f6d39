#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"
#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "dynamics/tangent_form.hpp"

/// \file The consistent start of TangentForm.
namespace tanor::detail {

namespace {

constexpr double allowed = 1e-3;  // largest correction by `check`, over the scene's size and its velocity scale

constexpr double step_of_irregular = 0.7548776662;

/// Returns the point whose numbers in both arrays differ most.
std::size_t worst_point(const std::vector<double>& a, const std::vector<double>& b) {
  std::size_t worst = 0;
  double largest = -1.0;
  for (std::size_t i = 0; i < a.size() / 3; ++i) {
    const double distance = norm(load(a.data(), i) - load(b.data(), i));
    if (distance > largest) {
      largest = distance;
      worst = i;
    }
  }
  return worst;
}

/// Throws InputError naming the point whose given position or velocity is farthest from that of its coordinates.
void check_start(const Workspace& work, const StartReport& report, const std::vector<double>& r_given,
                 const std::vector<double>& v_given, const double* r, const double* v) {
  const Model& model = work.model();
  const auto refuse = [&](const char* what, const std::vector<double>& given, const double* found, double by,
                          Dimension dimension, const char* scale, double size) {
    const std::size_t point = worst_point(given, std::vector<double>(found, found + given.size()));
    throw InputError("/motion/start", std::string("the initial ") + what + " of point " +
                                          text(model.numbering.user_point[point]) +
                                          " is not one of its coordinates': the nearest lies " +
                                          with_unit(text(by), model.system.units.letters(dimension)) + " (the " +
                                          scale + " is " + text(size) +
                                          ") away; at most 0.001 of the scale is corrected (\"start\": \"project\" "
                                          "takes the nearest)");
  };
  if (!(report.position_correction <= allowed * model.scene_size)) {
    refuse("position", r_given, r, report.position_correction, Dimension::Length, "scene's size", model.scene_size);
  }
  if (!(report.velocity_correction <= allowed * work.velocity_scale)) {
    refuse("velocity", v_given, v, report.velocity_correction, Dimension::Velocity, "velocity scale",
           work.velocity_scale);
  }
}

/// Checks xi(r(q, t), t) = 0, K'v + xi_t = 0, K'psi + phi = 0 and K'A = 0 (3), if constraints are given as well.
void check_constraints(Workspace& work, const TangentLinearization& at) {
  const Model& model = work.model();
  if (model.num_rows() == 0) return;
  constexpr double rounding = 1e-9;
  std::vector<double> position(model.num_rows()), velocity(model.num_rows());
  work.constraints.measure(at.r().data(), at.v().data(), position.data(), velocity.data());
  const auto name_worst = [&](const std::vector<double>& values, Dimension dimension = Dimension::None) {
    const auto worst = std::max_element(values.begin(), values.end());
    return work.name_row(static_cast<std::size_t>(worst - values.begin())) + " by " +
           with_unit(text(*worst), model.system.units.letters(dimension));
  };
  const double far = std::max(1.0, model.largest_norm(at.r().data()) / model.smallest_length);
  if (!(*std::max_element(position.begin(), position.end()) <= rounding * far)) {
    throw InputError("/coordinates", "the places that the coordinates describe violate " + name_worst(position) +
                                         " of its length; both must describe the same motion");
  }
  if (!(*std::max_element(velocity.begin(), velocity.end()) <= rounding * far * work.velocity_scale)) {
    throw InputError("/coordinates", "the velocities that the coordinates describe violate " +
                                         name_worst(velocity, Dimension::Velocity) +
                                         "; both must describe the same motion");
  }
  // If K'psi + phi = 0 and K'A = 0, the motion stays on the constraints.
  std::vector<double> second(model.num_rows()), nothing(at.r().size(), 0.0);
  const auto evaluate_second = [&](const std::vector<double>& w) {
    return work.constraints.evaluate_right_side(model.parallel, at.r().data(), at.v().data(), w.data(), second.data(),
                                                nullptr);
  };
  const double acceleration_scale = evaluate_second(nothing) + model.largest_norm(at.psi().data()) +
                                    work.velocity_scale * work.velocity_scale / model.scene_size;
  if (!(evaluate_second(at.psi()) <= rounding * far * acceleration_scale)) {
    for (double& each : second) each = std::abs(each);
    throw InputError("/coordinates", "the accelerations that the coordinates describe violate " +
                                         name_worst(second, Dimension::Acceleration) +
                                         "; both must describe the same motion");
  }
  // K'A x must vanish for any x. Three choices find a wrong column of A with practical certainty.
  std::vector<double> blocks(3 * work.constraints.num_blocks()), rows(model.num_rows()),
      x(work.coordinates.num_coordinates()), points(at.r().size(), 0.0);
  work.constraints.evaluate_gradients(model.parallel, at.r().data(), blocks.data());
  for (int attempt = 0; attempt < 3; ++attempt) {
    for (std::size_t j = 0; j < x.size(); ++j)
      x[j] = irregular(j * static_cast<std::size_t>(attempt + 1), step_of_irregular);
    at.apply(x.data(), points.data());
    const double size_of_Ax = model.largest_norm(points.data());
    const double worst =
        work.constraints.apply_transposed(model.parallel, blocks.data(), points.data(), nullptr, rows.data());
    if (!(worst <= rounding * size_of_Ax)) {
      for (double& row : rows) row = std::abs(row);
      const auto row = std::max_element(rows.begin(), rows.end()) - rows.begin();
      std::size_t point = 0;
      double along = 0.0;  // the part of that gradient by one point
      for (const Incidence& i : model.incidences) {
        if (i.row != row) continue;
        const double part = std::abs(dot(load(blocks.data(), i.block), load(points.data(), i.point)));
        if (!(part > along)) continue;
        along = part;
        point = static_cast<std::size_t>(i.point);
      }
      throw InputError("/coordinates", "the coordinates move along the gradient of " + name_worst(rows) +
                                           ", at point " + text(model.numbering.user_point[point]) +
                                           ": they are wider than the constraints; both must describe the same motion");
    }
  }
}

}  // namespace

StartReport TangentForm::start(double t, double* r, double* v, StartMode mode) {
  const std::size_t n = 3 * model_.num_points();
  work_.set_time(t);
  work_.prescribe_all(t, r, v);  // given motions of supports do not count
  const std::vector<double> r_given(r, r + n);
  std::vector<double> v_given(v, v + n), q_dot(size());
  StartReport report;

  // The coordinates are those of the given positions, unless the user gave them.
  dynamics_.locate(r, &q_);
  work_.coordinates.write_start(q_.data(), rates_.data());
  if (report.outcome = linearization_.find_rates(t, v, q_.data(), q_dot.data()); !report.outcome.ok()) return report;
  // Given rates count in the same way, in place of the `velocities` of those points.
  work_.coordinates.write_start(q_.data(), q_dot.data());
  linearization_.evaluate(t, q_.data(), q_dot.data(), true);
  work_.coordinates.copy_where_given(linearization_.v().data(), v_given.data());

  std::copy(linearization_.r().begin(), linearization_.r().end(), r);
  std::copy(linearization_.v().begin(), linearization_.v().end(), v);
  work_.measure_velocity_scale(t, r, v);
  report.position_correction = model_.largest_move(r, r_given.data());
  report.velocity_correction = model_.largest_move(v, v_given.data());
  report.relative =
      std::max(report.position_correction / model_.scene_size, report.velocity_correction / work_.velocity_scale);
  if (mode == StartMode::Check) check_start(work_, report, r_given, v_given, r, v);
  check_constraints(work_, linearization_);
  return report;
}

Outcome TangentForm::stand_beside(double t, double distance, double* r) {
  std::vector<double> q = q_, at_rest(size(), 0.0);
  if (distance > 0.0) {
    std::vector<double> x(size()), Ax(linearization_.r().size(), 0.0);
    for (std::size_t j = 0; j < size(); ++j) x[j] = irregular(j, step_of_irregular);
    linearization_.apply(x.data(), Ax.data());
    const double unit = model_.largest_norm(Ax.data());
    for (std::size_t j = 0; j < size(); ++j) q[j] += distance / unit * x[j];
  }
  linearization_.evaluate(t, q.data(), at_rest.data(), true);
  std::copy(linearization_.r().begin(), linearization_.r().end(), r);
  return linearization_.factorize(t);
}

}  // namespace tanor::detail
