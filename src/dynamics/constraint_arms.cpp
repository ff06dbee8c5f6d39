#include "dynamics/constraint_arms.hpp"

#include <variant>

#include "base/text.hpp"

namespace tanor {

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
    }
  }
}

Vec3 ConstraintArms::begin(const double* r, const Arm& arm) {
  return arm.begin < 0 ? arm.wheel : load(r, arm.begin);
}

void ConstraintArms::evaluate(const double* r, Vec3* vectors) const {
  for (std::size_t k = 0; k < arms_.size(); ++k) vectors[k] = load(r, arms_[k].end) - begin(r, arms_[k]);
}

double ConstraintArms::size(const double* r, std::size_t k) const {
  return norm(load(r, arms_[k].end)) + norm(begin(r, arms_[k]));
}

std::string ConstraintArms::name(std::size_t k) const {
  const Arm& arm = arms_[k];
  const auto user = [&](Index point) {
    return "point " + text(model_.numbering.user_point[static_cast<std::size_t>(point)]);
  };
  const std::string where = constraint_name(model_.system, arm.group) + "[" + text(arm.member) + "]: the ";
  if (arm.begin >= 0) return where + "leg from " + user(arm.begin) + " to " + user(arm.end);
  return where + "part from " + (arm.begin == -1 ? "a" : "b") + " to " + user(arm.end);
}

}  // namespace tanor
