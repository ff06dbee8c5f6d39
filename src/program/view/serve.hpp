#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace tanor::view {

/// A folder that is shown to browsers of this machine.
struct Service {
  std::filesystem::path folder;
  std::string first;                     ///< file served at "/"
  int port = 0;                          ///< port on 127.0.0.1; 0 for any free one
  std::function<void(int port)> begins;  ///< called once the server answers
  std::function<bool()> is_running;      ///< true while the run of the folder goes on; sent as the header X-Tanor-Run
};

/// Serves the files of a folder, and nothing outside it, until SIGINT, SIGTERM or SIGHUP arrives. It accepts only GET
/// and HEAD, and only the addresses 127.0.0.1 and localhost. Returns why it could not serve, or an empty text.
///
/// This function is in a separate module (`tanor_view`), so that runs need not load cpp-httplib and its dependencies.
std::string serve(const Service& service);

/// Name by which the program finds the module's function, and its type.
inline constexpr const char* serve_symbol = "tanor_serve_folder";
using ServeFunction = void(const Service& service, std::string* trouble);

}  // namespace tanor::view
