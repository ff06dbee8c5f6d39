/// `tanor view` serves the files of its folder and nothing else.

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// A socket that closes with its owner.
class Connection {
 public:
  explicit Connection(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(static_cast<std::uint16_t>(port));
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_open_ = connect(socket_, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  }
  ~Connection() { close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Returns the whole answer with its header.
  std::string ask(const std::string& request) const {
    if (!is_open_ || write(socket_, request.data(), request.size()) < 0) return "no connection";
    std::string answer;
    char bytes[4096];
    for (ssize_t taken = 0; (taken = read(socket_, bytes, sizeof bytes)) > 0;)
      answer.append(bytes, static_cast<std::size_t>(taken));
    return answer;
  }

 private:
  int socket_;
  bool is_open_;
};

/// `tanor view` on a folder `o`, until the test ends.
class Viewer {
 public:
  explicit Viewer(const Folder& folder, Words options = {})
      : out_(folder / "view.json"), program_(folder, make_words(std::move(options)), out_) {
    EXPECT_TRUE(wait_until([&] { return json::accept(report::read_text(out_)); }));
    port = json::parse(report::read_text(out_))["port"];
  }

  std::string ask(const std::string& method, const std::string& path, const std::string& more = "") const {
    return ask_host(method, path, "127.0.0.1:" + std::to_string(port), more);
  }
  std::string ask_host(const std::string& method, const std::string& path, const std::string& host,
                       const std::string& more = "") const {
    return Connection(port).ask(method + " " + path + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n");
  }
  int status(const std::string& method, const std::string& path) const {
    return std::stoi(ask(method, path).substr(9, 3));
  }
  Program& program() { return program_; }

  int port = 0;

 private:
  static Words make_words(Words options) {
    options.insert(options.begin(), {"view", "o", "--no-open", "--json"});
    return options;
  }

  std::string out_;
  Program program_;
};

/// Fills a folder with a page, a file below, a hidden file, and links, of which one stays inside and two lead out.
void fill(const Folder& folder) {
  std::filesystem::create_directories(folder / "o/trajectory");
  write_text(folder / "o/report.html", "<p>page</p>");
  write_text(folder / "o/summary.json", "{}");
  write_text(folder / "o/trajectory/frame.vtp", "frame");
  write_text(folder / "o/.tanor.lock", "1 run\n");
  write_text(folder / "secret.txt", "secret");
  std::filesystem::create_symlink("summary.json", folder / "o/inside.json");
  std::filesystem::create_symlink("../secret.txt", folder / "o/outside.txt");
  std::filesystem::create_symlink("..", folder / "o/up");
}

TEST(ViewTest, ServesThePageAndTheFilesOfTheFolder) {
  const Folder folder;
  fill(folder);
  const Viewer viewer(folder);

  EXPECT_TRUE(viewer.ask("GET", "/").ends_with("\r\n\r\n<p>page</p>"));
  EXPECT_TRUE(contains(viewer.ask("GET", "/"), "Content-Type: text/html"));
  EXPECT_TRUE(viewer.ask("HEAD", "/").ends_with("\r\n\r\n"));
  EXPECT_TRUE(viewer.ask("GET", "/trajectory/frame.vtp").ends_with("frame"));
  EXPECT_EQ(viewer.status("GET", "/inside.json"), 200);
  EXPECT_EQ(viewer.status("GET", "/missing.json"), 404);
}

TEST(ViewTest, NothingOutsideTheFolderCanBeRead) {
  const Folder folder;
  fill(folder);
  const Viewer viewer(folder);

  for (const std::string path :
       {"/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt", "/trajectory/../../secret.txt", "/outside.txt",
        "/up/secret.txt", "//etc/passwd", "/%2fetc/passwd", "/.tanor.lock", "/trajectory", "/o\\..\\secret.txt",
        "/report.html%00.txt"}) {
    const std::string answer = viewer.ask("GET", path);
    EXPECT_FALSE(contains(answer, "secret") || contains(answer, "root:")) << path << answer;
    EXPECT_FALSE(answer.starts_with("HTTP/1.1 200")) << path << answer;
  }
}

TEST(ViewTest, NothingCanBeWrittenAndOtherNamesAreRefused) {
  const Folder folder;
  fill(folder);
  const Viewer viewer(folder);

  for (const std::string method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS"})
    EXPECT_EQ(viewer.status(method, "/summary.json"), 405) << method;
  EXPECT_EQ(read_text(folder / "o/summary.json"), "{}");
  const std::string port = ":" + std::to_string(viewer.port);
  EXPECT_TRUE(viewer.ask_host("GET", "/", "localhost" + port).starts_with("HTTP/1.1 200"));
  EXPECT_TRUE(viewer.ask_host("GET", "/", "evil.example" + port).starts_with("HTTP/1.1 403"));
  EXPECT_TRUE(viewer.ask_host("GET", "/", "127.0.0.1").starts_with("HTTP/1.1 403"));
}

TEST(ViewTest, ATagTellsWhetherThePageIsANewOne) {
  const Folder folder;
  fill(folder);
  const Viewer viewer(folder);
  const std::string answer = viewer.ask("HEAD", "/");
  const std::size_t begin = answer.find("ETag: ") + 6;
  const std::string tag = answer.substr(begin, answer.find('\r', begin) - begin);

  EXPECT_TRUE(viewer.ask("GET", "/", "If-None-Match: " + tag + "\r\n").starts_with("HTTP/1.1 304"));
  write_text(folder / "o/report.html", "<p>another</p>");
  EXPECT_TRUE(viewer.ask("GET", "/", "If-None-Match: " + tag + "\r\n").ends_with("<p>another</p>"));
}

// The page of a killed run says forever that it goes on, but the header does not.
TEST(ViewTest, TellsWhetherTheRunGoesOn) {
  const Folder folder;
  fill(folder);
  const Viewer viewer(folder);
  EXPECT_TRUE(contains(viewer.ask("HEAD", "/"), "X-Tanor-Run: ended")) << "of a run that left its lock behind";
  // This is what src/program/cli/folder_lock.cpp does.
  const int lock = open((folder / "o/.tanor.lock").c_str(), O_RDWR);
  EXPECT_EQ(flock(lock, LOCK_EX | LOCK_NB), 0);
  EXPECT_TRUE(contains(viewer.ask("HEAD", "/"), "X-Tanor-Run: running"));
  close(lock);
  EXPECT_TRUE(contains(viewer.ask("HEAD", "/"), "X-Tanor-Run: ended"));
}

TEST(ViewTest, EndsWithoutAFaultOnCtrlC) {
  const Folder folder;
  fill(folder);
  Viewer viewer(folder);

  kill(viewer.program().process(), SIGINT);

  const Ended ended = viewer.program().wait();
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.err, "");
}

TEST(ViewTest, TakesAPortAloneOrSaysThatItIsNotFree) {
  const Folder folder;
  fill(folder);
  const Viewer viewer(folder);
  const std::string port = std::to_string(viewer.port);

  EXPECT_TRUE(contains(complaint(folder, {"view", "o", "--no-open", "--port", port}),
                       "--port: port " + port + " of 127.0.0.1 is not free"));
}

TEST(ViewTest, SaysWhatThereIsToDoWhereThereIsNoPage) {
  const Folder folder;
  std::filesystem::create_directory(folder / "o");
  write_text(folder / "net.json", "{}");

  EXPECT_TRUE(
      contains(complaint(folder, {"view", "o"}), "o: there is no report.html; tanor run SCENE --out o --report"));
  EXPECT_TRUE(contains(complaint(folder, {"view", "missing"}), "missing: there is no such folder"));
  EXPECT_TRUE(contains(complaint(folder, {"view", "net.json"}), "is a file; wanted the folder of a run"));
  EXPECT_TRUE(contains(complaint(folder, {"view", "o", "--port", "70000"}), "--port: must be a whole number"));
  write_text(folder / "o/.tanor.lock", "1 run\n");
  EXPECT_TRUE(contains(complaint(folder, {"view", "o"}), "there is no report.html")) << "a killed run left its lock";
  const int lock = open((folder / "o/.tanor.lock").c_str(), O_RDWR);
  ASSERT_EQ(flock(lock, LOCK_EX | LOCK_NB), 0);
  EXPECT_TRUE(contains(complaint(folder, {"view", "o"}), "began without --report"));
  close(lock);
}

}  // namespace
}  // namespace tanor::cli
