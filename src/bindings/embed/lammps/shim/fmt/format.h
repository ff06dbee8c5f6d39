#pragma once

#include <string>

/// \file Stands for a file of LAMMPS' own sources that its headers include and Debian does not install. These
/// declarations are enough for what we call, the functions that take a std::string.
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
