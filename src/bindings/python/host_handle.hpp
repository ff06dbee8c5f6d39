#pragma once

#include <tanor/constrainer.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "python/handle.hpp"

namespace tanor::python {

/// Reads float [3, 3], edges a, b, c row by row, or float [3] for an orthogonal cell.
PeriodicCell read_cell(const py::object& cell, const py::object& repeats);
/// Reads int [rows, 3], or no images for None.
std::vector<std::array<int, 3>> read_images(const py::object& images);

/// A Constrainer with its description and the edits since, from which copies are made. Copies replay in their order the
/// groups and observables that came and went and the points that were renumbered, because ids tell that order. Of
/// lengths, masses, positions and the cell they need only the present ones.
class HostHandle : public Handle<Constrainer> {
 public:
  /// The arguments that the user gave, None for those that were not given. `present_cell` is that of the last set_cell.
  struct Description {
    py::object masses, constraints, positions, cell, repeats, images, options, present_cell;
  };

  explicit HostHandle(Description description);

  const Description& description() const { return description_; }
  py::ssize_t num_points() const { return static_cast<py::ssize_t>(masses_.size()); }
  py::ssize_t num_rows() {
    return run([](const Constrainer& c) { return static_cast<py::ssize_t>(c.num_rows()); });
  }

  void set_cell(const py::object& edges, const py::object& repeats);
  ConstraintId add(const py::object& constraint, ConstPointArray positions, const py::object& images);
  void remove(const py::object& ids);
  void set_lengths(const py::object& ids, const py::object& lengths, const py::object& rates);
  void set_masses(const py::object& points, const py::object& masses);
  void renumber(const py::object& from, const py::object& masses, const py::object& positions, const py::object& index);

  std::size_t add_observable(const std::string& text, const std::string& name, const std::string& unit);
  void remove_observable(std::size_t number);

  py::bytes save();
  void restore(const py::bytes& saved);

  py::tuple state();
  static std::unique_ptr<HostHandle> from_state(const py::tuple& state);

 private:
  /// The length, its rate, and true if there was a rate once.
  using Length = std::tuple<double, double, bool>;

  Constrainer make() override;
  Periodicity read_periodicity() const;
  void replay(Constrainer* constrainer) const;
  void replay_lengths(Constrainer* constrainer) const;
  void take_positions(const ConstPointArray& positions);

  Description description_;
  py::list edits_;  // ("add", ...), ("remove", ids), ("renumber", from, masses), ("observe", …)
  std::map<ConstraintId, Length> lengths_;  // lengths that were set
  std::vector<double> masses_, positions_;  // [n], [3 n]: present masses; positions that were given last
  py::object saved_ = py::none();           // saved state of the original, until the copy is made
};

}  // namespace tanor::python
