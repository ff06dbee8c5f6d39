#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tanor {

/// Is a formula that is just the name a variable of that name?
bool is_variable_name(const std::string& name);
/// As a message shows it: control characters, which would cut it or run over it, as \x00.
std::string show_name(const std::string& name);
/// x1, y1, z1, x2, …
std::vector<std::string> name_coordinates(int num_points);

}  // namespace tanor
