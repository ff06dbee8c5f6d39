#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "cli/command_line.hpp"
#include "cli/folder_lock.hpp"
#include "cli/messages.hpp"
#include "report/html_page.hpp"
#include "report/module.hpp"
#include "report/stored_motion.hpp"
#include "view/serve.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

namespace {

view::ServeFunction* load_server() {
  return reinterpret_cast<view::ServeFunction*>(report::load_function(
      "tanor_view", view::serve_symbol,
      fmt::format("this tanor was built without cpp-httplib and has no server; {} opens in a browser by itself",
                  report::html_page_name)));
}

bool is_running(const fs::path& folder) {
  // A holder has no name yet for a moment, and none on a full disk.
  const std::optional<std::string> holder = find_holder(folder);
  return holder && (holder->empty() || *holder == "run");
}

/// Returns the folder of a run that has a page, or throws the reason why there is none.
fs::path require_page(const fs::path& given) {
  fs::path folder = given.filename() == report::html_page_name ? fs::absolute(given).parent_path() : given;
  if (!fs::exists(folder)) throw InputError(given.string(), "there is no such folder");
  if (!fs::is_directory(folder))
    throw InputError(given.string(), "is a file; wanted the folder of a run, such as net.out");
  if (fs::exists(folder / report::html_page_name)) return folder;
  if (is_running(folder))
    throw InputError(folder.string(), "the run that goes on there makes no page; it began without --report");
  const std::string why = report::read_stop(folder);
  throw InputError(folder.string(),
                   fmt::format("there is no {}; tanor run SCENE --out {} --report makes it{}", report::html_page_name,
                               typed(folder), why.empty() ? "" : "; the run there was stopped: " + why));
}

/// True if there is a window in which a browser could open; without one, a browser might write into the terminal.
bool has_display() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const char* const value = std::getenv(name);
    if (value && *value != '\0') return true;
  }
  return false;
}

/// The attributes with which a browser starts: it does not get Ctrl-C, and signals have their default actions.
struct BrowserAttributes {
  posix_spawnattr_t all;
  BrowserAttributes() {
    posix_spawnattr_init(&all);
    sigset_t none, piped;
    sigemptyset(&none);
    sigemptyset(&piped);
    for (const int signal : {SIGPIPE, SIGXFSZ}) sigaddset(&piped, signal);
    posix_spawnattr_setflags(&all, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&all, 0);
    posix_spawnattr_setsigmask(&all, &none);
    posix_spawnattr_setsigdefault(&all, &piped);
  }
  ~BrowserAttributes() { posix_spawnattr_destroy(&all); }
};

/// Opens the user's browser, as xdg-utils find it. Returns false if they are missing.
bool open_browser(const std::string& url) {
  std::string program = "xdg-open", place = url;
  std::array<char*, 3> words{program.data(), place.data(), nullptr};
  const BrowserAttributes attributes;
  posix_spawn_file_actions_t silence;
  posix_spawn_file_actions_init(&silence);
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&silence, descriptor, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  const bool is_started = posix_spawnp(&process, words[0], &silence, &attributes.all, words.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&silence);
  return is_started;
}

void print_address(const Options& options, const fs::path& folder, int port) {
  const std::string url = fmt::format("http://127.0.0.1:{}/", port);
  if (options.json) {
    print_json({{"url", url}, {"port", port}, {"folder", folder.string()}});
  } else {
    fmt::print("{} shows {}; Ctrl-C ends it\n", url, typed(folder));
  }
  std::fflush(stdout);
  if (options.server.no_open || (has_display() && open_browser(url)) || options.quiet) return;
  print_message(
      fmt::format("open it in a browser; from another machine, first ssh -L {}:127.0.0.1:{} HOST", port, port));
}

}  // namespace

ExitCode execute_view(const Options& options) {
  const fs::path folder = require_page(options.folder);
  view::ServeFunction* const serve = load_server();
  std::string trouble;
  serve({.folder = folder,
         .first = report::html_page_name,
         .port = options.server.port,
         .begins = [&](int port) { print_address(options, folder, port); },
         .is_running = [&] { return is_running(folder); }},
        &trouble);
  if (!trouble.empty()) throw InputError("--port", trouble);
  return ExitCode::Done;
}

}  // namespace tanor::cli
