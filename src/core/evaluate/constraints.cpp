#include "evaluate/constraints.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor::detail {

namespace {

/// A member of a constraint group on its way into a family.
struct Member {
  Index row;    // first inner row
  Index group;  // in System::constraints
  Index index;  // in its group
};

/// Reads the number of each member, which is its parameter or is measured at the initial positions. Members of a group
/// share a slot if the group gives one function (or number) for all.
class ParameterReader {
 public:
  explicit ParameterReader(ScalarTable* table) : table_(table) {}

  template <class Initial>
  void append(const Parameter& parameter, Member member, const Initial& initial) {
    const auto add = [&] { return table_->add(number_of(parameter, static_cast<std::size_t>(member.index), initial)); };
    if (parameter.functions.size() != 1 && parameter.constants.size() != 1) return table_->append_member(add());
    const auto [entry, is_new] = slot_of_group_.try_emplace(member.group, 0);
    if (is_new) entry->second = add();
    table_->append_member(entry->second);
  }

 private:
  ScalarTable* table_;
  std::map<Index, std::size_t> slot_of_group_;
};

/// Gives each group a slot for its geometry in a kernel's tables when the group is met first.
class GeometryReader {
 public:
  template <class Add>
  Index slot(Index group, const Add& add) {
    const auto [entry, is_new] = slots_.try_emplace(group, static_cast<Index>(slots_.size()));
    if (is_new) add();
    return entry->second;
  }

 private:
  std::map<Index, Index> slots_;
};

/// Returns the index of a group's type in the variant.
template <class Group, std::size_t... Kinds>
constexpr std::size_t kind_index(std::index_sequence<Kinds...>) {
  return ((std::is_same_v<Group, std::variant_alternative_t<Kinds, Constraint>> ? Kinds : 0) + ...);
}
template <class Group>
constexpr std::size_t kind_of = kind_index<Group>(std::make_index_sequence<std::variant_size_v<Constraint>>{});

/// Fills the families of a Constraints, kind by kind.
struct Builder {
  const System& system;
  const Numbering& numbering;
  double t;
  double size;                                       // m, size of the scene
  std::optional<Neighbourhoods> neighbourhoods;      // made when first needed: rods have lengths of their own
  std::vector<std::vector<Member>> members_of_kind;  // [index in the variant], by increasing row

  Builder(const System& s, const Numbering& n, double start)
      : system(s), numbering(n), t(start), size(scene_size(s)), members_of_kind(std::variant_size_v<Constraint>) {
    std::vector<Member> member_of_row(numbering.num_rows(), {-1, -1, -1});  // [first row]
    std::vector<std::size_t> counts(members_of_kind.size());
    const Index first_outside = find_first_outside(system);
    std::size_t counter = 0;
    for (std::size_t g = 0; g < system.constraints.size(); ++g) {
      const auto add = [&](const auto& group) {
        for (std::size_t k = 0; k < num_members(group); ++k) {
          const Index row = numbering.member_row[counter++];
          if (member_points(group, k)[0] >= first_outside) continue;
          member_of_row[row] = {row, static_cast<Index>(g), static_cast<Index>(k)};
          ++counts[system.constraints[g].index()];
        }
      };
      std::visit(add, system.constraints[g]);
    }
    for (std::size_t kind = 0; kind < counts.size(); ++kind) members_of_kind[kind].reserve(counts[kind]);
    for (const Member& member : member_of_row) {
      if (member.row >= 0) members_of_kind[system.constraints[member.group].index()].push_back(member);
    }
  }

  /// Returns the length of the neighbourhood of the first moving point, or that of the scene if no point moves.
  double length_around(std::span<const Index> points) {
    if (!neighbourhoods) neighbourhoods = find_neighbourhoods(system, t);
    for (const Index point : points) {
      const Index own = neighbourhoods->of_point[static_cast<std::size_t>(point)];
      if (own >= 0) return neighbourhoods->length[static_cast<std::size_t>(own)];
    }
    return size;
  }
  template <std::size_t N>
  std::array<Index, N> inner(std::span<const Index> user) const {
    std::array<Index, N> result;
    for (std::size_t p = 0; p < N; ++p) result[p] = numbering.inner_point[user[p]];
    return result;
  }

  /// Calls visit(group, member) for all members of one kind.
  template <class Group, class Visit>
  void for_each(const Visit& visit) const {
    for (const Member& member : members_of_kind[kind_of<Group>])
      visit(std::get<Group>(system.constraints[member.group]), member);
  }

