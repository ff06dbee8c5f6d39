/// Reads and validates a scene file as `tanor info` does.

#include "scene/scene.hpp"

#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tanor;
  const std::string text(fuzz::text_of(data, size));
  fuzz::takes([&] { scene::parse_scene(text, "no_folder/scene.json"); });
  return 0;
}
