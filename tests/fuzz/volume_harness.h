// Promises of every label volume, independent of its source.
#pragma once

#include <optional>

#include "preprocess/volume/label_volume.h"
#include "tests/fuzz/file_harness.h"

/// Suppresses leaks of ITK and its libraries on broken files, some bytes each.
extern "C" __attribute__((used)) const char*
__lsan_default_suppressions() {  // NOLINT: the name the sanitizer looks for
  return "leak:libITK\nleak:libgdcm\nleak:libniftiio\nleak:libtiff\nleak:libpng\n";
}

namespace kerf::fuzz {

/// @param flavour  0: no options; 1: with a spacing; 2: with a threshold too.
inline void readVolume(const std::filesystem::path& path, unsigned flavour) {
  LabelReadOptions options;
  options.max_bytes = 64 << 20;
  if (flavour > 0) options.spacing_mm = Vec3d(0.5, 0.5, 1);
  if (flavour > 1) options.threshold = 1;
  const Expected<LabelVolume> v = readLabelVolume(path, options);
  if (!v) return requireError(v.error());
  std::uint64_t voxels = 1, counted = 0;
  for (const int s : v->size) {
    require(s >= 1, "a volume has voxels");
    voxels *= static_cast<std::uint64_t>(s);
  }
  require(v->slices.size() == static_cast<std::size_t>(v->size[2]), "all slices");
  for (const LabelCount& c : countLabels(*v)) counted += c.voxels;
  require(counted == voxels, "a label per voxel");
  require(v->spacing.allFinite() && v->spacing.minCoeff() > 0, "spacing above zero");
  require(v->origin.allFinite() && v->direction.allFinite() && v->voxelVolume() > 0, "a grid in space");
}

}  // namespace kerf::fuzz
