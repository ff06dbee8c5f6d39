#pragma once

#include <memory>

#include "report/frame_file.hpp"

/// \file Frames as text. A file whose name ends in ".gz" is compressed.
namespace tanor::report {

/// Opens extended XYZ (OVITO, ASE): a line for each point with position and velocity, 10 significant digits (the .vtp
/// frames have all). `Lattice` and `pbc` are given if the sample is periodic along all three edges.
///
/// The species are "C" for points that move and "X" for supports: names that every reader of the format knows.
std::unique_ptr<FrameFile> open_xyz(const FrameFileRequest& request);

/// Opens a table of few points for spreadsheets. Each frame is a row with `t`, with `x<i>,y<i>,z<i>,vx<i>,vy<i>,vz<i>`
/// for each point i, with `tension(<name>)` for each rod, and with the edges `box[0].x` … and the `origin` of a
/// periodic cell, which a table has nowhere else; all digits.
std::unique_ptr<FrameFile> open_csv(const FrameFileRequest& request);

/// Opens a LAMMPS dump (for its read_dump, OVITO, ASE): id (the number of the point plus 1), type (1: moving, 2:
/// support), positions, velocities, and the force M w on each point, with 10 significant digits. In a periodic cell
/// positions are unwrapped. The time step is the number of the frame; the time stands above it.
std::unique_ptr<FrameFile> open_lammps_dump(const FrameFileRequest& request);
/// Opens a LAMMPS "dump local" (OVITO reads it as bonds): both ids of each rod, its length and its tension.
std::unique_ptr<FrameFile> open_lammps_rod_dump(const FrameFileRequest& request);

inline constexpr const char* observables_name = "observables.csv";
/// Opens a table of the observables over time for spreadsheets: a row for each frame, with the time and a column for
/// each number. The head names them with their units, "t [s],torque [N m],load(hook).x [N]"; names with commas stand in
/// quotes.
std::unique_ptr<FrameFile> open_observables(const FrameFileRequest& request);

}  // namespace tanor::report
