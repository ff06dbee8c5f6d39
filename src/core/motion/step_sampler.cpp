#include "motion/step_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "base/gauss_rule.hpp"
#include "base/instruction_sets.hpp"

namespace tanor::detail {

namespace {

/// The numbers [begin, end) of a step, which a SIMD loop examines.
struct Numbers {
  std::size_t begin, end;
  double h, moves_nothing;
};
double measure_bend(const Numbers& of, const double* x0, const double* v0, const double* a0, const double* x1,
                    const double* v1, const double* a1) {
  return dispatch([=, &of] {
    constexpr double tiny = 1e-300;
    const double h = of.h, by_v = h / 32.0, by_a = h * h / 64.0, moves_nothing = of.moves_nothing;
    double most = 0.0;
#pragma omp simd reduction(max : most)
    for (std::size_t i = of.begin; i < of.end; ++i) {
      const double missed = std::abs(by_v * (v0[i] - v1[i]) + by_a * (a0[i] + a1[i]));
      const double chord = std::abs(x1[i] - x0[i]), fast = std::abs(v0[i]), faster = std::abs(v1[i]);
      const double by_speed = h * (fast > faster ? fast : faster), move = (chord > by_speed ? chord : by_speed) + tiny;
      const double part = missed / move, bend = missed > moves_nothing ? part : 0.0;
      most = bend > most ? bend : most;
    }
    return most;
  });
}

/// Returns the forces to look for; null for fixed steps if no force acts briefly.
UnseenForces* list_unseen_forces(Mechanics& mechanics, bool adapts) {
  UnseenForces* const all = mechanics.unseen_forces();
  return all != nullptr && (adapts || mechanics.any(all->act_briefly())) ? all : nullptr;
}

}  // namespace

StepSampler::StepSampler(const IntegrationOptions& options, Mechanics& mechanics, const Scheme& scheme)
    : mechanics_(mechanics),
      forces_(list_unseen_forces(mechanics, scheme.is_adaptive())),
      may_jump_(forces_ != nullptr && scheme.ends_at_jumps() && mechanics.any(forces_->may_jump())) {
  // Fixed steps have no tolerance. An unseen change of velocity by one percent is worth a warning.
  constexpr double worth_a_warning = 1e-2;
  const bool adapts = scheme.is_adaptive();
  ends_at_jumps = scheme.ends_at_jumps();
  follows_tolerance = adapts;
  atol = adapts ? options.atol : 0.0;
  rtol = adapts ? options.rtol : worth_a_warning;
}

/// Computes the weights with which the scheme integrates a function of time alone. No scheme has more looks than its
/// order, so that they are the weights of the interpolating polynomial, w_i = integral of l_i(s) ds.
void StepSampler::weigh_looks() {
  if (std::equal(looks.begin(), looks.end(), looks_.begin(), looks_.end())) return;
  looks_.assign(looks.begin(), looks.end());
  weights_.assign(looks.size(), 0.0);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    for (const auto& [s, weight] : gauss_rule) {
      double value = weight;
      for (std::size_t j = 0; j < looks.size(); ++j)
        if (j != i) value *= (s - looks[j]) / (looks[i] - looks[j]);
      weights_[i] += value;
    }
  }
  weights = weights_;
}

/// Returns by how much the cubic misses the quintic in the middle of the step, relative to what each number moves:
///
///   h (v0 - v1)/32 + h^2 (a0 + a1)/64
double StepSampler::measure_bend() const {
  if (!follows_tolerance || !scheme_->knows_acceleration()) return 0.0;  // one cubic is enough for a warning
  const double least = own_atol_r.empty() ? 0.0 : *std::min_element(own_atol_r.begin(), own_atol_r.end());
  const double moves_nothing = 1e-3 * (atol > 0.0 ? atol : least);
  return mechanics_.parallel().max_over_ranges(from_->x.size(), [&](std::size_t begin, std::size_t end) {
    return detail::measure_bend({begin, end, h, moves_nothing}, from_->x.data(), from_->v.data(), from_->a.data(),
                                to_->x.data(), to_->v.data(), to_->a.data());
  });
}

