#include "view/serve.hpp"

#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

namespace tanor::view {

namespace {

namespace fs = std::filesystem;

constexpr const char* address = "127.0.0.1";

std::string find_type(const fs::path& file) {
  constexpr std::array<std::array<std::string_view, 2>, 8> types{{{".html", "text/html; charset=utf-8"},
                                                                  {".json", "application/json"},
                                                                  {".txt", "text/plain; charset=utf-8"},
                                                                  {".csv", "text/csv; charset=utf-8"},
                                                                  {".md", "text/plain; charset=utf-8"},
                                                                  {".svg", "image/svg+xml"},
                                                                  {".png", "image/png"},
                                                                  {".xyz", "text/plain; charset=utf-8"}}};
  const std::string ending = file.extension().string();
  const auto found = std::ranges::find(types, ending, [](const auto& row) { return row[0]; });
  return std::string(found == types.end() ? "application/octet-stream" : (*found)[1]);
}

/// Returns the file of a request: a regular file in the folder, not reached through "..", hidden names, or links that
/// lead out.
std::optional<fs::path> find_file(const fs::path& folder, const std::string& wanted) {
  if (wanted.find('\0') != std::string::npos || wanted.find('\\') != std::string::npos) return std::nullopt;
  for (const fs::path& part : fs::path(wanted)) {
    if (part.string().starts_with(".")) return std::nullopt;
  }
  std::error_code error;
  const fs::path file = fs::canonical(folder / fs::path(wanted).relative_path(), error);
  if (error || !fs::is_regular_file(file, error)) return std::nullopt;
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return end == folder.end() && rest != file.end() ? std::optional(file) : std::nullopt;
}

/// Returns a tag that differs for each version of a file, since files are replaced as a whole.
std::string make_tag(const fs::path& file, std::uintmax_t size) {
  std::error_code error;
  const auto time = fs::last_write_time(file, error).time_since_epoch().count();
  return '"' + std::to_string(time) + '-' + std::to_string(size) + '"';
}

void answer(const fs::path& file, const httplib::Request& request, httplib::Response* response) {
  const auto stream = std::make_shared<std::ifstream>(file, std::ios::binary | std::ios::ate);
  if (!*stream) {
    response->status = 404;
    return;
  }
  const auto size = static_cast<std::size_t>(stream->tellg());
  const std::string tag = make_tag(file, size);
  response->set_header("ETag", tag);
  if (request.get_header_value("If-None-Match") == tag) {
    response->status = 304;
    return;
  }
  response->set_content_provider(
      size, find_type(file), [stream](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        std::array<char, 1 << 16> bytes;
        stream->seekg(static_cast<std::streamoff>(offset));
        stream->read(bytes.data(), static_cast<std::streamsize>(std::min(length, bytes.size())));
        return stream->gcount() > 0 && sink.write(bytes.data(), stream->gcount());
      });
}

/// Refuses requests that would write, and pages of other sites that use a name of theirs for this machine.
httplib::Server::HandlerResponse admit(int port, const httplib::Request& request, httplib::Response* response) {
  using Answer = httplib::Server::HandlerResponse;
  const std::string host = request.get_header_value("Host"), number = ":" + std::to_string(port);
  if (request.method != "GET" && request.method != "HEAD") {
    response->status = 405;
    response->set_header("Allow", "GET, HEAD");
    return Answer::Handled;
  }
  if (host == address + number || host == "localhost" + number) return Answer::Unhandled;
  response->status = 403;
  return Answer::Handled;
}

/// Blocks the signals that end the server in all threads started from now on, so that one thread can wait for them.
sigset_t hold_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int bind(int port, httplib::Server* server) {
  if (port == 0) return server->bind_to_any_port(address);
  return server->bind_to_port(address, port) ? port : -1;
}

}  // namespace

std::string serve(const Service& service) {
  const fs::path folder = fs::canonical(service.folder);
  httplib::Server server;
  // Without this two servers would share a port.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  // An idle connection would delay the end, and many of them would delay a page.
  server.set_keep_alive_max_count(1);
  server.set_read_timeout(std::chrono::seconds(1));
  server.new_task_queue = [] { return new httplib::ThreadPool(32); };
  server.set_default_headers({{"Cache-Control", "no-cache"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Cross-Origin-Resource-Policy", "same-origin"},
                              {"Referrer-Policy", "no-referrer"}});
  const int port = bind(service.port, &server);
  if (port <= 0) return "port " + std::to_string(service.port) + " of 127.0.0.1 is not free; choose another one";
  server.set_pre_routing_handler(
      [port](const httplib::Request& request, httplib::Response& response) { return admit(port, request, &response); });
  server.Get("/.*", [&](const httplib::Request& request, httplib::Response& response) {
    // This precedes the look at the file, because a run writes its last page before it ends.
    response.set_header("X-Tanor-Run", service.is_running() ? "running" : "ended");
    const std::string wanted = request.path == "/" ? service.first : request.path.substr(1);
    const std::optional<fs::path> file = find_file(folder, wanted);
    if (file) return answer(*file, request, &response);
    response.status = 404;
    response.set_content("there is no such file here\n", "text/plain");
  });

  const sigset_t signals = hold_signals();
  std::thread thread([&] { server.listen_after_bind(); });
  while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  service.begins(port);
  int signal = 0;
  sigwait(&signals, &signal);
  server.stop();
  thread.join();
  return {};
}

}  // namespace tanor::view

extern "C" __attribute__((visibility("default"))) void tanor_serve_folder(const tanor::view::Service& service,
                                                                          std::string* trouble) {
  *trouble = tanor::view::serve(service);
}
