#include "geometry/base/atomic_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/temporary_folder.h"

namespace kerf::atomic_file_test {
namespace {

namespace fs = std::filesystem;

TEST(AtomicFile, AppearsOnCommitAndNotBefore) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("a.txt", "old");
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  auto file = AtomicFile::create(path);
  ASSERT_TRUE(file);
  const std::string text(200'000, 'n');
  file->stream() << text << 1.5;
  EXPECT_EQ(contentOf(path), "old");
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(contentOf(path), text + std::to_string(1.5).substr(0, 3));
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, WithoutCommitNothingIsLeft) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("a.txt", "old");
  {
    auto file = AtomicFile::create(path);
    file->stream() << "new" << std::flush;
    EXPECT_EQ(folder.entries(), 2u);
  }
  EXPECT_EQ(contentOf(path), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, SymbolicLinkStaysALink) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("a.txt", "old");
  fs::create_symlink("a.txt", folder.path() / "link");
  auto file = AtomicFile::create(folder.path() / "link");
  file->stream() << "new";
  ASSERT_TRUE(file->commit());
  EXPECT_TRUE(fs::is_symlink(folder.path() / "link"));
  EXPECT_EQ(contentOf(path), "new");
}

TEST(AtomicFile, FullDiskIsReportedByItsName) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  auto file = AtomicFile::create("/dev/full");
  ASSERT_TRUE(file);
  file->stream() << std::string(1 << 20, 'x');
  const auto done = file->commit();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Error::Code::kWriteFailed);
  EXPECT_EQ(done.error().file, "/dev/full");
  EXPECT_EQ(done.error().found, "No space left on device");
  EXPECT_FALSE(done.error().hint.empty());
  EXPECT_TRUE(fs::is_character_file("/dev/full")) << "a device must not be replaced by a file";
}

TEST(AtomicFile, MissingFolderAndFolderAsTargetAreRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(AtomicFile::create(folder.path() / "no" / "a.txt").error().found, "No such file or directory");
  EXPECT_EQ(AtomicFile::create(folder.path()).error().found, "Is a directory");
}

TEST(AtomicFile, ALinkToWhatIsNotThereIsRefused) {
  const TemporaryFolder folder;
  fs::create_symlink("nowhere.stl", folder.path() / "cut.stl");
  const auto made = AtomicFile::create(folder.path() / "cut.stl");
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().found, "a broken link");
  EXPECT_EQ(folder.entries(), 1u);
}

// A killed process leaves its partial output. The next process that writes into the folder deletes it, and nothing
// else.
TEST(AtomicFile, LeftoversOfAKilledProcessAreDeleted) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "cut.stl", bundle = folder.path() / "case";
  const pid_t child = ::fork();
  if (child == 0) {
    const auto one = AtomicFile::create(file);
    const auto two = AtomicFolder::create(bundle, false);
    if (one && two) ::kill(::getpid(), SIGKILL);
    ::_exit(1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(folder.entries(), 2u);

  auto other = AtomicFile::create(folder.path() / "another target");
  EXPECT_EQ(folder.entries(), 1u);
  auto mine = AtomicFile::create(file);
  auto third = AtomicFile::create(file);  // our own pending file stays
  EXPECT_EQ(folder.entries(), 3u);
  ASSERT_TRUE(mine && mine->commit());
  auto made = AtomicFolder::create(bundle, false);
  ASSERT_TRUE(made);
  std::ofstream(made->staging() / "case.toml") << 1;
  ASSERT_TRUE(made->commit());
  EXPECT_TRUE(fs::exists(file));
  EXPECT_TRUE(fs::exists(bundle));
  EXPECT_EQ(folder.entries(), 4u) << "these two, and the two that are being written";
}

// From before a reboot, or from another machine: whether its process lives is unknown.
TEST(AtomicFile, LeftoversOfAnotherBootAreDeletedAfterAWeek) {
  const TemporaryFolder folder;
  const fs::path young = folder.write(".a.stl.kerf-0123abcd-77-0", "x"),
                 old = folder.write(".b.kerf-0123abcd-77-1", "x");
  const fs::path mine = folder.write(".notes.kerf-of mine", "x"), aside = folder.write(".c.kerf-0123abcd-9-2-old", "c");
  for (const fs::path& file : {old, mine, aside})
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(8 * 24));
  (void)AtomicFile::create(folder.path() / "new");
  EXPECT_TRUE(fs::exists(young));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(mine));
  EXPECT_EQ(contentOf(folder.path() / "c"), "c") << "moved back";
}

// If a file system cannot exchange two folders, the old one is first moved aside. A program killed then leaves no
// target, but two whole folders.
TEST(AtomicFolder, ATargetThatWasMovedAsideByAKilledProcessComesBack) {
  const TemporaryFolder folder;
  const fs::path bundle = folder.path() / "case";
  std::string staging;
  {
    const auto made = AtomicFolder::create(bundle, false);
    ASSERT_TRUE(made);
    staging = made->staging().filename().string();
  }
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  int status = 0;
  ::waitpid(child, &status, 0);
  const std::string own = std::to_string(::getpid());
  const fs::path aside =
      folder.path() / (staging.substr(0, staging.rfind("-" + own + "-")) + "-" + std::to_string(child) + "-0-old");
  fs::create_directory(aside);
  std::ofstream(aside / "case.toml") << "years";

  EXPECT_FALSE(AtomicFolder::create(bundle, false)) << "it is there again";
  EXPECT_EQ(contentOf(bundle / "case.toml"), "years");
  EXPECT_EQ(folder.entries(), 1u);
}