/// Sets the mechanics' variables by interpolation of the scheme, and the points, at knots between two fractions of the
/// step.
void StepSampler::set_knots(double begin, double end, std::size_t pieces, Knots* room, PointPath* path) {
  const std::size_t n = 3 * forces_->num_points();
  for (auto* arrays : {&room->positions, &room->velocities, &room->variables, &room->rates})
    if (arrays->size() < pieces + 1) arrays->resize(pieces + 1);
  for (auto* pointers : {&path->positions, &path->velocities, &path->variables, &path->rates})
    pointers->resize(pieces + 1);
  DenseOutput inside(*scheme_, *from_, *to_, by_ends_ || !scheme_->interpolates_at_once());
  for (std::size_t k = 0; k <= pieces; ++k) {
    const double s = k == pieces ? end : begin + (end - begin) * static_cast<double>(k) / static_cast<double>(pieces);
    const State* const state = s == 0.0 ? from_ : s == 1.0 ? to_ : nullptr;
    room->positions[k].resize(n);
    room->velocities[k].resize(n);
    double time = t + s * h;
    if (state != nullptr) {
      time = state->t;
      path->variables[k] = state->x.data();
      path->rates[k] = state->v.data();
    } else {
      std::vector<double>&x = room->variables[k], &v = room->rates[k];
      x.resize(from_->x.size());
      v.resize(from_->x.size());
      (void)inside.evaluate(mechanics_.parallel(), s, x.data(), v.data());  // cannot fail, as nothing is prepared
      mechanics_.prescribe(time, x.data(), v.data());
      path->variables[k] = x.data();
      path->rates[k] = v.data();
    }
    const Kinematics points = forces_->find_points({time, path->variables[k], path->rates[k]},
                                                   room->positions[k].data(), room->velocities[k].data());
    path->positions[k] = points.x;
    path->velocities[k] = points.v;
  }
}

const PointPath* StepSampler::magnify(double begin, double end) {
  constexpr std::size_t pieces = 4;
  part_.t = t + begin * h;
  part_.h = (end - begin) * h;
  set_knots(begin, end, pieces, &knots_of_part_, &part_);
  return &part_;
}

/// Takes enough cubics to meet the error, which falls with the fourth power of their length.
void StepSampler::refine(double error) {
  constexpr double most_pieces = 64.0;
  const double wanted = std::clamp(std::ceil(std::pow(bend_ / error, 0.25)), 1.0, most_pieces);
  if (const auto pieces = static_cast<std::size_t>(wanted); positions.empty() || pieces > num_pieces())
    set_knots(0.0, 1.0, pieces, &knots_, this);
}

///   x + h v + h^2/2 a,   v + h a
void StepSampler::look_along_parabola(Scheme& scheme, const State& from, double time) {
  jump = {};
  if (!may_jump_ || !scheme.knows_acceleration()) return;
  const double step = time - from.t;
  ahead_.t = time;
  ahead_.x.resize(from.x.size());
  ahead_.v.resize(from.x.size());
  ahead_.a = from.a;
  for (std::size_t i = 0; i < from.x.size(); ++i) {
    ahead_.x[i] = from.x[i] + step * (from.v[i] + 0.5 * step * from.a[i]);
    ahead_.v[i] = from.v[i] + step * from.a[i];
  }
  mechanics_.prescribe(time, ahead_.x.data(), ahead_.v.data());
  (void)look(scheme, from, ahead_, true);
}

double StepSampler::look(Scheme& scheme, const State& from, const State& to, bool by_ends) {
  jump = {};
  passed = nullptr;
  if (forces_ == nullptr) return 1.0;
  constexpr double error = 1e-2;  // forces that need a better path call `refine`
  scheme_ = &scheme;
  from_ = &from;
  to_ = &to;
  by_ends_ = by_ends;
  t = from.t;
  h = to.t - from.t;
  if (!(h > 0.0)) return 1.0;
  looks = scheme.looks();
  weigh_looks();
  order = scheme.order();
  const PointTolerances own = mechanics_.point_tolerances();
  if (follows_tolerance) {
    own_atol_r = own.positions;
    own_atol_v = own.velocities;
  }
  accelerations = own.accelerations;
  bend_ = measure_bend();
  positions.clear();
  refine(error);
  const double part = forces_->find_unseen(this);
  jump.before = mechanics_.smallest(jump.before);
  jump.after = mechanics_.smallest(jump.after);
  return mechanics_.smallest(part);
}

}  // namespace tanor::detail
