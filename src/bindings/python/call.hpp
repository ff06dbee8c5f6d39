#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

/// \file
/// Calls of the library from Python, and of Python from the library.
namespace tanor::python {

namespace py = pybind11;

/// Runs the library without the interpreter's lock, so that other threads of Python go on.
template <class Work>
decltype(auto) without_lock(const Work& work) {
  const py::gil_scoped_release released;
  return work();
}

/// A Python object that the library may copy and drop on any thread.
class Shared {
 public:
  explicit Shared(py::object object)
      : object_(new py::object(std::move(object)), [](const py::object* last) {
          const py::gil_scoped_acquire acquired;
          delete last;
        }) {}

  /// Returns the object. Requires the interpreter's lock.
  const py::object& operator*() const { return *object_; }

 private:
  std::shared_ptr<const py::object> object_;
};

/// A handle serves one thread at a time. Python's threads run side by side while the library computes, so each call
/// takes its turn; the thread that has it may call again from inside (observers, functions).
class Turns {
 public:
  class Turn {
   public:
    Turn(Turns& turns, const char* what) : turns_(turns) {
      std::thread::id nobody{};
      const std::thread::id self = std::this_thread::get_id();
      is_outermost_ = turns_.owner_.compare_exchange_strong(nobody, self);
      if (!is_outermost_ && nobody != self) {
        throw std::runtime_error(std::string("this ") + what +
                                 " is in use by another thread; give each thread its own");
      }
    }
    ~Turn() {
      if (is_outermost_) turns_.owner_ = std::thread::id{};
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
    bool is_outermost_ = false;
  };

 private:
  std::atomic<std::thread::id> owner_{};
};

}  // namespace tanor::python
