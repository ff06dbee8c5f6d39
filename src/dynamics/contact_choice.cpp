#include "dynamics/contact_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "dynamics/normal_form.hpp"

/// \file Which contacts at rest stick and which begin to slide: islands of contacts as small dense problems, whose
/// motions are counted (docs/friction.md).
namespace tanor {

namespace {

/// Accelerations over their scale: less is rest.
constexpr double rounding_of_accelerations = 1e-9;

/// All digits but those of rounding; `scale`: the size of what cancels in it.
std::string text(const Vec3& a, double scale) {
  const auto digits = [scale](double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.13g", std::abs(x) > 1e-13 * scale ? x : 0.0);
    return std::string(buffer);
  };
  return "(" + digits(a.x) + ", " + digits(a.y) + ", " + digits(a.z) + ")";
}

}  // namespace

/// Islands with Coulomb's friction among those that are `wanted` [island]: their contacts, and what they held so far.
std::vector<ContactChoice> NormalForm::list_choices(const std::vector<char>& at_rest, const std::vector<char>& wanted,
                                                    std::size_t most_contacts) const {
  const Tangents& tangents = model_.constraints.tangents();
  const FrictionLaws& laws = friction_->laws();
  std::vector<ContactChoice> result;
  for (std::size_t island = 0; island < friction_->islands().size(); ++island) {
    if (wanted[island] == 0) continue;
    ContactChoice choice;
    choice.island = island;
    std::vector<double> before;
    for (const std::size_t c : friction_->islands().contacts[island]) {
      if (!laws.is_coulomb(c)) continue;
      const bool moves = at_rest[c] == 0;
      const Eigen::Index dimension = moves ? 1 : tangents[c].num_tangents();
      choice.problem.contacts.push_back(
          {static_cast<Eigen::Index>(before.size()), dimension, moves, moves ? laws.coefficient(c) : 0.0});
      choice.members.push_back(c);
      const Vec3 tau = friction_->force(c, lambda_.data());
      for (Eigen::Index k = 0; k < dimension; ++k) {
        const Vec3 e =
            moves ? laws.part_direction(laws.first_part(c)) : tangents.directions(c)[static_cast<std::size_t>(k)];
        choice.directions.push_back(e);
        before.push_back(dot(tau, e));
      }
    }
    if (choice.members.empty() || choice.size() > most_contacts) continue;
    choice.before = Eigen::Map<const Eigen::VectorXd>(before.data(), static_cast<Eigen::Index>(before.size()));
    result.push_back(std::move(choice));
  }
  return result;
}

/// How reactions and accelerations answer to friction: one solve for the first component of every island at once, one
/// for the second, …, with the factor of S in which no contact sticks.
void NormalForm::reduce(double t, const double* r, const double* v, std::vector<ContactChoice>* choices) {
  const Tangents& tangents = model_.constraints.tangents();
  std::vector<double> w(size()), dw(size()), b(num_rows()), lambda(num_rows()), dlambda(num_rows());
  const auto solve = [&](const std::vector<double>& right, std::vector<double>* multipliers) {
    respond(right.data(), multipliers->data(), dw.data());
    share_out(multipliers->data());
  };
  const auto write_forces = [&](const ContactChoice& choice, const std::vector<double>& from, auto&& column) {
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const Vec3 N = friction_->laws().normal_force(choice.members[c], from.data());
      column.template segment<3>(3 * static_cast<Eigen::Index>(c)) << N.x, N.y, N.z;
    }
  };
  const auto write_accelerations = [&](const ContactChoice& choice, const std::vector<double>& from, auto&& column) {
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const Vec3 a = load(from.data(), tangents[choice.members[c]].point);
      column.template segment<3>(3 * static_cast<Eigen::Index>(c)) << a.x, a.y, a.z;
    }
  };

  // Without Coulomb's friction.
  double scale = model_.evaluate_free(t, r, v, w.data());
  scale = larger(scale,
                 model_.constraints.evaluate_right_side(model_.parallel, r, v, w.data(), right_side_.data(), nullptr));
  w0_ = w.data();
  knows_accelerations_ = false;
  measure_accelerations(scale);
  b = right_side_;
  for (ContactChoice& choice : *choices) {
    choice.acceleration_scale = 0.0;
    for (const std::size_t contact : choice.members)
      choice.acceleration_scale = std::max(choice.acceleration_scale, acceleration_at(contact));
  }
  friction_->set_given({t, r, v, blocks_.data()}, lambda_.data());
  friction_->add(1.0, w.data(), b.data());
  solve(b, &lambda);
  for (std::size_t i = 0; i < w.size(); ++i) w[i] += dw[i];
  model_.constraints.evaluate_contacts(model_.parallel, r, v, w.data(), Tangents::Which::All, contact_rows_.data());
  std::size_t most = 0;
  for (ContactChoice& choice : *choices) {
    const auto m = 3 * static_cast<Eigen::Index>(choice.size()),
               k = static_cast<Eigen::Index>(choice.directions.size());
    most = std::max(most, choice.directions.size());
    ContactProblem& problem = choice.problem;
    problem.A.setZero(k, k);
    problem.W.setZero(m, k);
    problem.a0.setZero(k);
    problem.N0.setZero(m);
    choice.P.setZero(m, k);
    choice.P0.setZero(m);
    write_forces(choice, lambda, problem.N0);
    write_accelerations(choice, w, choice.P0);
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& contact = problem.contacts[c];
      const Tangents::Place& place = tangents[choice.members[c]];
      for (Eigen::Index i = 0; i < contact.dimension; ++i) {
        const auto row = contact.first + i;
        const double a = contact.moves
                             ? dot(choice.directions[static_cast<std::size_t>(row)], load(w.data(), place.point))
                             : contact_rows_[static_cast<std::size_t>(place.first_row + i)];
        problem.a0(row) = std::abs(a) > 1e-12 * choice.acceleration_scale ? a : 0.0;
      }
    }
  }
  // One newton along each component.
  for (std::size_t j = 0; j < most; ++j) {
    std::fill(b.begin(), b.end(), 0.0);
    std::vector<std::size_t> member(choices->size());
    for (std::size_t k = 0; k < choices->size(); ++k) {
      const ContactChoice& choice = (*choices)[k];
      if (j >= choice.directions.size()) continue;
      while (choice.problem.contacts[member[k]].first + choice.problem.contacts[member[k]].dimension <=
             static_cast<Eigen::Index>(j))
        ++member[k];
      friction_->coupling().add_force(choice.members[member[k]], choice.directions[j], b.data());
    }
    solve(b, &dlambda);
    for (std::size_t k = 0; k < choices->size(); ++k) {
      ContactChoice& choice = (*choices)[k];
      if (j >= choice.directions.size()) continue;
      const auto point = static_cast<std::size_t>(tangents[choice.members[member[k]]].point);
      add_to(dw.data(), point, model_.inverse_mass[point] * choice.directions[j]);
      const auto column = static_cast<Eigen::Index>(j);
      write_forces(choice, dlambda, choice.problem.W.col(column));
      write_accelerations(choice, dw, choice.P.col(column));
      for (std::size_t c = 0; c < choice.size(); ++c) {
        const auto& contact = choice.problem.contacts[c];
        for (Eigen::Index i = contact.first; i < contact.first + contact.dimension; ++i) {
          const Vec3 a = load(dw.data(), tangents[choice.members[c]].point);
          choice.problem.A(i, column) = dot(choice.directions[static_cast<std::size_t>(i)], a);
        }
      }
    }
  }
  for (ContactChoice& choice : *choices) {
    Eigen::MatrixXd& A = choice.problem.A;
    A = (0.5 * (A + A.transpose())).eval();
    // A point that others hold altogether does not move: m a over a force is rounding there.
    constexpr double rounding = 1e-13;
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& contact = choice.problem.contacts[c];
      const double mobility = model_.inverse_mass[static_cast<std::size_t>(tangents[choice.members[c]].point)];
      for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k) {
        if (std::abs(A(k, k)) > rounding * mobility) continue;
        A.row(k).setZero();
        A.col(k).setZero();
      }
    }
  }
}

