#include "picture/draw.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "picture/camera.hpp"
#include "picture/canvas.hpp"
#include "picture/legend.hpp"
#include "picture/shapes.hpp"

namespace tanor::picture {

namespace {

constexpr int rows_of_a_band = 64;

/// Returns how much distant parts fade. Crowded scenes need more, to show depth.
double choose_haze(const Picture& picture) {
  constexpr std::size_t crowd = 3000;
  return picture.frame.num_points() > crowd ? 0.75 : 0.3;
}

/// Draws the rows of a band. Rows around it are drawn too, because edges need them for their shades.
void draw_band(const Picture& picture, const Camera& camera, const Shapes& shapes, double bead, int first,
               std::uint32_t* pixels) {
  const int last = std::min(first + rows_of_a_band, picture.style.height), around = 2 + picture.style.width / 450;
  Canvas canvas(camera, picture.style.width, first - around, last + around);
  for (const Cone& cone : shapes.cones) canvas.add(cone);
  for (const Ball& ball : shapes.balls) canvas.add(ball);
  canvas.finish(choose_haze(picture), bead);
  for (const Surface& surface : shapes.surfaces) canvas.add(surface);
  for (const Triangle& triangle : shapes.triangles) canvas.add(triangle);
  canvas.resolve(first, last, pixels);
}

/// Draws band by band with all threads; the pixels do not depend on the number of threads.
std::vector<std::uint32_t> draw_motion(const Picture& picture, const Camera& camera, const Shapes& shapes,
                                       double bead) {
  const int height = picture.style.height;
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(picture.style.width) * static_cast<std::size_t>(height));
  std::atomic<int> next = 0;
  std::exception_ptr failure;
  std::mutex failing;
  const auto work = [&] {
    try {
      for (int first = 0; (first = next.fetch_add(rows_of_a_band)) < height;)
        draw_band(picture, camera, shapes, bead, first, pixels.data());
    } catch (...) {
      const std::lock_guard lock(failing);
      failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned k = 1; k < std::max(1u, std::thread::hardware_concurrency()); ++k) threads.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
  return pixels;
}

/// Returns a round force whose arrow fits beside the picture.
double choose_arrow(double largest) {
  const double unit = std::pow(10.0, std::floor(std::log10(largest)));
  for (const double factor : {5.0, 2.0})
    if (factor * unit <= largest) return factor * unit;
  return unit;
}

}  // namespace

Drawn draw(const Picture& picture) {
  const Scale scale = choose_scale(picture);
  const bool has_unknown = picture.style.shows_rods &&
                           std::ranges::any_of(picture.frame.tensions, [](double t) { return !std::isfinite(t); });
  const Layout layout = arrange(picture, scale.tensions.end() > 0.0 || has_unknown);
  const Camera camera(choose_eye(picture), scale.outline, 1.4 * scale.bead, layout.motion);
  const Shapes shapes = build_shapes(picture, scale, camera);
  std::vector<std::uint32_t> pixels = draw_motion(picture, camera, shapes, scale.bead);

  const report::MotionExtent& extent = picture.extent;
  Key key{.tensions = scale.tensions, .has_unknown = has_unknown, .force_unit = picture.frame.force_unit};
  key.has_less = key.tensions.least < 0.0 &&
                 std::ranges::any_of(picture.frame.tensions, [&](double t) { return t < key.tensions.least; });
  key.has_more = key.tensions.most > 0.0 &&
                 std::ranges::any_of(picture.frame.tensions, [&](double t) { return t > key.tensions.most; });
  if (scale.arrow > 0.0) {
    key.has_normal = picture.style.shows_normal;
    key.has_tangent = picture.style.shows_tangent && extent.has_friction;
    key.arrow = choose_arrow(extent.largest_force);
    key.arrow_pixels = key.arrow * scale.arrow / camera.pixel(camera.middle_depth());
  }
  return {finish_picture(picture, layout, key, &pixels), scale.tensions.end(), key.arrow, shapes.left_out};
}

}  // namespace tanor::picture