  /// Returns the number that an "initial" parameter takes from the start.
  template <class Kernel, class Group>
  double initial_number(const Group& group, Index k) const {
    const std::span<const Index> points = member_points(group, static_cast<std::size_t>(k));
    if constexpr (requires { Kernel::measure(group, t, Vec3{}); }) {
      return Kernel::measure(group, t, load(system.positions.data(), points[0]));
    } else {
      const PlacesIn at{system.positions.data()};
      const typename KindOf<Group>::template Definition<double> now(group, ClockOf<double>{t});
      return now.measure(MemberPlaces{points, at}, static_cast<std::size_t>(k));
    }
  }

  /// Appends the member's number to the kernel if the kind has one.
  template <class Kernel, class Group>
  void append_number(const Group& group, const Member& member, Kernel* kernel, ParameterReader* numbers) const {
    if constexpr (requires { KindOf<Group>::parameter; }) {
      const Parameter& given = group.*KindOf<Group>::parameter;
      const auto initial = [&] { return initial_number<Kernel>(group, member.index); };
      if constexpr (requires { kernel->own_constants(); }) {
        const auto k = static_cast<std::size_t>(member.index);
        kernel->own_constants().push_back(number_of(given, k, initial)(t).value());
      } else {
        numbers->append(given, member, initial);
      }
    }
  }

  template <class Kernel>
  static ScalarTable* own_table(Kernel* kernel) {
    if constexpr (requires { kernel->own(); }) return &kernel->own();
    return nullptr;
  }

  template <class Kernel>
  void fill(Family<Kernel>* family) {
    using Group = typename Kernel::Group;
    auto& kernel = family->kernel;
    GeometryReader geometry;
    ParameterReader numbers(own_table(&kernel));
    const auto takes = [](const Group& group) {
      if constexpr (requires { Kernel::takes(group); }) return Kernel::takes(group);
      return true;
    };
    std::size_t count = 0;
    for_each<Group>([&](const Group& group, const Member&) { count += takes(group) ? 1 : 0; });
    family->rows.reserve(count);
    kernel.points.reserve(count);
    for_each<Group>([&](const Group& group, const Member& member) {
      if (!takes(group)) return;
      const std::span<const Index> points = member_points(group, static_cast<std::size_t>(member.index));
      family->rows.push_back(member.row);
      kernel.points.push_back(inner<Kernel::num_points>(points));
      if constexpr (requires { kernel.size; }) kernel.size.push_back(length_around(points));
      if constexpr (requires { kernel.geometry; })
        kernel.geometry.push_back(geometry.slot(member.group, [&] { kernel.add(group); }));
      if constexpr (requires { kernel.member; }) kernel.member.push_back(member.index);
      if constexpr (requires { kernel.add_member(group, member.index); }) kernel.add_member(group, member.index);
      append_number(group, member, &kernel, &numbers);
    });
  }

  void fill(TupleFamily<LinearKernel>* family) { fill_tuples(family, &family->kernel.value); }
  void fill(TupleFamily<RopeKernel>* family) { fill_tuples(family, &family->kernel.length); }
  template <class Kernel>
  void fill_tuples(TupleFamily<Kernel>* family, ScalarTable* table) {
    using Group = typename Kernel::Group;
    ParameterReader numbers(table);
    for_each<Group>([&](const Group& group, const Member& member) {
      append_tuple(group, member, family);
      family->kernel.add_member(group);
      append_number(group, member, &family->kernel, &numbers);
    });
  }

  /// Sorts the members by groups, each of which calls its kernel for many of them at once.
  void fill(TupleFamily<UserKernels>* family) {
    std::ranges::stable_sort(members_of_kind[kind_of<UserConstraints>], {}, &Member::group);
    auto& groups = family->kernel.groups;
    Index before = -1;
    for_each<UserConstraints>([&](const UserConstraints& constraints, const Member& member) {
      if (member.group != before) groups.push_back({constraints.kernel, family->size(), family->size()});
      before = member.group;
      append_tuple(constraints, member, family);
      ++groups.back().last;
    });
  }

  template <class Group, class Family>
  void append_tuple(const Group& group, const Member& member, Family* family) {
    const std::span<const Index> points = member_points(group, static_cast<std::size_t>(member.index));
    std::vector<Index> own;
    for (const Index point : points) own.push_back(numbering.inner_point[point]);
    family->kernel.append_tuple(own, length_around(points));
    family->rows.push_back(member.row);
  }
};

}  // namespace

