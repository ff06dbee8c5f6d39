#pragma once

#include <optional>
#include <string>
#include <utility>

#include "python/call.hpp"

namespace tanor::python {

/// An object of the library that is made from a description on first use. Copies and pickles keep the description.
template <class Library>
class Handle {
 public:
  explicit Handle(std::string name) : name_(std::move(name)) {}
  virtual ~Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  /// Returns call(library's object), run without the interpreter's lock.
  template <class Call>
  auto run(const Call& call) {
    const Turns::Turn turn(turns_, name_.c_str());
    if (!made_) made_.emplace(make());
    return without_lock([&] { return call(*made_); });
  }

 private:
  virtual Library make() = 0;

  std::string name_;
  std::optional<Library> made_;
  Turns turns_;
};

/// Returns what a method of the library returns, called without the interpreter's lock. `Self` has run(call).
template <class Self, auto method>
auto ask(Self& self) {
  return self.run([](auto& library) { return (library.*method)(); });
}

}  // namespace tanor::python
