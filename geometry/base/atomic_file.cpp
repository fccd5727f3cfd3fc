#include "geometry/base/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <locale>
#include <optional>
#include <streambuf>

#include "geometry/base/hash.h"
#include "geometry/base/text.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

Error writeError(const fs::path& path, const std::string& step, int reason) {
  std::string hint = "check the path and its permissions";
  if (reason == ENOSPC || reason == EDQUOT) hint = "free some space or choose another disk; nothing was overwritten";
  if (reason == ENOENT) hint = "make the folder first";
  if (reason == EROFS) hint = "choose a writable disk";
  return {Error::Code::kWriteFailed, path.string(), step, std::strerror(reason), "", hint};
}

// Buffer over a file descriptor that remembers why a write failed; std::filebuf does not.
class DescriptorBuffer : public std::streambuf {
 public:
  explicit DescriptorBuffer(int fd) : fd_(fd) { setp(buffer_.data(), buffer_.data() + buffer_.size()); }
  int reason() const { return reason_; }

 protected:
  int_type overflow(int_type c) override {
    if (!drain()) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) {
      *pptr() = traits_type::to_char_type(c);
      pbump(1);
    }
    return traits_type::not_eof(c);
  }
  int sync() override { return drain() ? 0 : -1; }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const bool tells = offset == 0 && from == std::ios_base::cur;
    if (!tells && !drain()) return pos_type(off_type(-1));
    const int whence = from == std::ios_base::beg ? SEEK_SET : from == std::ios_base::cur ? SEEK_CUR : SEEK_END;
    const off_t at = ::lseek(fd_, offset, whence);
    return at < 0 ? pos_type(off_type(-1)) : pos_type(at + (pptr() - pbase()));
  }
  pos_type seekpos(pos_type at, std::ios_base::openmode which) override {
    return seekoff(off_type(at), std::ios_base::beg, which);
  }

 private:
  bool drain() {
    for (const char* p = pbase(); p < pptr() && reason_ == 0;) {
      const ssize_t n = ::write(fd_, p, static_cast<std::size_t>(pptr() - p));
      if (n >= 0)
        p += n;
      else if (errno != EINTR)
        reason_ = errno;
    }
    setp(buffer_.data(), buffer_.data() + buffer_.size());
    return reason_ == 0;
  }

  int fd_;
  int reason_ = 0;
  std::array<char, 1 << 16> buffer_;
};

fs::path folderOf(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

int syncPath(const fs::path& path, int flags) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | flags);
  if (fd < 0) return errno;
  // Some file systems cannot sync a folder (EINVAL); then there is nothing to wait for.
  const int reason = ::fsync(fd) != 0 && errno != EINVAL ? errno : 0;
  ::close(fd);
  return reason;
}

Expected<void> syncAllIn(const fs::path& folder) {
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const bool is_ours = it->is_directory(error) || it->is_regular_file(error);
    if (const int reason = is_ours ? syncPath(it->path(), 0) : 0)
      return fail(writeError(it->path(), "syncing to the disk", reason));
  }
  if (error) return fail(writeError(folder, "syncing to the disk", error.value()));
  return syncFolder(folder);
}

// Where a symbolic link leads, so that the link itself survives.
fs::path followed(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_symlink(path, ignored)) return path;
  const fs::path target = fs::weakly_canonical(path, ignored);
  return target.empty() ? path : target;
}

