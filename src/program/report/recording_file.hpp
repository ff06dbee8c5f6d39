#pragma once

#include <filesystem>
#include <string>

#include "report/recording.hpp"

namespace tanor::report {

inline constexpr const char* recording_name = "recording";

/// Replaces `directory/recording`, with which the page of a resumed run begins. The file has a line with the format's
/// number, the fingerprint, the time and everything recorded, and a line with the checksum of everything before.
void write_recording(const std::filesystem::path& directory, const std::string& fingerprint, double time,
                     const Recording& recording);

/// Takes what an earlier part of the run recorded until the simulation's time. Returns false if there is no file, or if
/// it is damaged, of another run, or of an earlier time. The page then begins where the run was resumed, and nothing
/// else is lost.
bool read_recording(const std::filesystem::path& directory, const std::string& fingerprint,
                    const Simulation& simulation, Recording* recording);

}  // namespace tanor::report
