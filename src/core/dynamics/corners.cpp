#include "dynamics/corners.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/numbers.hpp"
#include "base/text.hpp"
#include "system/formula_names.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

constexpr double least_rate = 1e-12;      // of a rate over the sum of its terms; what is below is rounding
constexpr double least_response = 1e-16;  // of g'e over g'M^-1 g; constraints hold what g moves if less is left
constexpr double visible = 1e-6;          // relative difference of two sides that is more than rounding

double scalar_product(std::span<const double> a, const double* b) {
  return std::inner_product(a.begin(), a.end(), b, 0.0);
}
double largest_magnitude(std::span<const double> x) {
  double most = 0.0;
  for (const double each : x) most = larger(most, std::abs(each));
  return most;
}

}  // namespace

// ---- the terms of a system ----

void GuideCorners::add_formula(const Expression& expression, std::string name, std::vector<std::string> variables,
                               std::vector<std::size_t> numbers) {
  Formula added{CornerTerms(expression), std::move(name), std::move(variables), std::move(numbers)};
  if (added.terms.empty() || added.numbers.empty()) return;
  num_terms_ += added.num_members() * added.terms.size();
  formulas_.push_back(std::move(added));
}

void GuideCorners::add_supports() {
  for (const Support& support : model_.system.supports)
    for (const ScalarFunction& component : support.displacement.components) add_function(component);
}

GuideCorners::Place GuideCorners::find(std::size_t term) const {
  auto formula = formulas_.begin();
  for (; term >= formula->num_members() * formula->terms.size(); ++formula)
    term -= formula->num_members() * formula->terms.size();
  return {&*formula, term / formula->terms.size(), term % formula->terms.size()};
}

std::string GuideCorners::name_term(std::size_t term) const {
  const auto [formula, member, own] = find(term);
  const std::string number = formula->num_members() > 1 ? "[" + text(member) + "]" : "";
  return formula->terms.name(own, formula->variables) + " in " + formula->name + number;
}

/// Returns the variables of a member, the time last.
std::vector<double> GuideCorners::load(const Formula& formula, std::size_t member, const Kinematics& at) const {
  const std::size_t count = formula.num_numbers();
  std::vector<double> variables(count + 1, at.t);
  for (std::size_t i = 0; i < count; ++i) variables[i] = at.x[formula.numbers[member * count + i]];
  return variables;
}

void GuideCorners::evaluate_terms(const Kinematics& at, double* arguments) {
  for (const Formula& formula : formulas_) {
    for (std::size_t member = 0; member < formula.num_members(); ++member) {
      formula.terms.evaluate(load(formula, member, at).data(), arguments);
      arguments += formula.terms.size();
    }
  }
}

void GuideCorners::append_instants(double begin, double end, std::vector<double>* instants) {
  constexpr double alike = 1e-9;
  std::vector<double> knots;
  for (const ScalarFunction& function : functions_) {
    knots.clear();
    function.append_knots(begin, end, &knots);
    for (const double t : knots) {
      const double next = std::nextafter(t, std::numeric_limits<double>::infinity());
      const double one = function(t).derivative(1), other = function(next).derivative(1);
      const double size = std::max(std::abs(one), std::abs(other));
      if (!(std::abs(other - one) <= alike * size) || std::isinf(size)) instants->push_back(t);
    }
  }
}

GuideCorners::Edge GuideCorners::make_edge(std::size_t term, const Kinematics& at) const {
  const auto [formula, member, own] = find(term);
  const std::size_t count = formula->num_numbers();
  std::vector<double> gradient(count + 1);
  formula->terms.differentiate(own, load(*formula, member, at).data(), gradient.data());
  Edge edge;
  edge.term = term;
  edge.u_t = gradient.back();
  edge.g.assign(size(), 0.0);
  for (std::size_t i = 0; i < count; ++i) edge.g[formula->numbers[member * count + i]] += gradient[i];
  return edge;
}

Outcome GuideCorners::refuse(std::size_t term, double t, const std::string& why) const {
  return {Status::Singular, "the corner of " + name_term(term) + " at t = " + text(t) + ": " + why};
}

