#include "geometry/base/assets.h"

#include <algorithm>
#include <cstdlib>

namespace kerf {

namespace fs = std::filesystem;

std::vector<fs::path> findAssets(const fs::path& name) {
  std::vector<fs::path> folders, out;
  if (const char* assets = std::getenv("KERF_ASSETS"); assets && *assets) folders.emplace_back(assets);
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed).parent_path();
  if (!failed) {
    folders.push_back(program / "../../../assets");
    folders.push_back(program / "../share/kerf");
  }
  folders.emplace_back(KERF_INSTALLED_ASSETS);
  folders.emplace_back(KERF_SOURCE_ASSETS);
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
