#include <limits>
#include <numeric>
#include <utility>

#include <tanor/ranks.hpp>

#include "base/text.hpp"
#include "dynamics/decisions.hpp"

namespace tanor {
using namespace detail;

RankSystem join_parts(System own, Ranks& ranks) {
  Decisions all(&ranks);
  const bool has_coordinates = all.any(!own.coordinates.empty());
  if (has_coordinates && !all.all(!own.coordinates.empty()))
    throw InputError("/coordinates", "are given on some ranks alone; every point that moves is covered, or none is");
  const Share points = all.share(own.num_points()), equations = all.share(num_equations(own));
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  if (points.all() > most)
    throw InputError("", text(points.all()) + " points on all ranks together; their numbers end at " + text(most));
  RankSystem result;
  result.num_owned = own.num_points();
  result.points.resize(own.num_points());
  std::iota(result.points.begin(), result.points.end(), static_cast<Index>(points.first));
  result.equations.resize(num_equations(own));
  std::iota(result.equations.begin(), result.equations.end(), equations.first);
  result.part.ranks = &ranks;
  result.system = std::move(own);
  return result;
}

}  // namespace tanor