std::string firstLineOf(const char* file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

// Tag of the process table that can tell whether a process lives: this machine, this boot, this PID namespace. Eight
// hexadecimal digits. A cloned machine shares name and number with its source, but not the random boot id.
const std::string& processTable() {
  static const std::string tag = [] {
    std::array<char, 256> host{};
    ::gethostname(host.data(), host.size() - 1);
    std::error_code ignored;
    const std::string names = host.data() + firstLineOf("/proc/sys/kernel/random/boot_id") +
                              fs::read_symlink("/proc/self/ns/pid", ignored).string();
    std::uint32_t hash = 2166136261u;  // FNV-1a
    for (const char c : names) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
    return fmt::format("{:08x}", hash);
  }();
  return tag;
}

// Temporary files lie beside their target, as .NAME.kerf-TABLE-PROCESS-NUMBER.
std::string temporaryPrefix(const fs::path& target) {
  return fmt::format(".{}.kerf-{}-", target.filename().string(), processTable());
}

constexpr std::string_view kMovedAside = "-old";  // the target while a new one takes its place

struct Leftover {
  std::string name, table;  // of the target
  int process = 0;
};

std::optional<Leftover> leftoverOf(const std::string& file) {
  constexpr std::string_view kMark = ".kerf-";
  const std::size_t mark = file.rfind(kMark), table = mark + kMark.size();
  if (mark == file.npos || mark < 2 || file.front() != '.' || file.find('-', table) != table + 8) return {};
  return Leftover{file.substr(1, mark - 1), file.substr(table, 8), std::atoi(file.c_str() + table + 9)};
}

// Deletes leftovers of killed processes in a folder, and restores a target that one of them moved aside. For processes
// of another machine, or of an earlier boot, it can not tell whether they live: their files count as leftovers after a
// week.
void sweepLeftovers(const fs::path& folder) {
  constexpr std::chrono::hours kNobodyWrites{7 * 24};
  std::error_code ignored;
  for (fs::directory_iterator it(folder, ignored), end; it != end; it.increment(ignored)) {
    const std::string file = it->path().filename().string();
    const auto left = leftoverOf(file);
    if (!left || left->process <= 0) continue;
    std::error_code failed;
    const bool is_dead = left->table == processTable()
                             ? ::kill(left->process, 0) != 0 && errno == ESRCH
                             : it->last_write_time(failed) < fs::file_time_type::clock::now() - kNobodyWrites;
    if (!is_dead || failed) continue;
    const fs::path target = folder / left->name;
    if (file.ends_with(kMovedAside) && !fs::exists(fs::symlink_status(target, ignored)))
      fs::rename(it->path(), target, ignored);
    else
      fs::remove_all(it->path(), ignored);
  }
}

// A name beside `target` that no living process uses; `make` returns false with errno set. Deletes leftovers of a
// killed process, and skips those with our id.
template <class Make>
std::string makeTemporary(const fs::path& target, const Make& make) {
  static std::atomic<unsigned> counter{0};
  sweepLeftovers(folderOf(target));
  for (int attempt = 0; attempt < 1000; ++attempt) {
    std::string name =
        (folderOf(target) / fmt::format("{}{}-{}", temporaryPrefix(target), ::getpid(), counter++)).string();
    if (make(name.c_str())) return name;
    if (errno != EEXIST) break;
  }
  return {};
}

}  // namespace

struct AtomicFile::State {
  State(int descriptor, fs::path asked_for, fs::path renamed_to, std::string temporary_file)
      : fd(descriptor),
        path(std::move(asked_for)),
        target(std::move(renamed_to)),
        temporary(std::move(temporary_file)),
        buffer(fd),
        stream(&buffer) {
    stream.imbue(std::locale::classic());
  }
  ~State() {
    if (fd >= 0) ::close(fd);
    if (!temporary.empty()) ::unlink(temporary.c_str());
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  Expected<void> flush();

  int fd;
  fs::path path, target;
  std::string temporary;  // empty: the target itself is being written
  DescriptorBuffer buffer;
  std::ostream stream;
};

AtomicFile::AtomicFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
AtomicFile::AtomicFile(AtomicFile&&) noexcept = default;
AtomicFile& AtomicFile::operator=(AtomicFile&&) noexcept = default;
AtomicFile::~AtomicFile() = default;

Expected<AtomicFile> AtomicFile::create(const fs::path& path) {
  const fs::path target = followed(path);
  struct stat status {};
  const bool exists = ::stat(target.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return fail(writeError(path, "opening for writing", EISDIR));
  if (exists && !S_ISREG(status.st_mode)) {
    const int fd = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd < 0) return fail(writeError(path, "opening for writing", errno));
    return AtomicFile(std::make_unique<State>(fd, path, target, std::string()));
  }
  if (!target.has_filename()) return fail(writeError(path, "opening for writing", EISDIR));
  std::error_code ignored;
  if (!exists && fs::is_symlink(fs::symlink_status(target, ignored)))
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .place = "opening for writing",
                 .found = "a broken link",
                 .expected = "a new file, or a link to one",
                 .hint = "delete the link, or choose another name"});
  int fd = -1;
  std::string temporary = makeTemporary(target, [&](const char* file) {
    return (fd = ::open(file, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) >= 0;
  });
  if (fd < 0) return fail(writeError(path, "opening for writing", errno));
  // Copies the permissions of the replaced file; if that fails, those of a new file suffice.
  if (exists && ::fchmod(fd, status.st_mode & 07777) != 0) errno = 0;
  return AtomicFile(std::make_unique<State>(fd, path, target, std::move(temporary)));
}

