#pragma once

#include <array>
#include <vector>

#include <tanor/enum_names.hpp>

namespace tanor::scene {

/// The files that a run can write its frames to.
enum class TrajectoryFormat { Xyz, Vtp, Lammps, H5md, Csv, Npz };

/// The output of a motion ("trajectory", "compression" of docs/scene-format.md).
struct TrajectoryFormats {
  std::vector<TrajectoryFormat> files{TrajectoryFormat::Xyz, TrajectoryFormat::Vtp};
  bool compression = false;
};

}  // namespace tanor::scene

template <>
inline constexpr std::array<tanor::EnumName<tanor::scene::TrajectoryFormat>, 6>
    tanor::enum_names<tanor::scene::TrajectoryFormat>{{{tanor::scene::TrajectoryFormat::Xyz, "xyz"},
                                                       {tanor::scene::TrajectoryFormat::Vtp, "vtp"},
                                                       {tanor::scene::TrajectoryFormat::Lammps, "lammps"},
                                                       {tanor::scene::TrajectoryFormat::H5md, "h5md"},
                                                       {tanor::scene::TrajectoryFormat::Csv, "csv"},
                                                       {tanor::scene::TrajectoryFormat::Npz, "npz"}}};
