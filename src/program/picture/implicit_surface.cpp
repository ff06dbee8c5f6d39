#include "picture/implicit_surface.hpp"

#include <algorithm>
#include <cmath>

#include "system/operations.hpp"

namespace tanor::picture {
using namespace detail;

namespace {

using Operation = Expression::Operation;

constexpr int parts = 24;           // along a side of the cube
constexpr int parts_of_a_line = 2;  // between lines of the net that is drawn on the surface

/// Reads a small whole number that may have passed through an interpolation.
std::optional<int> read_whole(double number, std::size_t bound) {
  const double whole = std::round(number);
  if (!(whole >= 0.0 && whole < static_cast<double>(bound))) return {};
  return static_cast<int>(whole);
}

/// A corner of the grid.
struct Node {
  std::array<int, 3> place;
  Vec3 r;
  double xi;
};

/// The intersection of the surface with the edge between two corners of a tetrahedron.
struct Crossing {
  const Node *inside, *outside;
  Vec3 r;
};

/// Returns true if two crossings span an edge along a line of the net: their corners, three in all, lie in one of its
/// planes.
bool is_on_line(const Crossing& a, const Crossing& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int plane = a.inside->place[axis];
    const bool is_in_plane = a.outside->place[axis] == plane && b.inside->place[axis] == plane &&
                             b.outside->place[axis] == plane && plane % parts_of_a_line == 0;
    if (is_in_plane) return true;
  }
  return false;
}

void add_triangle(const Crossing& a, const Crossing& b, const Crossing& c, std::vector<SurfacePart>* surface) {
  surface->push_back({{a.r, b.r, c.r}, {is_on_line(a, b), is_on_line(b, c), is_on_line(c, a)}});
}

/// Returns the zero of xi between two corners, found by bisection. Returns nothing if xi does not become small, because
/// it has a pole there or jumps.
std::optional<Vec3> find_zero(ImplicitFunction& xi, const Node& inside, const Node& outside) {
  constexpr int halvings = 5;
  Vec3 a = inside.r, b = outside.r;
  double xi_a = inside.xi, xi_b = outside.xi;
  for (int k = 0; k < halvings; ++k) {
    const Vec3 middle = 0.5 * (a + b);
    const double between = xi(middle);
    if (!std::isfinite(between)) return {};
    (between < 0.0 ? a : b) = middle;
    (between < 0.0 ? xi_a : xi_b) = between;
  }
  if (!(xi_b - xi_a < 0.5 * (outside.xi - inside.xi))) return {};
  return a + xi_a / (xi_a - xi_b) * (b - a);
}

/// Adds the part of the surface in a tetrahedron: nothing, or one or two triangles.
void cut_tetrahedron(ImplicitFunction& xi, const std::array<const Node*, 4>& corners,
                     std::vector<SurfacePart>* surface) {
  std::array<const Node*, 4> sorted = corners;
  const auto middle = std::partition(sorted.begin(), sorted.end(), [](const Node* each) { return each->xi < 0.0; });
  std::array<Crossing, 4> crossings;
  std::size_t count = 0;
  for (auto in = sorted.begin(); in != middle; ++in) {
    for (auto out = middle; out != sorted.end(); ++out) {
      const std::optional<Vec3> zero = find_zero(xi, **in, **out);
      if (!zero) return;
      crossings[count++] = {*in, *out, *zero};
    }
  }
  if (count == 3) add_triangle(crossings[0], crossings[1], crossings[2], surface);
  if (count == 4) {  // in the order a c, a d, b c, b d
    add_triangle(crossings[0], crossings[1], crossings[3], surface);
    add_triangle(crossings[0], crossings[3], crossings[2], surface);
  }
}

}  // namespace

std::optional<ImplicitFunction> ImplicitFunction::read(std::span<const double> numbers) {
  constexpr std::size_t head = 2, size_of_step = 4;
  if (numbers.size() < head + size_of_step || (numbers.size() - head) % size_of_step != 0) return {};
  ImplicitFunction xi;
  xi.t_ = numbers[0];
  for (std::size_t at = head; at < numbers.size(); at += size_of_step)
    if (!xi.append(numbers.subspan(at, size_of_step))) return {};
  const std::optional<int> result = read_whole(numbers[1], xi.steps_.size());
  if (!result) return {};
  xi.result_ = static_cast<std::size_t>(*result);
  xi.values_.resize(xi.steps_.size());
  return xi;
}

bool ImplicitFunction::append(std::span<const double> row) {
  constexpr std::size_t num_operations = static_cast<std::size_t>(Operation::Max) + 1, num_variables = 4;
  const std::optional<int> operation = read_whole(row[0], num_operations);
  const std::size_t bound = std::max<std::size_t>(steps_.size(), 1);  // operands precede their step
  const std::optional<int> a = read_whole(row[1], bound), b = read_whole(row[2], bound);
  if (!operation || !a || !b) return false;
  steps_.push_back({.operation = static_cast<Operation>(*operation), .a = *a, .b = *b, .constant = row[3]});
  return steps_.back().operation != Operation::Variable || read_whole(row[3], num_variables).has_value();
}

double ImplicitFunction::operator()(Vec3 place) {
  const std::array<double, 4> variables{place.x, place.y, place.z, t_};
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Expression::Instruction& step = steps_[k];
    values_[k] = step.operation == Operation::Variable ? variables[static_cast<std::size_t>(std::lround(step.constant))]
                                                       : perform(step, values_);
  }
  return values_[result_];
}

std::vector<SurfacePart> polygonise(ImplicitFunction xi, Vec3 middle, double half_side) {
  constexpr int nodes = parts + 1;
  std::vector<Node> grid;
  grid.reserve(nodes * nodes * nodes);
  for (int i = 0; i < nodes; ++i)
    for (int j = 0; j < nodes; ++j)
      for (int k = 0; k < nodes; ++k) {
        const Vec3 r = middle + half_side * Vec3{2.0 * i / parts - 1.0, 2.0 * j / parts - 1.0, 2.0 * k / parts - 1.0};
        grid.push_back({{i, j, k}, r, xi(r)});
      }
  // Six tetrahedra surround the diagonal of a cube; the bits of a corner are x, y, z.
  constexpr std::array<std::array<int, 4>, 6> tetrahedra{
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
  std::vector<SurfacePart> surface;
  for (const Node& first : grid) {
    const auto [i, j, k] = first.place;
    if (i == parts || j == parts || k == parts) continue;
    for (const std::array<int, 4>& tetrahedron : tetrahedra) {
      std::array<const Node*, 4> corners{};
      for (std::size_t c = 0; c < 4; ++c) {
        const int bits = tetrahedron[c];
        corners[c] = &grid[static_cast<std::size_t>(((i + (bits & 1)) * nodes + j + ((bits >> 1) & 1)) * nodes + k +
                                                    (bits >> 2))];
      }
      if (std::ranges::all_of(corners, [](const Node* each) { return std::isfinite(each->xi); }))
        cut_tetrahedron(xi, corners, &surface);
    }
  }
  return surface;
}

}  // namespace tanor::picture