void fill(const AtomicFolder& folder, const std::string& text) {
  std::ofstream(folder.staging() / "case.toml") << text;
  fs::create_directory(folder.staging() / "source-1");
  std::ofstream(folder.staging() / "source-1" / "x") << text;
}

TEST(AtomicFolder, AppearsOnCommitWithEverythingInIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "case";
  {
    auto abandoned = AtomicFolder::create(path, false);
    ASSERT_TRUE(abandoned);
    fill(*abandoned, "never");
  }
  EXPECT_EQ(folder.entries(), 0u);
  auto made = AtomicFolder::create(path / "", false);  // a trailing slash names the same folder
  ASSERT_TRUE(made) << made.error().message();
  fill(*made, "one");
  EXPECT_FALSE(fs::exists(path));
  ASSERT_TRUE(made->commit());
  EXPECT_EQ(contentOf(path / "source-1" / "x"), "one");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFolder, ReplacesOnlyOursAndOnlyWhenAllowed) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "case";
  auto first = AtomicFolder::create(path, false);
  fill(*first, "one");
  std::ofstream(first->staging() / "recipe.toml") << 1;
  ASSERT_TRUE(first->commit());
  EXPECT_FALSE(AtomicFolder::create(path, false));
  auto second = AtomicFolder::create(path, true);
  ASSERT_TRUE(second);
  fill(*second, "two");
  EXPECT_EQ(contentOf(path / "case.toml"), "one");
  ASSERT_TRUE(second->commit());
  EXPECT_EQ(contentOf(path / "case.toml"), "two");
  EXPECT_FALSE(fs::exists(path / "recipe.toml"));
  EXPECT_EQ(folder.entries(), 1u);

  fs::create_directory(folder.path() / "holiday");
  folder.write("holiday/picture", "p");
  const auto foreign = AtomicFolder::create(folder.path() / "holiday", true);
  ASSERT_FALSE(foreign);
  EXPECT_NE(foreign.error().message().find("not made by Kerf"), std::string::npos);
  EXPECT_FALSE(AtomicFolder::create(folder.path() / "holiday" / "picture", true)) << "a file is no folder";
}

TEST(AtomicFolder, WhatSomebodyLaidIntoABundleIsNotReplacedWithIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "case";
  auto first = AtomicFolder::create(path, false);
  fill(*first, "mesh = \"my bur.stl\"\nbody = 'my body.stl'");
  std::ofstream(first->staging() / "my bur.stl") << 1;  // named by a file of the bundle
  std::ofstream(first->staging() / "my body.stl") << 1;
  std::ofstream(first->staging() / ".run.toml.kerf-00000000-1-0") << 1;
  ASSERT_TRUE(first->commit());
  ASSERT_TRUE(AtomicFolder::create(path, true));

  std::ofstream(path / "thesis.doc") << "years of work";
  const auto refused = AtomicFolder::create(path, true);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().found.find("\"thesis.doc\""), std::string::npos) << refused.error().message();
  EXPECT_EQ(folder.entries(), 1u);

  // Placed there during the write.
  fs::remove(path / "thesis.doc");
  auto late = AtomicFolder::create(path, true);
  ASSERT_TRUE(late);
  fill(*late, "two");
  fs::create_directory(path / "holiday");
  EXPECT_FALSE(late->commit());
  EXPECT_TRUE(fs::exists(path / "holiday"));
  EXPECT_TRUE(fs::exists(path / "my bur.stl"));
}

TEST(AtomicFolder, ALinkToWhatIsNotThereIsRefusedBeforeTheWork) {
  const TemporaryFolder folder;
  fs::create_symlink("nowhere", folder.path() / "case");
  for (const bool overwrite : {false, true}) {
    const auto made = AtomicFolder::create(folder.path() / "case", overwrite);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().found, "a broken link");
  }
  EXPECT_FALSE(fs::exists(folder.path() / "nowhere"));
}

TEST(AtomicFolder, ABundleOfAnotherKindIsCalledByItsNameAndNotReplaced) {
  const TemporaryFolder folder;
  const std::pair<std::string, std::string> bundles[] = {{"case.toml", "a case"}, {"run.toml", "a run"}};
  for (const auto& [manifest, name] : bundles) {
    const fs::path path = folder.path() / manifest;
    fs::create_directory(path);
    std::ofstream(path / manifest) << 1;
    std::ofstream(path / "tool.toml") << 1;  // a run holds a copy of its tool
    for (const std::string other : {"case.toml", "run.toml", "tool.toml"}) {
      const auto made = AtomicFolder::create(path, true, other);
      EXPECT_EQ(static_cast<bool>(made), other == manifest) << other;
      if (!made) {
        EXPECT_EQ(made.error().found, "it is " + name);
      }
    }
  }
}

TEST(AtomicFolder, ATargetThatAppearsMeanwhileIsNotOverwritten) {
  const TemporaryFolder folder;
  auto made = AtomicFolder::create(folder.path() / "case", false);
  fill(*made, "late");
  fs::create_directory(folder.path() / "case");
  folder.write("case/x", "early");
  EXPECT_FALSE(made->commit());
  EXPECT_EQ(contentOf(folder.path() / "case" / "x"), "early");
}

}  // namespace
}  // namespace kerf::atomic_file_test