/// Static friction until a contact gives way, then that of sliding, until no other one gives way: `released` [contact]
/// have done so before. Of several motions the one whose friction is nearest to the one before.
void NormalForm::solve_choice(std::vector<char> released, std::size_t most_modes, ContactChoice* choice) const {
  const FrictionLaws& laws = friction_->laws();
  ContactProblem& problem = choice->problem;
  Uniqueness worst = Uniqueness::NotAsked;
  std::string reason;
  for (std::size_t pass = 0; pass <= choice->size(); ++pass) {
    bool has_released = false;
    for (std::size_t c = 0; c < choice->size(); ++c) {
      const std::size_t contact = choice->members[c];
      if (problem.contacts[c].moves) continue;
      problem.contacts[c].mu =
          released[contact] != 0 ? laws.coefficient_of_sliding(contact) : laws.static_coefficient(contact);
    }
    ContactSolutions& solutions = choice->solutions =
        find_all(problem, most_modes, pass == 0 ? choice->before : choice->x);
    if (solutions.uniqueness > worst) {
      worst = solutions.uniqueness;
      reason = solutions.reason;
    }
    choice->x.resize(0);
    if (solutions.found.empty() || worst == Uniqueness::Several) {
      if (solutions.found.empty()) break;
    }
    const auto nearer = [&](const auto& a, const auto& b) {
      return (a - choice->before).squaredNorm() < (b - choice->before).squaredNorm();
    };
    choice->x = *std::min_element(solutions.found.begin(), solutions.found.end(), nearer);
    const Eigen::VectorXd a = problem.accelerations(choice->x);
    const double least =
        rounding_of_accelerations * std::max(choice->acceleration_scale, problem.acceleration_scale(choice->x));
    for (std::size_t c = 0; c < choice->size(); ++c) {
      const auto& [first, dimension, moves, mu] = problem.contacts[c];
      const std::size_t contact = choice->members[c];
      if (moves || released[contact] != 0 || a.segment(first, dimension).norm() <= least) continue;
      if (laws.static_coefficient(contact) <= laws.coefficient_of_sliding(contact)) continue;
      released[contact] = 1;
      has_released = true;
    }
    if (!has_released || worst == Uniqueness::Several) break;
  }
  choice->solutions.uniqueness = worst;
  choice->solutions.reason = reason;
}

