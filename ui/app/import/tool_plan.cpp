#include "ui/app/import/tool_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/tool/tool_file.h"
#include "geometry/tool/tool_template.h"
#include "preprocess/close/close.h"
#include "ui/app/base/language.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

Mesh scaledTool(const Mesh& mesh, double scale) {
  Mesh out = mesh;
  for (Vec3d& p : out.vertices) p = roundedToFloat(Vec3d(scale * p));
  return out;
}

std::string idOf(const fs::path& file) {
  const std::string id = toolIdOf(file.stem().string());
  return id.empty() ? "my-tool" : id;
}

// Makes a text safe within quotes, or behind a # in a line.
std::string plain(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == '"' || c == '\\' || c == 127) c = '_';
  return text;
}

// An id free in both files and all tools: the rack shows only the first of two tools with one id.
std::string freeId(const std::string& wanted, const fs::path& folder, const std::vector<std::string>& ids_taken) {
  std::vector<fs::path> folders = defaultToolFolders();
  folders.push_back(folder);
  std::error_code ignored;
  const auto isTaken = [&](const std::string& id) {
    const bool is_known = std::find(ids_taken.begin(), ids_taken.end(), id) != ids_taken.end();
    const auto has_it = [&](const fs::path& of) { return fs::exists(of / (id + ".toml"), ignored); };
    return is_known || std::any_of(folders.begin(), folders.end(), has_it) ||
           fs::exists(folder / (id + ".ply"), ignored);
  };
  std::string out = wanted;
  for (int n = 2; isTaken(out); ++n) out = fmt::format("{}-{}", wanted, n);
  return out;
}

}  // namespace

ToolPlan::ToolPlan(fs::path file, std::shared_ptr<const Mesh> mesh, double scale_to_mm)
    : file_(std::move(file)),
      mesh_(std::move(mesh)),
      scale_(scale_to_mm),
      ways_(toolWays(scaledTool(*mesh_, scale_))) {}

void ToolPlan::setScale(double scale_to_mm) {
  if (scale_to_mm == scale_) return;
  const std::string name = way().name;
  scale_ = scale_to_mm;
  ways_ = toolWays(scaledTool(*mesh_, scale_));
  way_ = 0;
  cut_below_mm_ = 0;
  if (is_chosen_) (void)setWay(name);
}

Expected<void> ToolPlan::setWay(const std::string& name) {
  if (name == "auto") {
    way_ = 0;
    is_chosen_ = false;
    return {};
  }
  std::string names;
  for (std::size_t n = 0; n < ways_.size(); ++n) {
    names += ways_[n].name + ", ";
    if (ways_[n].name != name) continue;
    way_ = n;
    is_chosen_ = true;
    return {};
  }
  return fail({.code = Error::Code::kBadValue, .found = "\"" + name + "\"", .expected = "one of " + names + "or auto"});
}

Expected<void> ToolPlan::setCutBelow(double mm) {
  if (!(mm >= kLeastCut && mm <= kMostCut))
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("{:g} mm", mm),
                 .expected = fmt::format("{:g} to {:g} mm above the tip", kLeastCut, kMostCut)});
  cut_below_mm_ = mm;
  return {};
}

bool ToolPlan::isDoubtful() const {
  if (is_chosen_) return false;
  // The same direction under another name is no other end.
  constexpr double kSameWay = 0.98;  // cosine
  return std::any_of(ways_.begin(), ways_.end(), [&](const ToolWay& other) {
    return other.axis.dot(way().axis) < kSameWay && other.tip_width_mm < ToolWay::kDoubt * way().tip_width_mm;
  });
}

std::vector<Finding> ToolPlan::findings() const {
  const ToolWay& now = way();
  std::vector<Finding> out;
  const std::string tip = shownNumbers("{:.3g} mm wide at the tip, shank towards {}", now.tip_width_mm, now.name);
  if (is_chosen_)
    out.push_back({Finding::Weight::kFine, "Axis", tip});
  else if (isDoubtful())
    out.push_back(
        {Finding::Weight::kDoubtful, "Axis", tip + ": a guess, another end is almost as thin. Check the direction"});
  else
    out.push_back({Finding::Weight::kMended, "Axis", tip + ": the thinnest end. Check the direction"});
  return out;
}

std::string ToolPlan::id() const { return idOf(file_); }

Expected<fs::path> writeMeshTool(const MeshToolOrder& order, const fs::path& folder, const Progress& progress) {
  Mesh solid = scaledTool(withoutStrayVertices(*order.mesh), order.scale_to_mm);
  solid.vertex_colors.clear();
  solid.face_colors.clear();
  if (!report(progress, 0, "closing the tool")) return cancelled();
  if (!checkMesh(solid).print_ready) {
    KERF_TRY(closed, closeMesh(solid, closeOptionsOf(order.closing), progress));
    solid = std::move(closed.mesh);
  }
  // Measures the solid: closing may have moved its end.
  const ToolWay way = toolWayAlong(solid, order.way.name, order.way.axis);

  std::error_code failed;
  fs::create_directories(folder, failed);
  const std::string id = freeId(order.id, folder, order.ids_taken);
  const fs::path mesh_file = folder / (id + ".ply"), tool_file = folder / (id + ".toml");
  MeshToolNumbers numbers;
  numbers.name = plain(order.file.stem().string());
  numbers.origin = plain(fmt::format("{}, read as {}", order.file.string(), order.unit));
  numbers.tip = way.tip;
  numbers.axis = way.axis;
  numbers.cut_below_mm = order.cut_below_mm;

  const auto written = [&]() -> Expected<void> {
    KERF_CHECK(writeMesh(mesh_file, solid));
    KERF_TRY(toml, AtomicFile::create(tool_file));
    toml.stream() << meshToolTemplate(mesh_file.filename().string(), id, numbers);
    KERF_CHECK(toml.commit());
    KERF_CHECK(readTool(tool_file));
    return {};
  }();
  if (written) return tool_file;
  fs::remove(tool_file, failed);
  fs::remove(mesh_file, failed);
  return fail(written.error());
}

}  // namespace kerf
