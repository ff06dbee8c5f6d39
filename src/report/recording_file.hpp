#pragma once

#include <filesystem>
#include <string>

#include "report/recording.hpp"

namespace tanor::report {

inline constexpr const char* recording_name = "recording";

/// Replaces `directory/recording`, from which the page of a run that goes on begins: a line with the format's number;
/// the fingerprint, the time and all that was recorded; a line with the checksum of everything before.
void write_recording(const std::filesystem::path& directory, const std::string& fingerprint, double time,
                     const Recording& recording);

/// Takes up what an earlier part of the run recorded until the simulation's time. False: nothing lies there, or it is
/// damaged, of another run, or of an earlier time; the page then begins where the run went on, and nothing else is
/// lost.
bool read_recording(const std::filesystem::path& directory, const std::string& fingerprint,
                    const Simulation& simulation, Recording* recording);

}  // namespace tanor::report