/// One of several that share a load gives way only where no share bears it: until then nobody has.
void NormalForm::choose(const std::vector<char>& released, std::size_t most_modes, ContactChoice* choice) const {
  const FrictionLaws& laws = friction_->laws();
  const auto gets_weaker = [&](std::size_t c) {
    return released[c] != 0 && laws.static_coefficient(c) > laws.coefficient_of_sliding(c);
  };
  if (std::any_of(choice->members.begin(), choice->members.end(), gets_weaker)) {
    solve_choice(std::vector<char>(released.size(), 0), most_modes, choice);
    find_share(choice);
    if (choice->load < 1.0 - to_spare) return;
  }
  solve_choice(released, most_modes, choice);
  find_share(choice);
}

/// What sticks by x, and how it shares its load.
void NormalForm::find_share(ContactChoice* choice) const {
  choice->load = std::numeric_limits<double>::quiet_NaN();
  if (choice->x.size() == 0) return;
  const ContactProblem& problem = choice->problem;
  const Eigen::VectorXd a = problem.accelerations(choice->x);
  const double least =
      rounding_of_accelerations * std::max(choice->acceleration_scale, problem.acceleration_scale(choice->x));
  choice->sticks.assign(choice->size(), 0);
  for (std::size_t c = 0; c < choice->size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    const Eigen::VectorXd own_a = a.segment(first, dimension), own_x = choice->x.segment(first, dimension);
    const double limit = mu * problem.normal_force(c, choice->x).norm(), size = own_x.norm();
    // Small accelerations count where friction is at its limit, and against them.
    const bool begins = own_a.norm() > 1e-3 * least && size > (1.0 - 1e-9) * limit &&
                        -own_x.dot(own_a) > (1.0 - 1e-6) * size * own_a.norm();
    choice->sticks[c] = !moves && own_a.norm() <= least && !begins;
  }
  choice->share = choice->x;
  // At a start the least friction of few contacts will do, where it obeys the law.
  const bool prefers_least = is_start() && choice->size() <= most_contacts_counted;
  choice->load = share_load(problem, choice->sticks, prefers_least, &choice->share, &choice->weights);
}

