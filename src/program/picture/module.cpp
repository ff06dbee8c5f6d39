#include <exception>

#include "picture/draw.hpp"

/// The function of the module, which the program calls by its name.
extern "C" __attribute__((visibility("default"))) void tanor_draw_picture(const tanor::picture::Picture& picture,
                                                                          tanor::picture::Drawn* drawn,
                                                                          std::string* trouble) {
  try {
    *drawn = tanor::picture::draw(picture);
  } catch (const std::exception& exception) {
    *trouble = exception.what();
  }
}
