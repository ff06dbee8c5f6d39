/// \file How the parts of a host are made, and what goes over from old parts.

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "host/host_parts.hpp"

namespace tanor {

namespace {

template <class Value>
void unite(const std::vector<Value>& from, std::vector<Value>* to) {
  for (const Value& value : from) {
    if (std::ranges::find(*to, value) == to->end()) to->push_back(value);
  }
}

void add_up(const Counters& more, Counters* sum) {
  sum->evaluations += more.evaluations;
  sum->factorizations += more.factorizations;
  sum->solves += more.solves;
  sum->iterations += more.iterations;
  sum->rank_decisions += more.rank_decisions;
}

/// What StepProjection remembers: the multipliers of the last step [d] and of the one before, and their h.
std::vector<double> read_steps(ConstrainedHost* host) {
  std::vector<double> numbers;
  Memory memory(&numbers);
  host->form.steps().exchange_memory(memory);
  return numbers;
}

/// Groups of a part are called "\x1f3": the host's group 3.
constexpr char mark = '\x1f';

}  // namespace

/// Where the host's points were when the last call began.
void HostParts::read_positions(Part* part) {
  ConstrainedHost* const host = part->host.get();
  if (host == nullptr || !std::exchange(host->was_called, false)) return;
  const std::vector<double>& from = host->images ? host->place.host : host->place.r;
  for (std::size_t i = 0; i < part->places.size(); ++i) {
    const auto inner = static_cast<std::size_t>(host->model.numbering.inner_point[i]);
    std::copy_n(&from[3 * inner], 3, &points_.positions[3 * static_cast<std::size_t>(part->places[i])]);
  }
  if (host->images) points_.cell = host->place.cell;
}

void HostParts::read_guesses(Part* part) {
  if (part->host != nullptr) add_up(part->host->work.counters, &left_counters_);
  if (part->host == nullptr || part->members.empty()) return;
  const std::vector<double> steps = read_steps(part->host.get());
  const Numbering& numbering = part->host->model.numbering;
  const std::size_t num_rows = numbering.num_rows();
  last_h_ = steps[2 * num_rows];
  before_h_ = steps[2 * num_rows + 1];
  for (std::size_t m = 0; m < part->members.size(); ++m) {
    const ConstraintId id = part->members[m];
    for (std::size_t k = 0; k < inventory_.num_rows(id); ++k) {
      const std::size_t row = static_cast<std::size_t>(numbering.member_row[m]) + k;
      part->guesses.push_back({id, k, steps[row], steps[num_rows + row], part->host->place.was_checked});
    }
  }
}

System HostParts::make_system(Part* part) {
  part->places = part->moving;
  for (const ConstraintId id : part->members) {
    for (const Index point : inventory_.points(id)) {
      if (points_.is_support(point)) part->places.push_back(point);
    }
  }
  std::ranges::sort(part->places);
  part->places.erase(std::unique(part->places.begin(), part->places.end()), part->places.end());
  System system;
  Support supports{"supports", {}, {}};
  for (const Index point : part->places) {
    const auto number = static_cast<std::size_t>(point);
    const auto own = static_cast<Index>(system.masses.size());
    local_[number] = own;
    const bool is_support = points_.is_support(point);
    if (is_support) supports.points.push_back(own);
    system.masses.push_back(is_support ? 1.0 : points_.mass[number]);
    const auto position = points_.positions.begin() + static_cast<std::ptrdiff_t>(3 * number);
    system.positions.insert(system.positions.end(), position, position + 3);
  }
  if (!supports.points.empty()) system.supports.push_back(std::move(supports));
  system.constraints =
      inventory_.take(part->members, [&](Index point) { return local_[static_cast<std::size_t>(point)]; });
  std::size_t first = 0;
  for (Constraint& constraint : system.constraints) {
    const std::string name = mark + std::to_string(inventory_.group_number(part->members[first]));
    std::visit([&](auto& group) { group.name = name; }, constraint);
    first += shape_of(constraint).members;
  }
  return system;
}

void HostParts::build(Part* part) {
  try {
    part->host = make_host(part);
  } catch (const InputError& wrong) {
    throw InputError(wrong.where(), with_names(*part, wrong.what()));
  }
  part->has_rows = false;
  go_on(part);
  set_host_points(*part);
}

std::unique_ptr<ConstrainedHost> HostParts::make_host(Part* part) {
  System system = make_system(part);
  SolverOptions options = options_;
  std::int64_t weight = 0;
  for (const Island& island : part->islands) weight += island.weight;
  if (weight < least_for_threads) options.threads = 1;
  std::unique_ptr<PeriodicImages> images;
  if (cell_) {
    images = std::make_unique<PeriodicImages>(system, Periodicity{points_.cell, inventory_.take_images(part->members)});
    images->prepare(&system);
    images->set_cell(*cell_);
    images->set_offsets(&system);
  }
  auto host = std::make_unique<ConstrainedHost>(std::move(system), options);
  if (images) {
    images->use(host->model.numbering);
    host->set_images(std::move(images));
  }
  return host;
}

/// The guesses of old parts become those of their constraints in a new one. Only what is new is checked again.
void HostParts::go_on(Part* part) const {
  std::vector<Guess> guesses = std::exchange(part->guesses, {});
  if (guesses.empty()) return;
  const auto name = [](const Guess& guess) { return std::pair(guess.id, guess.row); };
  std::ranges::sort(guesses, {}, name);
  std::vector<double> steps = read_steps(part->host.get());
  const Numbering& numbering = part->host->model.numbering;
  const std::size_t num_rows = numbering.num_rows();
  steps[2 * num_rows] = last_h_;
  steps[2 * num_rows + 1] = before_h_;
  std::size_t num_checked = 0;
  for (std::size_t m = 0; m < part->members.size(); ++m) {
    const ConstraintId id = part->members[m];
    auto guess = std::ranges::lower_bound(guesses, std::pair(id, std::size_t{0}), {}, name);
    for (; guess != guesses.end() && guess->id == id; ++guess) {
      const std::size_t row = static_cast<std::size_t>(numbering.member_row[m]) + guess->row;
      steps[row] = guess->last;
      steps[num_rows + row] = guess->before;
      num_checked += guess->was_checked ? 1 : 0;
    }
  }
  part->host->place.was_checked = num_checked == num_rows;
  Memory memory{std::span<const double>(steps)};
  part->host->form.steps().exchange_memory(memory);
}

/// "\x1f3[5]" becomes the name of the fifth member of the host's group 3 in this part.
std::string HostParts::with_names(const Part& part, const std::string& text) const {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find(mark, at);
    result += text.substr(at, begin - at);
    if (begin == std::string::npos) break;
    const std::size_t open = text.find('[', begin), close = text.find(']', begin);
    at = text.find_first_not_of("0123456789", begin + 1);
    const auto group = std::stoul(text.substr(begin + 1));
    const auto is_there = [&](ConstraintId id) { return inventory_.group_number(id) == group; };
    const auto first = std::ranges::find_if(part.members, is_there);
    if (open != at || first == part.members.end()) {
      result += inventory_.group_name(group);
      continue;
    }
    result += inventory_.member_name(*(first + static_cast<std::ptrdiff_t>(std::stoul(text.substr(open + 1)))));
    at = close + 1;
  }
  return result;
}