// ---- a crossing ----

namespace {

/// The rate c = g'v + u_t, and what rounding leaves of it.
struct Rate {
  double value, scale;

  Rate(std::span<const double> g, const double* v, double u_t) : value(u_t), scale(std::abs(u_t)) {
    for (std::size_t i = 0; i < g.size(); ++i) {
      value += g[i] * v[i];
      scale += std::abs(g[i] * v[i]);
    }
  }
  bool is_zero() const { return !(std::abs(value) > least_rate * scale); }
};

/// Returns true if e/|e| is the same on both sides, so that there is no corner.
bool are_alike(std::span<const double> g, const std::vector<double>& before, const std::vector<double>& after) {
  const double one = 1.0 / std::sqrt(scalar_product(g, before.data())),
               other = 1.0 / std::sqrt(scalar_product(g, after.data()));
  double most = 0.0, differ = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    most = larger(most, std::abs(one * before[i]));
    differ = larger(differ, std::abs(one * before[i] - other * after[i]));
  }
  return differ <= visible * most;
}

}  // namespace

/// Sorts `which` into edges that the constraints let the motion pass, each once, and those whose g they hold.
Outcome GuideCorners::find_edges(const Kinematics& before, const Kinematics& after, std::span<const std::size_t> which,
                                 std::vector<Edge>* edges, std::vector<Edge>* held) {
  constexpr double same = 1e-10;
  std::vector<Edge> all;
  for (const std::size_t term : which) all.push_back(make_edge(term, before));
  if (all.empty()) return {};
  if (Outcome found = respond(before, all, &Edge::before); !found.ok()) return found;
  if (Outcome found = respond(after, all, &Edge::after); !found.ok()) return found;
  for (Edge& edge : all) {
    const double from = scalar_product(edge.g, edge.before.data()), to = scalar_product(edge.g, edge.after.data());
    if (!std::isfinite(from + to))
      return refuse(edge.term, before.t, "its gradient is not finite, and no rounding tells where the motion goes on");
    if (!(std::min(from, to) > least_response * edge.free)) {
      held->push_back(std::move(edge));
      continue;
    }
    const auto known = std::ranges::find_if(*edges, [&](const Edge& other) {
      const double both = scalar_product(other.g, edge.before.data()),
                   own = scalar_product(other.g, other.before.data());
      return both * both >= (1.0 - same) * from * own;
    });
    if (known == edges->end())
      edges->push_back(std::move(edge));
    else if (Outcome passes = check_order(before, after, *known, edge); !passes.ok())
      return passes;
  }
  return check_apart(before.t, *edges);
}

/// Checks that the arguments of terms that constraints hold go on as functions of time, and not back as at a cusp.
Outcome GuideCorners::check_held(double t, const std::vector<Edge>& held, const double* v_before,
                                 const double* v) const {
  for (const Edge& edge : held) {
    const Rate one(edge.g, v_before, edge.u_t), other(edge.g, v, edge.u_t);
    if (!one.is_zero() && !(one.value * other.value > 0.0))
      return refuse(edge.term, t, "the other side has no way on, as at a cusp");
  }
  return {};
}

/// Several edges may be met at once if none moves what another one moves. Otherwise their order, which rounding
/// decides, would matter.
Outcome GuideCorners::check_apart(double t, const std::vector<Edge>& edges) const {
  constexpr double nothing = 1e-9;
  for (std::size_t j = 1; j < edges.size(); ++j) {
    for (std::size_t k = 0; k < j; ++k) {
      for (std::vector<double> Edge::*e : {&Edge::before, &Edge::after}) {
        const std::vector<double>&one = edges[j].*e, &other = edges[k].*e;
        const double least = nothing * largest_magnitude(one), least_other = nothing * largest_magnitude(other);
        for (std::size_t i = 0; i < one.size(); ++i) {
          if (std::abs(one[i]) > least && std::abs(other[i]) > least_other)
            return refuse(edges[j].term, t,
                          "that of " + name_term(edges[k].term) +
                              " is met at once, and where the motion goes on depends on their order");
        }
      }
    }
  }
  return {};
}

