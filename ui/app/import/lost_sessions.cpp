#include "ui/app/import/lost_sessions.h"

#include <algorithm>
#include <system_error>

#include "geometry/base/atomic_file.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/session/run_branch.h"
#include "sim/run/session/session_run.h"
#include "ui/app/import/opening.h"

namespace kerf {

namespace fs = std::filesystem;

namespace {

// The run is open, or ended without its field.
bool isLost(const fs::path& folder, const RunManifest& manifest) {
  std::error_code none;
  const bool has_field = fs::file_size(folder / "run.vdb", none) > 0 && !none;
  return manifest.is_open || (manifest.mode == kModeSession && !has_field);
}

}  // namespace

std::vector<LostSession> findLostSessions(const fs::path& data) {
  std::vector<LostSession> out;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(data / "sessions", failed)) {
    const auto manifest = readRunManifest(entry.path());
    if (!manifest || !isLost(entry.path(), *manifest) || !RunLock::take(entry.path())) continue;
    out.push_back({entry.path(), fs::path(manifest->case_path).stem().string()});
  }

  const auto timeOf = [](const LostSession& lost) {
    std::error_code none;
    return fs::last_write_time(lost.folder / "session.kerflog", none);
  };
  std::sort(out.begin(), out.end(), [&](const LostSession& a, const LostSession& b) { return timeOf(a) > timeOf(b); });
  return out;
}

std::uintmax_t bytesOf(const LostSession& lost) {
  std::uintmax_t out = 0;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(lost.folder, failed))
    if (entry.is_regular_file(failed)) out += entry.file_size(failed);
  return out;
}

Expected<void> discardSession(const fs::path& folder) {
  KERF_TRY(manifest, readRunManifest(folder));
  if (!isLost(folder, manifest))
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = "a run that has ended",
                 .expected = "a session without a running program",
                 .hint = "delete the folder yourself if it is not needed"});
  const auto lock = RunLock::take(folder);
  if (!lock)
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = "another program is using it",
                 .expected = "a session without a running program",
                 .hint = "it is no longer a lost session"});
  KERF_CHECK(requireOnlyOurs(folder, kRunManifest));

  std::error_code failed;
  fs::remove_all(folder, failed);
  if (!failed) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = folder.string(),
               .found = failed.message(),
               .expected = "a folder that can be deleted",
               .hint = "delete the folder yourself"});
}

DroppedRuns keepDropped(const fs::path& session, const std::vector<std::uint64_t>& dropped, const fs::path& data,
                        const std::string& name, const Progress& progress) {
  DroppedRuns out;
  for (const std::uint64_t began : dropped) {
    const fs::path folder = newSessionFolder(data, name);
    const auto saved = branchRun(session, {.step_began = began}, folder, progress);
    if (saved)
      out.runs[began] = folder;
    else if (saved.error().code != Error::Code::kEmpty)
      out.failed = saved.error();
  }

  std::error_code ignored;
  if (!out.failed) fs::remove_all(session, ignored);
  return out;
}

}  // namespace kerf
