#include "system/pair_rules.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "base/text.hpp"
#include "system/enum_check.hpp"
#include "system/field_checks.hpp"

namespace tanor::detail {

namespace {

const double lowest_point = std::exp2(1.0 / 6.0);  // lowest point of the Lennard-Jones potential, in sigma

bool has_no_cutoff(PairLaw law) {
  return law == PairLaw::Log || law == PairLaw::Coulomb;
}

/// Returns all points, or those of the list. Throws if one is there twice.
std::vector<Index> points_of(const System& system, const PairForces& pairs, const std::string& where) {
  if (pairs.points.empty()) {
    std::vector<Index> all(system.num_points());
    std::iota(all.begin(), all.end(), Index{0});
    return all;
  }
  std::vector<char> is_named(system.num_points());
  for (std::size_t k = 0; k < pairs.points.size(); ++k) {
    char& named = is_named[static_cast<std::size_t>(pairs.points[k])];
    if (named) {
      throw InputError(element(where + "/points", k),
                       "point " + text(pairs.points[k]) + " is named twice; a point makes no pair with itself");
    }
    named = true;
  }
  return pairs.points;
}

void check_box(const PairForces& pairs, const std::string& where) {
  check_vector(pairs.box, where, "box");
  if (pairs.box == Vector3{}) return;
  if (std::isinf(cutoff_of(pairs))) {
    const char* const law = pairs.law == PairLaw::Log ? "law log, whose force reaches every image; leave it out"
                            : pairs.law == PairLaw::Coulomb
                                ? "law coulomb, for which there is no periodic sum; leave it out"
                                : "a law without a cutoff; give one, or leave the box out";
    throw InputError(where, "box " + text(pairs.box) + " is given to " + law);
  }
  const double least = 2.0 * cutoff_of(pairs);
  for (const double edge : pairs.box) {
    check_number(edge, ValueRange::not_negative, where, "box edge");
    if (edge > 0.0 && edge < least) {
      const auto [given, wanted] = texts_apart(std::array{edge, least});
      throw InputError(where, "box edge " + given + " is shorter than twice the cutoff; " + wanted +
                                  " or longer is right, or 0 along an axis that is not periodic");
    }
  }
}

void check_charges(const PairForces& pairs, std::size_t num_points, const std::string& where) {
  if (pairs.law != PairLaw::Coulomb) return;
  if (pairs.charges.size() != 1 && pairs.charges.size() != num_points)
    throw InputError(where, text_of_count(pairs.charges.size(), "charge") + " for " +
                                text_of_count(num_points, "point") + "; one for all or one each is right");
  for (std::size_t k = 0; k < pairs.charges.size(); ++k)
    check_number(pairs.charges[k], ValueRange::any, element(where, k), "charge");
}

bool are_joined(const System& system, Index i, Index j) {
  for (const Constraint& constraint : system.constraints) {
    const auto* rods = std::get_if<Rods>(&constraint);
    if (!rods) continue;
    for (const auto& [a, b] : rods->pairs) {
      if ((a == i && b == j) || (a == j && b == i)) return true;
    }
  }
  return false;
}

}  // namespace

void for_each_meeting(const System& system, const Vector3& box, const std::vector<Index>& points,
                      const std::function<void(Index i, Index j)>& visit) {
  // Sorted by their place in the box, points that meet stand side by side.
  std::vector<std::pair<Vector3, Index>> places;
  for (const Index point : points) {
    Vector3 place;
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = system.positions[3 * static_cast<std::size_t>(point) + k];
      place[k] = box[k] > 0.0 ? x - box[k] * std::floor(x / box[k]) : x;
    }
    places.emplace_back(place, point);
  }
  std::sort(places.begin(), places.end());
  for (std::size_t a = 0; a < places.size(); ++a) {
    for (std::size_t b = a + 1; b < places.size() && places[b].first == places[a].first; ++b)
      visit(places[a].second, places[b].second);
  }
}

double cutoff_of(const PairForces& pairs) {
  constexpr double none = std::numeric_limits<double>::infinity();
  if (has_no_cutoff(pairs.law)) return none;
  if (pairs.law == PairLaw::Wca) return lowest_point * pairs.sigma;
  if (pairs.law != PairLaw::Lj) return pairs.cutoff.value_or(none);
  return pairs.cutoff.value_or(2.5 * pairs.sigma);
}

void check_pair_rules(const System& system, const PairForces& pairs, const std::function<bool(Index)>& is_support,
                      const std::string& where) {
  const std::vector<Index> points = points_of(system, pairs, where);
  check_enum(pairs.law, PairLaw::Morse, (where + "/law").c_str());
  check_fields(pairs, 0.0, where);
  check_charges(pairs, points.size(), where + "/charges");
  if (pairs.cutoff && (has_no_cutoff(pairs.law) || pairs.law == PairLaw::Wca)) {
    throw InputError(where + "/cutoff", "cutoff " + text(*pairs.cutoff) + " is given to a law that " +
                                            (pairs.law == PairLaw::Wca ? "has its own, 2^(1/6) sigma" : "has none") +
                                            "; leave it out");
  }
  check_box(pairs, where + "/box");
  for_each_meeting(system, pairs.box, points, [&](Index i, Index j) {
    if ((is_support(i) && is_support(j)) || (pairs.exclude_rods && are_joined(system, i, j))) return;
    throw InputError(where,
                     "points " + text(i) + " and " + text(j) + " are at the same place; their force has no direction");
  });
}

}  // namespace tanor::detail