/// On a way without branches, as on a wire, edges may be met at once if the motion that has passed one of them,
/// whichever it is, passes the other one, too. The branches between are looked at beside the corner.
Outcome GuideCorners::check_order(const Kinematics& before, const Kinematics& after, const Edge& one,
                                  const Edge& other) {
  constexpr double parallel = 1e-10, beside = 1e-9;
  const double a = scalar_product(one.g, one.g.data()), b = scalar_product(one.g, other.g.data()),
               c = scalar_product(other.g, other.g.data()), det = a * c - b * b;
  if (det <= parallel * a * c) return {};  // the same edge twice
  const Outcome refused =
      refuse(other.term, before.t,
             "that of " + name_term(one.term) + " is met at once, and where the motion goes on depends on their order");
  const double goes = scalar_product(other.g, one.before.data());
  const double distance = beside * (largest_magnitude({after.x, size()}) + model_.smallest_length);
  std::vector<double> from(num_terms_), to(num_terms_), here(num_terms_), x(size());
  evaluate_terms(before, from.data());
  evaluate_terms(after, to.data());
  for (const bool passes_one : {true, false}) {
    const std::vector<double>&first = passes_one ? to : from, &second = passes_one ? from : to;
    // u of both at the place x + p g + q h
    const double u = std::copysign(distance * std::sqrt(a), first[one.term]),
                 w = std::copysign(distance * std::sqrt(c), second[other.term]);
    const double p = (c * u - b * w) / det, q = (a * w - b * u) / det;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = after.x[i] + p * one.g[i] + q * other.g[i];
    const Kinematics at{after.t, x.data(), after.v};
    evaluate_terms(at, here.data());
    if ((here[one.term] < 0.0) != (u < 0.0) || (here[other.term] < 0.0) != (w < 0.0)) return refused;
    std::vector<Edge> between{one};
    if (Outcome found = respond(at, between, &Edge::before); !found.ok()) return found;
    if (!(goes * scalar_product(other.g, between[0].before.data()) > 0.0)) return refused;
  }
  return {};
}

/// v += c (e+/sqrt(g'e g'e+) - e/(g'e))
Outcome GuideCorners::turn(const Edge& edge, double t, const double* v_before, double* v) const {
  const Rate rate(edge.g, v_before, edge.u_t);
  if (rate.is_zero()) {
    if (are_alike(edge.g, edge.before, edge.after)) return {};
    return refuse(edge.term, t,
                  "it is met without speed across it, so that rounding would tell where the motion goes on");
  }
  const double from = scalar_product(edge.g, edge.before.data()), to = scalar_product(edge.g, edge.after.data());
  const double whole = rate.value / from, turned = rate.value / std::sqrt(from * to);
  for (std::size_t i = 0; i < edge.g.size(); ++i) v[i] += turned * edge.after[i] - whole * edge.before[i];
  return {};
}

/// Checks that what edges have turned is a velocity on the other side, which the projection to v has left as it was.
Outcome GuideCorners::check_others(double t, const std::vector<Edge>& edges, std::span<const double> turned,
                                   const double* v) const {
  for (const Edge& edge : edges) {
    const double most = largest_magnitude(edge.after);
    double speed = 0.0, moved = 0.0;
    for (std::size_t i = 0; i < turned.size(); ++i) {
      if (!(std::abs(edge.after[i]) > least_rate * most)) continue;
      speed = larger(speed, std::abs(turned[i]));
      moved = larger(moved, std::abs(v[i] - turned[i]));
    }
    if (!(moved <= visible * speed))
      return refuse(edge.term, t, "another corner is met at once, and where the motion goes on depends on their order");
  }
  return {};
}

