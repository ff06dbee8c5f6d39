#include "ranks/cut_team.hpp"

#include "base/numbers.hpp"
#include "base/text.hpp"
#include "dynamics/equations_of_motion.hpp"
#include "ranks/halo_pairs.hpp"

namespace tanor::detail {

namespace {

void number(std::vector<Index>* points, const Numbering& numbering) {
  for (Index& point : *points) point = numbering.inner_point[static_cast<std::size_t>(point)];
}

std::vector<PointExchange::Link> number_links(const Part& part, const Numbering& numbering) {
  std::vector<PointExchange::Link> links;
  for (const Part::Link& given : part.links) {
    PointExchange::Link& link = links.emplace_back(PointExchange::Link{given.rank, given.sent, given.received});
    number(&link.sent, numbering);
    number(&link.received, numbering);
  }
  return links;
}

}  // namespace

CutTeam::CutTeam(Workspace& work, const Part& part)
    : Team(part.ranks),
      part_(part),
      work_(work),
      guests_(part.guests),
      exchange_(*part.ranks, number_links(part, work.model().numbering)),
      energies_(work, part),
      neighbourhoods_(work, part) {
  number(&guests_, work.model().numbering);
  for (const Part::SharedRow& shared : part.shared_rows) work.rank -= shared.is_counted ? 0 : 1;
  for (const Part::SharedPairs& pairs : part.shared_pairs)
    work.forces.add_pairs_beyond(std::make_unique<HaloPairs>(work.model(), pairs, *part.ranks));
}

void CutTeam::fetch_guests(double* points) {
  exchange_.fetch([&](Index i) { return load(points, i); },
                  [&](Index i, const Vec3& vector) { store(points, i, vector); });
}

void CutTeam::add_to_guests(const double* x, double* y) const {
  for (const Index guest : guests_) add_to(y, guest, load(x, guest));
}

const double* CutTeam::without_guests(const double* points, std::vector<double>* copy) const {
  if (points != copy->data()) copy->assign(points, points + 3 * work_.model().num_points());
  for (const Index guest : guests_) store(copy->data(), guest, Vec3{});
  return copy->data();
}

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
  for (std::size_t k = 0; k < 3 * work_.model().num_moving(); ++k) u[k] += work_.velocity_scale * irregular(k);
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
