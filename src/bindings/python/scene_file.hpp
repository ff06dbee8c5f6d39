#pragma once

#include <optional>
#include <string>

#include "python/call.hpp"
#include "scene/scene.hpp"

namespace tanor::python {

/// A scene file as Python holds it: its text and what overrides it, and "system", "motion" and "solver" as far as
/// Python has looked at them. These may have been changed since, and count before the text, which is read anew after a
/// pickle.
class SceneFile {
 public:
  SceneFile(std::string text, std::string file, py::dict overrides);

  /// Returns the scene. Throws InputError.
  const scene::Scene& read();
  /// Reads it again with other overrides. What throws an InputError changes nothing.
  void read_with(const py::dict& changed);

  const std::string text, file;
  py::dict overrides;  // by name
  py::dict seen;

 private:
  std::optional<scene::Scene> scene_;
};

}  // namespace tanor::python