/// Checks that no function of time has a cusp, at which its rate grows without bound.
Outcome GuideCorners::check_rates(double t) const {
  constexpr double near = 8.0 * eps, beside = 1e-9, grows = 3.0;
  const double size = std::max(1.0, std::abs(t));
  std::vector<double> knots;
  for (const ScalarFunction& function : functions_) {
    knots.clear();
    function.append_knots(t - beside * size, t + beside * size, &knots);
    if (knots.empty() || std::isfinite(function.smooth_until(t - beside * size))) continue;  // a table is smooth
    for (const double side : {-size, size}) {
      const double rate = std::abs(function(t + near * side).derivative(1));
      if (rate <= grows * std::abs(function(t + beside * side).derivative(1))) continue;
      return {Status::Singular, "the corner of a function of time at t = " + text(t) + " is a cusp"};
    }
  }
  return {};
}

Outcome GuideCorners::cross(const Kinematics& before, const Kinematics& after, std::span<const std::size_t> which,
                            double* v, Power* work) {
  if (const double missed = gap(before, after); !(missed <= visible)) {
    const std::string what = "the two sides do not meet, they are " + text(missed) + " of a length apart";
    if (!which.empty()) return refuse(which.front(), before.t, what);
    return {Status::Singular, "a function of time jumps at t = " + text(before.t) + ": " + what};
  }
  if (which.empty())
    if (Outcome found = check_rates(before.t); !found.ok()) return found;
  std::vector<Edge> edges, held;
  if (Outcome found = find_edges(before, after, which, &edges, &held); !found.ok()) return found;
  const std::vector<double> given(before.v, before.v + size());
  std::copy(given.begin(), given.end(), v);
  for (const Edge& edge : edges) {
    if (Outcome found = turn(edge, before.t, given.data(), v); !found.ok()) return found;
  }
  const std::vector<double> turned(v, v + size());
  if (Outcome found = project(before, after, !edges.empty(), v); !found.ok()) return found;
  if (Outcome found = check_others(before.t, edges, turned, v); !found.ok()) return found;
  if (Outcome found = check_held(before.t, held, given.data(), v); !found.ok()) return found;
  *work = {};
  if (model_.is_rheonomic())
    work->supports = kinetic_energy({after.t, after.x, v}) - kinetic_energy({before.t, before.x, given.data()});
  if (!model_.has_friction()) return {};
  double changed = 0.0;
  for (std::size_t i = 0; i < size(); ++i) changed = larger(changed, std::abs(v[i] - given[i]));
  if (changed <= visible * largest_magnitude(given)) return {};
  return {Status::Singular, "a corner at t = " + text(before.t) +
                                " is met with friction, whose loss there depends on how the corner is rounded"};
}

/// Looks at e on both sides, at places that differ by rounding along e.
Outcome GuideCorners::check_standing(const Kinematics& at, std::size_t term) {
  std::vector<Edge> edge{make_edge(term, at)};
  if (!Rate(edge[0].g, at.v, edge[0].u_t).is_zero()) return {};
  if (Outcome found = respond(at, edge, &Edge::before); !found.ok()) return found;
  const std::vector<double> along = edge[0].before;
  const double slope = scalar_product(edge[0].g, along.data());
  if (!(slope > least_response * edge[0].free)) return {};
  double size_of_terms = std::numeric_limits<double>::min();
  for (std::size_t i = 0; i < size(); ++i)
    size_of_terms = std::max({size_of_terms, std::abs(edge[0].g[i] * at.x[i]), eps * std::abs(edge[0].g[i])});
  std::vector<double> arguments(num_terms_), low(size()), high(size());
  const auto is_negative = [&](double s, std::vector<double>* x) {
    for (std::size_t i = 0; i < size(); ++i) (*x)[i] = at.x[i] + s * along[i];
    evaluate_terms({at.t, x->data(), at.v}, arguments.data());
    return arguments[term] < 0.0;
  };
  constexpr int most_tries = 12;
  double distance = 8.0 * eps * size_of_terms / slope;
  for (int k = 0; k < most_tries; ++k, distance *= 8.0) {
    if (is_negative(-distance, &low) == is_negative(distance, &high)) continue;
    if (Outcome found = respond({at.t, low.data(), at.v}, edge, &Edge::before); !found.ok()) return found;
    if (Outcome found = respond({at.t, high.data(), at.v}, edge, &Edge::after); !found.ok()) return found;
    if (are_alike(edge[0].g, edge[0].before, edge[0].after)) return {};
    return refuse(term, at.t, "the motion stands in it or follows its edge, where no side of it holds");
  }
  return {};
}

