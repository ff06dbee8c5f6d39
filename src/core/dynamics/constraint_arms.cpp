#include "dynamics/constraint_arms.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <variant>

#include "base/text.hpp"

namespace tanor::detail {

ConstraintArms::ConstraintArms(const Model& model) : model_(model) {
  const auto inner = [&](Index point) { return model.numbering.inner_point[static_cast<std::size_t>(point)]; };
  for (std::size_t group = 0; group < model.system.constraints.size(); ++group) {
    const Constraint& constraint = model.system.constraints[group];
    if (const auto* const pulleys = std::get_if<Pulleys>(&constraint)) {
      for (std::size_t k = 0; k < pulleys->pairs.size(); ++k) {
        arms_.push_back({group, k, -1, inner(pulleys->pairs[k][0]), make_vec3(pulleys->a)});
        arms_.push_back({group, k, -2, inner(pulleys->pairs[k][1]), make_vec3(pulleys->b)});
      }
    } else if (const auto* const angles = std::get_if<Angles>(&constraint)) {
      for (std::size_t k = 0; k < angles->triples.size(); ++k)
        for (const std::size_t end : {0, 2})
          arms_.push_back({group, k, inner(angles->triples[k][1]), inner(angles->triples[k][end]), {}});
    } else if (const auto* const ropes = std::get_if<Ropes>(&constraint)) {
      for (std::size_t k = 0; k < ropes->paths.size(); ++k)
        for (std::size_t p = 1; p < ropes->paths[k].size(); ++p)
          arms_.push_back({group, k, inner(ropes->paths[k][p - 1]), inner(ropes->paths[k][p]), {}});
    } else if (const auto* const rods = std::get_if<Rods>(&constraint)) {
      // Rods that share one function run out together.
      const auto& lengths = rods->length.functions;
      for (std::size_t k = 0; k < std::min(lengths.size(), rods->pairs.size()); ++k) {
        const Vec3 shift = rods->offsets.empty() ? Vec3{} : -make_vec3(rods->offsets[k]);
        if (!lengths[k].is_constant())
          arms_.push_back({group, k, inner(rods->pairs[k][0]), inner(rods->pairs[k][1]), shift, lengths[k]});
      }
    }
  }
}

Vec3 ConstraintArms::begin(const double* r, const Arm& arm) {
  return arm.begin < 0 ? arm.shift : load(r, arm.begin) + arm.shift;
}

void ConstraintArms::evaluate(const double* r, Vec3* vectors) const {
  for (std::size_t k = 0; k < arms_.size(); ++k) vectors[k] = load(r, arms_[k].end) - begin(r, arms_[k]);
}

double ConstraintArms::size(const double* r, std::size_t k) const {
  return norm(load(r, arms_[k].end)) + norm(begin(r, arms_[k]));
}

double ConstraintArms::given_length(double t, std::size_t k) const {
  double length = std::numeric_limits<double>::infinity();
  if (!arms_[k].length.is_constant()) arms_[k].length.sample(std::span<const double>(&t, 1), &length);
  return length;
}

std::string ConstraintArms::name(std::size_t k) const {
  const Arm& arm = arms_[k];
  const auto user = [&](Index point) {
    return "point " + text(model_.numbering.user_point[static_cast<std::size_t>(point)]);
  };
  const std::string where = constraint_name(model_.system, arm.group) + "[" + text(arm.member) + "]: the ";
  if (arm.begin >= 0)
    return where + (arm.length.is_constant() ? "leg" : "rod") + " from " + user(arm.begin) + " to " + user(arm.end);
  return where + "part from " + (arm.begin == -1 ? "a" : "b") + " to " + user(arm.end);
}

}  // namespace tanor::detail
