#include "geometry/base/assets.h"

#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <cstdlib>

namespace kerf {

namespace fs = std::filesystem;

namespace {

fs::path& prefix() {
  static fs::path found = KERF_PREFIX;
  return found;
}

}  // namespace

fs::path installedPrefix() { return prefix(); }

void setInstalledPrefix(const fs::path& found) { prefix() = found; }

fs::path ownFolder() {
  Dl_info info{};
  link_map* loaded = nullptr;
  std::error_code failed;
  const bool is_known = dladdr1(reinterpret_cast<const void*>(&ownFolder), &info, reinterpret_cast<void**>(&loaded),
                                RTLD_DL_LINKMAP) != 0;
  const bool is_program = !is_known || !loaded || loaded->l_name[0] == '\0';
  const fs::path file = is_program ? fs::read_symlink("/proc/self/exe", failed) : fs::canonical(loaded->l_name, failed);
  return failed ? fs::path() : file.parent_path();
}

std::vector<fs::path> findAssets(const fs::path& name) {
  std::vector<fs::path> folders, out;
  if (const char* assets = std::getenv("KERF_ASSETS"); assets && *assets) folders.emplace_back(assets);
  std::error_code failed;
  if (const fs::path own = ownFolder(); !own.empty()) {
    // bin/, lib/, lib/x86_64-linux-gnu/, lib/python3/dist-packages/kerf/
    for (fs::path up = own / ".."; folders.size() < 8 && fs::exists(up, failed); up /= "..")
      folders.push_back(up / "share/kerf");
  }
  folders.push_back(installedPrefix() / "share/kerf");
  for (const fs::path& folder : folders) {
    const fs::path place = fs::weakly_canonical(folder / name, failed);
    if (!failed && fs::exists(place, failed) && std::find(out.begin(), out.end(), place) == out.end())
      out.push_back(place);
  }
  return out;
}

Expected<void> requireAssets() {
  const char* const assets = std::getenv("KERF_ASSETS");
  if (!assets || !*assets) return {};

  const fs::path folder = assets;
  std::error_code ignored;
  if (fs::is_directory(folder / "tools", ignored) || fs::is_directory(folder / "paths", ignored) ||
      fs::is_regular_file(folder / "materials.toml", ignored))
    return {};
  return fail({.code = Error::Code::kBadValue,
               .file = folder.string(),
               .place = "KERF_ASSETS",
               .found = fs::is_directory(folder, ignored) ? "a folder without assets" : "no such folder",
               .expected = "a folder that holds tools/, paths/ or materials.toml",
               .hint = "unset KERF_ASSETS for the assets that come with Kerf"});
}

}  // namespace kerf