std::ostream& AtomicFile::stream() { return state_->stream; }

Expected<void> AtomicFile::State::flush() {
  stream.flush();
  if (buffer.reason() != 0) return fail(writeError(path, "writing", buffer.reason()));
  if (!stream)
    return fail(
        {.code = Error::Code::kWriteFailed, .file = path.string(), .place = "writing", .found = "the stream failed"});
  return {};
}

Expected<fs::path> AtomicFile::flushed() {
  KERF_CHECK(state_->flush());
  return fs::path(state_->temporary);
}

Expected<std::string> AtomicFile::sha256() {
  KERF_TRY(file, flushed());
  if (file.empty()) return std::string();
  return sha256OfFile(file);
}

Expected<void> AtomicFile::commit() {
  State& s = *state_;
  KERF_CHECK(s.flush());
  // A terminal or pipe cannot be synced (EINVAL, EROFS).
  if (::fsync(s.fd) != 0 && !s.temporary.empty()) return fail(writeError(s.path, "syncing to the disk", errno));
  const int fd = s.fd;
  s.fd = -1;
  if (::close(fd) != 0) return fail(writeError(s.path, "closing", errno));
  if (s.temporary.empty()) return {};
  if (::rename(s.temporary.c_str(), s.target.c_str()) != 0)
    return fail(writeError(s.path, "renaming into place", errno));
  s.temporary.clear();
  return syncFolder(folderOf(s.target));
}

struct AtomicFolder::State {
  ~State() {
    std::error_code ignored;
    if (!staging.empty()) fs::remove_all(staging, ignored);
  }
  fs::path path, target, staging;
  std::string manifest;
  bool overwrite = false;
};

