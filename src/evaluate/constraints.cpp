#include "evaluate/constraints.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor {

namespace {

/// A member of a constraint group on its way into a family.
struct Member {
  Index row;    // first inner row
  Index group;  // in System::constraints
  Index index;  // in its group
};

/// The number of a member: its parameter, or what the initial positions say. Members of a group share a slot where the
/// group gives one function (or number) for all.
class ParameterReader {
 public:
  explicit ParameterReader(ScalarTable* table) : table_(table) {}

  template <class Initial>
  void append(const Parameter& parameter, Member member, const Initial& initial) {
    const bool shared = parameter.functions.size() == 1 || parameter.constants.size() == 1;
    if (shared) {
      const auto [entry, is_new] = slot_of_group_.try_emplace(member.group, 0);
      if (is_new) entry->second = table_->add(value(parameter, 0));
      table_->append_member(entry->second);
    } else {
      table_->append_member(
          table_->add(parameter.is_initial() ? ScalarFunction(initial()) : value(parameter, member.index)));
    }
  }

 private:
  static ScalarFunction value(const Parameter& parameter, Index k) {
    return parameter.functions.empty() ? ScalarFunction(parameter.constants[k]) : parameter.functions[k];
  }

  ScalarTable* table_;
  std::map<Index, std::size_t> slot_of_group_;
};

/// Slot of a group's geometry in a kernel's tables, made when the group is met first.
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

/// Place of a group's type in the variant.
template <class Group, std::size_t... Kinds>
constexpr std::size_t kind_index(std::index_sequence<Kinds...>) {
  return ((std::is_same_v<Group, std::variant_alternative_t<Kinds, Constraint>> ? Kinds : 0) + ...);
}

/// Fills the families of a Constraints, kind by kind.
struct Builder {
  const System& system;
  const Numbering& numbering;
  double t;
  double size;                                           // of the scene
  mutable std::optional<Neighbourhoods> neighbourhoods;  // made when first needed: rods have lengths of their own
  std::vector<std::vector<Member>> members_of_kind;      // [index in the variant], by increasing row

  Builder(const System& s, const Numbering& n, double start)
      : system(s), numbering(n), t(start), size(scene_size(s)), members_of_kind(std::variant_size_v<Constraint>) {
    std::vector<Member> member_of_row(numbering.num_rows(), {-1, -1, -1});  // with this first row
    std::size_t counter = 0;
    for (std::size_t g = 0; g < system.constraints.size(); ++g) {
      const std::size_t count = std::visit([](const auto& group) { return num_members(group); }, system.constraints[g]);
      for (std::size_t k = 0; k < count; ++k) {
        const Index row = numbering.member_row[counter++];
        member_of_row[row] = {row, static_cast<Index>(g), static_cast<Index>(k)};
      }
    }
    for (const Member& member : member_of_row) {
      if (member.row >= 0) members_of_kind[system.constraints[member.group].index()].push_back(member);
    }
  }

  /// Of the neighbourhood of the first point that moves; of the scene where none does.
  double length_around(std::span<const Index> points) const {
    if (!neighbourhoods) neighbourhoods = find_neighbourhoods(system, t);
    for (const Index point : points) {
      const Index own = neighbourhoods->of_point[static_cast<std::size_t>(point)];
      if (own >= 0) return neighbourhoods->length[static_cast<std::size_t>(own)];
    }
    return size;
  }
  Vec3 initial(Index user_point) const { return load(system.positions.data(), user_point); }

  template <std::size_t N>
  std::array<Index, N> inner(const std::array<Index, N>& user) const {
    std::array<Index, N> result;
    for (std::size_t p = 0; p < N; ++p) result[p] = numbering.inner_point[user[p]];
    return result;
  }

  /// visit(group, member) for all members of one kind.
  template <class Group, class Visit>
  void for_each(const Visit& visit) const {
    constexpr std::size_t kind = kind_index<Group>(std::make_index_sequence<std::variant_size_v<Constraint>>{});
    for (const Member& member : members_of_kind[kind]) visit(std::get<Group>(system.constraints[member.group]), member);
  }