// ---- points ----

template <class Group>
void GuideCorners::add_functions(const Group& group) {
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    const Value& value = group.*field.value;
    if constexpr (std::is_same_v<Value, VectorFunction>)
      for (const ScalarFunction& component : value.components) add_function(component);
    if constexpr (std::is_same_v<Value, Parameter>)
      for (const ScalarFunction& function : value.functions) add_function(function);
  });
}

PointCorners::PointCorners(Workspace& work, Linearization& linearization, Projector& projector)
    : GuideCorners(work), linearization_(linearization), projector_(projector) {
  add_supports();
  const System& system = model_.system;
  const Index first_outside = find_first_outside(system);
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    std::visit([&](const auto& group) { add_functions(group); }, system.constraints[k]);
    const auto* const group = std::get_if<UserConstraints>(&system.constraints[k]);
    if (group == nullptr || group->kernel.expression == nullptr) continue;
    std::vector<std::size_t> numbers;
    for (const auto& tuple : group->tuples) {
      for (const Index point : tuple) {
        if (point >= first_outside) continue;
        const auto inner = static_cast<std::size_t>(model_.numbering.inner_point[static_cast<std::size_t>(point)]);
        for (std::size_t c = 0; c < 3; ++c) numbers.push_back(3 * inner + c);
      }
    }
    std::vector<std::string> variables = name_coordinates(group->kernel.num_points);
    variables.emplace_back("t");
    add_formula(*group->kernel.expression, constraint_name(system, k), std::move(variables), std::move(numbers));
  }
}

void PointCorners::choose_sides(double t, double* r, const double* v) {
  constexpr int most_tries = 12;
  constexpr double clearly = 1e-3;
  std::vector<double> arguments(num_terms()), ahead(num_terms()), moved(r, r + size());
  const std::span<const double> given(r, size()), rates(v, size());
  const double fastest = largest_magnitude(rates);
  evaluate_terms({t, r, v}, arguments.data());
  if (std::ranges::count(arguments, 0.0) == 0 || fastest == 0.0) return;
  const double before = work_.velocity_violation(t, r, v);
  double s = eps * std::max(largest_magnitude(given), model_.smallest_length) / fastest;
  for (int k = 0; k < most_tries; ++k, s *= 4.0) {
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = r[i] + s * v[i];
    evaluate_terms({t, moved.data(), v}, ahead.data());
    bool has_left = true;
    for (std::size_t j = 0; j < ahead.size(); ++j) has_left = has_left && (arguments[j] != 0.0 || ahead[j] != 0.0);
    if (!has_left) continue;
    if (work_.velocity_violation(t, moved.data(), v) < clearly * before) std::ranges::copy(moved, r);
    return;
  }
}

/// e = P M^-1 g = M^-1 g - M^-1 K S^-1 K'M^-1 g
Outcome PointCorners::respond(const Kinematics& at, std::span<Edge> edges, std::vector<double> Edge::*e) {
  if (Outcome found = linearization_.update(at.t, at.x); !found.ok()) return found;
  std::vector<double> rows(model_.num_rows()), lambda(model_.num_rows()), taken(size());
  for (Edge& edge : edges) {
    std::vector<double>& response = edge.*e;
    response = edge.g;
    for (std::size_t i = 0; i < size(); ++i) response[i] *= model_.inverse_mass[i / 3];
    edge.free = scalar_product(edge.g, response.data());
    if (rows.empty()) continue;
    linearization_.apply_transposed(response.data(), nullptr, rows.data());
    linearization_.solve_refined(rows.data(), lambda.data(), taken.data());
    model_.add_to_moving(taken.data(), response.data());
  }
  return {};
}