Constraints::Constraints(const System& system, const Numbering& numbering, double t)
    : num_points_(numbering.num_points()), num_rows_(numbering.num_rows()) {
  Builder builder(system, numbering, t);
  std::apply([&](auto&... family) { (builder.fill(&family), ...); }, families_);
  for_each_family([&](auto& family) {
    family.first_block = static_cast<Index>(num_blocks_);
    num_blocks_ += family.num_blocks();
  });
  open.others_ = everything_ = select(std::vector<char>(num_rows_, 1));
  if (!numbering.one_sided.empty()) {
    open.candidates_ = list_incidences();
    std::erase_if(open.candidates_,
                  [&](const Incidence& i) { return numbering.may_open[static_cast<std::size_t>(i.row)] == 0; });
  }
  if (!system.friction.empty()) {
    tangents_ = Tangents(system, numbering, list_incidences(), static_cast<Index>(num_blocks_));
    num_blocks_ += tangents_.num_blocks();
  }
  set_time(t);
}

bool Constraints::depends_on_time() const {
  bool result = false;
  for_each_family([&](const auto& family) { result = result || family.kernel.depends_on_time(); });
  return result;
}

void Constraints::turn_frames(const double* blocks, double* others) const {
  const Family<LineKernel>& lines = family<LineKernel>();
  if (lines.kernel.gradients_are_constant()) return;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::size_t first = static_cast<std::size_t>(lines.first_block) + 2 * k;
    const Vec3 e1 = load(blocks, first), e2 = load(blocks, first + 1);
    const Vec3 o1 = load(others, first), o2 = load(others, first + 1);
    // The angle beta maximizes e1.(c o1 + s o2) + e2.(c o2 - s o1), with c = cos beta and s = sin beta.
    const double c = dot(e1, o1) + dot(e2, o2), s = dot(e1, o2) - dot(e2, o1), length = std::hypot(c, s);
    if (!(length > 0.0)) continue;
    store(others, first, (c / length) * o1 + (s / length) * o2);
    store(others, first + 1, (c / length) * o2 - (s / length) * o1);
  }
}

bool Constraints::gradients_are_constant() const {
  // Contacts may change between stick and slip, and one-sided rows open.
  return tangents_.num_blocks() == 0 && open.candidates_.empty() && gradients_are_constant(everything_);
}

void Constraints::OpenRows::set(const Constraints& constraints, std::span<const char> is_open) {
  if (std::ranges::equal(is_open, is_open_)) return;
  is_open_.assign(is_open.begin(), is_open.end());
  rows_.clear();
  blocks_.clear();
  std::vector<char> takes_part(is_open.size());
  for (std::size_t a = 0; a < is_open.size(); ++a) {
    takes_part[a] = is_open[a] == 0;
    if (is_open[a] != 0) rows_.push_back(static_cast<Index>(a));
  }
  for (const Incidence& incidence : candidates_)
    if (is_open[static_cast<std::size_t>(incidence.row)] != 0) blocks_.push_back(incidence.block);
  others_ = constraints.select(takes_part);
  ++num_changes_;
}

namespace {

/// True if |gradient| of a kernel's rows never changes.
template <class Kernel>
constexpr bool has_constant_norms = Kernel::unit_gradient || requires(const Kernel kernel) {
  kernel.squared_norm(0, 0);
};
}  // namespace

bool Constraints::gradient_norms_are_constant() const {
  bool result = open.candidates_.empty();
  for_each_family(
      [&](const auto& family) { result = result && has_constant_norms<std::remove_cvref_t<decltype(family.kernel)>>; });
  return result;
}

std::vector<double> Constraints::squared_gradient_norms() const {
  if (!gradient_norms_are_constant()) return {};
  std::vector<double> result(num_blocks_, 1.0);
  for_each_family([&](const auto& family) {
    using Kernel = std::remove_cvref_t<decltype(family.kernel)>;
    if constexpr (!Kernel::unit_gradient && has_constant_norms<Kernel>) {
      auto block = static_cast<std::size_t>(family.first_block);
      for (std::size_t k = 0; k < family.size(); ++k) {
        for (std::size_t p = 0; p < family.num_blocks_of(k); ++p) result[block++] = family.kernel.squared_norm(k, p);
      }
    }
  });
  return result;
}

void Constraints::set_time(double t) {
  for_each_family([&](auto& family) { family.kernel.set_time(t); });
  tangents_.set_time(t);
}

