#include "ui/app/import/session_file.h"

#include <gtest/gtest.h>

#include <functional>
#include <span>
#include <sstream>
#include <vector>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/formats/zip_archive.h"
#include "sim/run/files/run_manifest.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/import/opening.h"
#include "ui/app/import/session_list.h"
#include "ui/app/script/app_script.h"
#include "ui/app/view/scene.h"
#include "ui/app/workbench/sessions.h"

namespace kerf::session_file_test {
namespace {

namespace fs = std::filesystem;
using internal::ZipEntry;

class SessionFileTest : public testing::Test {
 protected:
  WorkbenchOptions options(const std::string& data) const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / data;
    out.tools = {"round-014"};
    out.real_time = {.priority = 0, .lock_memory = false};
    out.keeps_recent = true;
    return out;
  }
  // Runs a script against a workbench with its own data folder, and ends the session.
  Expected<void> play(const std::string& script, const std::string& data = "data") {
    Workbench bench(options(data));
    Camera camera = *cameraFromView("top");
    AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
    auto played = runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
    bench.sessions->close();
    while (bench.jobs->running()) bench.update();
    removed_ = bench.document->removedMm3();
    session_ = bench.document->sessionFolder();
    notices_.clear();
    for (const Notice& notice : bench.notices->list()) notices_ += notice.text + "\n";
    return played;
  }
  std::string opening() const {
    const fs::path file = folder_.path() / "block.ply";
    EXPECT_TRUE(writeMesh(file, test::blockMesh(false)));
    return "file.open \"" + file.string() + "\"\nwait\nview.fit\ncut.force 2\n";
  }
  static std::string cutting(int x) {
    return "cut.press " + std::to_string(x) + " 150\nwait 1\ncut.release\nwait 0.1\n";
  }
  fs::path saved() const { return folder_.path() / "my block.kerf"; }
  std::size_t sessionsIn(const std::string& data) const { return findSessions(folder_.path() / data).size(); }

  TemporaryFolder folder_;
  double removed_ = 0;
  fs::path session_;
  std::string notices_;
};

TEST_F(SessionFileTest, ASavedSessionGoesOnWhereNothingElseIs) {
  const std::string save = "file.save-as \"" + saved().string() + "\"\nwait\n";
  ASSERT_TRUE(play(opening() + cutting(200) + save + cutting(220) + "edit.undo\nwait 0.2\n")) << notices_;
  ASSERT_TRUE(isSessionFile(saved())) << notices_;
  const auto first = readRunManifest(session_);
  ASSERT_TRUE(first);
  const double removed = removed_;
  for (const char* const gone : {"data", "block.ply"}) fs::remove_all(folder_.path() / gone);

  // The cut after saving was undone: both are in the same state. Another scan must not be needed.
  const std::string open = "file.open \"" + saved().string() + "\"\nwait\n";
  ASSERT_TRUE(play(open + "expect removed " + std::to_string(removed - 1e-4) + " " + std::to_string(removed + 1e-4) +
                       "\n" + cutting(180) + "file.save\nwait\n",
                   "other"))
      << notices_;
  EXPECT_EQ(sessionsIn("other"), 2u) << "the unpacked one, and the new one";
  EXPECT_EQ(sessionTitle(session_), "my block");

  // The file has the newer state now.
  const double more = removed_;
  EXPECT_GT(more, removed + 0.01);
  ASSERT_TRUE(
      play(open + "expect removed " + std::to_string(more - 1e-4) + " " + std::to_string(more + 1e-4) + "\n", "third"))
      << notices_;
  ASSERT_TRUE(play(open, "third")) << notices_;
  EXPECT_EQ(sessionsIn("third"), 1u) << "opened twice, it is there once";
}

TEST_F(SessionFileTest, WithoutACutThereIsNothingToSave) {
  (void)play(opening() + "file.save-as \"" + saved().string() + "\"\nwait\n");
  EXPECT_NE(notices_.find("nothing is cut"), std::string::npos) << notices_;
  EXPECT_FALSE(fs::exists(saved()));
  EXPECT_FALSE(play(opening() + "file.save\n")) << "a script has nobody to ask for a name";
}

// ---- Untrusted files

class ForeignFile : public SessionFileTest {
 protected:
  void SetUp() override {
    ASSERT_TRUE(play(opening() + cutting(200))) << notices_;
    ASSERT_TRUE(packSession(session_, saved()));
    const auto source = internal::loadMeshSource(saved());
    ASSERT_TRUE(source);
    auto archive = internal::ZipArchive::open(*source);
    ASSERT_TRUE(archive);
    for (std::uint64_t n = 0; n < archive->count(); ++n) {
      ZipEntry& entry = entries_.emplace_back(ZipEntry{archive->nameOf(n), {}});
      ASSERT_TRUE(archive->read(n, [&](std::string_view piece) -> Expected<void> {
        entry.bytes += piece;
        return {};
      }));
    }
  }
  std::string& bytesOf(const std::string& name) {
    for (ZipEntry& entry : entries_)
      if (entry.name == name) return entry.bytes;
    ADD_FAILURE() << name;
    return entries_.front().bytes;
  }
  void replaceInContents(const std::string& from, const std::string& to) {
    std::string& text = bytesOf("session.toml");
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << text;
    text.replace(at, from.size(), to);
  }
  std::string packed() const {
    std::ostringstream out;
    EXPECT_TRUE(internal::writeZip(out, entries_));
    return out.str();
  }
  // The message; and nothing was written.
  std::string refused(const std::string& bytes) {
    const fs::path file = folder_.write("foreign.kerf", bytes), data = folder_.path() / "foreign";
    const auto unpacked = unpackSession(file, data);
    EXPECT_FALSE(unpacked) << "unpacked to " << *unpacked;
    if (unpacked) return "";
    EXPECT_TRUE(!fs::exists(data / "sessions") || fs::is_empty(data / "sessions"));
    EXPECT_TRUE(!fs::exists(data / "unpacked-cases") || fs::is_empty(data / "unpacked-cases"));
    EXPECT_FALSE(fs::exists(folder_.path() / "evil")) << "written outside";
    EXPECT_NE(unpacked.error().message().find(file.string()), std::string::npos) << unpacked.error().message();
    return unpacked.error().message();
  }
  std::string refused() { return refused(packed()); }

