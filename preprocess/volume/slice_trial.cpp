#include "preprocess/volume/slice_trial.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

// Starts the program with `channel` as its standard input; its output is dropped. The signals of the host are not
// its own: Ctrl-C reaches the host alone, which then kills it.
// @return an error number.
int start(pid_t& child, const fs::path& program, VolumeFormat format, std::uint64_t max_bytes, int channel) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, channel, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);

  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  std::string name = program.string(), kind = std::to_string(static_cast<int>(format)),
              most = std::to_string(max_bytes);
  char* const words[] = {name.data(), kind.data(), most.data(), nullptr};
  const int error = posix_spawn(&child, name.c_str(), &actions, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

// The paths, each ended by a zero. A program that died shows when its answer is read.
void sendPaths(int channel, const std::vector<fs::path>& files) {
  std::string list;
  for (const fs::path& f : files) list += f.string() + '\0';
  for (std::size_t sent = 0; sent < list.size();) {
    const auto n = send(channel, list.data() + sent, list.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno != EINTR) break;
    if (n > 0) sent += static_cast<std::size_t>(n);
  }
  shutdown(channel, SHUT_WR);
}

// Waits for one byte; without one the program died. Its exit status is not used: a host that ignores SIGCHLD gets
// none.
Expected<bool> answerOf(int channel, const Progress& progress) {
  constexpr int kWait_ms = 100;
  for (;;) {
    pollfd waits{channel, POLLIN, 0};
    const int ready = poll(&waits, 1, kWait_ms);
    if (ready > 0) {
      char answer = 0;
      const auto n = read(channel, &answer, 1);
      if (n >= 0 || errno != EINTR) return n == 1;
    } else if (!report(progress, 0, "trying the slices")) {
      return cancelled();
    }
  }
}

// Ends with its scope.
struct Child {
  pid_t id = 0;
  bool has_answered = false;
  ~Child() {
    if (id == 0) return;
    if (!has_answered) kill(id, SIGKILL);
    while (waitpid(id, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
};

}  // namespace

Expected<bool> survivesReading(const std::vector<fs::path>& files, VolumeFormat format, std::uint64_t max_bytes,
                               const Progress& progress) {
  KERF_TRY(folder, volumeReaderFolder());
  const fs::path program = folder / "kerf-slice-trial";
  const auto unusable = [&](const std::string& why) {
    return fail({.code = Error::Code::kUnsupported,
                 .file = program.string(),
                 .found = "it cannot be started: " + why,
                 .expected = "the program that tries slices before Kerf reads them",
                 .hint = "apt install kerf-volumes; without packages install or build Kerf again, as a whole"});
  };
  int ends[2];
  const auto meaning = [](int error) { return std::generic_category().message(error); };
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return unusable(meaning(errno));
  const Descriptor ours(ends[0]);
  Descriptor its(ends[1]);
  Child child;
  pid_t id = 0;
  if (const int error = start(id, program, format, max_bytes, its.get()); error != 0) return unusable(meaning(error));
  child.id = id;
  its.close();

  sendPaths(ours.get(), files);
  KERF_TRY(begins, answerOf(ours.get(), progress));
  if (!begins) return unusable("it ended before it read a slice");
  KERF_TRY(survives, answerOf(ours.get(), progress));
  child.has_answered = true;
  return survives;
}

}  // namespace kerf::internal
