/// Reads a file of another program, in the format TANOR_FORMAT of "import".

#include "scene/scene.hpp"

#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tanor;
  static const fuzz::InputFile file("." TANOR_FORMAT);
  file.write(fuzz::text_of(data, size));
  for (const std::string keys : {"", R"(, "bonds": "distance", "angles": "rigid")", R"(, "angles": "rigid")"}) {
    const std::string scene = R"({"tanor_scene": 1, "import": {"format": ")" TANOR_FORMAT R"(", "file": ")" +
                              file.path().string() + "\"" + keys + "}}";
    fuzz::takes([&] { scene::parse_scene(scene, file.folder() / "scene.json"); });
  }
  return 0;
}
