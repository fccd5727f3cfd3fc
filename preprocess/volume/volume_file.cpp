// Loads kerf_volumes.so, and ITK with it, when the first volume is read: few commands read one.
#include "preprocess/volume/volume_file.h"

#ifndef KERF_ITK_IS_LINKED
#include <dlfcn.h>
#endif

#include "geometry/base/assets.h"
#include "geometry/base/version.h"
#include "preprocess/volume/itk_reader.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

struct FoundReader {
  const ItkReader* reader = nullptr;
  fs::path folder;
};

#ifdef KERF_ITK_IS_LINKED

Expected<FoundReader> findReader() { return FoundReader{kerfItkReader(), {}}; }

#else

// Beside the program (build tree and installed alike), and where Kerf was installed.
std::vector<fs::path> placesOfReader() {
  std::vector<fs::path> places;
  const fs::path own = ownFolder();
  // bin/, lib/, lib/x86_64-linux-gnu/, lib/python3/dist-packages/kerf/
  std::error_code failed;
  for (fs::path up = own / ".."; !own.empty() && places.size() < 5 && fs::exists(up, failed); up /= "..")
    places.push_back((up / KERF_LIBRARY_FOLDER / "kerf/kerf_volumes.so").lexically_normal());
  places.push_back(installedPrefix() / KERF_LIBRARY_FOLDER / "kerf/kerf_volumes.so");
  return places;
}

Expected<FoundReader> findReader() {
  const std::vector<fs::path> places = placesOfReader();
  const auto unusable = [&](std::string file, std::string found) {
    return fail({.code = Error::Code::kUnsupported,
                 .file = std::move(file),
                 .found = std::move(found),
                 .expected = std::string("the library of Kerf ") + kVersion + " that reads volumes and slices of a CT",
                 .hint = "apt install kerf-volumes; without packages install or build Kerf again, as a whole"});
  };

  for (const fs::path& place : places) {
    std::error_code failed;
    if (!fs::exists(place, failed)) continue;

    // Never closed: ITK's registrations at load keep references to it.
    void* library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) return unusable(place.string(), std::string("it cannot be loaded: ") + dlerror());
    const auto entry = reinterpret_cast<decltype(&kerfItkReader)>(dlsym(library, "kerfItkReader"));
    if (!entry) return unusable(place.string(), "another library");
    const ItkReader* reader = entry();
    if (std::string(reader->version) != kVersion || reader->header_size != sizeof(VolumeHeader))
      return unusable(place.string(), std::string("the library of Kerf ") + reader->version);
    return FoundReader{reader, place.parent_path()};
  }
  return unusable(places.front().string(), "no such file");
}

#endif

const Expected<FoundReader>& reader() {
  static const Expected<FoundReader> found = findReader();
  return found;
}

}  // namespace

Expected<void> loadVolumeReader() {
  if (!reader()) return fail(reader().error());
  return {};
}

Expected<fs::path> volumeReaderFolder() {
  KERF_CHECK(loadVolumeReader());
  return reader()->folder;
}

Expected<VolumeHeader> readVolumeHeader(const fs::path& path, VolumeFormat format) {
  KERF_CHECK(loadVolumeReader());
  return reader()->reader->read_header(path, format);
}

Expected<void> readVolumeValues(const fs::path& path, VolumeFormat format, std::byte* out, std::uint64_t bytes) {
  KERF_CHECK(loadVolumeReader());
  return reader()->reader->read_values(path, format, out, bytes);
}

bool isDicom(const fs::path& path) { return reader() && reader()->reader->is_dicom(path); }

}  // namespace kerf::internal