  template <bool Timed, bool Shifted>
  void fill(Family<RodKernel<Timed, Shifted>>* family) const {
    auto& kernel = family->kernel;
    ParameterReader moving(&kernel.moving_length);
    for_each<Rods>([&](const Rods& rods, const Member& member) {
      if (rods.length.functions.empty() == Timed || rods.offsets.empty() == Shifted) return;
      const auto& pair = rods.pairs[member.index];
      const auto initial_length = [&] {
        const Vec3 offset = Shifted ? make_vec3(rods.offsets[member.index]) : Vec3{};
        return norm(initial(pair[1]) - initial(pair[0]) + offset);
      };
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(pair));
      if constexpr (Shifted) kernel.offset.push_back(make_vec3(rods.offsets[member.index]));
      if constexpr (Timed) {
        moving.append(rods.length, member, initial_length);
      } else {
        const auto& lengths = rods.length.constants;
        kernel.length.push_back(lengths.empty() ? initial_length() : lengths[lengths.size() == 1 ? 0 : member.index]);
      }
    });
  }

  void fill(Family<PlaneKernel>* family) const {
    auto& kernel = family->kernel;
    GeometryReader geometry;
    ParameterReader offset(&kernel.offset);
    for_each<Planes>([&](const Planes& planes, const Member& member) {
      const Index point = planes.points[member.index];
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(std::array{point}));
      kernel.size.push_back(length_around({&point, 1}));
      kernel.geometry.push_back(geometry.slot(member.group, [&] { kernel.normal.add(planes.normal); }));
      offset.append(planes.offset, member, [&] {
        const auto n = planes.normal(t);
        return dot({n[0].value(), n[1].value(), n[2].value()}, initial(point));
      });
    });
  }

  void fill(Family<SphereKernel>* family) const {
    auto& kernel = family->kernel;
    GeometryReader geometry;
    ParameterReader radius(&kernel.radius);
    for_each<Spheres>([&](const Spheres& spheres, const Member& member) {
      const Index point = spheres.points[member.index];
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(std::array{point}));
      kernel.geometry.push_back(geometry.slot(member.group, [&] { kernel.center.add(spheres.center); }));
      radius.append(spheres.radius, member,
                    [&] { return norm(initial(point) - make_moving(spheres.center(t)).value); });
    });
  }

  void fill(Family<LineKernel>* family) const {
    auto& kernel = family->kernel;
    GeometryReader geometry;
    for_each<Lines>([&](const Lines& lines, const Member& member) {
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(std::array{lines.points[member.index]}));
      kernel.size.push_back(length_around({&lines.points[member.index], 1}));
      kernel.geometry.push_back(geometry.slot(member.group, [&] {
        kernel.origin.add(lines.origin);
        kernel.normals.add(lines.direction);
      }));
    });
  }

  void fill(Family<CircleKernel>* family) const {
    auto& kernel = family->kernel;
    GeometryReader geometry;
    ParameterReader radius(&kernel.radius);
    for_each<Circles>([&](const Circles& circles, const Member& member) {
      const Index point = circles.points[member.index];
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(std::array{point}));
      kernel.geometry.push_back(geometry.slot(member.group, [&] {
        kernel.center.add(circles.center);
        kernel.normal.add(circles.normal);
      }));
      radius.append(circles.radius, member, [&] {
        const Vec3 a = initial(point) - make_moving(circles.center(t)).value;
        const Vec3 n = ToUnit{}(circles.normal(t)).value;
        return norm(a - dot(n, a) * n);
      });
    });
  }

  void fill(Family<AngleKernel>* family) const {
    auto& kernel = family->kernel;
    ParameterReader cosine(&kernel.cosine);
    for_each<Angles>([&](const Angles& angles, const Member& member) {
      const auto& [i, j, k] = angles.triples[member.index];
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(angles.triples[member.index]));
      kernel.size.push_back(length_around(angles.triples[member.index]));
      cosine.append(angles.cosine, member, [&, i = i, j = j, k = k] {
        const Vec3 a = initial(i) - initial(j), b = initial(k) - initial(j);
        return dot(a, b) / (norm(a) * norm(b));
      });
    });
  }

  void fill(Family<PulleyKernel>* family) const {
    auto& kernel = family->kernel;
    GeometryReader geometry;
    ParameterReader length(&kernel.length);
    for_each<Pulleys>([&](const Pulleys& pulleys, const Member& member) {
      const auto& pair = pulleys.pairs[member.index];
      const Vec3 a = make_vec3(pulleys.a), b = make_vec3(pulleys.b);
      family->rows.push_back(member.row);
      kernel.points.push_back(inner(pair));
      kernel.size.push_back(length_around(pair));
      kernel.geometry.push_back(geometry.slot(member.group, [&] { kernel.wheels.push_back({a, b, pulleys.ratio}); }));
      length.append(pulleys.length, member,
                    [&] { return norm(initial(pair[0]) - a) + pulleys.ratio * norm(initial(pair[1]) - b); });
    });
  }

  void fill(LinearFamily* family) const {
    auto& kernel = family->kernel;
    ParameterReader value(&kernel.value);
    for_each<Linears>([&](const Linears& linears, const Member& member) {
      const auto& tuple = linears.tuples[member.index];
      double norm2 = 0.0, sum = 0.0;
      for (std::size_t p = 0; p < tuple.size(); ++p) {
        const Vec3 c = make_vec3(linears.coefficients[p]);
        kernel.points.push_back(numbering.inner_point[tuple[p]]);
        kernel.coefficients.push_back(c);
        norm2 = std::max(norm2, dot(c, c));
        sum += dot(c, initial(tuple[p]));
      }
      kernel.start.push_back(static_cast<Index>(kernel.points.size()));
      kernel.norms.push_back(std::sqrt(norm2));
      kernel.size.push_back(length_around(tuple));
      family->rows.push_back(member.row);
      value.append(linears.value, member, [&] { return sum; });
    });
  }

  void fill(UserFamily* family) const {
    auto& groups = family->kernel.groups;
    GeometryReader geometry;
    for_each<UserConstraints>([&](const UserConstraints& constraints, const Member& member) {
      const Index slot = geometry.slot(member.group, [&] { groups.push_back({constraints.kernel, {}, {}, {}}); });
      UserGroup& group = groups[static_cast<std::size_t>(slot)];
      for (const Index point : constraints.tuples[member.index]) group.points.push_back(numbering.inner_point[point]);
      group.rows.push_back(member.row);
      group.lengths.push_back(length_around(constraints.tuples[member.index]));
    });
    Index num_blocks = 0;
    for (UserGroup& group : groups) {
      group.first_block = num_blocks;
      num_blocks += static_cast<Index>(group.points.size());
    }
  }
};

