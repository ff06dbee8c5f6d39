#include "host/c_members.hpp"

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>

namespace tanor::detail {

namespace {

Vector3 vector_at(const double* numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

/// The layout of a kind in tn_add: the points and the numbers of a member. If `has_number`, the last number is the
/// member's own, and the group has the others.
struct KindLayout {
  size_t num_points, num_parameters;
  bool has_number;
  Constraint (*make)(const double* parameters);
};
KindLayout layout_of(tn_kind kind) {
  switch (kind) {
    case TN_ROD:
      return {2, 1, true, [](const double*) -> Constraint { return Rods{}; }};
    case TN_ANGLE:
      return {3, 1, true, [](const double*) -> Constraint { return Angles{}; }};
    case TN_PLANE:
      return {1, 4, true, [](const double* p) -> Constraint { return Planes{.normal = vector_at(p)}; }};
    case TN_SPHERE:
      return {1, 4, true, [](const double* p) -> Constraint { return Spheres{.center = vector_at(p)}; }};
    case TN_LINE:
      return {1, 6, false, [](const double* p) -> Constraint {
                return Lines{.origin = vector_at(p), .direction = vector_at(p + 3)};
              }};
    case TN_CIRCLE:
      return {1, 7, true, [](const double* p) -> Constraint {
                return Circles{.center = vector_at(p), .normal = vector_at(p + 3)};
              }};
  }
  throw InputError("", "there is no kind " + std::to_string(static_cast<int>(kind)));
}

/// Makes a group of the members [begin, end), which have the same shape.
Constraint make_group(const KindLayout& layout, size_t begin, size_t end, const int32_t* points,
                      const double* parameters) {
  Constraint constraint = layout.make(parameters != nullptr ? parameters + begin * layout.num_parameters : nullptr);
  std::visit(
      [&]<class Kind>(Kind& group) {
        for (size_t k = begin; k < end; ++k) {
          auto& members = group.*KindOf<Kind>::members;
          using Member = typename std::remove_cvref_t<decltype(members)>::value_type;
          const int32_t* const own = points + k * layout.num_points;
          if constexpr (std::is_same_v<Member, Index>) {
            members.push_back(*own);
          } else if constexpr (!std::is_same_v<Member, std::vector<Index>>) {
            std::copy_n(own, layout.num_points, members.emplace_back().begin());
          }
        }
        if constexpr (requires { KindOf<Kind>::parameter; }) {
          std::vector<double> numbers;
          for (size_t k = begin; parameters != nullptr && k < end; ++k)
            numbers.push_back(parameters[(k + 1) * layout.num_parameters - 1]);
          group.*KindOf<Kind>::parameter = std::move(numbers);
        }
      },
      constraint);
  return constraint;
}

}  // namespace

std::vector<ConstraintId> add_members(Constrainer* constrainer, tn_kind kind, size_t count, const int32_t* points,
                                      const double* parameters) {
  const KindLayout layout = layout_of(kind);
  const size_t width = layout.num_parameters, shape = layout.has_number ? width - 1 : width;
  if (count > 0 && shape > 0 && parameters == nullptr) throw InputError("", "parameters is a null pointer");
  std::vector<ConstraintId> added;
  try {
    for (size_t begin = 0, end = 0; begin < count; begin = end) {
      const auto has_shape = [&](size_t k) {
        const double* const first = shape > 0 ? parameters + begin * width : nullptr;
        return shape == 0 || std::equal(first, first + shape, parameters + k * width);
      };
      while (end < count && has_shape(end)) ++end;
      end = std::max(end, begin + 1);  // a NaN differs from itself; `add` refuses it
      const ConstraintId id = constrainer->add(make_group(layout, begin, end, points, parameters));
      for (size_t k = begin; k < end; ++k) added.push_back(id + static_cast<ConstraintId>(k - begin));
    }
  } catch (const InputError&) {
    constrainer->remove(added);
    throw;
  }
  return added;
}

}  // namespace tanor::detail
