/// Reads a file of another program's answer, TANOR_EXTENSION .json or .txt, as `tanor error-time --reference` does.

#include "scene/reference_state.hpp"

#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tanor;
  static const fuzz::InputFile file(TANOR_EXTENSION);
  static const System system{.positions = {0, 0, 0, 1, 0, 0}, .masses = {1, 1}, .supports = {{"s", {0}, {}}}};
  file.write(fuzz::text_of(data, size));
  fuzz::takes([&] { scene::read_reference_state(file.path(), system, 1.0); });
  return 0;
}
