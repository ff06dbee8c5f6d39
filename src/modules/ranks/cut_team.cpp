#include "ranks/cut_team.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "base/numbers.hpp"
#include "base/text.hpp"
#include "dynamics/equations_of_motion.hpp"
#include "ranks/halo_pairs.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor::detail {

namespace {

void number(std::vector<Index>* points, const Numbering& numbering) {
  for (Index& point : *points) point = numbering.inner_point[static_cast<std::size_t>(point)];
}

std::vector<Part::Link> number_links(const Part& part, const Numbering& numbering) {
  std::vector<Part::Link> links = part.links;
  for (Part::Link& link : links)
    for (std::vector<Index>* const points : {&link.sent, &link.received}) number(points, numbering);
  return links;
}

}  // namespace

CutTeam::CutTeam(Workspace& work, const Part& part)
    : Team(part.ranks),
      part_(part),
      work_(work),
      model_(work.model()),
      guests_(part.guests),
      exchange_(*part.ranks, number_links(part, model_.numbering)) {
  number(&guests_, model_.numbering);
  list_elsewhere();
  measure_lengths();
  list_neighbourhoods();
  for (const Part::SharedRow& shared : part.shared_rows) work.rank -= shared.is_counted ? 0 : 1;
  for (const Part::SharedPairs& pairs : part.shared_pairs)
    work.forces.add_pairs_beyond(std::make_unique<HaloPairs>(model_, pairs, *part.ranks));
}

void CutTeam::fetch_guests(double* points) {
  exchange_.fetch([&](Index i) { return load(points, i); },
                  [&](Index i, const Vec3& vector) { store(points, i, vector); });
}

void CutTeam::add_to_guests(const double* x, double* y) const {
  for (const Index guest : guests_) add_to(y, guest, load(x, guest));
}

const double* CutTeam::without_guests(const double* points, std::vector<double>* copy) const {
  if (points != copy->data()) copy->assign(points, points + 3 * model_.num_points());
  for (const Index guest : guests_) store(copy->data(), guest, Vec3{});
  return copy->data();
}

// ---- energies that others count ----

void CutTeam::list_elsewhere() {
  const std::vector<const Part::SharedRow*> shared = find_shared_rows(model_, part_);
  for (std::size_t a = 0; a < shared.size(); ++a)
    if (shared[a] != nullptr && !shared[a]->is_counted) rows_elsewhere_.push_back(a);
  if (part_.energies_counted_elsewhere.empty()) return;
  System others = model_.system;
  others.forces.clear();
  std::size_t num_pairs = 0;  // entries of pair forces so far
  for (std::size_t f = 0; f < model_.system.forces.size(); ++f) {
    const Force& force = model_.system.forces[f];
    const auto* const pairs = std::get_if<PairForces>(&force);
    const std::size_t entry = pairs != nullptr ? num_pairs++ : 0;
    if (std::ranges::find(part_.energies_counted_elsewhere, f) == part_.energies_counted_elsewhere.end()) continue;
    if (pairs != nullptr)
      add_pairs_with_guests(entry, *pairs);
    else
      others.forces.push_back(force);
  }
  if (!others.forces.empty()) counted_elsewhere_ = std::make_unique<Forces>(others, model_.numbering);
}

void CutTeam::add_pairs_with_guests(std::size_t entry, const PairForces& pairs) {
  PairForces own = pairs;
  own.points.clear();
  const bool has_charges = pairs.charges.size() == pairs.points.size();
  if (has_charges) own.charges.clear();
  for (std::size_t k = 0; k < pairs.points.size(); ++k) {
    const Index inner = model_.numbering.inner_point[static_cast<std::size_t>(pairs.points[k])];
    if (static_cast<std::size_t>(inner) >= model_.num_moving()) continue;  // a guest
    own.points.push_back(pairs.points[k]);
    if (has_charges) own.charges.push_back(pairs.charges[k]);
  }
  pairs_with_guests_.push_back({entry, PairField(model_.system, own, model_.numbering)});
  work_.forces.leave_out_pairs_of_supports(entry);  // those of guests, which are their owners' business
}

/// Two ranks have each pair of a point and a guest, of whose energy each counts half.
double CutTeam::potential_elsewhere(double t, const double* r) {
  double result = counted_elsewhere_ ? counted_elsewhere_->potential(model_.parallel, t, r) : 0.0;
  for (auto& [entry, among_own] : pairs_with_guests_)
    result +=
        0.5 * (work_.forces.potential_of_pairs(model_.parallel, entry, r) - among_own.potential(model_.parallel, r));
  return result;
}