  std::vector<ZipEntry> entries_;
};

TEST_F(ForeignFile, UnchangedItIsUnpacked) {
  const auto run = unpackSession(folder_.write("same.kerf", packed()), folder_.path() / "foreign");
  ASSERT_TRUE(run) << run.error().message();
  EXPECT_EQ(readRunManifest(*run)->state_hash, readRunManifest(session_)->state_hash);
}

TEST_F(ForeignFile, AWayOutOfTheFolderIsRefused) {
  for (const char* const name : {"run/../../../../evil", "../evil", "/tmp/evil", "run/..", "run//evil", "run/a\\\\b",
                                 "run/.hidden", "evil", "run/a/b/c/d/e/f/g"}) {
    const std::string before = bytesOf("session.toml");
    replaceInContents("'run/run.vdb'", std::string("\"") + name + "\"");
    for (ZipEntry& entry : entries_)
      if (entry.name == "run/run.vdb") entry.name = name;
    EXPECT_NE(refused().find("does not belong into a session"), std::string::npos) << name;
    for (ZipEntry& entry : entries_)
      if (entry.name == name) entry.name = "run/run.vdb";
    bytesOf("session.toml") = before;
  }
}

TEST_F(ForeignFile, ALinkIsRefused) {
  std::string bytes = packed();
  const std::size_t header = bytes.find("PK\1\2");  // of the first entry in the central directory
  ASSERT_NE(header, std::string::npos);
  bytes[header + 5] = 3;  // made by Unix
  const std::uint32_t mode = 0120777;
  bytes[header + 40] = static_cast<char>(mode & 0xff);
  bytes[header + 41] = static_cast<char>(mode >> 8);
  EXPECT_NE(refused(bytes).find("a link"), std::string::npos);
}

TEST_F(ForeignFile, OtherBytesThanThoseListedAreRefused) {
  bytesOf("run/run.toml") += "\n";
  EXPECT_NE(refused().find("more bytes"), std::string::npos);
  bytesOf("run/run.toml").pop_back();
  bytesOf("run/run.toml").back() = ' ';
  EXPECT_NE(refused().find("other bytes"), std::string::npos);
}

TEST_F(ForeignFile, AFileThatIsNotListedIsRefusedAndOneThatIsMissing) {
  entries_.push_back({"run/more.bin", "x"});
  EXPECT_NE(refused().find("does not list"), std::string::npos);
  entries_.pop_back();
  entries_.pop_back();
  EXPECT_NE(refused().find("it is missing"), std::string::npos);
}

TEST_F(ForeignFile, AZipBombIsRefused) {
  std::string& bytes = bytesOf("run/session.kerflog");
  const std::size_t before = bytes.size();
  bytes.assign(std::size_t{600} << 20, '\0');
  const auto hash = sha256(std::as_bytes(std::span(bytes.data(), bytes.size())));
  replaceInContents("size = " + std::to_string(before), "size = " + std::to_string(bytes.size()));
  EXPECT_NE(refused().find("a zip bomb"), std::string::npos);
}

TEST_F(ForeignFile, ANewerVersionAnOpenSessionAndAScriptAreRefused) {
  replaceInContents("version = 1", "version = 2");
  EXPECT_NE(refused().find("newer Kerf"), std::string::npos);
  replaceInContents("version = 2", "version = 1");

  std::string& manifest = bytesOf("run/run.toml");
  const std::size_t size = manifest.size(), at = manifest.find("is_open = false");
  const std::string before = sha256(std::as_bytes(std::span(manifest.data(), size)));
  ASSERT_NE(at, std::string::npos);
  manifest.replace(at, 15, "is_open = true ");
  replaceInContents(before, sha256(std::as_bytes(std::span(manifest.data(), size))));
  EXPECT_NE(refused().find("session"), std::string::npos);

  EXPECT_FALSE(isSessionFile(folder_.write("script.kerf", "file.open tooth.ply\n")));
  EXPECT_EQ(kindOf(folder_.path() / "script.kerf"), FileKind::kScan);
  EXPECT_FALSE(refused("PK\3\4 cut short").empty());
}

// ---- The list of sessions

TEST(SessionTitle, IsTheNameWithoutTheTime) {
  EXPECT_EQ(sessionTitle("/a/tooth 36-20261128-210833-123.run"), "tooth 36");
  EXPECT_EQ(sessionTitle("/a/tooth-20261128-210833-123-2.run"), "tooth");
  EXPECT_EQ(sessionTitle("/a/tooth-2026.run"), "tooth-2026");
  EXPECT_EQ(sessionTitle("/a/-20261128-210833-123.run"), "-20261128-210833-123");
}

TEST_F(SessionFileTest, ASessionIsFoundRenamedStartedOverAndDeleted) {
  ASSERT_TRUE(play(opening() + cutting(200))) << notices_;
  const fs::path data = folder_.path() / "data", before = session_;
  const auto recent = [&] { return RecentFiles(data).list().empty() ? fs::path() : RecentFiles(data).list()[0].path; };
  EXPECT_EQ(recent(), before) << "in place of the scan";
  ASSERT_EQ(RecentFiles(data).list().size(), 1u);

  EXPECT_FALSE(renameSession(data, before, "../out"));
  EXPECT_FALSE(renameSession(data, before, ""));
  EXPECT_FALSE(renameSession(data, data / "cases", "a case"));
  ASSERT_TRUE(play("session.rename 1 Upper left\n")) << notices_;
  const fs::path now = data / "sessions" / "Upper left.run";
  EXPECT_TRUE(isRun(now));
  EXPECT_EQ(recent(), now);
  ASSERT_TRUE(play("recent.start-over 1\nwait\nexpect removed 0 0\n")) << notices_;
  ASSERT_TRUE(play("recent.open 1\nwait\nexpect removed 0.01 9\nview.fit\n" + cutting(180))) << notices_;
  EXPECT_EQ(recent(), session_) << "the newer state in place of the earlier one";
  EXPECT_EQ(sessionTitle(session_), "Upper left");
  EXPECT_EQ(sessionsIn("data"), 2u);

  folder_.write("data/sessions/Upper left.run/notes.txt", "mine");
  EXPECT_FALSE(deleteSession(data, now)) << "a file of the user";
  fs::remove(now / "notes.txt");
  EXPECT_FALSE(play("session.delete 2\n")) << "not without a confirmation";
  ASSERT_TRUE(play("session.delete 2 delete\n")) << notices_;
  EXPECT_FALSE(fs::exists(now));
  EXPECT_EQ(sessionsIn("data"), 1u);
}

}  // namespace
}  // namespace kerf::session_file_test
