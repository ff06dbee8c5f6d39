#include "evaluate/force_series.hpp"

#include <type_traits>
#include <variant>

#include "base/text.hpp"
#include "kinds/energy_groups.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

/// Records the force on the last point of a member. The variables are r of its points, then v and its number if these
/// are read.
template <class G>
Expression take_down(const G& group, int num_points, bool has_velocities, bool has_number) {
  const auto p = static_cast<std::size_t>(num_points);
  const auto force = [&](const std::vector<Traced>& x) {
    std::vector<TripleOf<Traced>> places;
    for (std::size_t i = 0; i + 2 < x.size(); i += 3) places.push_back({x[i], x[i + 1], x[i + 2]});
    const std::span<const TripleOf<Traced>> all = places;
    const typename KindOf<G>::template Definition<Traced> definition(group, ClockOf<double>{});
    const TripleOf<Traced> f =
        definition.force(all.first(p), all.subspan(has_velocities ? p : 0), has_number ? x.back() : Traced(0.0));
    return std::vector{f.x, f.y, f.z};
  };
  return *record_expression(3 * num_points * (has_velocities ? 2 : 1) + (has_number ? 1 : 0), force);
}

}  // namespace

/// Reads the forces of a system, entry by entry.
class ForceSeries::Reader {
 public:
  Reader(ForceSeries* series, const System& system, const Numbering& numbering)
      : series_(*series), system_(system), numbering_(numbering) {}

  /// Returns false if there is no series.
  bool add(const Gravity& gravity) {
    series_.gravity_ = series_.gravity_ + make_vec3(gravity.acceleration);
    return true;
  }
  bool add(const ConstantForce& given) {
    Expression expression;
    for (int c = 0; c < 3; ++c) (void)Traced::variable(expression);
    expression.results = expression.variables;
    Group& group = add_group(expression, list_variables(0, false, 3), 1, 3);
    std::vector<std::size_t> slots;
    for (const ScalarFunction& component : given.force.components) slots.push_back(series_.table_.add(component));
    for (const Index point : given.points) add_member(group, {&point, 1}, slots);
    return true;
  }
  bool add(const FormulaForce& formula) {
    if (!formula.kernel.expression) return false;
    const int p = formula.kernel.num_points;
    Group& group = add_group(*formula.kernel.expression, list_variables(p, true, 1), p, 1);
    const std::size_t time = series_.table_.add(ScalarFunction::formula("t"));
    for (const Index point : formula.points) add_tuple(group, {&point, 1}, {&time, 1});
    for (const auto& tuple : formula.tuples) add_tuple(group, tuple, {&time, 1});
    return true;
  }
  bool add(const PairForces& pairs) {
    const EnergyGroup smooth = make_pair_energies(system_, pairs);
    return !smooth.points.empty() && add_energy(smooth);
  }
  bool add(const Potential& group) { return add_energy(make_energy_group(system_, group)); }
  template <HasEnergy G>
  bool add(const G& group) {
    return add_energy(make_energy_group(system_, group));
  }
  /// Adds a kind that has a definition. Other kinds have no series.
  template <class G>
  bool add(const G& given) {
    if constexpr (!requires { sizeof(typename KindOf<G>::template Definition<Traced>); }) {
      return false;
    } else {
      const bool has_velocities = KindOf<G>::reads_velocities(given);
      bool has_number = false;
      if constexpr (requires { KindOf<G>::reads_number(given); }) has_number = KindOf<G>::reads_number(given);
      constexpr int num_points = points_of_member<G>();
      Group& group =
          add_group(take_down(given, num_points, has_velocities, has_number),
                    list_variables(num_points, has_velocities, has_number ? 1 : 0), num_points, has_number ? 1 : 0);
      for (std::size_t k = 0; k < num_members(given); ++k) {
        std::vector<std::size_t> slots;
        if (has_number) slots.push_back(series_.table_.add(number_of(given, k)));
        add_member(group, member_points(given, k), slots);
      }
      return true;
    }
  }

