#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace tanor::view {

/// A folder, shown to browsers of this machine.
struct Service {
  std::filesystem::path folder;
  std::string first;                     ///< file behind "/"
  int port = 0;                          ///< on 127.0.0.1; 0: any that is free
  std::function<void(int port)> begins;  ///< called once the server answers
  std::function<bool()> is_running;      ///< whether the run of the folder goes on; the header X-Tanor-Run tells it
};

/// Serves the files of a folder, and nothing outside it, until SIGINT, SIGTERM or SIGHUP comes. Only GET and HEAD, only
/// for the addresses 127.0.0.1 and localhost. Returns why it could not, or nothing.
///
/// It lies in a module of its own (`tanor_view`), so that runs need not load cpp-httplib and what that needs.
std::string serve(const Service& service);

/// The name by which the program finds the module's function, and its type.
inline constexpr const char* serve_symbol = "tanor_serve_folder";
using ServeFunction = void(const Service& service, std::string* trouble);

}  // namespace tanor::view
