#include "sim/device/zero_guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <system_error>
#include <utility>

extern char** environ;

namespace kerf {
namespace {

namespace fs = std::filesystem;

constexpr int kOpensWithinMs = 10'000;  // a machine that is very busy
constexpr int kEndsWithinMs = 1'000;

// Beside the program (build tree and installed alike), where Kerf was installed, in the tree it was built in.
Expected<fs::path> findProgram() {
  std::error_code failed;
  std::vector<fs::path> places;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed).parent_path();
  if (!failed) places.push_back((program / ".." / KERF_LIBRARY_FOLDER / "kerf/kerf-zero-guard").lexically_normal());
  places.emplace_back(KERF_INSTALLED_GUARD);
  places.emplace_back(KERF_BUILT_GUARD);
  for (const fs::path& place : places)
    if (::access(place.c_str(), X_OK) == 0) return place;
  return fail({.code = Error::Code::kNotFound,
               .file = places.front().string(),
               .found = "no such program",
               .expected = "the small program that takes the force away should this one be killed",
               .hint = "install or build Kerf again, as a whole"});
}

tl::unexpected<Error> noProcess(const std::string& path, const char* what, int reason) {
  return fail({.code = Error::Code::kBadValue,
               .file = path,
               .found = fmt::format("{}: {}", what, std::strerror(reason)),
               .expected = "a small process beside this one, which takes the force away should this one be killed",
               .hint = "close other programs, or raise the limits nproc and nofile"});
}

// Two ends of which none is 0, 1 or 2, whatever this process has closed; both close when another program is started.
bool openSocket(std::array<int, 2>& ends) {
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return false;
  for (int& end : ends) {
    if (end > STDERR_FILENO) continue;
    const int higher = ::fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    ::close(end);
    end = higher;
  }
  return ends[0] >= 0 && ends[1] >= 0;
}

// In a session of its own, without any file of this process but the socket, as its input.
int spawn(const fs::path& program, const std::vector<std::string>& words, int socket, pid_t& process) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  sigset_t none;
  ::sigemptyset(&none);
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_adddup2(&files, socket, STDIN_FILENO);
  ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK);

  const int reason = ::posix_spawn(&process, program.c_str(), &files, &attributes, arguments.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&files);
  return reason;
}

// It says one byte when it has opened the node.
bool isReady(int socket) {
  pollfd waits{socket, POLLIN, 0};
  int found = -1;
  do found = ::poll(&waits, 1, kOpensWithinMs);
  while (found < 0 && errno == EINTR);
  char word = 0;
  return found > 0 && ::recv(socket, &word, 1, 0) == 1;
}

}  // namespace

Expected<ZeroGuard> ZeroGuard::start(const std::string& path, std::span<const Report> reports) {
  KERF_TRY(program, findProgram());
  std::vector<std::string> words = {program.string(), path};
  for (const Report& report : reports) {
    std::string digits;
    for (const std::uint8_t byte : report) digits += fmt::format("{:02x}", byte);
    words.push_back(std::move(digits));
  }

  std::array<int, 2> ends{-1, -1};
  if (!openSocket(ends)) return noProcess(path, "no socket", errno);
  ZeroGuard out;
  out.socket_ = ends[0];
  pid_t process = -1;
  const int reason = spawn(program, words, ends[1], process);
  ::close(ends[1]);
  if (reason != 0) return noProcess(path, "no process", reason);
  out.process_ = process;
  if (isReady(out.socket_)) return out;
  return fail({.code = Error::Code::kUnreadable,
               .file = path,
               .found = "a device that does not open a second time",
               .expected = "one that a small process beside this one may write to, should this one be killed",
               .hint = "close other programs that use it; plug it out and in"});
}

ZeroGuard::ZeroGuard(ZeroGuard&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), process_(std::exchange(other.process_, -1)) {}

ZeroGuard& ZeroGuard::operator=(ZeroGuard&& other) noexcept {
  if (this == &other) return *this;
  end();
  socket_ = std::exchange(other.socket_, -1);
  process_ = std::exchange(other.process_, -1);
  return *this;
}

ZeroGuard::~ZeroGuard() { end(); }

bool ZeroGuard::isThere() const noexcept {
  if (socket_ < 0) return false;
  pollfd end{socket_, 0, 0};
  return ::poll(&end, 1, 0) == 0;
}

void ZeroGuard::release() noexcept {
  const char not_needed = 'n';
  if (socket_ >= 0) (void)::send(socket_, &not_needed, 1, MSG_NOSIGNAL);
  end();
}

void ZeroGuard::end() noexcept {
  if (socket_ >= 0) {
    ::shutdown(socket_, SHUT_RDWR);  // for a child of this process, too, that was forked meanwhile and has it open
    ::close(socket_);
  }
  if (process_ > 0) {
    constexpr timespec kMs{0, 1'000'000};
    for (int n = 0; n < kEndsWithinMs && ::waitpid(process_, nullptr, WNOHANG) == 0; ++n) ::nanosleep(&kMs, nullptr);
  }
  socket_ = process_ = -1;
}

}  // namespace kerf
