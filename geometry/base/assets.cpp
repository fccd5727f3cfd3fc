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

}  // namespace kerf