 private:
  Group& add_group(const Expression& expression, std::vector<SeriesVariable> variables, int num_points,
                   int num_functions, bool is_energy = false) {
    const bool is_of_points = is_energy || expression.results.size() == 3 * static_cast<std::size_t>(num_points);
    series_.groups_.push_back(
        {ProgramFamily(SeriesProgram(expression, is_energy), std::move(variables), num_points, num_functions),
         series_.num_blocks_, is_energy, is_of_points ? static_cast<std::size_t>(num_points) : 1});
    return series_.groups_.back();
  }
  /// Adds energies. A tuple's constants and the time enter as functions of time.
  bool add_energy(const EnergyGroup& energy) {
    if (!energy.kernel.expression) return false;
    const int p = energy.kernel.num_points, c = energy.kernel.num_constants;
    Group& group = add_group(*energy.kernel.expression, list_variables(p, false, c + 1), p, c + 1, true);
    const std::size_t time = series_.table_.add(ScalarFunction::formula("t"));
    for (std::size_t k = 0; k * static_cast<std::size_t>(p) < energy.points.size(); ++k) {
      std::vector<std::size_t> slots;
      for (int i = 0; i < c; ++i)
        slots.push_back(
            series_.table_.add(energy.constants[k * static_cast<std::size_t>(c) + static_cast<std::size_t>(i)]));
      slots.push_back(time);
      add_tuple(group, std::span(energy.points).subspan(k * static_cast<std::size_t>(p), static_cast<std::size_t>(p)),
                slots);
    }
    return true;
  }
  /// Adds a member with a block for each of its points.
  void add_tuple(Group& group, std::span<const Index> users, std::span<const std::size_t> slots) {
    std::vector<Index> points;
    for (const Index user : users) {
      points.push_back(numbering_.inner_point[static_cast<std::size_t>(user)]);
      series_.incidences_.push_back({points.back(), 0, series_.num_blocks_++, 1.0});
    }
    group.family.append_member(points, slots);
  }
  void add_member(Group& group, std::span<const Index> users, std::span<const std::size_t> slots) {
    std::vector<Index> points;
    for (const Index point : users) points.push_back(numbering_.inner_point[static_cast<std::size_t>(point)]);
    group.family.append_member(points, slots);
    const Index block = series_.num_blocks_++;
    series_.incidences_.push_back({points.back(), 0, block, 1.0});
    if (points.size() == 2) series_.incidences_.push_back({points.front(), 0, block, -1.0});
  }
  /// Returns the number of member k as it is at the start.
  template <class G>
  double number_of(const G& given, std::size_t k) const {
    if constexpr (requires { KindOf<G>::parameter; }) {
      const auto measure = [&] {
        const PlacesIn at{system_.positions.data()};
        const typename KindOf<G>::template Definition<double> definition(given, ClockOf<double>{});
        return definition.measure(MemberPlaces{member_points(given, k), at}, k);
      };
      return detail::number_of(given.*KindOf<G>::parameter, k, measure)(0.0).value();
    }
    return 0.0;
  }

  ForceSeries& series_;
  const System& system_;
  const Numbering& numbering_;
};

ForceSeries::ForceSeries(const System& system, const Numbering& numbering, double t0) {
  Reader reader(this, system, numbering);
  for (std::size_t g = 0; g < system.forces.size() && obstacle_.empty(); ++g) {
    const Force& force = system.forces[g];
    if (std::visit([&](const auto& given) { return reader.add(given); }, force)) continue;
    const bool is_pairs = std::holds_alternative<PairForces>(force);
    obstacle_ = "forces[" + text(g) + "] cannot be expanded in time: " +
                (is_pairs ? "pair forces have no series" : "it is known as a function alone");
  }
  if (obstacle_.empty() && table_.has_unknown(t0)) obstacle_ = "a force is known as a function of time alone";
  std::erase_if(groups_, [](const Group& group) { return group.family.size() == 0; });
}

void ForceSeries::begin(double t, int order) {
  table_.expand(t, order);
  for (Group& group : groups_) group.family.resize(order);
}

template <class Lane>
void ForceSeries::write_forces(const Group& group, const Lane* lanes, std::size_t chunk, int k, double* blocks) {
  const ProgramFamily& family = group.family;
  const std::size_t first = chunk * series_width, count = std::min(series_width, family.size() - first);
  const std::size_t blocks_of_member = group.blocks_of_member;
  const auto force = [&](std::size_t i, std::size_t m) {
    const SeriesProgram& program = family.program();
    return group.is_energy ? -member_of(program.adjoint(lanes, family.order(), i)[k], m)
                           : member_of(program.result(lanes, family.order(), i)[k], m);
  };
  for (std::size_t m = 0; m < count; ++m) {
    for (std::size_t i = 0; i < blocks_of_member; ++i) {
      store(blocks, static_cast<std::size_t>(group.first_block) + (first + m) * blocks_of_member + i,
            {force(3 * i, m), force(3 * i + 1, m), force(3 * i + 2, m)});
    }
  }
}

void ForceSeries::advance(const Parallel& parallel, int k, std::span<double* const> coefficients, double* blocks) {
  for (Group& group : groups_) {
    ProgramFamily& family = group.family;
    const SeriesProgram& program = family.program();
    const auto advance_chunk = [&](std::size_t chunk, auto* lanes) {
      using Lane = std::remove_pointer_t<decltype(lanes)>;
      const Lane seed = Lane{} + (k == 0 ? 1.0 : 0.0);
      family.load(lanes, chunk, k, coefficients, table_);
      program.evaluate(lanes, family.order(), k);
      if (group.is_energy) program.differentiate(lanes, family.order(), k, &seed);
      write_forces(group, lanes, chunk, k, blocks);
    };
    family.for_each_chunk(parallel, advance_chunk);
  }
}

}  // namespace tanor::detail
