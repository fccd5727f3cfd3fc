#include "ui/app/import/session_list.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <ctime>
#include <string_view>
#include <system_error>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/session/session_run.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kLongestSessionName = 100;  // bytes

// Of the manifest, written at the beginning and at the end. 0: there is none.
std::time_t timeOfSession(const fs::path& folder) {
  struct stat known {};
  return ::stat((folder / kRunManifest).c_str(), &known) == 0 ? known.st_mtime : 0;
}

std::uintmax_t bytesBelow(const fs::path& folder) {
  std::uintmax_t out = 0;
  std::error_code failed;
  for (fs::recursive_directory_iterator file(folder, failed), end; !failed && file != end; file.increment(failed))
    if (std::error_code unknown; file->is_regular_file(unknown)) out += file->file_size(unknown);
  return out;
}

// Cuts the time that newSessionFolder() adds. False: there is none.
bool cutTime(std::string& name) {
  constexpr std::string_view kTime = "-00000000-000000-000";
  if (name.size() <= kTime.size()) return false;
  const std::size_t begin = name.size() - kTime.size();
  for (std::size_t n = 0; n < kTime.size(); ++n) {
    const char c = name[begin + n];
    if (kTime[n] == '-' ? c != '-' : c < '0' || c > '9') return false;
  }
  name.resize(begin);
  return true;
}

// Takes the lock: no program uses the session.
Expected<RunLock> takeSession(const fs::path& data, const fs::path& folder) {
  std::error_code failed;
  const bool is_below = fs::equivalent(folder.parent_path(), data / "sessions", failed) && !failed;
  if (!is_below || fs::is_symlink(folder, failed) || !isRun(folder))
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = "no session of the sessions folder",
                 .expected = "a session in " + (data / "sessions").string(),
                 .hint = "use the file manager for other folders"});
  return RunLock::take(folder);
}

Expected<void> requireFileName(const fs::path& folder, const std::string& name) {
  const auto isBad = [](unsigned char c) { return c < 0x20 || c == 0x7f || c == '/' || c == '\\'; };
  const bool is_good = !name.empty() && name.size() <= kLongestSessionName && name.front() != '.' &&
                       name.front() != ' ' && name.back() != ' ' && std::none_of(name.begin(), name.end(), isBad);
  if (is_good) return {};
  return fail(
      {.code = Error::Code::kBadValue,
       .file = folder.string(),
       .place = "name",
       .found = "\"" + name + "\"",
       .expected = fmt::format("1 to {} bytes, without slashes, and no dot or space at the start", kLongestSessionName),
       .hint = "session.rename 1 Upper left molar"});
}

}  // namespace

std::string sessionTitle(const fs::path& folder) {
  std::string out = (folder.has_filename() ? folder : folder.parent_path()).stem().string();
  if (cutTime(out)) return out;
  std::string without_number = out.substr(0, out.rfind('-'));  // newSessionFolder() numbers sessions of one millisecond
  return cutTime(without_number) ? without_number : out;
}

std::string sessionDate(const fs::path& folder) {
  const std::time_t time = timeOfSession(folder);
  return time == 0 ? "" : fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(time));
}

std::vector<SavedSession> findSessions(const fs::path& data) {
  std::vector<std::pair<std::time_t, SavedSession>> found;
  std::error_code failed;
  for (fs::directory_iterator entry(data / "sessions", failed), end; !failed && entry != end; entry.increment(failed)) {
    const fs::path& folder = entry->path();
    if (folder.filename().string().starts_with('.') || !isRun(folder)) continue;  // a dot: being written
    const auto manifest = readRunManifest(folder);
    if (!manifest) continue;
    found.push_back({timeOfSession(folder), {folder, sessionTitle(folder), sessionDate(folder), bytesBelow(folder)}});
    found.back().second.has_ended = !manifest->is_open;
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second.folder > b.second.folder;
  });

  std::vector<SavedSession> out;
  for (auto& [time, session] : found) out.push_back(std::move(session));
  return out;
}

Expected<fs::path> renameSession(const fs::path& data, const fs::path& folder, const std::string& name) {
  KERF_CHECK(requireFileName(folder, name));
  const auto lock = takeSession(data, folder);
  if (!lock) return fail(lock.error());
  const fs::path to = folder.parent_path() / (name + ".run");
  std::error_code failed;
  if (to == folder) return folder;
  if (fs::exists(fs::symlink_status(to, failed)))
    return fail({.code = Error::Code::kBadValue,
                 .file = to.string(),
                 .place = "name",
                 .found = "another session has this name",
                 .expected = "a new name",
                 .hint = "add a number"});
  fs::rename(folder, to, failed);
  if (!failed) return to;
  return fail({.code = Error::Code::kWriteFailed,
               .file = folder.string(),
               .found = failed.message(),
               .expected = "a folder that can be renamed",
               .hint = "check the permissions of " + folder.parent_path().string()});
}

Expected<void> deleteSession(const fs::path& data, const fs::path& folder) {
  const auto lock = takeSession(data, folder);
  if (!lock) return fail(lock.error());
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

}  // namespace kerf
