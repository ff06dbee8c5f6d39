#pragma once

/// Teaches a running LAMMPS, `lammps` being its LAMMPS_NS::LAMMPS*, the style tanor/rods.
extern "C" __attribute__((visibility("default"))) void tanor_lammps_register(void* lammps);
