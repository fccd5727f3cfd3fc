#include "sim/run/scene/chunk_look.h"

#include <utility>

#include "geometry/case/case_bundle.h"
#include "geometry/field/material.h"
#include "sim/live/chunk_occlusion.h"
#include "sim/live/tissue_colours.h"

namespace kerf::internal {

Expected<decltype(RemesherOptions::finish)> chunkLook(LookedAt of) {
  KERF_TRY(materials, readDefaultMaterials());
  return [labels = TissueLabels::of(*of.object), palette = TissuePalette(materials), of = std::move(of)](
             MeshChunk& chunk, const OverlayField& field) {
    chunk.colours = tissueColours(chunk, labels, palette);
    if (of.scan) chunk.scan_colours = scanColours(chunk, *of.scan, *of.original);
    if (of.is_beside) {
      asNeighbour(chunk.colours);
      asNeighbour(chunk.scan_colours);
    }
    chunk.occlusion = occlusionOf(chunk, field);
  };
}

Expected<std::shared_ptr<const ScanColours>> scanColoursOf(const std::filesystem::path& case_folder) {
  KERF_TRY(solid, readCaseSolid(case_folder));
  return ScanColours::of(std::move(solid));
}

}  // namespace kerf::internal