namespace {

// Kind of a Kerf folder, if it differs from the kind of that manifest, else null. A run holds a copy of its tool, as a
// baked tool does.
const char* otherBundle(const fs::path& folder, std::string_view manifest) {
  constexpr std::array<std::pair<std::string_view, const char*>, 3> kBundles{
      {{"case.toml", "it is a case"}, {"run.toml", "it is a run"}, {"tool.vdb", "it is a baked tool"}}};
  std::error_code ignored;
  for (const auto& [file, what] : kBundles)
    if (fs::exists(folder / file, ignored)) {
      const bool is_tool = file == "tool.vdb" && manifest == "tool.toml";
      return file == manifest || is_tool ? nullptr : what;
    }
  return nullptr;
}

// Files that bundles hold beside those named in their .toml files.
bool isUsualName(const std::string& name, std::string_view manifest) {
  constexpr std::array<std::string_view, 23> kNames{
      "tool.ply",    "tools",    "run.new.vdb", "case.toml",  "recipe.toml",   "solid.ply",        "anatomy.vdb",
      "run.toml",    "run.vdb",  "begin.vdb",   "forces.csv", "summary.json",  "session.kerflog",  "sound.wav",
      "tool.toml",   "tool.vdb", "path.toml",   "path.csv",   "saw-plan.toml", "piece-names.toml", "lock",
      "picture.png", "trim.toml"};
  if (name == manifest || name.starts_with("source-") || name.starts_with("checkpoint-")) return true;
  if (std::find(kNames.begin(), kNames.end(), name) != kNames.end()) return true;
  return manifest.ends_with(".ply") && name.ends_with(".ply");  // demo anatomy without a recipe
}

// The text of all .toml files of a folder, of each no more than Kerf ever writes.
std::string tomlTextOf(const fs::path& folder) {
  constexpr std::size_t kMost = 1 << 20;
  std::string out;
  std::error_code ignored;
  for (fs::directory_iterator it(folder, ignored), end; it != end; it.increment(ignored)) {
    if (it->path().extension() == ".toml") out += readSmallFile(it->path(), kMost).value_or("");
  }
  return out;
}

// The first entry, by name, not written by Kerf in a folder to replace: it would be lost. Empty if none.
std::string foreignEntry(const fs::path& folder, std::string_view manifest) {
  const std::string named = tomlTextOf(folder);
  std::string first;
  std::error_code ignored;
  for (fs::directory_iterator it(folder, ignored), end; it != end; it.increment(ignored)) {
    std::string name = it->path().filename().string();
    const bool is_named =
        named.find('"' + name + '"') != std::string::npos || named.find("'" + name + "'") != std::string::npos;
    const bool is_leftover = name.starts_with('.') && name.find(".kerf-") != std::string::npos;
    if (isUsualName(name, manifest) || is_named || is_leftover) continue;
    if (first.empty() || name < first) first = std::move(name);
  }
  return first;
}

Error holdsForeign(const fs::path& path, const std::string& entry) {
  return {.code = Error::Code::kWriteFailed,
          .file = path.string(),
          .place = "folder",
          .found = "it also holds \"" + entry + "\", which Kerf did not write",
          .expected = "a folder without other files",
          .hint = "move it away, or choose another name"};
}

}  // namespace

AtomicFolder::AtomicFolder(std::unique_ptr<State> state) : state_(std::move(state)) {}
AtomicFolder::AtomicFolder(AtomicFolder&&) noexcept = default;
AtomicFolder& AtomicFolder::operator=(AtomicFolder&&) noexcept = default;
AtomicFolder::~AtomicFolder() = default;

const fs::path& AtomicFolder::staging() const { return state_->staging; }
const fs::path& AtomicFolder::target() const { return state_->target; }

Expected<AtomicFolder> AtomicFolder::create(const fs::path& path, bool overwrite, std::string_view manifest) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->target = followed(path.has_filename() ? path : path.parent_path());
  state->overwrite = overwrite;
  state->manifest = manifest;
  if (!state->target.has_filename()) return fail(writeError(path, "making the folder", EINVAL));
  sweepLeftovers(folderOf(state->target));
  std::error_code error;
  const fs::file_status status = fs::status(state->target, error);
  if (fs::exists(status)) {
    const auto refuse = [&](const char* found, const std::string& expected, const char* hint) {
      return fail({.code = Error::Code::kWriteFailed,
                   .file = path.string(),
                   .place = "folder",
                   .found = found,
                   .expected = expected,
                   .hint = hint});
    };
    if (!fs::is_directory(status))
      return refuse("a file of that name exists", "a folder or nothing", "choose another name");
    const bool empty = fs::is_empty(state->target, error);
    if (error) return fail(writeError(path, "looking into the folder", error.value()));
    if (!empty && !overwrite) return refuse("it exists already", "a new folder", "choose another name, or --overwrite");
    const std::string expected = fmt::format("a folder with {} in it, or an empty one", manifest);
    if (const char* other = empty ? nullptr : otherBundle(state->target, manifest))
      return refuse(other, expected, "choose another name: only a folder of the same kind is replaced");
    if (!empty && !fs::exists(state->target / manifest, error))
      return refuse("it exists and was not made by Kerf", expected,
                    "choose another name; Kerf deletes only its own files");
    if (const std::string foreign = empty ? "" : foreignEntry(state->target, manifest); !foreign.empty())
      return fail(holdsForeign(path, foreign));
  } else if (fs::is_symlink(fs::symlink_status(state->target, error))) {
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .place = "folder",
                 .found = "a broken link",
                 .expected = "a new folder, or a link to one",
                 .hint = "delete the link, or choose another name"});
  }
  state->staging = makeTemporary(state->target, [](const char* folder) { return ::mkdir(folder, 0777) == 0; });
  if (state->staging.empty()) return fail(writeError(path, "making the folder", errno));
  return AtomicFolder(std::move(state));
}

