#include <cmath>
#include <random>

#include "base/text.hpp"
#include "dynamics/forms.hpp"

/// \file Checks rank K + rank A = 3n: the coordinates reach every motion that the constraints allow.
namespace tanor::detail {

namespace {

/// The largest defect of (10) on a random force, and the point where it occurs.
struct Missing {
  double part = 0.0;
  std::size_t point = 0;
};

/// Measures the defect of (10), M A H^-1 A'u + K S^-1 K'M^-1 u = u, where both forms are linearized. Its projectors are
/// orthogonal in |M^-1/2 .|, so for u = M^1/2 z with random z the defect is the part of z that belongs to neither T nor
/// N.
Missing find_missing(Workspace& work, MultiplierForm& normal, TangentForm& tangent) {
  const Model& model = work.model();
  const std::size_t n = 3 * model.num_points(), moving = 3 * model.num_moving();
  std::vector<double> u(n, 0.0), M_inverse_u(n, 0.0), rest(n), rows(model.num_rows()), lambda(rows), dw(n);
  std::mt19937 generator(1);
  std::normal_distribution<double> z;
  Missing worst;
  for (std::size_t i = 0; i < moving; ++i) {
    u[i] = std::sqrt(model.mass[i / 3]) * z(generator);
    M_inverse_u[i] = model.inverse_mass[i / 3] * u[i];
  }
  tangent.dynamics().completed().find_reactions(u.data(), rest.data());  // u - M A H^-1 A'u
  work.constraints.apply_transposed(model.parallel, normal.linearization().blocks().data(), M_inverse_u.data(), nullptr,
                                    rows.data());
  normal.linearization().solve_refined(rows.data(), lambda.data(), dw.data());  // -M^-1 K S^-1 K'M^-1 u
  for (std::size_t i = 0; i < model.num_moving(); ++i) {
    const double root = std::sqrt(model.mass[i]);
    const double part = norm((1.0 / root) * load(rest.data(), i) + root * load(dw.data(), i));
    if (part > worst.part) worst = {part, i};
  }
  return worst;
}

}  // namespace

/// K'A = 0 has been checked, so (10) holds if and only if T and N fill the space. K may lose rank at the start alone,
/// as in a four-bar that lies flat. Then configurations nearby decide.
void Forms::check_completeness(double t, const double* r) {
  constexpr double rounding = 1e-6;  // a motion that is left out leaves about 1/sqrt(3n) of z at some point
  constexpr double aside = 1e-2;     // distance to those configurations, over the size of the scene
  if (work.constraints.tangents().num_sticking() > 0) return;  // S holds more than the constraints
  const auto find_at = [&](double distance, std::vector<double>* places) -> std::optional<Missing> {
    if (!tangent->stand_beside(t, distance, places->data()).ok()) return std::nullopt;
    if (!normal->linearise(t, places->data()).ok()) return std::nullopt;
    if (distance > 0.0) (void)normal->linearization().decide_rank_again(places->data(), RankScope::AllRows);
    return find_missing(work, *normal, *tangent);
  };
  std::vector<double> places(r, r + 3 * model.num_points());
  std::optional<Missing> missing = find_at(0.0, &places);
  if (missing && missing->part <= rounding) return;
  const std::size_t rank_of_K = normal->linearization().dependences().report().rank;
  missing = find_at(aside * model.scene_size, &places);
  if (normal->linearise(t, r).ok()) (void)normal->linearization().decide_rank_again(r, RankScope::AllRows);
  if (!missing || missing->part <= rounding) return;
  throw InputError("/coordinates", "the coordinates are narrower than the constraints, which let point " +
                                       text(model.numbering.user_point[missing->point]) +
                                       " move where no coordinate leads: rank K = " + text(rank_of_K) +
                                       " and rank A = " + text(tangent->size()) + " do not add up to 3n = " +
                                       text(3 * model.num_moving()) + "; both must describe the same motion");
}

}  // namespace tanor::detail