void Constraints::set_offsets(std::span<const RowOffset> offsets) {
  const auto set = [&](auto& rods) {
    for (std::size_t k = 0; k < rods.size(); ++k) {
      const auto found = std::ranges::lower_bound(offsets, static_cast<std::size_t>(rods.rows[k]), {}, &RowOffset::row);
      if (found != offsets.end() && found->row == static_cast<std::size_t>(rods.rows[k]))
        rods.kernel.offset[k] = found->offset;
    }
  };
  set(std::get<Family<RodKernel<false, true>>>(families_));
  set(std::get<Family<RodKernel<true, true>>>(families_));
}

double Constraints::evaluate_values(const Parallel& parallel, const double* r, double* xi) const {
  const double worst = evaluate_values(parallel, open.others_, r, xi);
  open.clear(xi);
  tangents_.write_values(r, xi);
  return worst;
}

double Constraints::evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rate) const {
  open.clear(rate);
  return larger(evaluate_rates(parallel, open.others_, r, v, rate), tangents_.evaluate_rates(v, rate));
}

void Constraints::evaluate_gradients(const Parallel& parallel, const double* r, double* blocks) {
  evaluate_gradients(parallel, open.others_, r, blocks);
  open.clear_blocks(blocks);
  tangents_.write_gradients(parallel, blocks);
}

double Constraints::evaluate_right_side(const Parallel& parallel, const double* r, const double* v, const double* w0,
                                        double* phi, double* blocks) {
  const double worst = evaluate_right_side(parallel, open.others_, r, v, w0, phi, blocks);
  open.clear(phi);
  if (blocks != nullptr) open.clear_blocks(blocks);
  if (tangents_.size() == 0) return worst;
  if (blocks != nullptr) tangents_.write_gradients(parallel, blocks);
  return larger(worst, evaluate_contacts(parallel, r, v, w0, Tangents::Which::Sticking, phi));
}

/// Evaluates the rows of contacts. If their guides turn, T'K_g_dot takes two more evaluations of phi for each
/// direction.
double Constraints::evaluate_contacts(const Parallel& parallel, const double* r, const double* v, const double* w0,
                                      Tangents::Which which, double* phi) {
  std::array<const double*, 2> turn{};
  if (const int num_turning = tangents_.num_turning(v, which); num_turning > 0) {
    const std::size_t size = 3 * num_points_;
    nothing_.assign(size, 0.0);
    turns_.resize(3 * num_rows_);
    double* const other = turns_.data() + 2 * num_rows_;
    const auto evaluate_at = [&](int k, double s, double* result) {
      shifted_.assign(v, v + size);
      tangents_.shift_velocities(k, s, v, shifted_.data());
      evaluate_right_side(parallel, open.others_, r, shifted_.data(), nothing_.data(), result, nullptr);
    };
    double speed = 0.0;
    for (std::size_t i = 0; i < size; ++i) speed = std::max(speed, std::abs(v[i]));
    const double s = speed > 0.0 ? speed : 1.0;
    for (int k = 0; k < num_turning; ++k) {
      double* const result = turns_.data() + static_cast<std::size_t>(k) * num_rows_;
      evaluate_at(k, s, result);
      evaluate_at(k, -s, other);
      for (std::size_t a = 0; a < num_rows_; ++a) result[a] = (result[a] - other[a]) / (4.0 * s);
      turn[static_cast<std::size_t>(k)] = result;
    }
  }
  return tangents_.evaluate_right_side(v, w0, turn, which, phi);
}

double Constraints::apply_transposed(const Parallel& parallel, const double* blocks, const double* x,
                                     const double* shift, double* y) const {
  open.clear(y);
  return larger(apply_transposed(parallel, open.others_, blocks, x, shift, y),
                tangents_.apply_transposed(blocks, x, shift, y));
}

void Constraints::measure(const double* r, const double* v, double* position, double* velocity) const {
  for_each_family([&](const auto& family) { family.measure(r, v, position, velocity); });
  open.clear(position);
  open.clear(velocity);
  tangents_.write_values(r, position);
  tangents_.evaluate_rates(v, velocity);
}

std::vector<Incidence> Constraints::list_incidences() const {
  const auto list = [&](const auto& append) {
    for_each_family([&](const auto& family) { family.list_incidences(append); });
    tangents_.list_incidences(append);
  };
  std::size_t count = 0;
  list([&](const Incidence&) { ++count; });
  std::vector<Incidence> result;
  result.reserve(count);
  list([&](const Incidence& incidence) { result.push_back(incidence); });
  return result;
}

void Constraints::write_lengths(double* lengths) const {
  for_each_family([&](const auto& family) { family.write_lengths(lengths); });
}

}  // namespace tanor::detail
