#include "system/formula_names.hpp"

#include <tanor/error.hpp>

#include "base/text.hpp"
#include "system/formula.hpp"

namespace tanor::detail {

bool is_variable_name(const std::string& name) {
  try {
    return name != "pi" && Formula(name, {&name, 1}).depends_on(0);
  } catch (const InputError&) {
    return false;
  }
}

std::string show_name(const std::string& name) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string result;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f)
      result += c;
    else
      result += std::string("\\x") + digits[byte / 16] + digits[byte % 16];
  }
  return result;
}

void check_name(const std::string& name, const std::string& where) {
  if (show_name(name) != name)
    throw InputError(where, "the name \"" + show_name(name) + "\" holds a line break or another control character");
}

std::vector<std::string> name_coordinates(int num_points) {
  std::vector<std::string> names;
  for (int i = 1; i <= num_points; ++i) {
    for (const char* axis : {"x", "y", "z"}) names.push_back(axis + text(i));
  }
  return names;
}

}  // namespace tanor::detail
