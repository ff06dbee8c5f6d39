#pragma once

/// Adds the style tanor/rods to a running LAMMPS; `lammps` is its LAMMPS_NS::LAMMPS*.
extern "C" __attribute__((visibility("default"))) void tanor_lammps_register(void* lammps);
