#pragma once

/// \file
/// Second derivatives; see Curved.

#include <tanor/forward.hpp>
