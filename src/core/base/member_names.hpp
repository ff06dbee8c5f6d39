#pragma once

#include <algorithm>
#include <array>
#include <string_view>

/// \file The names that structs and their members have in the code. Reports have the same ones in Python and in JSON.
namespace tanor::detail {

/// Returns the last name in what a compiler says of a template's argument: "points" of "… [with auto member =
/// &tanor::PlanSummary::points; …]".
constexpr std::string_view last_name(std::string_view function) {
  const auto end = function.find_first_of(";]", function.find('['));
  const std::string_view argument = function.substr(0, end);
  return argument.substr(argument.find_last_of(": ") + 1);
}

/// Returns "PlanSummary" of a struct, without its namespaces.
template <class Struct>
constexpr std::string_view name_of_struct() {
  return last_name(__PRETTY_FUNCTION__);
}

/// Returns "points" of &PlanSummary::points.
template <auto member>
constexpr std::string_view name_of_member() {
  return last_name(__PRETTY_FUNCTION__);
}

/// The same with a zero behind it, for what wants a text of C.
template <auto member>
inline constexpr auto member_key = [] {
  std::array<char, name_of_member<member>().size() + 1> letters{};
  std::ranges::copy(name_of_member<member>(), letters.begin());
  return letters;
}();

}  // namespace tanor::detail
