#include "ui/app/base/user_files.h"

#include <algorithm>
#include <cstdlib>
#include <ostream>
#include <span>
#include <sstream>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/text.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

fs::path userFolder(const char* variable, const char* below_home) {
  if (const char* xdg = std::getenv(variable); xdg && *xdg == '/') return fs::path(xdg) / "kerf";
  const char* home = std::getenv("HOME");
  return fs::path(home ? home : "/tmp") / below_home / "kerf";
}

fs::path absoluteOf(const fs::path& path) {
  std::error_code failed;
  const fs::path out = fs::absolute(path, failed).lexically_normal();
  return out.has_filename() ? out : out.parent_path();
}

bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

}  // namespace

fs::path userDataFolder() { return userFolder("XDG_DATA_HOME", ".local/share"); }
fs::path userConfigFolder() { return userFolder("XDG_CONFIG_HOME", ".config"); }

RecentFiles::RecentFiles(fs::path folder) : folder_(std::move(folder)) { read(); }

void RecentFiles::read() {
  list_.clear();
  std::istringstream in(readSmallFile(folder_ / "recent.txt", kMost << 13).value_or(""));  // two paths a line
  for (std::string line; std::getline(in, line) && list_.size() < kMost;)
    if (line.starts_with('/')) list_.push_back({line, isThere(line)});
}

void RecentFiles::refresh() {
  for (RecentFile& file : list_) file.is_there = isThere(file.path);
}

Expected<void> RecentFiles::add(const fs::path& path) {
  const fs::path absolute = absoluteOf(path);
  if (absolute.string().find('\n') != std::string::npos) return {};  // a line cannot hold this name
  read();                                                            // entries added by another window
  std::erase_if(list_, [&](const RecentFile& file) { return file.path == absolute; });
  list_.insert(list_.begin(), {absolute, isThere(absolute)});

  std::vector<fs::path> gone;
  for (std::size_t n = kMost; n < list_.size(); ++n) gone.push_back(listPictureOf(list_[n].path));
  list_.resize(std::min(list_.size(), kMost));
  KERF_CHECK(write());
  std::error_code failed;
  for (const fs::path& picture : gone) fs::remove(picture, failed);
  return {};
}

Expected<void> RecentFiles::replace(const fs::path& old, const fs::path& now) {
  KERF_CHECK(add(now));
  const fs::path before = absoluteOf(old);
  if (before == absoluteOf(now)) return {};
  const auto at = std::find_if(list_.begin(), list_.end(), [&](const RecentFile& file) { return file.path == before; });
  return at != list_.end() ? forget(static_cast<std::size_t>(at - list_.begin())) : Expected<void>{};
}

Expected<void> RecentFiles::forget(std::size_t n) {
  if (n >= list_.size()) return {};
  const fs::path path = list_[n].path;
  read();
  std::erase_if(list_, [&](const RecentFile& file) { return file.path == path; });
  KERF_CHECK(write());
  std::error_code ignored;
  fs::remove(listPictureOf(path), ignored);
  return {};
}

fs::path RecentFiles::pictureOf(const fs::path& path) const {
  const fs::path own = path / "picture.png";  // kSessionPicture
  return isThere(own) ? own : listPictureOf(path);
}

fs::path RecentFiles::listPictureOf(const fs::path& path) const {
  const std::string text = absoluteOf(path).string();
  return folder_ / "recent" / (sha256(std::as_bytes(std::span(text.data(), text.size()))).substr(0, 24) + ".png");
}

Expected<void> RecentFiles::write() const {
  std::error_code ignored;
  fs::create_directories(folder_ / "recent", ignored);
  KERF_TRY(file, AtomicFile::create(folder_ / "recent.txt"));
  for (const RecentFile& recent : list_) file.stream() << recent.path.string() << '\n';
  return file.commit();
}

}  // namespace kerf