/// The multipliers that belong to what was chosen: where iterations begin. As in `reduce`.
void NormalForm::guess_multipliers(double t, const double* r, const double* v,
                                   const std::vector<ContactChoice>& choices) {
  std::vector<double> w(size()), b(num_rows());
  (void)model_.evaluate_free(t, r, v, w.data());
  model_.constraints.evaluate_right_side(model_.parallel, r, v, w.data(), b.data(), nullptr);
  friction_->set_given({t, r, v, blocks_.data()}, lambda_.data());
  friction_->add(1.0, w.data(), b.data());
  for (const ContactChoice& choice : choices) {
    for (std::size_t c = 0; choice.x.size() > 0 && c < choice.size(); ++c) {
      const auto& contact = choice.problem.contacts[c];
      for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k)
        friction_->coupling().add_force(choice.members[c], choice.x(k) * choice.directions[static_cast<std::size_t>(k)],
                                        b.data());
    }
  }
  respond(b.data(), lambda_.data(), w.data());
  share_out(lambda_.data());
}

Outcome NormalForm::explain_choice(double t, const ContactChoice& choice) const {
  const auto& found = choice.solutions.found;
  const auto name = [&](std::size_t member) {
    return "friction at t = " + tanor::text(t) + ": " + model_.name_contact(choice.members[member]);
  };
  if (found.size() < 2) {
    return {Status::NoSolution, name(0) + (choice.size() > 1 ? " and others of its island" : "") +
                                    ": no accelerations obey the law (all modes of stick and slip were tried); the "
                                    "velocity would have to jump"};
  }
  // The contact whose accelerations differ most.
  std::size_t worst = 0;
  double most = -1.0;
  for (std::size_t c = 0; c < choice.size(); ++c) {
    const double apart = norm(choice.acceleration(c, found[0]) - choice.acceleration(c, found[1]));
    if (apart <= most) continue;
    most = apart;
    worst = c;
  }
  std::string what = name(worst) + ": " + std::to_string(found.size()) + " accelerations obey the law: ";
  for (std::size_t k = 0; k < found.size(); ++k)
    what += (k == 0                  ? ""
             : k + 1 == found.size() ? " and "
                                     : ", ") +
            text(choice.acceleration(worst, found[k]), choice.acceleration_scale);
  return {Status::NotUnique, what + " m/s^2; at a start nothing says which"};
}

