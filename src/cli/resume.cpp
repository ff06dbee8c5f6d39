#include "cli/resume.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

namespace tanor::cli {

namespace {

Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double norm(const Vector3& a) {
  return std::sqrt(dot(a, a));
}

/// The numbers that "initial" stands for: the value of each constraint and spring at the scene's own positions, which
/// a simulation that starts at a checkpoint could not know any more.
class InitialValues {
 public:
  explicit InitialValues(const System& system) : positions_(system.positions) {}

  void operator()(Rods& rods) const {
    fill(&rods.length, rods.pairs.size(), [&](std::size_t k) {
      const Vector3 offset = rods.offsets.empty() ? Vector3{} : rods.offsets[k];
      return norm(at(rods.pairs[k][0]) - at(rods.pairs[k][1]) - offset);
    });
  }
  void operator()(Planes& planes) const {
    const Vector3 normal = value(planes.normal);
    fill(&planes.offset, planes.points.size(), [&](std::size_t k) { return dot(normal, at(planes.points[k])); });
  }
  void operator()(Spheres& spheres) const {
    const Vector3 center = value(spheres.center);
    fill(&spheres.radius, spheres.points.size(), [&](std::size_t k) { return norm(at(spheres.points[k]) - center); });
  }
  void operator()(Lines&) const {}
  void operator()(Circles& circles) const {
    const Vector3 center = value(circles.center), normal = value(circles.normal);
    fill(&circles.radius, circles.points.size(), [&](std::size_t k) {
      const Vector3 a = at(circles.points[k]) - center;
      const double height = dot(a, normal) / norm(normal);
      return std::sqrt(dot(a, a) - height * height);
    });
  }
  void operator()(Angles& angles) const {
    fill(&angles.cosine, angles.triples.size(), [&](std::size_t k) {
      const auto [i, j, l] = angles.triples[k];
      const Vector3 a = at(i) - at(j), b = at(l) - at(j);
      return dot(a, b) / (norm(a) * norm(b));
    });
  }
  void operator()(Pulleys& pulleys) const {
    fill(&pulleys.length, pulleys.pairs.size(), [&](std::size_t k) {
      const auto [i, j] = pulleys.pairs[k];
      return norm(at(i) - pulleys.a) + pulleys.ratio * norm(at(j) - pulleys.b);
    });
  }
  void operator()(Linears& linears) const {
    fill(&linears.value, linears.tuples.size(), [&](std::size_t k) {
      double sum = 0.0;
      for (std::size_t p = 0; p < linears.coefficients.size(); ++p) {
        sum += dot(linears.coefficients[p], at(linears.tuples[k][p]));
      }
      return sum;
    });
  }
  void operator()(Springs& springs) const {
    fill(&springs.rest_length, springs.pairs.size(),
         [&](std::size_t k) { return norm(at(springs.pairs[k][1]) - at(springs.pairs[k][0])); });
  }
  template <class Force>
  void operator()(Force&) const {}

 private:
  Vector3 at(Index point) const {
    const double* r = &positions_[3 * static_cast<std::size_t>(point)];
    return {r[0], r[1], r[2]};
  }
  static Vector3 value(const VectorFunction& function) {
    const auto jets = function(0.0);
    return {jets[0].value(), jets[1].value(), jets[2].value()};
  }
  template <class Value>
  static void fill(Parameter* parameter, std::size_t count, const Value& value) {
    if (!parameter->is_initial()) return;
    for (std::size_t k = 0; k < count; ++k) parameter->constants.push_back(value(k));
  }

  std::vector<double> positions_;
};

/// The scene's system with its moving points where the checkpoint has them. Supports keep their initial positions, to
/// which their displacement is added.
System move_to(System system, const report::Checkpoint& checkpoint) {
  const InitialValues fill(system);
  for (Constraint& constraint : system.constraints) std::visit(fill, constraint);
  for (Force& force : system.forces) std::visit(fill, force);

  std::vector<bool> is_support(system.num_points(), false);
  for (const Support& support : system.supports) {
    for (const Index point : support.points) is_support[point] = true;
  }
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    if (!is_support[i]) std::copy_n(&checkpoint.positions[3 * i], 3, &system.positions[3 * i]);
  }
  system.velocities = checkpoint.velocities;
  return system;
}

double larger(double a, double b) {
  return (b > a || std::isnan(b)) ? b : a;
}

}  // namespace

Simulation make_simulation(System system, MotionOptions motion, const SolverOptions& solver,
                           const std::optional<report::Checkpoint>& checkpoint) {
  if (!checkpoint) return Simulation(std::move(system), motion, solver);
  motion.start = StartMode::Check;
  return Simulation(move_to(std::move(system), *checkpoint), motion, solver, checkpoint->report.time);
}

MotionReport add_reports(const std::optional<report::Checkpoint>& before, const MotionReport& since) {
  if (!before) return since;
  const MotionReport& first = before->report;
  MotionReport sum = since;
  sum.steps += first.steps;
  sum.rejected += first.rejected;
  sum.start = first.start;
  sum.position_violation = larger(first.position_violation, since.position_violation);
  sum.velocity_violation = larger(first.velocity_violation, since.velocity_violation);
  sum.acceleration_violation = larger(first.acceleration_violation, since.acceleration_violation);
  sum.reciprocal_condition = std::min(first.reciprocal_condition, since.reciprocal_condition);
  sum.energy.start = first.energy.start;
  sum.energy.work_of_supports += first.energy.work_of_supports;
  sum.energy.work_of_forces += first.energy.work_of_forces;
  sum.energy.scale = std::max(first.energy.scale, since.energy.scale);
  sum.counters.evaluations += first.counters.evaluations;
  sum.counters.factorizations += first.counters.factorizations;
  sum.counters.solves += first.counters.solves;
  sum.times.evaluate += first.times.evaluate;
  sum.times.assemble += first.times.assemble;
  sum.times.factor += first.times.factor;
  sum.times.solve += first.times.solve;
  return sum;
}

}  // namespace tanor::cli
