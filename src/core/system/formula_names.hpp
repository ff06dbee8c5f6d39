#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tanor::detail {

/// True if a formula that is just the name is a variable of that name.
bool is_variable_name(const std::string& name);
/// Returns the name as a message shows it: control characters, which would cut it or run over it, become \x00 and the
/// like.
std::string show_name(const std::string& name);
/// Throws InputError if a name, which stands in pages and tables, holds a line break or another control character.
void check_name(const std::string& name, const std::string& where);
/// Returns x1, y1, z1, x2, …
std::vector<std::string> name_coordinates(int num_points);

}  // namespace tanor::detail
