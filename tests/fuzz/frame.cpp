/// Reads a frame of a stored motion (.vtp) as `tanor picture` and `tanor view` do: at its time, between it and itself a
/// second later, and its extent. With TANOR_DRAWS_PICTURES it is also drawn, small.

#include "report/stored_motion.hpp"

#include "target.hpp"

#if TANOR_DRAWS_PICTURES
#include "picture/draw.hpp"

/// The fonts that fontconfig has found are its own until the end of the process.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions() {
  return "leak:libfontconfig";
}
#endif

namespace {

using namespace tanor;

/// Writes a list of two frames that are the same file.
void write_list(const std::filesystem::path& folder) {
  std::ofstream(folder / "trajectory.pvd") << R"(<DataSet timestep="0" file="input.vtp"/>)"
                                           << R"(<DataSet timestep="1" file="input.vtp"/>)";
}

void draw_instant(const report::StoredMotion& motion, double time) {
  const report::StoredFrame frame = motion.at(time).frame;
  const report::MotionExtent extent = motion.measure();
#if TANOR_DRAWS_PICTURES
  picture::draw({frame, extent, {.width = 24, .height = 16, .shows_legend = frame.guides.empty()}});
#else
  (void)frame, (void)extent;
#endif
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile file(".vtp");
  file.write(fuzz::text_of(data, size));
  write_list(file.folder());
  fuzz::takes([] {
    const report::StoredMotion motion(file.folder());
    for (const double time : {0.0, 0.25}) draw_instant(motion, time);
  });
  return 0;
}
