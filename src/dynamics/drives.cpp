#include "dynamics/drives.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include "base/vec3.hpp"
#include "system/contacts.hpp"
#include "system/members.hpp"

namespace tanor {

namespace {

constexpr std::size_t most_members = 16;       // of an entry that are looked at
constexpr std::size_t most_samples = 1 << 14;  // of a step, beside the knots of tables

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;  // clang 14 wants to be told

/// visit(k) for at most `most_members` of `count`, evenly spread.
template <class Visit>
void for_some(std::size_t count, const Visit& visit) {
  const std::size_t some = std::min(count, most_members);
  for (std::size_t i = 0; i < some; ++i) visit(i * count / some);
}

/// Variable i of an expression takes part; of the first one that is said of constants, too.
bool depends_on(const Expression& expression, std::size_t variable) {
  const int number = expression.variables[variable];
  if (std::ranges::count(expression.results, number) > 0) return true;
  return std::ranges::any_of(expression.instructions, [number](const Expression::Instruction& i) {
    return i.operation != Expression::Operation::Variable && (i.a == number || i.b == number || i.c == number);
  });
}
/// Time is the last one.
bool depends_on_time(const Expression& expression) {
  return depends_on(expression, expression.variables.size() - 1);
}
bool depends_on_state(const Expression& expression) {
  for (std::size_t i = 0; i + 1 < expression.variables.size(); ++i) {
    if (depends_on(expression, i)) return true;
  }
  return false;
}

/// With a tuple's own numbers in the place of the variables behind its coordinates.
Expression with_constants(const Potential& group, std::size_t k) {
  Expression result = *group.kernel.expression;
  const auto first = result.variables.begin() + 3 * group.kernel.num_points;
  const auto last = first + static_cast<std::ptrdiff_t>(group.constants.size());
  for (std::size_t c = 0; const std::vector<double>& each : group.constants)
    result.instructions[static_cast<std::size_t>(first[static_cast<std::ptrdiff_t>(c++)])] = {
        .operation = Expression::Operation::Constant, .constant = each[each.size() == 1 ? 0 : k]};
  result.variables.erase(first, last);
  return result;
}

double length_of(const VectorFunction& a, double t) {
  const std::array<Jet<2>, 3> at = a(t);
  return std::hypot(at[0].value(), at[1].value(), at[2].value());
}

std::size_t num_coordinates(const Coordinates& coordinates) {
  return std::visit([](const auto& group) { return num_coordinates_of(group); }, coordinates);
}

}  // namespace

Drives::Drives(const System& system, const Numbering& numbering, std::span<const double> inverse_mass,
               double scene_size, double t)
    : numbering_(numbering), scene_size_(scene_size) {
  for (std::size_t i = 0; i < system.num_points(); ++i)
    reach_ = std::max(reach_, norm(load(system.positions.data(), i)));
  reach_ = std::max(reach_, scene_size);
  // Each entry appends what it has under its name.
  const auto enter = [&](std::string name) { names_.push_back(std::move(name)); };
  for (std::size_t k = 0; k < system.supports.size(); ++k) {
    const Support& support = system.supports[k];
    enter("the motion of " + (support.name.empty() ? "supports[" + std::to_string(k) + "]" : support.name));
    add(support.displacement, Level::Position, 1.0, support.points);
  }
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    enter(constraint_name(system, k));
    add_constraint(system.constraints[k], t);
  }
  std::size_t first_coordinate = 0;
  for (std::size_t k = 0; k < system.coordinates.size(); ++k) {
    enter(coordinates_name(system, k));
    add_coordinates(system.coordinates[k], t, first_coordinate);
    first_coordinate += num_coordinates(system.coordinates[k]);
  }
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    enter(force_name(system, k));
    add_force(system.forces[k], inverse_mass);
  }
  const std::vector<Contact> contacts = system.friction.empty() ? std::vector<Contact>{} : list_contacts(system);
  for (std::size_t k = 0; k < system.friction.size(); ++k) {
    enter(friction_name(system, k));
    std::vector<Index> points;
    for (const Contact& contact : contacts) {
      if (contact.friction == static_cast<Index>(k)) points.push_back(contact.point);
    }
    std::visit([&](const auto& law) { add(law.velocity, Level::Velocity, 1.0, points); }, system.friction[k]);
  }
  if (empty()) return;
  // As many as an advance of one step looks at, so that nothing is allocated later.
  constexpr std::size_t most = 4096 + 128;
  for (std::vector<double>* array :
       {&fractions_, &widths_, &times_, &values_, &knots_, &cosines_, &chebyshev_, &next_, &after_next_, &missed_})
    array->reserve(most);
}

