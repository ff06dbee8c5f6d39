#include "host/host_parts.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <utility>

#include "base/checksum.hpp"
#include "base/memory.hpp"
#include "dynamics/self_stress.hpp"

namespace tanor::detail {

namespace {

/// Points and rows from which threads of its own pay for a part.
constexpr std::int64_t least_for_threads = 16384;

template <class Value>
void unite(const std::vector<Value>& from, std::vector<Value>* to) {
  for (const Value& value : from) {
    if (std::ranges::find(*to, value) == to->end()) to->push_back(value);
  }
}

}  // namespace

HostParts::HostParts(HostPoints points, std::optional<PeriodicCell> cell, const SolverOptions& options)
    : points_(std::move(points)),
      cell_(cell),
      options_(options),
      parallel_(options.threads),
      supports_(points_.list_supports()) {
  if (cell_) points_.cell = *cell_;
}

// ---- edits ----

ConstraintId HostParts::add(Constraint group, std::vector<std::array<int, 3>> images) {
  ++num_edits_;
  has_changed_ = true;
  if (!images.empty() && !inventory_.has_images()) partition_.touch_all();  // all others have images too, from now on
  return inventory_.add(std::move(group), std::move(images));
}

void HostParts::remove(std::span<const ConstraintId> ids) {
  ++num_edits_;
  for (const ConstraintId id : ids) partition_.touch_constraint(id);
  inventory_.remove(ids);
  has_changed_ = true;
}

void HostParts::set_length(ConstraintId id, double length, double rate) {
  const bool is_read = inventory_.set_length(id, length, rate);
  if (!is_read) {
    partition_.touch_constraint(id);
    has_changed_ = true;
    return;
  }
  HostPart* const part = partition_.part_of(id);
  if (part == nullptr || part->host == nullptr) return;  // the next plan reads it
  part->host->work.constraints.set_time(part->host->work.time());
  part->host->place.stands = false;
}

void HostParts::set_mass(Index point, double mass) {
  if (std::exchange(points_.mass[static_cast<std::size_t>(point)], mass) == mass || points_.is_support(point)) return;
  partition_.touch_point(point);
  has_changed_ = true;
}

void HostParts::renumber(std::vector<Index> of_host, std::span<const double> masses) {
  ++num_edits_;
  points_.keep(of_host);
  partition_.drop_left_points();
  for (std::size_t i = 0; i < of_host.size(); ++i) {
    if (of_host[i] >= 0) set_mass(of_host[i], masses[i]);
  }
  partition_.add_points(points_.admit(std::move(of_host), masses));
  supports_ = points_.list_supports();
  for (const auto& part : parts()) {
    if (part->host != nullptr) part->number_points(points_);
  }
  has_changed_ = true;
}

void HostParts::set_positions(const ConstPointArray& at) {
  read_positions();  // later calls then read no positions from parts
  copy_points(at, points_.of_host, points_.positions.data());
  if (cell_) points_.cell = *cell_;
}

void HostParts::read_positions() {
  for (const auto& part : parts()) history_.read_positions(part.get());
}

void HostParts::set_cell(const PeriodicCell& cell) {
  (void)plan();
  const auto set = [&](const PeriodicCell& now) {
    for (const auto& part : parts()) part->host->place.images->set_cell(now);
  };
  const PeriodicCell old = *cell_;
  set(cell);
  for (const auto& part : parts()) {
    try {
      part->host->check_cell();
    } catch (const InputError& wrong) {
      set(old);
      throw InputError(wrong.where(), with_names(*part, wrong.what()));
    }
  }
  cell_ = cell;
}

/// Cuts the islands into parts, or puts them all into one. All is planned anew.
void HostParts::cut(bool is_cut) {
  if (is_cut == partition_.is_cut()) return;
  partition_.cut(is_cut);
  has_changed_ = true;
}

void HostParts::expect_edits() {
  cut(true);
}

// ---- plans ----

std::size_t HostParts::plan() {
  if (partition_.has_edits()) expect_edits();
  return plan_changes();
}

std::size_t HostParts::plan_changes() {
  if (!has_changed_) return 0;
  partition_.divide_changes(&history_);
  std::size_t result = 0;
  for (const auto& part : parts()) {
    if (part->host != nullptr) continue;
    try {
      part->host = make_host(part.get());
    } catch (const InputError& wrong) {
      throw InputError(wrong.where(), with_names(*part, wrong.what()));
    }
    part->number_points(points_);
    history_.hand_over(part.get());
    result += part->islands.size();
  }
  for (const auto& part : parts()) part->number_rows(inventory_);
  summarise();
  has_changed_ = false;
  return result;
}

std::unique_ptr<ConstrainedHost> HostParts::make_host(HostPart* part) {
  System system = make_system_of(part);
  SolverOptions options = options_;
  std::int64_t weight = 0;
  for (const HostIsland& island : part->islands) weight += island.weight;
  if (weight < least_for_threads) options.threads = 1;
  part->has_own_threads = options.threads != 1;
  std::unique_ptr<PeriodicImages> images;
  if (cell_) {
    images = std::make_unique<PeriodicImages>(system, Periodicity{points_.cell, inventory_.take_images(part->members)});
    images->set_positions(&system);
    images->set_cell(*cell_);
    images->set_offsets(&system);
  }
  auto host = std::make_unique<ConstrainedHost>(std::move(system), options);
  if (images) {
    images->use(host->model.system, host->model.numbering);
    host->set_images(std::move(images));
  }
  return host;
}

System HostParts::make_system_of(HostPart* part) {
  part->places = part->moving;
  for (const ConstraintId id : part->members) {
    for (const Index point : inventory_.points(id)) {
      if (points_.is_support(point)) part->places.push_back(point);
    }
  }
  std::ranges::sort(part->places);
  part->places.erase(std::unique(part->places.begin(), part->places.end()), part->places.end());
  local_.resize(points_.size(), -1);
  for (std::size_t k = 0; k < part->places.size(); ++k)
    local_[static_cast<std::size_t>(part->places[k])] = static_cast<Index>(k);
  System system = points_.make_system(part->places);
  system.constraints =
      inventory_.take(part->members, [&](Index point) { return local_[static_cast<std::size_t>(point)]; });
  std::size_t first = 0;
  for (Constraint& constraint : system.constraints) {
    const std::string name = Inventory::part_name(inventory_.group_number(part->members[first]));
    std::visit([&](auto& group) { group.name = name; }, constraint);
    first += shape_of(constraint).members;
  }
  return system;
}

// ---- memory ----

/// Returns the header of saved bytes, with a fingerprint of the masses and of the constraints by the host's numbers.
SavedHeader HostParts::header() const {
  Checksum sum;
  const auto add = [&]<class Number>(Number number) { sum.add(std::span<const Number>(&number, 1)); };
  for (const Index point : points_.of_host) add(points_.mass[static_cast<std::size_t>(point)]);
  for (ConstraintId id = 0; id < inventory_.next_id(); ++id) {
    if (!inventory_.has(id)) continue;
    add(inventory_.kind(id));
    for (const Index point : inventory_.points(id)) add(points_.host_point[static_cast<std::size_t>(point)]);
  }
  return {.magic = {'t', 'a', 'n', 'o', 'r', ' ', 'c', 'o'}, .version = 2, .fingerprint = sum.value()};
}

std::vector<std::byte> HostParts::save() {
  std::vector<double> numbers;
  Memory memory(&numbers);
  exchange_memory(memory);
  std::vector<std::uint64_t> words;
  for (const std::uint64_t word : std::bit_cast<std::array<std::uint64_t, 3>>(header())) words.push_back(word);
  for (const double number : numbers) words.push_back(std::bit_cast<std::uint64_t>(number));
  words.push_back(checksum_of(std::as_bytes(std::span(words))));
  const auto bytes = std::as_bytes(std::span(words));
  return {bytes.begin(), bytes.end()};
}

void HostParts::restore(std::span<const std::byte> bytes) {
  constexpr SavedBy by{"/state", "a Constrainer", "other points or constraints"};
  const std::span<const std::byte> body = check_frame(bytes, header(), by);
  std::vector<double> numbers(body.size() / sizeof(double));
  if (!numbers.empty()) std::memcpy(numbers.data(), body.data(), numbers.size() * sizeof(double));
  Memory memory{std::span<const double>(numbers)};
  exchange_memory(memory);
  memory.finish();
}

/// Writes what parts remember, and the numbers of points, to `memory`, or reads it from there.
void HostParts::exchange_memory(Memory& memory) {
  (void)plan();
  std::vector<Index> of_host = points_.of_host;
  std::size_t size = points_.size();
  memory.exchange(size, of_host);
  if (memory.reads() && (of_host != points_.of_host || size != points_.size())) rename_points(of_host, size);
  bool is_cut = partition_.is_cut();
  memory.exchange(is_cut);
  cut(is_cut);
  (void)plan_changes();
  for (const auto& part : parts()) {
    part->host->form.exchange_memory(memory);
    part->host->place.stands = false;  // so that the next call factorizes, in the saved handle and in the restored one
  }
}

/// Gives other numbers to the points. All is planned anew.
void HostParts::rename_points(const std::vector<Index>& of_host, std::size_t size) {
  read_positions();
  HostPoints points = points_.renamed(of_host, size);
  inventory_.rename_points([&](Index point) {
    return of_host[static_cast<std::size_t>(points_.host_point[static_cast<std::size_t>(point)])];
  });
  points_ = std::move(points);
  supports_ = points_.list_supports();
  partition_.restart();
  has_changed_ = true;
  (void)plan();
}

// ---- sums over the parts ----

void HostParts::summarise() {
  large_.clear();
  small_.clear();
  reports_.resize(parts().size());
  PlanSummary sum;
  sum.points = num_points();
  sum.supports = supports_.size();
  sum.equations = inventory_.num_rows();
  for (std::size_t k = 0; k < parts().size(); ++k) {
    const ConstrainedHost& host = *parts()[k]->host;
    (parts()[k]->has_own_threads ? large_ : small_).push_back(k);
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
  Counters sum = history_.counters();
  for (const auto& part : parts()) {
    if (part->host != nullptr) add_up(part->host->work.counters, &sum);
  }
  return sum;
}

RankReport HostParts::find_rank(const ConstPointArray& positions, double time) {
  RankReport sum;
  sum.multipliers_unique.resize(inventory_.num_rows(), true);
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& part : parts()) {
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

std::vector<double> HostParts::find_self_stress() {
  std::vector<double> result;
  for (const auto& part : parts()) {
    ConstrainedHost& host = *part->host;
    if (!host.linearization.dependences().is_found()) continue;
    (void)host.linearization.decide_rank_again(host.place.r.data());
    const std::vector<double> own = detail::find_self_stress(host.linearization.dependences(), host.model.numbering);
    if (!own.empty()) result.resize(inventory_.num_rows());
    for (std::size_t a = 0; a < own.size(); ++a) result[static_cast<std::size_t>(host.host_row[a])] = own[a];
  }
  return result;
}

}  // namespace tanor::detail