/// Rows only come at the end, or move forward together with all that follow.
void HostParts::number_rows(Part* part) const {
  if (part->members.empty()) return;
  const std::size_t first = inventory_.first_row(part->members.front());
  const std::size_t last = inventory_.first_row(part->members.back());
  const std::size_t first_move = std::exchange(part->first_row, first) - first;
  const std::size_t last_move = std::exchange(part->last_row, last) - last;
  std::vector<Index>& rows = part->host->host_row;
  if (std::exchange(part->has_rows, true) && first_move == last_move) {
    if (last_move == 0) return;
    for (Index& row : rows) row -= static_cast<Index>(last_move);
    return;
  }
  const Numbering& numbering = part->host->model.numbering;
  std::vector<Index> of_user;
  for (const ConstraintId id : part->members) {
    for (std::size_t k = 0; k < inventory_.num_rows(id); ++k)
      of_user.push_back(static_cast<Index>(inventory_.first_row(id) + k));
  }
  for (std::size_t a = 0; a < rows.size(); ++a) rows[a] = of_user[static_cast<std::size_t>(numbering.user_row[a])];
}

void HostParts::set_host_points(const Part& part) const {
  std::vector<Index> host_points;
  for (const Index point : part.places) host_points.push_back(points_.host_point[static_cast<std::size_t>(point)]);
  part.host->transfer.set_points(host_points);
}