template <class Kernel>
Index blocks_of(const Family<Kernel>& family) {
  return static_cast<Index>(family.size()) * Kernel::num_blocks;
}
Index blocks_of(const LinearFamily& family) {
  return static_cast<Index>(family.kernel.points.size());
}
Index blocks_of(const UserFamily& family) {
  Index result = 0;
  for (const UserGroup& group : family.kernel.groups) result += static_cast<Index>(group.points.size());
  return result;
}

}  // namespace

Constraints::Constraints(const System& system, const Numbering& numbering, double t)
    : num_points_(numbering.num_points()), num_rows_(numbering.num_rows()) {
  const Builder builder(system, numbering, t);
  std::apply([&](auto&... family) { (builder.fill(&family), ...); }, families_);
  for_each_family([&](auto& family) {
    family.first_block = static_cast<Index>(num_blocks_);
    num_blocks_ += static_cast<std::size_t>(blocks_of(family));
  });
  everything_ = select(std::vector<char>(num_rows_, 1));
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
    // max over beta of e1.(c o1 + s o2) + e2.(c o2 - s o1)
    const double c = dot(e1, o1) + dot(e2, o2), s = dot(e1, o2) - dot(e2, o1), length = std::hypot(c, s);
    if (!(length > 0.0)) continue;
    store(others, first, (c / length) * o1 + (s / length) * o2);
    store(others, first + 1, (c / length) * o2 - (s / length) * o1);
  }
}