double CutTeam::rate_elsewhere(const Kinematics& at) {
  if (!counted_elsewhere_ || !counted_elsewhere_->has_work()) return 0.0;
  counted_elsewhere_->evaluate_powers(model_.parallel, at.t, at.x, at.v);
  return counted_elsewhere_->energies().explicit_rate(model_.parallel);
}

// ---- neighbourhoods ----

/// Gives shared neighbourhoods the length of all their points together.
void CutTeam::measure_lengths() {
  constexpr double far = -std::numeric_limits<double>::max();
  std::vector<double> ends(6 * part_.num_shared_neighbourhoods, far);  // largest r and largest -r
  const System& system = model_.system;
  const auto shared_of = [&](Index point) { return part_.shared_neighbourhood[static_cast<std::size_t>(point)]; };
  const auto include = [&](Index neighbourhood, std::size_t point) {
    double* const own = ends.data() + 6 * static_cast<std::size_t>(neighbourhood);
    for (std::size_t c = 0; c < 3; ++c) {
      own[c] = std::max(own[c], system.positions[3 * point + c]);
      own[3 + c] = std::max(own[3 + c], -system.positions[3 * point + c]);
    }
  };
  for (std::size_t i = 0; i < system.num_points(); ++i)
    if (shared_of(static_cast<Index>(i)) >= 0) include(shared_of(static_cast<Index>(i)), i);
  // Supports belong to no neighbourhood, but hold those that do.
  for_each_member(system, [&](std::span<const Index> points, int) {
    const auto shared = std::ranges::max(points, {}, shared_of);
    for (const Index point : points)
      if (shared_of(shared) >= 0) include(shared_of(shared), static_cast<std::size_t>(point));
  });
  part_.ranks->find_largest(ends);
  Neighbourhoods all = find_neighbourhoods(system, work_.time());
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    const Index own = shared_of(static_cast<Index>(i));
    if (own < 0 || all.of_point[i] < 0) continue;
    const double* const box = ends.data() + 6 * static_cast<std::size_t>(own);
    all.length[static_cast<std::size_t>(all.of_point[i])] =
        norm(Vec3{box[0] + box[3], box[1] + box[4], box[2] + box[5]});
  }
  work_.scales = Scales(all, model_.numbering, model_.incidences, model_.scene_size);
  work_.scales.stand_beside_others();
}

void CutTeam::list_neighbourhoods() {
  std::map<std::size_t, std::size_t> shared;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const Index of_all = part_.shared_neighbourhood[static_cast<std::size_t>(model_.numbering.user_point[i])];
    if (of_all >= 0) shared[work_.scales.of_point(i)] = static_cast<std::size_t>(of_all);
  }
  for (const auto& [here, of_all] : shared) neighbourhoods_.push_back({here, of_all});
}

void CutTeam::find_largest(std::span<double> of_neighbourhoods) {
  std::vector<double> largest(part_.num_shared_neighbourhoods, std::numeric_limits<double>::lowest());
  for (const auto& [here, of_all] : neighbourhoods_)
    largest[of_all] = std::max(largest[of_all], of_neighbourhoods[here]);
  part_.ranks->find_largest(largest);
  for (const auto& [here, of_all] : neighbourhoods_) of_neighbourhoods[here] = largest[of_all];
}

// ---- S and the rank of K ----

std::unique_ptr<RankRevealingFactor> CutTeam::make_factor(Workspace& work, const SolverOptions& options,
                                                          const std::vector<double>& blocks, Contacts*) {
  auto factor = std::make_unique<CutFactor>(work, part_, options, blocks);
  rank_ = &factor->dependences();
  return factor;
}

/// Refuses systems with prestress. Dependent rows may hold what K alone lets move, such as the inner points of a
/// straight row of rods between two supports. Some velocity that K allows then asks for accelerations that no
/// multipliers give.
Outcome CutTeam::check_start(EquationsOfMotion& form, const Kinematics& at) {
  if (!rank_->is_found()) return {};
  std::vector<double> u(at.v, at.v + form.size()), w(form.size());
  for (std::size_t k = 0; k < 3 * model_.num_moving(); ++k) u[k] += work_.velocity_scale * irregular(k);
  fetch_guests(u.data());
  if (ProjectionReport report = form.project_velocities(at.t, at.x, u.data()); !report.outcome.ok())
    return report.outcome;
  Request request;
  request.gradients = Gradients::Keep;
  Outcome outcome = form.accelerations({at.t, at.x, u.data()}, request, AccelerationOutput(w.data()));
  if (outcome.status != Status::Contradictory) return outcome;
  return {Status::Singular, rank_->explain("depends on") + " at t = " + text(at.t) +
                                ", and prestress holds what they let move; take one rank"};
}

}  // namespace tanor::detail