/// The motions of contacts at rest, and of those that move, are counted: at a start of all islands, else of those that
/// are `wanted`. Sets the modes of what has a solution; `choices`: the islands, with what each takes.
Outcome NormalForm::count_choices(double t, const double* r, const double* v, const std::vector<char>& at_rest,
                                  std::span<const std::size_t> releases, const std::vector<char>& wanted,
                                  std::size_t most_contacts, std::vector<ContactChoice>* choices) {
  Tangents& tangents = model_.constraints.tangents();
  FrictionLaws& laws = friction_->laws();
  friction_->set_place({t, r, v, blocks_.data()});
  *choices = list_choices(at_rest, wanted, most_contacts);
  if (choices->empty()) return {};
  std::vector<char> stuck(tangents.size(), 0);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    stuck[c] = tangents.sticks(c);
    tangents.set_stick(c, false);
  }
  // Other contacts than these are left as they are.
  std::vector<char> is_member(tangents.size(), 0);
  for (const ContactChoice& choice : *choices) {
    for (const std::size_t c : choice.members) is_member[c] = 1;
  }
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (is_member[c] == 0) tangents.set_stick(c, stuck[c] != 0);
  }
  forget_compliance();
  const auto back = [&] {
    for (std::size_t c = 0; c < tangents.size(); ++c) tangents.set_stick(c, stuck[c] != 0);
    forget_compliance();
  };
  if (Outcome outcome = linearise(t, r); !outcome.ok()) {
    back();
    return outcome;
  }
  reduce(t, r, v, choices);
  std::vector<char> released(tangents.size(), 0);
  for (const std::size_t c : releases) released[c] = 1;
  const bool is_start = this->is_start();
  constexpr std::size_t all_modes = 1000000,
                        modes_on_the_way = 20000;  // work of the search: seconds, and some hundredths
  Outcome failed;
  for (ContactChoice& choice : *choices) {
    choose(released, is_start ? all_modes : modes_on_the_way, &choice);
    note_verdict(choice.solutions.uniqueness, choice.solutions.reason);
    const bool is_refused = choice.solutions.uniqueness == Uniqueness::None ||
                            (choice.solutions.uniqueness == Uniqueness::Several && is_start);
    if (is_refused && failed.ok()) failed = explain_choice(t, choice);
  }
  guess_multipliers(t, r, v, *choices);
  back();
  if (!failed.ok()) {
    last_.friction = {.contacts = tangents.size()};
    last_.friction.uniqueness = verdict_;
    return failed;
  }
  for (const ContactChoice& choice : *choices) {
    if (choice.x.size() == 0) continue;
    const Eigen::VectorXd a = choice.problem.accelerations(choice.x);
    const double least =
        rounding_of_accelerations * std::max(choice.acceleration_scale, choice.problem.acceleration_scale(choice.x));
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& [first, dimension, moves, mu] = choice.problem.contacts[c];
      if (moves) continue;
      const std::size_t contact = choice.members[c];
      Vec3 towards{}, along{};
      for (Eigen::Index k = first; k < first + dimension; ++k) {
        towards = towards + a(k) * choice.directions[static_cast<std::size_t>(k)];
        along = along - choice.x(k) * choice.directions[static_cast<std::size_t>(k)];
      }
      const bool slides = norm(towards) > least;
      // One that stands below its limit shares its load with others.
      const double limit = mu * choice.problem.normal_force(c, choice.x).norm();
      const bool gives_way =
          released[contact] != 0 && choice.x.segment(first, dimension).norm() >= (1.0 - 1e-9) * limit;
      tangents.set_stick(contact, !slides && !gives_way);
      laws.set_at_limit(contact, false);
      if (slides)
        laws.set_sense(contact, (1.0 / norm(towards)) * towards);
      else if (gives_way && norm(along) > 0.0)
        laws.set_sense(contact, (1.0 / norm(along)) * along);
    }
  }
  return {};
}