bool Constraints::gradients_are_constant() const {
  // contacts may change between stick and slip
  return tangents_.num_blocks() == 0 && gradients_are_constant(everything_);
}

bool Constraints::gradient_norms_are_constant() const {
  return std::get<Family<AngleKernel>>(families_).size() == 0 && std::get<UserFamily>(families_).size() == 0;
}

std::vector<double> Constraints::squared_gradient_norms() const {
  if (!gradient_norms_are_constant()) return {};
  std::vector<double> result(num_blocks_, 1.0);
  const auto& pulleys = std::get<Family<PulleyKernel>>(families_);
  for (std::size_t k = 0; k < pulleys.size(); ++k) {
    const double ratio = pulleys.kernel.wheels[static_cast<std::size_t>(pulleys.kernel.geometry[k])].ratio;
    result[static_cast<std::size_t>(pulleys.first_block) + 2 * k + 1] = ratio * ratio;
  }
  const auto& linears = std::get<LinearFamily>(families_);
  const auto& coefficients = linears.kernel.coefficients;
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    result[static_cast<std::size_t>(linears.first_block) + k] = dot(coefficients[k], coefficients[k]);
  }
  return result;
}

void Constraints::set_time(double t) {
  for_each_family([&](auto& family) { family.kernel.set_time(t); });
  tangents_.set_time(t);
}

double Constraints::evaluate_values(const Parallel& parallel, const double* r, double* xi) const {
  const double worst = evaluate_values(parallel, everything_, r, xi);
  tangents_.write_values(r, xi);
  return worst;
}

double Constraints::evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rate) const {
  return larger(evaluate_rates(parallel, everything_, r, v, rate), tangents_.evaluate_rates(v, rate));
}

void Constraints::evaluate_gradients(const Parallel& parallel, const double* r, double* blocks) {
  evaluate_gradients(parallel, everything_, r, blocks);
  tangents_.write_gradients(parallel, blocks);
}

double Constraints::evaluate_right_side(const Parallel& parallel, const double* r, const double* v, const double* w0,
                                        double* phi, double* blocks) {
  const double worst = evaluate_right_side(parallel, everything_, r, v, w0, phi, blocks);
  if (tangents_.size() == 0) return worst;
  if (blocks != nullptr) tangents_.write_gradients(parallel, blocks);
  return larger(worst, evaluate_contacts(parallel, r, v, w0, Tangents::Which::Sticking, phi));
}

/// The rows of contacts; where their guides turn, T'K_g_dot by two more evaluations of phi a direction.
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
      evaluate_right_side(parallel, everything_, r, shifted_.data(), nothing_.data(), result, nullptr);
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
  return larger(apply_transposed(parallel, everything_, blocks, x, shift, y),
                tangents_.apply_transposed(blocks, x, shift, y));
}

void Constraints::measure(const double* r, const double* v, double* position, double* velocity) const {
  for_each_family([&](const auto& family) { family.measure(r, v, position, velocity); });
  tangents_.write_values(r, position);
  tangents_.evaluate_rates(v, velocity);
}

std::vector<Incidence> Constraints::list_incidences() const {
  std::vector<Incidence> result;
  for_each_family([&](const auto& family) {
    family.list_incidences([&](const Incidence& incidence) { result.push_back(incidence); });
  });
  tangents_.list_incidences([&](const Incidence& incidence) { result.push_back(incidence); });
  return result;
}

void Constraints::write_lengths(double* lengths) const {
  for_each_family([&](const auto& family) { family.write_lengths(lengths); });
}

double Constraints::smallest_length(double scene_size) const {
  double result = scene_size;
  for_each_family([&](const auto& family) {
    for (std::size_t k = 0; k < family.size(); ++k) result = std::min(result, family.kernel.scale(k));
  });
  return result;
}

}  // namespace tanor
