#include "preprocess/demo/demo_anatomy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "geometry/base/atomic_file.h"
#include "geometry/formats/mesh_writer.h"

namespace kerf {
namespace {

std::string recipe(const DemoAnatomy& a) {
  std::string text = fmt::format(
      "# Made by Kerf: an invented anatomy with textbook dimensions, not a patient's.\n"
      "format = \"kerf-recipe\"\nversion = 1\nname = \"{}\"\nunit = \"mm\"\nvoxel = {}\n"
      "\n# In order of priority: where parts overlap, the first one wins.\n",
      a.title, a.voxel_mm);
  for (const DemoAnatomy::Part& part : a.parts)
    text += fmt::format("[[part]]\nmaterial = \"{}\"\nmesh = \"{}\"\n\n", part.material, part.file);
  text += "[outline]\nmeshes = [";
  for (std::size_t i = 0; i < a.outline.size(); ++i) text += fmt::format("{}\"{}\"", i ? ", " : "", a.outline[i]);
  return text + "]\n";
}

}  // namespace

const Mesh& DemoAnatomy::mesh(const std::string& file) const {
  const auto it = std::find_if(files.begin(), files.end(), [&](const File& f) { return f.name == file; });
  assert(it != files.end());
  return it->mesh;
}

Expected<void> writeDemoAnatomy(const DemoAnatomy& anatomy, const std::filesystem::path& folder, bool overwrite) {
  auto target = AtomicFolder::create(folder, overwrite, anatomy.manifest());
  if (!target) return fail(target.error());
  for (const DemoAnatomy::File& file : anatomy.files)
    if (const auto written = writeMesh(target->staging() / file.name, file.mesh); !written) return written;
  if (anatomy.parts.empty()) return target->commit();
  auto text = AtomicFile::create(target->staging() / anatomy.manifest());
  if (!text) return fail(text.error());
  text->stream() << recipe(anatomy);
  if (const auto written = text->commit(); !written) return written;
  return target->commit();
}

}  // namespace kerf
