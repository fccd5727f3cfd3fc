// Whether the ledger is true: its volumes against those of the mesh.
#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/scenes/strokes.h"

namespace kerf::cli {

Expected<Result> benchLedger(const Bench& bench) {
  Result r(SceneId::kLedger,
           "10 000 strokes of a 1 mm ball through a block of 20 x 20 x 5.6 mm at 0.1 mm; a filling that is cut away");
  std::uint64_t hash = 0;
  for (const bool geometry_only : {true, false}) {
    const char* const how = geometry_only ? "without resistance" : "eroding";
    scenes::RandomStrokes strokes;
    strokes.block = {20, 20, 5.6};
    strokes.count = 10000;
    strokes.geometry_only = geometry_only;
    KERF_TRY(ledger, scenes::cutAtRandom(strokes, bench.progress));
    r.add(fmt::format("{}: removed", how), ledger.removed, "mm3");
    r.add(fmt::format("{}: left", how), ledger.left, "mm3");
    r.add(fmt::format("{}: removed, off the mesh", how), std::abs(ledger.errorPercent()), "%");
    r.add(fmt::format("{}: as loaded, off the mesh", how),
          100 * std::abs(ledger.loaded - ledger.mesh_loaded) / ledger.mesh_loaded, "%");
    r.add(fmt::format("{}: removed + left against loaded", how), ledger.imbalance());
    hash = hash * 0x100000001b3ull ^ ledger.state;

    KERF_TRY(filling, scenes::cutFilling(geometry_only));
    r.add(fmt::format("{}: filling added", how), filling.added, "mm3");
    r.add(fmt::format("{}: filling left", how), filling.left, "mm3");
    r.add(fmt::format("{}: filling added less removed", how), std::abs(filling.added - filling.removed), "mm3");
  }
  r.state_hash = fmt::format("{:016x}", hash);
  return r;
}

}  // namespace kerf::cli