Expected<void> AtomicFolder::commit() {
  State& s = *state_;
  std::error_code error;
  KERF_CHECK(syncAllIn(s.staging));

  // rename() replaces nothing or an empty folder; for a full one, an exchange leaves the old folder in staging.
  if (::rename(s.staging.c_str(), s.target.c_str()) == 0) {
    s.staging.clear();
  } else if ((errno == ENOTEMPTY || errno == EEXIST) && s.overwrite) {
    if (!fs::exists(s.target / s.manifest, error))  // it came while we worked
      return fail(writeError(s.path, "renaming into place", EEXIST));
    if (const std::string foreign = foreignEntry(s.target, s.manifest); !foreign.empty())
      return fail(holdsForeign(s.path, foreign));
    if (::renameat2(AT_FDCWD, s.staging.c_str(), AT_FDCWD, s.target.c_str(), RENAME_EXCHANGE) != 0) {
      const std::string aside = s.staging.string() + std::string(kMovedAside);
      if (::rename(s.target.c_str(), aside.c_str()) != 0)
        return fail(writeError(s.path, "moving the old folder aside", errno));
      if (::rename(s.staging.c_str(), s.target.c_str()) != 0) {
        const int reason = errno;
        ::rename(aside.c_str(), s.target.c_str());
        return fail(writeError(s.path, "renaming into place", reason));
      }
      s.staging = aside;
    }
    fs::remove_all(s.staging, error);
    if (error)
      return fail(writeError(s.path, "deleting the old folder " + s.staging.filename().string(), error.value()));
    s.staging.clear();
  } else if (errno == ENOTEMPTY || errno == EEXIST) {
    return fail({.code = Error::Code::kWriteFailed,
                 .file = s.path.string(),
                 .place = "folder",
                 .found = "another program wrote it in the meantime",
                 .expected = "an unchanged folder",
                 .hint = "look into the folder; choose another name, or --overwrite"});
  } else {
    return fail(writeError(s.path, "renaming into place", errno));
  }
  return syncFolder(folderOf(s.target));
}

Expected<void> syncFolder(const fs::path& folder) {
  if (const int reason = syncPath(folder.empty() ? fs::path(".") : folder, O_DIRECTORY))
    return fail(writeError(folder, "syncing the folder to the disk", reason));
  return {};
}

Expected<void> syncTree(const fs::path& folder) {
  KERF_CHECK(syncAllIn(folder));
  std::error_code ignored;
  fs::path above = folderOf(fs::absolute(folder, ignored));
  KERF_CHECK(syncFolder(above));
  for (; above != folderOf(above); above = folderOf(above)) syncPath(folderOf(above), O_DIRECTORY);  // they may be new
  return {};
}

Expected<void> copyFile(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed) return fail(writeError(to, "copying " + from.string(), failed.value()));
  return {};
}

Expected<void> requireOnlyOurs(const fs::path& folder, std::string_view manifest) {
  const std::string foreign = foreignEntry(folder, manifest);
  if (!foreign.empty()) return fail(holdsForeign(folder, foreign));
  return {};
}

}  // namespace kerf
