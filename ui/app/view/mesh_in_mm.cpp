#include "ui/app/view/mesh_in_mm.h"

#include <fmt/format.h>

#include <utility>

#include "geometry/formats/mesh_io.h"
#include "preprocess/unit/unit.h"

namespace kerf {

Expected<MeshInMm> readMeshInMm(const std::filesystem::path& file, const std::string& asked_unit) {
  KERF_TRY(read, readMesh(file));
  KERF_TRY(unit, chooseUnit(bounds(read.mesh), asked_unit, read.declared_unit));
  MeshInMm out{std::move(read.mesh), unit.unit, std::move(read.objects), {}};
  if (unit.scale_to_mm != 1) {
    for (Vec3d& p : out.mesh.vertices) p *= unit.scale_to_mm;
    out.note = fmt::format("the file is in {}, the numbers are mm: {}", unit.unit, unit.reason);
  } else if (unit.is_doubtful) {
    out.note = "CHECK THE UNIT: " + unit.reason;
  }
  return out;
}

}  // namespace kerf