Outcome PointCorners::project(const Kinematics&, const Kinematics& after, bool, double* v) {
  if (Outcome found = linearization_.update(after.t, after.x); !found.ok()) return found;
  std::vector<double> r(after.x, after.x + size());
  work_.prescribe(after.t, r.data(), v);
  return projector_.project_velocities(after.t, r.data(), v).outcome;
}

double PointCorners::gap(const Kinematics& before, const Kinematics& after) {
  return work_.position_violation(after.t, after.x) - work_.position_violation(before.t, before.x);
}

double PointCorners::kinetic_energy(const Kinematics& at) {
  return 0.5 * model_.power(at.v, at.v);
}

// ---- coordinates ----

TangentCorners::TangentCorners(Workspace& work, TangentLinearization& linearization)
    : GuideCorners(work), linearization_(linearization) {
  add_supports();
  for (const Coordinates& coordinates : model_.system.coordinates)
    std::visit([&](const auto& group) { add_functions(group); }, coordinates);
  // The numbers of the coordinates in the order of the user, at their places in the inner order.
  std::vector<double> users(size()), inner(size());
  std::iota(users.begin(), users.end(), 0.0);
  work_.coordinates.gather(users.data(), inner.data());
  std::vector<std::size_t> place(size());
  for (std::size_t j = 0; j < size(); ++j) place[static_cast<std::size_t>(inner[j])] = j;
  const System& system = model_.system;
  for (std::size_t k = 0, first = 0; k < system.coordinates.size(); ++k) {
    const auto* const group = std::get_if<UserCoordinates>(&system.coordinates[k]);
    const std::size_t count =
        std::visit([](const auto& each) { return num_coordinates_of(each); }, system.coordinates[k]);
    if (group != nullptr && group->kernel.expression != nullptr) {
      const auto begin = place.begin() + static_cast<std::ptrdiff_t>(first);
      std::vector<std::string> variables;
      for (int j = 0; j < group->kernel.num_coordinates; ++j) variables.push_back("coordinate " + text(j));
      variables.emplace_back("t");
      add_formula(*group->kernel.expression, coordinates_name(system, k), std::move(variables),
                  {begin, begin + static_cast<std::ptrdiff_t>(count)});
    }
    first += count;
  }
}

/// e = H^-1 g, and A e behind it, which shows corners across which H does not jump.
Outcome TangentCorners::respond(const Kinematics& at, std::span<Edge> edges, std::vector<double> Edge::*e) {
  linearization_.evaluate(at.t, at.x, at.v, true);
  if (Outcome found = linearization_.factorize(at.t); !found.ok()) return found;
  for (Edge& edge : edges) {
    std::vector<double>& response = edge.*e;
    response = edge.g;
    linearization_.solve_negative(response.data());
    for (double& each : response) each = -each;
    edge.free = scalar_product(edge.g, response.data());
    std::vector<double> points(3 * model_.num_points(), 0.0);
    linearization_.apply(response.data(), points.data());
    response.insert(response.end(), points.begin(), points.end());
  }
  return {};
}

Outcome TangentCorners::project(const Kinematics& before, const Kinematics& after, bool is_turned, double* v) {
  if (is_turned) return {};
  linearization_.evaluate(before.t, before.x, before.v, false);
  const std::vector<double> of_points = linearization_.v();
  return linearization_.find_rates(after.t, of_points.data(), after.x, v);
}

double TangentCorners::gap(const Kinematics& before, const Kinematics& after) {
  linearization_.evaluate(before.t, before.x, before.v, false);
  const std::vector<double> r = linearization_.r();
  linearization_.evaluate(after.t, after.x, before.v, false);
  return model_.largest_move(r.data(), linearization_.r().data()) / model_.scene_size;
}

double TangentCorners::kinetic_energy(const Kinematics& at) {
  linearization_.evaluate(at.t, at.x, at.v, false);
  return 0.5 * model_.power(linearization_.v().data(), linearization_.v().data());
}

}  // namespace tanor::detail
