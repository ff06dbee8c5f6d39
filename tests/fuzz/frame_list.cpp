/// Reads the list of the frames of a stored motion (.pvd), beside a good frame `frame.vtp` that it may name.

#include "report/stored_motion.hpp"

#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tanor;
  static const fuzz::InputFile file(".none");
  static const bool has_frame = std::filesystem::copy_file(TANOR_FRAME, file.folder() / "frame.vtp");
  if (!has_frame) std::abort();
  std::ofstream(file.folder() / "trajectory.pvd", std::ios::binary) << fuzz::text_of(data, size);
  fuzz::takes([] {
    const report::StoredMotion motion(file.folder());
    for (const double part : {0.0, 0.4, 1.0}) (void)motion.at((1.0 - part) * motion.begin() + part * motion.end());
    (void)motion.measure();
  });
  return 0;
}
