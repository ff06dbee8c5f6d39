#include "motion/rattle.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"
#include "base/parallel.hpp"
#include "base/point_source.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

namespace {

constexpr std::array<double, Rattle::tile + 3> at_rest{};

/// The accelerations without the constraints: those of each number, or the same for all points that move.
struct FreeAccelerations {
  const double* each;     // null if moving points have the same
  const double* uniform;  // [tile + 3], x y z x y z …
  std::size_t num_moving;

  /// Calls visit(begin, end, a) for pieces [begin, end) of these numbers; their accelerations begin at a.
  template <class Visit>
  void for_pieces(std::size_t first, std::size_t last, const Visit& visit) const {
    if (each != nullptr) return visit(first, last, each + first);
    const auto visit_tiles = [&](std::size_t begin, std::size_t end, const double* a) {
      for (std::size_t i = begin; i < end; i += Rattle::tile) visit(i, std::min(i + Rattle::tile, end), a + begin % 3);
    };
    const std::size_t end_moving = std::clamp(3 * num_moving, first, last);
    visit_tiles(first, end_moving, uniform);
    visit_tiles(end_moving, last, at_rest.data());
  }
};

/// Computes v1/2 = v + h/2 a and x1 = x + h v1/2 of the moving points that are asked for.
class FreeMove final : public PointSource {
 public:
  FreeMove(const State& from, double h, const FreeAccelerations& a, std::size_t num_moving, double* middle, double* x1)
      : from_(from), h_(h), a_(a), num_moving_(num_moving), middle_(middle), x1_(x1) {}

  void bring(std::size_t first, std::size_t count) const override {
    move(3 * std::min(first, num_moving_), 3 * std::min(first + count, num_moving_));
  }
  /// Does the same for supports, before what is prescribed at them is written.
  void move_supports() const { move(3 * num_moving_, from_.x.size()); }

 private:
  void move(std::size_t first, std::size_t last) const {
    a_.for_pieces(first, last, [this](std::size_t begin, std::size_t end, const double* a) {
      const double *const x = from_.x.data() + begin, *const v = from_.v.data() + begin;
      double* __restrict middle = middle_ + begin;
      double* __restrict x1 = x1_ + begin;
      const double h = h_, half = 0.5 * h;
      for (std::size_t i = 0; i < end - begin; ++i) {
        middle[i] = v[i] + half * a[i];
        x1[i] = x[i] + h * middle[i];
      }
    });
  }

  const State& from_;
  double h_;
  const FreeAccelerations& a_;
  std::size_t num_moving_;
  double *middle_, *x1_;
};

/// Computes v1 = v1/2 + h/2 a; `middle` and `v1` may be one array.
void kick(const Parallel& parallel, double h, const FreeAccelerations& a, const std::vector<double>& middle,
          std::vector<double>* v1) {
  const double half = 0.5 * h;
  parallel.for_ranges(middle.size(), [&](std::size_t first, std::size_t last) {
    a.for_pieces(first, last, [&](std::size_t begin, std::size_t end, const double* own) {
      for (std::size_t i = begin; i < end; ++i) (*v1)[i] = middle[i] + half * own[i - begin];
    });
  });
}

StepProjector& projector_of(Mechanics& mechanics) {
  ensure(mechanics.step_projector() != nullptr, "rattle steps in normal form");
  return *mechanics.step_projector();
}

}  // namespace

Rattle::Rattle(Mechanics& mechanics, int passes)
    : mechanics_(mechanics),
      projector_(projector_of(mechanics)),
      passes_(passes),
      has_work_(mechanics.has_work()),
      knows_acceleration_(has_work_ || mechanics.events() != nullptr),
      depends_on_velocity_(mechanics.any(projector_.depends_on_velocity())),
      is_constant_(mechanics.all(projector_.is_constant())),
      free_(mechanics.size()),
      middle_(depends_on_velocity_ ? mechanics.size() : 0) {
  const Vec3* const uniform = projector_.uniform_acceleration();
  if (mechanics.all(uniform != nullptr)) {
    is_uniform_ = true;
    for (std::size_t k = 0; k < uniform_.size() / 3; ++k) store(uniform_.data(), k, *uniform);
    // A motion that is saved here may go on where the accelerations are read from the array.
    for (std::size_t i = 0; i < projector_.num_moving(); ++i) store(free_.data(), i, *uniform);
  }
}