/// Modes and shares are those of x, where contacts that stick share their load; of `all` choices: everywhere. What has
/// no acceleration sticks. Where no share leaves a contact anything to spare, all accelerations are still 0, and
/// nothing tells yet what will move: those are held a little longer, until what they lack rises above rounding
/// (`overload`).
Outcome NormalForm::take_choices(double t, const double* r, const std::vector<char>& at_rest, bool all,
                                 std::vector<ContactChoice>* choices) {
  Tangents& tangents = model_.constraints.tangents();
  overloads_.resize(at_rest.size(), 0);
  softness_.resize(at_rest.size(), 0);
  bool has_taken = false;
  for (ContactChoice& choice : *choices) {
    if (choice.x.size() == 0) continue;
    const bool shares = !std::isnan(choice.load);
    const bool is_overloaded = std::any_of(choice.members.begin(), choice.members.end(),
                                           [&](std::size_t contact) { return overloads_[contact] != 0; });
    if (!all && !shares && !is_overloaded) continue;
    // On curves where friction changes no reaction those that give way are found exactly by the search, on the way.
    const ContactProblem& problem = choice.problem;
    const bool on_curves = std::all_of(problem.contacts.begin(), problem.contacts.end(),
                                       [](const auto& each) { return each.dimension == 1; });
    constexpr double rounding = 1e-11;
    if (!all && !is_start() && on_curves && problem.W.norm() <= rounding) continue;
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& [first, dimension, moves, mu] = choice.problem.contacts[c];
      const std::size_t contact = choice.members[c];
      const bool sticks = choice.sticks[c] != 0;
      const auto force = [&, first = first, dimension = dimension](const Eigen::VectorXd& x) {
        Vec3 sum{};
        for (Eigen::Index k = first; k < first + dimension; ++k)
          sum = sum + x(k) * choice.directions[static_cast<std::size_t>(k)];
        return sum;
      };
      const Vec3 given = force(choice.x), shared = force(choice.share);
      if (!moves && !sticks && norm(given) > 0.0) friction_->laws().set_sense(contact, (-1.0 / norm(given)) * given);
      friction_->laws().set_reference(contact, sticks ? shared : Vec3{});
      const double bits = shares ? -softness_steps * std::log2(choice.weights(static_cast<Eigen::Index>(c))) : 0.0;
      softness_[contact] = static_cast<int>(std::lround(std::clamp(bits, 0.0, 10.0 * softness_steps)));
      const double limit = mu * choice.problem.normal_force(c, choice.share).norm();
      overloads_[contact] = sticks && norm(shared) > (1.0 - to_spare) * limit;
      if (at_rest[contact] != 0) tangents.set_stick(contact, sticks);
    }
    choice.has_shared = has_taken = true;
  }
  if (!has_taken) return {};
  forget_compliance();
  return linearise(t, r);
}

/// Islands that were not counted have one motion where friction changes no reaction, or little (`is_monotone`).
Outcome NormalForm::judge_many(double t, const double* r, const double* v, const std::vector<char>& at_rest,
                               const std::vector<char>& wanted) {
  constexpr std::size_t most_reduced = 256;  // one solve each
  if (std::none_of(wanted.begin(), wanted.end(), [](char is) { return is != 0; })) return {};
  Tangents& tangents = model_.constraints.tangents();
  friction_->set_place({t, r, v, blocks_.data()});
  std::vector<ContactChoice> choices = list_choices(at_rest, wanted, std::numeric_limits<std::size_t>::max());
  std::erase_if(choices, [&](const ContactChoice& choice) {
    const bool are_too_many = choice.size() > most_reduced;
    if (are_too_many) note_verdict(Uniqueness::Unproven, "modes of more than ten contacts are too many to try");
    return are_too_many;
  });
  if (choices.empty()) return {};
  std::vector<std::size_t> stuck;
  for (const ContactChoice& choice : choices) {
    for (const std::size_t c : choice.members) {
      if (!tangents.sticks(c)) continue;
      stuck.push_back(c);
      tangents.set_stick(c, false);
    }
  }
  forget_compliance();
  Outcome outcome = linearise(t, r);
  if (outcome.ok()) reduce(t, r, v, &choices);
  for (ContactChoice& choice : choices) {
    for (std::size_t c = 0; c < choice.size(); ++c)
      choice.problem.contacts[c].mu = friction_->laws().static_coefficient(choice.members[c]);
    const bool is_proven = outcome.ok() && is_monotone(choice.problem);
    note_verdict(is_proven ? Uniqueness::Proven : Uniqueness::Unproven,
                 is_proven ? "" : "modes of more than ten contacts are too many to try");
  }
  for (const std::size_t c : stuck) tangents.set_stick(c, true);
  forget_compliance();
  return linearise(t, r);
}

