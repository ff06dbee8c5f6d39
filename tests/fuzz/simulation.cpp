/// Reads a scene file, starts it, moves it by two steps, saves it, and goes on from what was saved.

#include "scene/scene.hpp"

#include "small_scene.hpp"
#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tanor;
  const std::string text(fuzz::text_of(data, size));
  fuzz::takes([&] {
    scene::Scene scene = scene::parse_scene(text, "no_folder/scene.json");
    if (!fuzz::is_small(scene.system)) return;
    scene.solver.threads = 1;
    const double t_end = scene.has_end() ? scene.t_end : 1.0;
    Simulation first(scene.system, scene.motion, scene.solver);
    if (!fuzz::advance_few_steps(&first, t_end)) return;
    Simulation second(scene.system, scene.motion, scene.solver);
    second.restore(first.save());
    fuzz::advance_few_steps(&second, t_end);
  });
  return 0;
}
