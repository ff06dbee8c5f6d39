#pragma once

#include <string>

/// \file LAMMPS' headers name this one of its own sources, which Debian does not install. These declarations are enough
/// for what we call: the functions that take a std::string.
namespace fmt {
inline namespace v7_lmp {
struct format_args {};
struct string_view {
  string_view(const char*) {}
  string_view(const std::string&) {}
};
template <class... Arguments>
format_args make_args_checked(Arguments&&...) {
  return {};
}
}  // namespace v7_lmp
}  // namespace fmt
