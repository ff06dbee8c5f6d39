/// Reads arrays of NumPy that follow one another.

#include "scene/npy.hpp"

#include "target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tanor;
  std::string_view bytes = fuzz::text_of(data, size);
  fuzz::takes([&] {
    while (!bytes.empty()) scene::read_npy("input.npy", &bytes);
  });
  return 0;
}