// ---- what there is ----

void Drives::add(const ScalarFunction& function, Level level, double scale, std::span<const Index> users_points) {
  if (function.is_constant() || users_points.empty()) return;
  Function added{function, level, scale, {}, names_.size() - 1};
  for_some(users_points.size(), [&](std::size_t k) {
    added.points.push_back(numbering_.inner_point[static_cast<std::size_t>(users_points[k])]);
  });
  functions_.push_back(std::move(added));
}

void Drives::add(const VectorFunction& function, Level level, double scale, std::span<const Index> users_points) {
  for (const ScalarFunction& component : function.components) add(component, level, scale, users_points);
}

/// One function for all members, or one each.
template <class Group>
void Drives::add(const Parameter& parameter, double scale, const Group& group) {
  if (parameter.functions.empty() || num_members(group) == 0) return;
  if (parameter.functions.size() == 1) {
    std::vector<Index> points;
    for_some(num_members(group), [&](std::size_t k) { points.push_back(member_points(group, k).back()); });
    return add(parameter.functions[0], Level::Position, scale, points);
  }
  for (std::size_t k = 0; k < parameter.functions.size(); ++k)
    add(parameter.functions[k], Level::Position, scale, member_points(group, k));
}

void Drives::add(const Expression& expression, Program::As as, double scale, std::size_t first_coordinate,
                 std::span<const Index> users_points) {
  Program added{as,
                SeriesProgram(expression, as == Program::As::AConstraint || as == Program::As::AnEnergy),
                {},
                first_coordinate,
                scale,
                !depends_on_state(expression),
                names_.size() - 1};
  for (const Index point : users_points)
    added.points.push_back(numbering_.inner_point[static_cast<std::size_t>(point)]);
  programs_.push_back(std::move(added));
}

double Drives::lever(const VectorFunction& direction, double t) const {
  return direction.is_constant() ? 0.0 : reach_ / length_of(direction, t);
}

void Drives::add_force(const Force& force, std::span<const double> inverse_mass) {
  // of the lightest of some points
  const auto largest_inverse = [&](std::span<const Index> points) {
    double largest = 0.0;
    for (const Index point : points) largest = std::max(largest, inverse_mass[numbering_.inner_point[point]]);
    return largest;
  };
  // A black box tells nothing of its functions of time.
  const auto may_be_driven = [](const auto& kernel) {
    return kernel.expression != nullptr && depends_on_time(*kernel.expression);
  };
  if (const auto* given = std::get_if<ConstantForce>(&force)) {
    const double largest = largest_inverse(given->points);
    if (largest > 0.0) add(given->force, Level::Acceleration, largest, given->points);
  } else if (const auto* formula = std::get_if<FormulaForce>(&force); formula && may_be_driven(formula->kernel)) {
    const auto watch = [&](std::span<const Index> points) {
      const double largest = largest_inverse(points);
      if (largest > 0.0) add(*formula->kernel.expression, Program::As::AForce, largest, 0, points);
    };
    for_some(formula->points.size(), [&](std::size_t k) { watch({&formula->points[k], 1}); });
    for_some(formula->tuples.size(), [&](std::size_t k) { watch(formula->tuples[k]); });
  } else if (const auto* group = std::get_if<Potential>(&force); group && may_be_driven(group->kernel)) {
    for_some(group->points.size(), [&](std::size_t k) {
      const double largest = largest_inverse(group->points[k]);
      if (largest > 0.0) add(with_constants(*group, k), Program::As::AnEnergy, largest, 0, group->points[k]);
    });
  }
}

/// Of all members.
template <class Group>
std::vector<Index> list_points(const Group& group) {
  std::vector<Index> points;
  for (std::size_t k = 0; k < num_members(group); ++k) {
    for (const Index point : member_points(group, k)) points.push_back(point);
  }
  return points;
}

