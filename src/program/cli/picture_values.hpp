#pragma once

#include "cli/command_table.hpp"
#include "picture/style.hpp"

/// Values of the options of `tanor picture`.
namespace tanor::cli {

/// Reads "1600x1000".
Value size_of_picture(picture::Style* style);
/// Reads "auto", an axis, or two angles.
Value view_of_picture(picture::Style* style);
Value projection_of_picture(picture::Style* style);
/// Reads what is shown, as names between commas. What is not named is not shown.
Value parts_of_picture(picture::Style* style);

}  // namespace tanor::cli
