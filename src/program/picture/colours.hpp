#pragma once

#include "report/colours.hpp"

namespace tanor::picture {

using report::ground, report::ink, report::bead_colour, report::support_colour, report::normal_colour,
    report::tangent_colour, report::guide_colour, report::earth_colour;
using report::Rgb, report::mix, report::colour_of;

}  // namespace tanor::picture