/// The fields of a group that move its points: places by as much, directions and parameters by a lever.
template <class Group>
void Drives::add_fields(const Group& group, double t) {
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    const Value& value = group.*field.value;
    if constexpr (std::is_same_v<Value, VectorFunction>) {
      const bool turns = field.data.role == FieldRole::Direction;
      add(value, Level::Position, turns ? lever(value, t) : 1.0, list_points(group));
    } else if constexpr (std::is_same_v<Value, Parameter>) {
      double scale = 1.0;
      if constexpr (requires { KindOf<Group>::leverage(group, t, scene_size_); })
        scale = KindOf<Group>::leverage(group, t, scene_size_);
      if (scale > 0.0) add(value, scale, group);
    }
  });
}

void Drives::add_constraint(const Constraint& constraint, double t) {
  std::visit(Overloaded{[&](const auto& group) { add_fields(group, t); },
                        [&](const UserConstraints& group) {
                          if (group.kernel.expression == nullptr || !group.kernel.depends_on_time) return;
                          for_some(group.tuples.size(), [&](std::size_t k) {
                            add(*group.kernel.expression, Program::As::AConstraint, 1.0, 0, group.tuples[k]);
                          });
                        }},
             constraint);
}

void Drives::add_coordinates(const Coordinates& coordinates, double t, std::size_t first_coordinate) {
  std::visit(Overloaded{[&](const auto& group) { add_fields(group, t); },
                        [&](const UserCoordinates& group) {
                          if (group.kernel.expression == nullptr || !group.kernel.depends_on_time) return;
                          for_some(group.tuples.size(), [&](std::size_t k) {
                            add(*group.kernel.expression, Program::As::SomeCoordinates, 1.0,
                                first_coordinate + k * static_cast<std::size_t>(group.kernel.num_coordinates),
                                group.tuples[k]);
                          });
                        }},
             coordinates);
}

// ---- one look ----

DriveReport Drives::look(const DrivenStep& step, const Place& place) {
  DriveReport report;
  const auto make_times = [&] {
    times_.resize(fractions_.size());
    for (std::size_t i = 0; i < times_.size(); ++i) times_[i] = step.t + fractions_[i] * step.h;
  };
  for (const Function& each : functions_) {
    place_samples(step, each.level, &each.function);
    make_times();
    values_.resize(times_.size());
    each.function.sample(times_, values_.data());
    judge(step, place, each.points, each.level, each.scale, values_.data(), each.name, &report);
  }
  for (const Program& each : programs_) {
    report.is_of_time_alone = report.is_of_time_alone && each.is_of_time_alone;
    if (each.as == Program::As::SomeCoordinates && place.q == nullptr) continue;
    const Level level = each.is_force() ? Level::Acceleration : Level::Position;
    place_samples(step, level, nullptr);
    make_times();
    const double scale = each.scale / run(each, place);
    for (std::size_t m = 0; m < each.num_values(); ++m)
      judge(step, place, each.points, level, scale, values_.data() + m * times_.size(), each.name, &report);
  }
  return report;
}

/// Chebyshev points (1 - cos(pi j/N))/2, then the middles of pieces: equal ones, cut at the knots of tables.
void Drives::place_samples(const DrivenStep& step, Level level, const ScalarFunction* function) {
  const std::size_t num_nodes = static_cast<std::size_t>(step.degree) + 1 + static_cast<std::size_t>(level);
  const double wanted =
      std::clamp(std::ceil(step.h / step.spacing), static_cast<double>(num_nodes), static_cast<double>(most_samples));
  const auto num_equal = static_cast<std::size_t>(wanted);
  knots_.clear();
  if (function != nullptr) function->append_knots(step.t, step.t + step.h, &knots_);
  if (has_equal_pieces_ && knots_.empty() && num_nodes == num_nodes_ && num_equal == num_samples_) return;

  if (num_nodes != num_nodes_) {
    cosines_.resize(2 * (num_nodes - 1));
    for (std::size_t j = 0; j < cosines_.size(); ++j)
      cosines_[j] = std::cos(std::numbers::pi * static_cast<double>(j) / static_cast<double>(num_nodes - 1));
  }
  num_nodes_ = num_nodes;
  has_equal_pieces_ = knots_.empty();
  num_samples_ = num_equal + knots_.size();
  fractions_.resize(num_nodes_);
  for (std::size_t j = 0; j < num_nodes_; ++j) fractions_[j] = 0.5 * (1.0 - cosines_[j]);
  widths_.clear();
  std::size_t knot = 0;
  double begin = 0.0;
  for (std::size_t i = 1; i <= num_equal; ++i) {
    const double end = static_cast<double>(i) / wanted;
    const auto close_piece = [&](double at) {
      fractions_.push_back(0.5 * (begin + at));
      widths_.push_back(at - begin);
      begin = at;
    };
    for (; knot < knots_.size(); ++knot) {
      const double at = (knots_[knot] - step.t) / step.h;
      if (!(at < end)) break;
      close_piece(std::max(at, begin));
    }
    close_piece(end);
  }
  num_samples_ = widths_.size();
  choose_weights();
}

