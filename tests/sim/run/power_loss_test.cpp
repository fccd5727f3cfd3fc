// The power fails after any system call of a session: the session is whole, or recoverRun() finishes it.
//
// The test sits between the program and the C library. After each call that syncs a file or changes names in a folder,
// it keeps the disk as a power failure would leave it. Unsynced content is lost: the file is empty. A name may reach
// the disk at once, or with the next sync of its folder: the test keeps both disks.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "sim/run/session/run_branch.h"
#include "sim/run/session/session_run.h"
#include "sim/session/session_log.h"
#include "tests/sim/person_at_mouse.h"

namespace kerf::power_loss_test {
namespace {

namespace fs = std::filesystem;

// Content of files by relative name below a folder; no value for folders.
using Disk = std::map<std::string, std::optional<std::string>>;

class PowerFailures {
 public:
  explicit PowerFailures(fs::path root) : root_(fs::canonical(root)) {}

  void hasSynced(int fd) {
    const std::lock_guard lock(mutex_);
    const fs::path path = fs::read_symlink("/proc/self/fd/" + std::to_string(fd));
    if (path != root_ && !path.string().starts_with(root_.string() + "/")) return;
    if (fs::is_directory(path))
      names_[idOf(path)] = namesIn(path);
    else
      contents_[idOf(path)] = contentOf(path);
    keep();
  }
  void hasChangedNames() {
    const std::lock_guard lock(mutex_);
    keep();
  }
  std::vector<Disk> disks() const { return disks_; }

 private:
  // Identifies a file or folder for its lifetime, as inode numbers are reused.
  using Id = std::pair<std::uint64_t, std::int64_t>;
  struct Named {
    Id id;
    bool is_folder = false;
  };
  using Names = std::map<std::string, Named>;

