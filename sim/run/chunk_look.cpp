#include "sim/run/chunk_look.h"

#include <utility>

#include "geometry/field/material.h"
#include "sim/live/chunk_occlusion.h"
#include "sim/live/tissue_colours.h"

namespace kerf::internal {

Expected<decltype(RemesherOptions::finish)> chunkLook(std::shared_ptr<const BakedObject> object, bool is_beside) {
  KERF_TRY(materials, readDefaultMaterials());
  return [labels = TissueLabels::of(*object), palette = TissuePalette(materials), object = std::move(object),
          is_beside](MeshChunk& chunk, const OverlayField& field) {
    chunk.colours = tissueColours(chunk, labels, palette);
    if (is_beside) asNeighbour(chunk.colours);
    chunk.occlusion = occlusionOf(chunk, field);
  };
}

}  // namespace kerf::internal