/// e at the samples, by Clenshaw's scheme for all of them side by side:
///
///   p(x) = sum c_k T_k(x),   b_k = c_k + 2 x b_{k+1} - b_{k+2},   p = c_0 + x b_1 - b_2,   x = 1 - 2 s
void Drives::deviate(const double* values) {
  if (weights_ != nullptr) return deviate_by_weights(values);
  const std::size_t degree = num_nodes_ - 1;
  chebyshev_.assign(num_nodes_, 0.0);
  for (std::size_t k = 0; k < num_nodes_; ++k) {
    // c_k = 2/N sum'' f_j cos(pi j k/N), the first and the last ones halved
    double sum = 0.0;
    for (std::size_t j = 0; j < num_nodes_; ++j) {
      const double weight = j == 0 || j == degree ? 0.5 : 1.0;
      sum += weight * values[j] * cosines_[j * k % (2 * degree)];
    }
    chebyshev_[k] = (k == 0 || k == degree ? 1.0 : 2.0) / static_cast<double>(degree) * sum;
  }
  next_.assign(num_samples_, 0.0);
  after_next_.assign(num_samples_, 0.0);
  missed_.resize(num_samples_);
  const double* const s = fractions_.data() + num_nodes_;
  for (std::size_t k = degree; k >= 1; --k) {
    for (std::size_t i = 0; i < num_samples_; ++i) {
      const double b = chebyshev_[k] + 2.0 * (1.0 - 2.0 * s[i]) * next_[i] - after_next_[i];
      after_next_[i] = next_[i];
      next_[i] = b;
    }
  }
  for (std::size_t i = 0; i < num_samples_; ++i)
    missed_[i] = values[num_nodes_ + i] - (chebyshev_[0] + (1.0 - 2.0 * s[i]) * next_[i] - after_next_[i]);
}

/// The same for the samples of most looks, which are the same ones:
///
///   p(s) = sum_j w_j(s) f_j
void Drives::deviate_by_weights(const double* values) {
  missed_.resize(num_samples_);
  const double* weight = weights_->data();
  for (std::size_t i = 0; i < num_samples_; ++i) {
    double p = 0.0;
    for (std::size_t j = 0; j < num_nodes_; ++j) p += *weight++ * values[j];
    missed_[i] = values[num_nodes_ + i] - p;
  }
}

void Drives::choose_weights() {
  weights_ = nullptr;
  if (!has_equal_pieces_ || num_samples_ != num_nodes_) return;
  if (all_weights_.size() <= num_nodes_) all_weights_.resize(num_nodes_ + 1);
  std::vector<double>& weights = all_weights_[num_nodes_];
  if (weights.empty()) {
    // Of each node what it adds to p at the samples: there it is all that deviates.
    std::vector<double> values(2 * num_nodes_, 0.0);
    weights.resize(num_nodes_ * num_nodes_);
    for (std::size_t j = 0; j < num_nodes_; ++j) {
      values[j] = 1.0;
      deviate(values.data());
      values[j] = 0.0;
      for (std::size_t i = 0; i < num_nodes_; ++i) weights[i * num_nodes_ + j] = -missed_[i];
    }
  }
  weights_ = &weights;
}

/// Values are known to the rounding of their times.
void Drives::silence_rounding(const DrivenStep& step, const double* samples, double largest) {
  double slope = 0.0;
  for (std::size_t i = 1; i < num_samples_; ++i) {
    const double distance = 0.5 * (widths_[i - 1] + widths_[i]) * step.h;
    if (distance > 0.0) slope = std::max(slope, std::abs(samples[i] - samples[i - 1]) / distance);
  }
  const double noise = 64.0 * std::numeric_limits<double>::epsilon() * (largest + slope * std::abs(step.t));
  for (double& missed : missed_) missed = std::abs(missed) > noise ? missed : 0.0;
}

