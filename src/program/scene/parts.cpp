#include "scene/parts.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/suggestion.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

using Part = std::pair<std::string_view, std::vector<std::string_view>>;

const std::vector<Part>& parts() {
  static const std::vector<Part> all{
      {"",
       {"tanor_scene", "name", "parameters", "points", "generate", "import", "supports", "constraints", "coordinates",
        "forces", "friction", "cell", "observe", "events", "units", "motion", "solver", "equilibrium", "modes"}},
      {"cell", {"edges", "origin"}},
      {"units", {"name", "length", "mass", "time", "force", "energy", "temperature", "pressure", "boltzmann"}},
      {"observe", {"name", "what", "unit", "every_step"}},
      {"events", {"name", "when", "do", "of"}},

      {"motion",
       {"method", "step", "rtol", "atol", "order", "spectral_radius", "max_step", "t_start", "t_end", "output_every",
        "output_points", "stabilisation", "start", "trajectory", "compression"}},
      {"solver",
       {"form", "linear_solver", "ordering", "threads", "certificate", "friction", "reuse", "exact", "contact", "way"}},
      {"contact", {"max_at_one_instant", "max_events"}},
      {"equilibrium",
       {"method", "force_tolerance", "max_iterations", "accept", "at", "load_steps", "prestress", "one_sided",
        "friction", "time"}},
      {"modes", {"count", "damped", "buckling"}},
      {"import",
       {"file", "get", "format", "bonds", "types", "angles", "mass", "dihedrals", "bond_style", "angle_style",
        "dihedral_style", "fene_repulsion", "units", "atom_style"}},
      {"points", {"positions", "velocities", "masses"}}};
  return all;
}

}  // namespace

const std::vector<std::string_view>& keys_of(std::string_view part) {
  return std::ranges::find(parts(), part, &Part::first)->second;
}

std::string explain_key(std::string_view key, const std::vector<std::string_view>& known) {
  if (std::string near = suggest(key, {known.begin(), known.end()}); !near.empty()) return near;
  for (const auto& [part, keys] : parts())
    if (std::ranges::find(keys, key) != keys.end())
      return part.empty() ? " (a key of the scene itself)" : " (a key of /" + std::string(part) + ")";
  return "";
}

}  // namespace tanor::scene