/// Contacts that bear all they can do so from now on: what they shared with others that stick is then determined.
bool NormalForm::set_limits(const std::vector<ContactChoice>& choices) {
  Tangents& tangents = model_.constraints.tangents();
  FrictionLaws& laws = friction_->laws();
  bool has_changed = false;
  for (const ContactChoice& choice : choices) {
    for (std::size_t c = 0; choice.x.size() > 0 && c < choice.size(); ++c) {
      const auto& [first, dimension, moves, mu] = choice.problem.contacts[c];
      const std::size_t contact = choice.members[c];
      const double limit = mu * choice.problem.normal_force(c, choice.x).norm();
      const double size = choice.x.segment(first, dimension).norm();
      if (moves || !tangents.sticks(contact) || size < (1.0 - 1e-9) * limit || size == 0.0) continue;
      Vec3 along{};
      for (Eigen::Index k = first; k < first + dimension; ++k)
        along = along - choice.x(k) / size * choice.directions[static_cast<std::size_t>(k)];
      laws.set_sense(contact, along);
      laws.set_at_limit(contact, laws.static_coefficient(contact) > laws.coefficient_of_sliding(contact));
      tangents.set_stick(contact, false);
      has_changed = true;
    }
  }
  return has_changed;
}

void NormalForm::note_verdict(Uniqueness uniqueness, const std::string& reason) {
  if (uniqueness <= verdict_) return;
  verdict_ = uniqueness;
  verdict_reason_ = reason;
}

/// What is known about all modes, and about reactions, into the report of this instant.
void NormalForm::add_verdict() {
  FrictionReport& report = last_.friction;
  const auto add = [&](Uniqueness uniqueness, const std::string& reason) {
    if (uniqueness < report.uniqueness || (uniqueness == report.uniqueness && !report.uniqueness_reason.empty()))
      return;
    report.uniqueness = uniqueness;
    report.uniqueness_reason = reason;
  };
  if (const std::string contact = find_undetermined_reaction(); !contact.empty()) {
    add(Uniqueness::Unproven, "constraints that depend on each other share the reaction of " + contact +
                                  " by convention, and the motion depends on the share");
  }
  if (verdict_ > Uniqueness::Proven) add(verdict_, verdict_reason_);
  // What is not proven has no bound.
  if (report.uniqueness != Uniqueness::Proven) report.error_bound = std::numeric_limits<double>::quiet_NaN();
}

/// Dependent constraints share their load in many ways: a contact whose reaction depends on the share has no motion
/// but by convention. Names it; empty: there is none.
std::string NormalForm::find_undetermined_reaction() const {
  if (!redundancy_.is_found()) return {};
  const FrictionLaws& laws = friction_->laws();
  const Tangents& tangents = model_.constraints.tangents();
  std::vector<double> lengths(num_rows(), 0.0);  // of gradients in the norm of M^-1
  for (const Incidence& i : model_.incidences) {
    const Vec3 g = load(blocks_.data(), i.block);
    lengths[static_cast<std::size_t>(i.row)] += model_.inverse_mass[static_cast<std::size_t>(i.point)] * dot(g, g);
  }
  for (double& length : lengths) length = length > 0.0 ? std::sqrt(length) : 1.0;
  std::vector<double> z(num_rows(), 0.0);  // K z = 0
  for (const Redundancy::Found& found : redundancy_.list()) {
    std::fill(z.begin(), z.end(), 0.0);
    const auto row = static_cast<std::size_t>(found.row);
    z[row] = 1.0 / lengths[row];
    double largest = z[row];
    for (const auto& [other, coefficient] : found.terms) {
      const auto a = static_cast<std::size_t>(other);
      z[a] = -coefficient / lengths[a];
      largest = std::max(largest, std::abs(z[a]));
    }
    for (std::size_t c = 0; c < tangents.size(); ++c) {
      constexpr double rounding = 1e-8;
      if (!laws.is_coulomb(c) || laws.static_coefficient(c) == 0.0) continue;
      if (norm(laws.normal_force(c, z.data())) > rounding * largest) return model_.name_contact(c);
    }
  }
  return {};
}

}  // namespace tanor
