#include "contact/cone_problem.hpp"

#include <algorithm>
#include <cmath>

#include "contact/cone.hpp"

namespace tanor::detail {

Vec3 ConeProblem::velocity(std::size_t contact, const double* r) const {
  Vec3 u = load(q.data(), contact);
  for (std::size_t k = start[contact]; k < start[contact + 1]; ++k) u = u + blocks[k] * load(r, columns[k]);
  return u;
}

void ConeProblem::find_velocities(const double* r, double* u) const {
  for (std::size_t c = 0; c < num_contacts(); ++c) store(u, c, velocity(c, r));
}

const Block3& ConeProblem::own_block(std::size_t contact) const {
  const auto first = columns.begin() + static_cast<std::ptrdiff_t>(start[contact]),
             end = columns.begin() + static_cast<std::ptrdiff_t>(start[contact + 1]);
  return blocks[static_cast<std::size_t>(std::lower_bound(first, end, static_cast<int>(contact)) - columns.begin())];
}

double ConeProblem::scale() const {
  double trace = 0.0;
  for (std::size_t c = 0; c < num_contacts(); ++c) {
    const Block3& own = own_block(c);
    trace += own(0, 0) + own(1, 1) + own(2, 2);
  }
  return num_contacts() > 0 ? trace / (3.0 * static_cast<double>(num_contacts())) : 1.0;
}

double error_of_contacts(const ConeProblem& problem, std::span<const double> r) {
  const double a = problem.scale();
  double error = 0.0, size = 0.0;
  for (std::size_t c = 0; c < problem.num_contacts(); ++c) {
    const double mu = problem.friction[c];
    const Vec3 own = load(r.data(), c), u = with_dilatancy(problem.velocity(c, r.data()), mu);
    error += squared(own - project_onto_cone(own - (1.0 / a) * u, mu));
    size += squared(load(problem.q.data(), c));
  }
  return size > 0.0 ? a * std::sqrt(error / size) : 0.0;
}

}  // namespace tanor::detail
