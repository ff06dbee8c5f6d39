#pragma once

#include <png.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace tanor::picture {

/// Pixels of a PNG file, as libpng reads them.
struct Decoded {
  int width = 0, height = 0;
  std::vector<std::uint8_t> bytes;  ///< r, g, b a pixel

  const std::uint8_t* at(int x, int y) const { return &bytes[3 * (static_cast<std::size_t>(y) * width + x)]; }
  bool is_ground(int x, int y) const { return at(x, y)[0] == 255 && at(x, y)[1] == 255 && at(x, y)[2] == 255; }
};

inline Decoded decode(const std::string& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, png.data(), png.size())) throw std::runtime_error(image.message);
  image.format = PNG_FORMAT_RGB;
  Decoded decoded{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  decoded.bytes.resize(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, decoded.bytes.data(), 0, nullptr))
    throw std::runtime_error(image.message);
  return decoded;
}

}  // namespace tanor::picture
