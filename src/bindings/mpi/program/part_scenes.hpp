#pragma once

#include <filesystem>

#include "mpi/tanor_mpi.hpp"
#include "scene/scene.hpp"

/// \file Scenes of which each rank has its own, "melt-{rank}.json".
namespace tanor::mpi {

inline constexpr const char* rank_word = "{rank}";

/// Returns true if the name of a scene stands for one scene a rank.
bool names_parts(const std::filesystem::path& name);

/// Returns the name of a rank's scene: "melt-3.json".
std::filesystem::path name_part(const std::filesystem::path& name, int rank);

/// Makes the scenes of all ranks one run, on this rank: checks that all ask for the same motion, gives the run a name,
/// "melt", and tells the first rank what it does not know of the others' points. Throws InputError on all ranks.
/// Collective.
void merge_parts(MpiRanks& ranks, const std::filesystem::path& name, scene::Scene* own);

}  // namespace tanor::mpi