/// What the step misses of x and v, and what the function does in it.
Drives::Misses Drives::measure_misses(const DrivenStep& step, Level level, const double* samples, double range) const {
  Misses result;
  double once = 0.0, twice = 0.0;  // integrals of e from the step's beginning
  for (std::size_t i = 0; i < num_samples_; ++i) {
    const double width = widths_[i] * step.h;
    once += width * missed_[i];
    twice += width * once;
    if (level == Level::Acceleration) {
      result.v = std::max(result.v, std::abs(once));
      result.x = std::max(result.x, std::abs(twice));
      result.v_done += width * std::abs(samples[i]);
    } else if (level == Level::Velocity) {
      result.x = std::max(result.x, std::abs(once));
    } else {
      result.x = std::max(result.x, std::abs(missed_[i]));
    }
  }
  if (level == Level::Acceleration) result.x_done = result.v_done * step.h;
  if (level == Level::Velocity) result.x_done = range * step.h;
  if (level == Level::Position) result.x_done = range;
  return result;
}

/// Pieces between which straight lines follow the function to a hundredth of what varies: between p + 1 places such a
/// line errs by |g''| (h/p)^2/8.
int Drives::count_pieces(Level level, const double* samples, double range, double largest) const {
  constexpr double straight = 0.01;
  const double* const s = fractions_.data() + num_nodes_;
  double bend = 0.0;
  for (std::size_t i = 1; i + 1 < num_samples_; ++i) {
    const double before = s[i] - s[i - 1], after = s[i + 1] - s[i];
    if (!(before > 0.0 && after > 0.0)) continue;
    const double slope_before = (samples[i] - samples[i - 1]) / before,
                 slope_after = (samples[i + 1] - samples[i]) / after;
    bend = std::max(bend, std::abs(slope_after - slope_before) * 2.0 / (before + after));
  }
  // What holds a contact on something that moves goes by the second derivative, which bends faster.
  const double factor = level == Level::Acceleration ? 1.0 : 2.0;
  const double pieces = factor * std::sqrt(bend / 8.0 / (straight * (range + straight * largest)));
  return static_cast<int>(std::min<double>(std::ceil(pieces), DriveReport::most_pieces));
}

void Drives::judge(const DrivenStep& step, const Place& place, std::span<const Index> points, Level level, double scale,
                   const double* values, std::size_t name, DriveReport* report) {
  deviate(values);
  const double* const samples = values + num_nodes_;
  const auto [least, most] = std::minmax_element(values, values + num_nodes_ + num_samples_);
  const double range = *most - *least, largest = std::max(std::abs(*most), std::abs(*least));
  if (!(range > 0.0) || !std::isfinite(range)) return;
  silence_rounding(step, samples, largest);
  const Misses missed = measure_misses(step, level, samples, range);

  // Of the point that may miss least.
  double v_allowed = std::numeric_limits<double>::infinity(), x_allowed = v_allowed;
  for (const Index point : points) {
    const auto p = static_cast<std::size_t>(point);
    v_allowed = std::min(v_allowed, place.scales.velocity_tolerance(step.atol, p) + step.rtol * norm(load(place.v, p)));
    x_allowed = std::min(x_allowed, place.scales.position_tolerance(step.atol, p) + step.rtol * norm(load(place.r, p)));
  }
  v_allowed += step.rtol * scale * missed.v_done;
  x_allowed += step.rtol * scale * missed.x_done;
  const double error = scale * std::max(missed.v / v_allowed, missed.x / x_allowed);
  if (error > report->error) {
    report->error = error;
    report->drive = name;
  }

  // Of what is a matter of velocities, a fifth and more.
  constexpr double unseen = 0.2;
  const bool is_acceleration = level == Level::Acceleration;
  if (is_acceleration ? missed.v > unseen * missed.v_done : missed.x > unseen * missed.x_done) {
    const double velocity = scale * (is_acceleration ? missed.v : missed.x / step.h);
    report->velocity = std::max(report->velocity, velocity);
  }
  if (scale * (is_acceleration ? missed.v_done : missed.x_done) > (is_acceleration ? v_allowed : x_allowed))
    report->pieces = std::max(report->pieces, count_pieces(level, samples, range, largest));
}

}  // namespace tanor
