#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "certificate/certificate.hpp"
#include "certificate/verifier.hpp"
#include "system/chosen_members.hpp"

/// \file Certificates of systems with one-sided constraints: an answer is that of the system without the open ones,
/// whose gaps are not negative, and the others do not pull.
namespace tanor::detail {

namespace {

/// Moves arrays [3n] from one inner order to another.
std::vector<double> reorder(const Numbering& from, const Numbering& to, const std::vector<double>& points) {
  std::vector<double> user(points.size()), result(points.size());
  from.scatter_points(points, user);
  to.gather_points(user, result);
  return result;
}

/// Lets the contacts of the closed part stick where those of the answer do, with the same friction `own` [row].
void copy_modes(const Forms& forms, const Answer& answer, Forms* closed, std::vector<double>* own) {
  const auto key = [](const Forms& of, const Tangents::Place& place) {
    return std::pair{place.friction, of.model.numbering.user_point[static_cast<std::size_t>(place.point)]};
  };
  const Tangents& from = forms.work.constraints.tangents();
  Tangents& to = closed->work.constraints.tangents();
  std::map<std::pair<Index, Index>, std::size_t> number;  // law and user's point, which has one guide of the law
  for (std::size_t c = 0; c < to.size(); ++c) number[key(*closed, to[c])] = c;
  for (std::size_t c = 0; c < from.size(); ++c) {
    if (!from.sticks(c)) continue;
    const std::size_t other = number.at(key(forms, from[c]));
    to.set_stick(other, true);
    for (int k = 0; k < from[c].num_tangents(); ++k)
      (*own)[static_cast<std::size_t>(to[other].first_row + k)] =
          answer.lambda[static_cast<std::size_t>(from[c].first_row + k)];
  }
}

/// Verifies 0 <= g _|_ p >= 0: gaps of open rows over their length, and forces of closed ones over the largest of them.
CertificateCheck verify_sides(const Forms& forms, const Answer& answer) {
  const Model& model = forms.model;
  const Numbering& numbering = model.numbering;
  const auto d = numbering.num_user_rows;
  std::vector<double> r(answer.r.size()), nothing(answer.r.size(), 0.0), xi(d), rate(d), second(d);
  numbering.scatter_points(answer.r, r);
  Definitions(model.system, forms.start_time()).taylor(model.parallel, answer.t, r, nothing, nothing, xi, rate, second);
  double largest = 0.0, worst = 0.0;
  for (const double lambda : answer.lambda) largest = std::max(largest, std::abs(lambda));
  std::size_t where = 0;
  for (const OneSidedRow& each : numbering.one_sided) {
    const auto row = static_cast<std::size_t>(each.row), user = static_cast<std::size_t>(numbering.user_row[row]);
    const double length = forms.work.scales.length(forms.work.scales.of_row(row));
    const double gap = each.sign * xi[user] / length, force = each.sign * answer.lambda[row];
    const bool is_open = forms.work.constraints.open.have(row);
    const double error = std::max(is_open ? -gap : std::abs(gap), largest > 0.0 ? -force / largest : 0.0);
    if (error <= worst) continue;
    worst = error;
    where = user;
  }
  return {"s xi >= 0, s lambda >= 0, xi lambda = 0", worst, 1e-9, worst > 0.0 ? equation_name(model.system, where) : "",
          "sides of constraints"};
}

}  // namespace

Certificate certify_one_sided(Forms& forms, const Answer& answer, SecondFactorization by) {
  const Numbering& numbering = forms.model.numbering;
  std::vector<bool> is_open(numbering.num_user_rows, false);
  std::vector<double> lambda(numbering.num_user_rows), kept;
  numbering.scatter_rows(answer.lambda, lambda);
  for (const OneSidedRow& each : numbering.one_sided) {
    const auto row = static_cast<std::size_t>(each.row);
    is_open[static_cast<std::size_t>(numbering.user_row[row])] = forms.work.constraints.open.have(row);
  }
  Forms closed(without_open_rows(forms.model.system, is_open), {}, forms.start_time());
  const Numbering& other = closed.model.numbering;
  const auto move = [&](const std::vector<double>& points) { return reorder(numbering, other, points); };
  const std::vector<double> r = move(answer.r), v = move(answer.v), w = move(answer.w), eta = move(answer.eta),
                            tau = move(answer.tau);
  for (std::size_t a = 0; a < lambda.size(); ++a)
    if (!is_open[a]) kept.push_back(lambda[a]);
  std::vector<double> own(other.num_rows(), 0.0);
  for (std::size_t a = 0; a < own.size(); ++a)
    if (!other.is_contact_row(a)) own[a] = kept[static_cast<std::size_t>(other.user_row[a])];
  copy_modes(forms, answer, &closed, &own);

  closed.work.set_time(answer.t);
  std::vector<double> rest = r, motion = v;
  closed.work.prescribe_all(answer.t, rest.data(), motion.data());
  closed.work.measure_velocity_scale(answer.t, r.data(), v.data());
  if (Outcome outcome = closed.normal->linearise(answer.t, r.data()); !outcome.ok())
    return make_failed_certificate(outcome);
  Certificate certificate = Verifier(closed, {answer.t, r, v, w, eta, own, tau, answer.friction}, by).verify();
  certificate.checks.push_back(verify_sides(forms, answer));
  return certificate;
}

}  // namespace tanor::detail
