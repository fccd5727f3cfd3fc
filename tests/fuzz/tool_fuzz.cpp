#include <cmath>

#include "geometry/tool/tool_file.h"
#include "tests/fuzz/file_harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  static const fuzz::ScratchFile file("tool.toml");
  file.fill(data, size);
  const Expected<Tool> tool = readTool(file.path());
  if (!tool) {
    fuzz::requireError(tool.error());
    return 0;
  }
  fuzz::require(tool->cut != nullptr, "a tool that was read has a cutting part");
  fuzz::require(std::isfinite(tool->cut->distance(Vec3d(0.3, -0.2, 0.1))), "its distance is a number");
  fuzz::require(std::isfinite(plungeVolume(*tool, 1)), "the volume it takes is a number");
  fuzz::require(!describe(*tool).empty() && !toJson(*tool).empty(), "it can be told");
  return 0;
}