/// Writes M^-1 f into `free_`, unless all points have the same, or it is constant and stands there already.
Outcome Rattle::find_free(const Kinematics& at, const Request& request) {
  if (is_uniform_ || (has_constant_ && is_constant_)) return {};
  Outcome outcome =
      mechanics_.together([&] { return projector_.free_accelerations(at, request, free_.data(), &largest_free_); });
  has_constant_ = outcome.ok() && is_constant_;
  return outcome;
}

StepResult Rattle::step(const State& from, double h, State* to) {
  const Parallel& parallel = mechanics_.parallel();
  const double t = to->t;
  const auto fail = [](Outcome outcome) { return StepResult{.outcome = std::move(outcome)}; };
  StepResult result;

  // M^-1 f at the beginning, which is known from the last step if forces do not depend on v. Fixed steps have no
  // tolerance that would ask for exact accelerations.
  const Request request = IntegrationOptions().request(Gradients::Keep);
  if (!knows_free_ || free_time_ != from.t || depends_on_velocity_) {
    if (Outcome found = find_free(from.at(), request); !found.ok()) return fail(std::move(found));
  }
  knows_free_ = false;

  // v1/2 = v + h/2 M^-1 f and r1 = r0 + h v1/2, then both along M^-1 K(r0) until xi(r1, t1) = 0
  std::vector<double>& middle = depends_on_velocity_ ? middle_ : to->v;
  const std::size_t num_moving = projector_.num_moving();
  const FreeAccelerations free{is_uniform_ ? nullptr : free_.data(), uniform_.data(), num_moving};
  const FreeMove move(from, h, free, num_moving, middle.data(), to->x.data());
  move.move_supports();
  to->work = from.work;
  mechanics_.prescribe(t, to->x.data(), to->v.data());
  ProjectionReport positions =
      mechanics_.project_together([&] { return projector_.project_step(t, h, move, to->x.data(), middle.data()); });
  if (!positions.outcome.ok()) return fail(std::move(positions.outcome));
  result.position_violation = positions.violation;
  if (Outcome found = mechanics_.linearise(t, to->x.data()); !found.ok()) return fail(std::move(found));

  // v1 = v1/2 + h/2 M^-1 f1, projected onto K(r1)'v1 + xi_t = 0; repeated with the better v1 if f1 depends on v1
  const std::vector<double>* guess = &middle;
  for (int pass = 0; pass < (depends_on_velocity_ ? passes_ : 1); ++pass) {
    if (Outcome found = find_free({t, to->x.data(), guess->data()}, request); !found.ok())
      return fail(std::move(found));
    kick(parallel, h, free, middle, &to->v);
    mechanics_.prescribe(t, to->x.data(), to->v.data());
    ProjectionReport velocities = mechanics_.project_together(
        [&] { return projector_.project_step_velocities(t, h, to->x.data(), to->v.data()); });
    if (!velocities.outcome.ok()) return fail(std::move(velocities.outcome));
    result.velocity_violation = velocities.violation;
    guess = &to->v;
  }
  knows_free_ = true;
  free_time_ = t;

  if (knows_acceleration_) {
    if (Outcome found = mechanics_.accelerations(to->at(), request, to->output()); !found.ok())
      return fail(std::move(found));
  }
  if (has_work_) {
    // The trapezoidal rule has the scheme's order.
    to->work.add(0.5 * h, from.power);
    to->work.add(0.5 * h, to->power);
  }
  return result;
}

}  // namespace tanor::detail