void HostParts::summarise() {
  large_.clear();
  small_.clear();
  reports_.resize(parts_.size());
  PlanSummary sum;
  sum.points = num_points();
  sum.supports = supports_.size();
  sum.equations = inventory_.num_rows();
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const ConstrainedHost& host = *parts_[k]->host;
    (host.options.threads == 1 ? small_ : large_).push_back(k);
    const PlanSummary& own = host.forms.plan;
    if (k == 0) {
      sum.linear_solvers.clear();
      sum.linear_solver_reason = own.linear_solver_reason;
    }
    sum.islands += own.islands;
    sum.parts += own.parts;
    sum.pattern_nonzeros += own.pattern_nonzeros;
    sum.factor_nonzeros += own.factor_nonzeros;
    sum.factor_flops += own.factor_flops;
    sum.normal_flops += own.normal_flops;
    unite(own.linear_solvers, &sum.linear_solvers);
    unite(own.orderings, &sum.orderings);
    unite(own.factorizations, &sum.factorizations);
    unite(own.left_out, &sum.left_out);
    const Numbering& numbering = host.model.numbering;
    for (std::size_t a = numbering.first_idle_row(); a < numbering.num_rows(); ++a)
      sum.idle_equations.push_back(static_cast<std::size_t>(host.host_row[a]));
  }
  summary_ = std::move(sum);
}

Counters HostParts::counters() const {
  Counters sum = left_counters_;
  for (const auto& part : parts_) {
    if (part->host != nullptr) add_up(part->host->work.counters, &sum);
  }
  return sum;
}

bool HostParts::closes_ways() const {
  return std::ranges::any_of(parts_,
                             [](const auto& part) { return part->host->images && part->host->images->close_ways(); });
}

RankReport HostParts::find_rank(const ConstPointArray& positions, double time) {
  RankReport sum;
  sum.multipliers_unique.resize(inventory_.num_rows(), true);
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& part : parts_) {
    const RankReport own = part->host->find_rank(positions, time);
    const std::vector<Index>& user_row = part->host->model.numbering.user_row;
    std::vector<std::size_t> host_row(user_row.size());
    for (std::size_t a = 0; a < user_row.size(); ++a)
      host_row[static_cast<std::size_t>(user_row[a])] = static_cast<std::size_t>(part->host->host_row[a]);
    sum.rank += own.rank;
    sum.degrees_of_freedom += own.degrees_of_freedom;
    for (const RowDependence& dependence : own.dependences) {
      RowDependence& added = sum.dependences.emplace_back(dependence);
      added.row = host_row[added.row];
      for (RowDependence::Term& term : added.terms) term.row = host_row[term.row];
      added.what = with_names(*part, added.what);
    }
    for (std::size_t row = 0; row < host_row.size(); ++row)
      sum.multipliers_unique[host_row[row]] = own.multipliers_unique[row];
    for (const Index point : own.prestress_rigid_points) {
      const auto place = static_cast<std::size_t>(part->places[static_cast<std::size_t>(point)]);
      sum.prestress_rigid_points.push_back(points_.host_point[place]);
    }
    if (own.smallest_singular_value > 0.0) smallest = std::min(smallest, own.smallest_singular_value);
  }
  if (smallest < std::numeric_limits<double>::infinity()) sum.smallest_singular_value = smallest;
  return sum;
}

}  // namespace tanor