  static Id idOf(const fs::path& path) {
    struct statx status {};
    ::statx(AT_FDCWD, path.c_str(), AT_SYMLINK_NOFOLLOW, STATX_INO | STATX_BTIME, &status);
    return {status.stx_ino, status.stx_btime.tv_sec * 1'000'000'000 + status.stx_btime.tv_nsec};
  }
  static Names namesIn(const fs::path& folder) {
    Names out;
    std::error_code gone;
    for (fs::directory_iterator it(folder, gone), end; !gone && it != end; it.increment(gone))
      out[it->path().filename()] = {idOf(it->path()), it->is_directory(gone)};
    return out;
  }
  std::string syncedOf(const Id& id) const {
    const auto at = contents_.find(id);
    return at == contents_.end() ? std::string() : at->second;
  }
  void addEager(const fs::path& folder, const std::string& prefix, Disk& out) const {
    for (const auto& [name, named] : namesIn(folder)) {
      out[prefix + name] = named.is_folder ? std::nullopt : std::optional(syncedOf(named.id));
      if (named.is_folder) addEager(folder / name, prefix + name + "/", out);
    }
  }
  void addLazy(const Id& folder, const std::string& prefix, Disk& out) const {
    const auto at = names_.find(folder);
    if (at == names_.end()) return;
    for (const auto& [name, named] : at->second) {
      out[prefix + name] = named.is_folder ? std::nullopt : std::optional(syncedOf(named.id));
      if (named.is_folder) addLazy(named.id, prefix + name + "/", out);
    }
  }
  void keep() {
    Disk eager, lazy;
    addEager(root_, "", eager);
    addLazy(idOf(root_), "", lazy);
    for (Disk& disk : std::array{std::move(eager), std::move(lazy)})
      if (std::find(disks_.begin(), disks_.end(), disk) == disks_.end()) disks_.push_back(std::move(disk));
  }

  fs::path root_;
  std::mutex mutex_;
  std::map<Id, std::string> contents_;
  std::map<Id, Names> names_;
  std::vector<Disk> disks_;
};

PowerFailures* watching = nullptr;

template <class Tell>
int told(long result, const Tell& tell) {
  const int reason = errno;
  if (watching && result >= 0) tell(*watching);
  errno = reason;
  return static_cast<int>(result);
}
int synced(long result, int fd) {
  return told(result, [fd](PowerFailures& power) { power.hasSynced(fd); });
}
int renamed(long result) {
  return told(result, [](PowerFailures& power) { power.hasChangedNames(); });
}

void restore(const Disk& disk, const fs::path& folder) {
  fs::create_directories(folder);
  for (const auto& [name, content] : disk) {
    if (content)
      std::ofstream(folder / name, std::ios::binary) << *content;
    else
      fs::create_directories(folder / name);
  }
}

}  // namespace
}  // namespace kerf::power_loss_test

// Replaces the C library's functions.
extern "C" {
int fsync(int fd) { return kerf::power_loss_test::synced(::syscall(SYS_fsync, fd), fd); }
int fdatasync(int fd) { return kerf::power_loss_test::synced(::syscall(SYS_fdatasync, fd), fd); }
int rename(const char* from, const char* to) noexcept {
  return kerf::power_loss_test::renamed(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}
int unlink(const char* path) noexcept {
  return kerf::power_loss_test::renamed(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}
}

namespace kerf::power_loss_test {
namespace {

TEST(PowerLoss, BehindAnySystemCallOfASessionItsCutIsKept) {
  const TemporaryFolder folder;
  const fs::path block = test::bakedBlock(folder), sessions = folder.path() / "sessions";
  fs::create_directory(sessions);
  PowerFailures power(sessions);
  watching = &power;
  std::size_t opened = 0;
  Expected<RunManifest> ended = fail({});
  {
    auto run = LiveRun::open(block, sessions / "block.run", test::someTools());
    ASSERT_TRUE(run) << run.error().message();
    opened = power.disks().size();
    test::Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 1);
    ended = (*run)->finish();
  }
  watching = nullptr;
  ASSERT_TRUE(ended) << ended.error().message();
  const double removed = replayRun(sessions / "block.run")->removed_mm3;
  EXPECT_GT(removed, 0.05);

  const std::vector<Disk> disks = power.disks();
  std::size_t recovered_whole = 0, ended_whole = 0;
  EXPECT_GT(disks.size(), opened + 4);
  for (std::size_t n = 0; n < disks.size(); ++n) {
    SCOPED_TRACE("disk " + std::to_string(n) + " of " + std::to_string(disks.size()));
    const fs::path after = folder.path() / ("after " + std::to_string(n)), run = after / "block.run";
    restore(disks[n], after);
    if (!fs::exists(run / kRunManifest)) {
      EXPECT_LT(n, opened + 2) << "the session is lost";
      continue;
    }
    const auto manifest = readRunManifest(run);
    ASSERT_TRUE(manifest) << manifest.error().message();
    const auto log = readSessionLog(run / "session.kerflog");
    if (!manifest->is_open) {
      EXPECT_TRUE(log && log->is_closed) << "its log is lost";
      const auto field = readRunCutField(run);
      EXPECT_TRUE(field) << field.error().message();
      ++ended_whole;
      continue;
    }
    const auto recovered = recoverRun(run);
    if (!recovered) {
      EXPECT_TRUE(!log || recovered.error().code == Error::Code::kEmpty) << recovered.error().message();
      EXPECT_FALSE(log && log->is_closed);
      continue;
    }
    if (!log->is_closed) continue;
    EXPECT_EQ(recovered->manifest.state_hash, ended->state_hash);
    EXPECT_NEAR(recovered->replay.removed_mm3, removed, 1e-12);
    const auto field = readRunCutField(run);
    EXPECT_TRUE(field) << field.error().message();
    ++recovered_whole;
  }
  EXPECT_GE(recovered_whole, 2u);
  EXPECT_GE(ended_whole, 1u);
}

// A session of two tools. The second is never in hand.
class DamagedRun : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path block = test::bakedBlock(folder_);
    auto run = LiveRun::open(block, run_, test::someTools());
    ASSERT_TRUE(run) << run.error().message();
    test::Mouse mouse(**run);
    mouse.drill({-1, 0, 0}, 1);
    const auto ended = (*run)->finish();
    ASSERT_TRUE(ended) << ended.error().message();
    ended_ = *ended;
  }
  void openAgain() {
    RunManifest open = ended_;
    open.is_open = true;
    ASSERT_TRUE(writeRunManifest(run_, open));
    fs::remove(run_ / "run.vdb");
  }

  const TemporaryFolder folder_;
  const fs::path run_ = folder_.path() / "block.run";
  RunManifest ended_;
};

TEST_F(DamagedRun, ADamagedFieldBesideAWholeLogIsRebuiltToTheByte) {
  const std::string field = contentOf(run_ / "run.vdb"), manifest = contentOf(run_ / "run.toml");
  for (const std::string& damaged : {std::string(), field.substr(0, field.size() / 2), std::string("gone")}) {
    fs::remove(run_ / "run.vdb");
    if (damaged != "gone") std::ofstream(run_ / "run.vdb", std::ios::binary) << damaged;
    const auto refused = exportBundle(run_);
    ASSERT_FALSE(refused);
    if (damaged != "gone") {
      EXPECT_NE(refused.error().hint.find("kerf recover"), std::string::npos) << refused.error().message();
    }
    const auto recovered = recoverRun(run_);
    ASSERT_TRUE(recovered) << recovered.error().message();
    EXPECT_NE(recovered->replay.note.find("rebuilt from the log"), std::string::npos) << recovered->replay.note;
    EXPECT_EQ(contentOf(run_ / "run.vdb"), field);
    EXPECT_EQ(contentOf(run_ / "run.toml"), manifest);
    EXPECT_TRUE(exportBundle(run_));
  }
  EXPECT_FALSE(recoverRun(run_)) << "it is whole";
}

TEST_F(DamagedRun, ADamagedFieldIsNotRebuiltFromALogThatLeadsElsewhere) {
  const fs::path log = run_ / "session.kerflog";
  fs::resize_file(log, fs::file_size(log) / 2);
  std::ofstream(run_ / "run.vdb") << "x";
  const auto recovered = recoverRun(run_);
  ASSERT_FALSE(recovered);
  EXPECT_NE(recovered.error().message().find("another state"), std::string::npos) << recovered.error().message();
  EXPECT_EQ(contentOf(run_ / "run.vdb"), "x");
}

TEST_F(DamagedRun, ADamagedToolThatCutNothingLosesNoSession) {
  openAgain();
  fs::resize_file(run_ / ended_.tools[1].file, 0);
  const auto recovered = recoverRun(run_);
  ASSERT_TRUE(recovered) << recovered.error().message();
  EXPECT_TRUE(recovered->replay.is_same);
  EXPECT_EQ(recovered->manifest.state_hash, ended_.state_hash);
  EXPECT_NE(recovered->replay.note.find("round-010"), std::string::npos) << recovered->replay.note;
  EXPECT_TRUE(exportBundle(run_));

  const fs::path branch = folder_.path() / "branch.run";
  const auto branched = branchRun(run_, {}, branch);
  ASSERT_TRUE(branched) << branched.error().message();
  const auto replayed = replayRun(branch);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same) << replayed->note;
}

TEST_F(DamagedRun, ADamagedToolThatCutIsNamed) {
  openAgain();
  fs::resize_file(run_ / ended_.tools[0].file, 0);
  const auto recovered = recoverRun(run_);
  ASSERT_FALSE(recovered);
  EXPECT_NE(recovered.error().file.find("round-014"), std::string::npos) << recovered.error().message();
}

}  // namespace
}  // namespace kerf::power_loss_test
