// Every development mesh passes the full chain: bake, cut by a bur and by a saw, export to four formats, read back,
// judge. Vertices farther than two voxels from the cut must come back bit for bit. Runs where the data is (KERF_DATA).
//
// KERF_TABLE=FILE appends one row per mesh to FILE (docs/results/real-data.md holds such a table).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>

#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/bake.h"
#include "preprocess/unit/unit.h"
#include "sim/hand/path.h"
#include "sim/run/cut/geometry_cut.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/report/replay.h"
#include "tests/support/places.h"
#include "tests/support/slice.h"
#include "tests/support/temporary_folder.h"

namespace kerf::data_walk_test {
namespace {

namespace fs = std::filesystem;

fs::path dataFolder() {
  const char* given = std::getenv("KERF_DATA");
  return given ? fs::path(given) : fs::path(kSourceFolder) / ".." / "shared" / "data";
}

// Files that are not meshes. All others must pass.
const std::set<std::string> kRefused = {"points-only-tooth.ply", "cbct-jaws-teeth-labels.nii.gz",
                                        "ct-skull-phantom-128-intensity.nrrd"};

// Every file of the folder except its README; one empty name without a folder, so that the test reports it.
std::vector<std::string> filesOfFolder(bool refused) {
  std::vector<std::string> names;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(dataFolder(), missing)) {
    const std::string name = entry.path().filename().string(), extension = entry.path().extension().string();
    const bool is_mesh_file = extension == ".stl" || extension == ".ply" || extension == ".obj" || extension == ".off";
    if (refused ? kRefused.count(name) > 0 : is_mesh_file && !kRefused.count(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  if (names.empty()) names.emplace_back();
  return names;
}

std::string testName(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param.empty() ? "no_data" : info.param;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

using Place = std::array<double, 3>;
Place place(const Vec3d& p) { return {p.x(), p.y(), p.z()}; }

// Cut of an object. All lengths scale with the object, and the cut passes one of its highest vertices.
struct Plan {
  Vec3d up, along, across;  // axes
  Vec3d top;                // one vertex in fifty is higher
  double height = 0;        // of the box along `up`
  double scale = 1;         // of the tools: 1 for a bur 1.4 mm wide
  double voxel_mm = 0.1;
};

Plan planFor(const Mesh& solid, const CloseReport& closing, double diagonal, double voxel_mm) {
  Plan plan;
  plan.voxel_mm = voxel_mm;
  plan.scale = std::min(1.0, 0.15 * diagonal / 1.4);
  plan.up = closing.base_direction ? Vec3d(-*closing.base_direction) : Vec3d(Vec3d::UnitZ());
  const Vec3d size = bounds(solid).size();
  plan.height = std::abs(size.dot(plan.up));
  double longest = -1;
  for (int k = 0; k < 3; ++k)
    if (std::abs(plan.up[k]) < 0.5 && size[k] > longest) {
      longest = size[k];
      plan.along = Vec3d::Unit(k);
    }
  plan.across = plan.up.cross(plan.along);
  // Not the highest vertex, which may be the tip of a thorn.
  std::vector<Vec3d> by_height = solid.vertices;
  const auto high = by_height.begin() + static_cast<std::ptrdiff_t>(by_height.size() * 49 / 50);
  std::nth_element(by_height.begin(), high, by_height.end(), [&](const Vec3d& a, const Vec3d& b) {
    return std::pair(a.dot(plan.up), place(a)) < std::pair(b.dot(plan.up), place(b));
  });
  plan.top = *high;
  return plan;
}

Eigen::Quaterniond frame(const Vec3d& x, const Vec3d& z) {
  Eigen::Matrix3d r;
  r << x, z.cross(x), z;
  return Eigen::Quaterniond(r).normalized();
}

std::string csv(const std::vector<Rigid3>& poses) {
  std::string text = "t,x,y,z,qw,qx,qy,qz\n";
  for (std::size_t n = 0; n < poses.size(); ++n) {
    const Vec3d& p = poses[n].translation;
    const Eigen::Quaterniond& q = poses[n].rotation;
    text += fmt::format("{},{},{},{},{},{},{},{}\n", n, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
  }
  return text;
}

std::string burTool(double scale) {
  return fmt::format(
      "format = \"kerf-tool\"\nversion = 1\nid = \"walk-bur\"\nname = \"Round bur\"\nkind = \"bur\"\n"
      "shape = \"round\"\nhead_diameter = {:.6f}\n",
      1.4 * scale);
}

std::string sawTool(double scale) {
  return fmt::format(
      "format = \"kerf-tool\"\nversion = 1\nid = \"walk-saw\"\nname = \"Saw\"\nkind = \"blade\"\n"
      "motion = \"reciprocating\"\nthickness = {:.6f}\nset_per_side = {:.6f}\nwidth = {:.6f}\nlength = {:.6f}\n"
      "stroke = {:.6f}\ntooth_pitch = {:.6f}\nedge_depth = {:.6f}\n",
      std::max(0.05, 0.4 * scale), 0.02 * scale, std::max(0.2, 5 * scale), std::max(1.0, 25 * scale), 3 * scale,
      std::max(0.1, 1.41 * scale), std::max(0.05, 0.5 * scale));
}

// A groove along the box through `top`; lift; a second one aslant, with the bur turning through 50 degrees.
std::string burPath(const Plan& plan) {
  const double d = 1.4 * plan.scale;
  const auto pose = [&](double a, double b, double u, double degrees) {
    const Eigen::AngleAxisd tilt(degrees * M_PI / 180, plan.along);
    return Rigid3{Eigen::Quaterniond(tilt) * frame(plan.along, plan.up),
                  plan.top + d * (a * plan.along + b * plan.across + u * plan.up)};
  };
  return csv({pose(-6, 0, -0.6, 0), pose(6, 0, -0.6, 0), pose(6, 0, 1.2, -25), pose(5, -2.5, 1.2, -25),
              pose(5, -2.5, -0.2, -25), pose(-4, 2, -1.3, 25), pose(-4, 2, 1.2, 25)});
}

// A blade across the box, a few degrees askew, straight down through `top`.
std::string sawPath(const Plan& plan) {
  const Vec3d z = (plan.across + 0.13 * plan.along + 0.05 * plan.up).normalized();
  const Vec3d x = (plan.up - plan.up.dot(z) * z).normalized();
  const Eigen::Quaterniond r = frame(x, z);
  const double length = std::max(1.0, 25 * plan.scale), depth = std::min(0.4 * plan.height, 8 * plan.scale);
  const Vec3d start = plan.top - 0.5 * length * z + plan.scale * plan.up;
  return csv({{r, start}, {r, start - (plan.scale + depth) * plan.up}});
}

// Distance of each vertex to all cuts of a run, mm. At or above `far`, any such value is allowed.
std::vector<double> distanceToCut(const std::vector<Vec3d>& points, const fs::path& tool_file,
                                  const fs::path& path_file, double far) {
  std::vector<double> nearest(points.size(), far);
  const auto tool = readTool(tool_file);
  const auto path = readPath(path_file);
  if (!tool || !path) throw std::runtime_error("the test's own files do not read");
  for (std::size_t s = 0; s + 1 < path->poses.size(); ++s) {
    const SweptTool sweep(*tool->cut, path->poses[s].T_object_tool, path->poses[s + 1].T_object_tool);
    Box3 box = sweep.bounds();
    box.grow(far);
    for (std::size_t v = 0; v < points.size(); ++v)
      if (box.contains(points[v])) nearest[v] = std::min(nearest[v], sweep.distance(points[v], far, 1e-6));
  }
  return nearest;
}

struct FarVertices {
  std::size_t count = 0, missing = 0, out_of_order = 0, recoloured = 0;
  std::size_t faces = 0, faces_recoloured = 0;  // triangles with all corners far and unchanged
};

// Looks up the vertices of `solid` at least `far` from the cut in the export, by their exact float32 places.
FarVertices compare(const Mesh& solid, const std::vector<double>& distance, double far, const Mesh& result) {
  FarVertices out;
  std::map<Place, std::uint32_t> where;
  for (std::uint32_t v = 0; v < result.vertices.size(); ++v) where.emplace(place(result.vertices[v]), v);
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> found(solid.vertices.size(), kNone);
  std::uint32_t last = 0;
  for (std::size_t v = 0; v < solid.vertices.size(); ++v) {
    if (distance[v] < far) continue;
    ++out.count;
    const auto it = where.find(place(solid.vertices[v]));
    if (it == where.end()) {
      ++out.missing;
      continue;
    }
    found[v] = it->second;
    out.out_of_order += found[v] < last;
    last = found[v];
    if (solid.hasVertexColors() && result.hasVertexColors())
      out.recoloured += solid.vertex_colors[v] != result.vertex_colors[found[v]];
  }
  if (!solid.hasFaceColors() || !result.hasFaceColors()) return out;
  const auto turned = [](Triangle t) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    return t;
  };
  std::map<Triangle, Rgba8> color;
  for (std::size_t t = 0; t < result.triangles.size(); ++t)
    color.emplace(turned(result.triangles[t]), result.face_colors[t]);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    Triangle mapped;
    for (std::size_t k = 0; k < 3; ++k) mapped[k] = found[solid.triangles[t][k]];
    if (std::count(mapped.begin(), mapped.end(), kNone)) continue;
    const auto it = color.find(turned(mapped));
    if (it == color.end()) continue;  // the cut went through a triangle larger than itself
    ++out.faces;
    out.faces_recoloured += it->second != solid.face_colors[t];
  }
  return out;
}

struct Verdicts {
  int passed = 0, failed = 0;
  std::string failures;
};

// External programs. Missing ones print SKIP and do not count.
Verdicts askValidators(const fs::path& mesh, bool quick) {
  Verdicts out;
  const std::string command = fmt::format("\"{}/tests/validators/validate\" {} \"{}\" 2>&1", kSourceFolder,
                                          quick ? "--quick" : "", mesh.string());
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) throw std::runtime_error("validators cannot be started");
  char line[4096];
  while (std::fgets(line, sizeof line, pipe)) {
    const std::string text = line;
    out.passed += text.starts_with("PASS ");
    if (text.starts_with("FAIL ")) {
      ++out.failed;
      out.failures += text;
    }
  }
  ::pclose(pipe);
  return out;
}

class Refused : public testing::TestWithParam<std::string> {};

TEST_P(Refused, WithAReasonAndNothingLeftBehind) {
  if (GetParam().empty()) GTEST_SKIP() << "no data in " << dataFolder() << " (set KERF_DATA)";
  const TemporaryFolder folder;
  const auto report = bake({dataFolder() / GetParam()}, folder.path() / "a.case", {});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message().find(GetParam()), std::string::npos) << report.error().message();
  EXPECT_FALSE(report.error().hint.empty());
  EXPECT_EQ(folder.entries(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Files, Refused, testing::ValuesIn(filesOfFolder(true)), testName);

class DataWalk : public testing::TestWithParam<std::string> {};

TEST_P(DataWalk, BakeCutExportReadBack) {
  KERF_SLICE_OF(3, GetParam());
  if (GetParam().empty()) GTEST_SKIP() << "no data in " << dataFolder() << " (set KERF_DATA)";
  const fs::path source_file = dataFolder() / GetParam();
  const TemporaryFolder folder;
  const double start = seconds();

  auto source = readMesh(source_file);
  ASSERT_TRUE(source) << source.error().message();
  const auto unit = chooseUnit(bounds(source->mesh), "", source->declared_unit);
  ASSERT_TRUE(unit) << unit.error().message();
  for (Vec3d& p : source->mesh.vertices) p = roundedToFloat(p * unit->scale_to_mm);
  const double diagonal = bounds(source->mesh).size().norm();

  BakeOptions options;
  if (diagonal < 3) options.voxelize.voxel_mm = diagonal / 100;
  const double h = options.voxelize.voxel_mm;
  const fs::path case_folder = folder.path() / "a.case";
  const auto baked = bake({source_file}, case_folder, options);
  ASSERT_TRUE(baked) << baked.error().message();
  const double bake_seconds = seconds() - start;
  const auto solid = readCaseSolid(case_folder);
  ASSERT_TRUE(solid) << solid.error().message();
  EXPECT_TRUE(baked->manifest.exact) << "wrapped: the scan is not kept";

  std::set<Place> of_solid;
  for (const Vec3d& p : solid->vertices) of_solid.insert(place(p));
  std::set<Place> of_source;
  std::vector<Vec3d> kept_by_closing;
  for (const Triangle& t : source->mesh.triangles)
    for (const std::uint32_t v : t)
      if (of_source.insert(place(source->mesh.vertices[v])).second && of_solid.count(place(source->mesh.vertices[v])))
        kept_by_closing.push_back(source->mesh.vertices[v]);

  const Plan plan = planFor(*solid, baked->close, diagonal, h);
  const fs::path bur = folder.write("walk-bur.toml", burTool(plan.scale)),
                 saw = folder.write("walk-saw.toml", sawTool(plan.scale)),
                 groove = folder.write("groove.csv", burPath(plan)), slot = folder.write("slot.csv", sawPath(plan));
  const double far = 2 * h;
  std::size_t scan_far = 0, scan_kept = 0, exported_triangles[2] = {};
  double removed[2] = {}, run_seconds[2] = {};
  Verdicts verdicts;
  for (int run = 0; run < 2; ++run) {
    const fs::path &tool = run ? saw : bur, &path = run ? slot : groove;
    SCOPED_TRACE(run ? "saw" : "bur");
    const double run_start = seconds();
    const fs::path run_folder = folder.path() / (run ? "saw.run" : "bur.run");
    const auto cut = cutCase(case_folder, tool, path, run_folder);
    ASSERT_TRUE(cut) << cut.error().message();
    const auto exported = exportBundle(run_folder);
    ASSERT_TRUE(exported) << exported.error().message();
    run_seconds[run] = seconds() - run_start;
    const PostOpReport& r = exported->post_op.report;
    EXPECT_GT(r.removed_volume_mm3, 0);
    removed[run] = r.removed_volume_mm3;
    exported_triangles[run] = exported->post_op.mesh.triangles.size();

    const std::vector<double> solid_distance = distanceToCut(solid->vertices, tool, path, far);
    const std::vector<double> scan_distance = distanceToCut(kept_by_closing, tool, path, far);
    for (const char* extension : {".ply", ".stl", ".obj", ".off"}) {
      SCOPED_TRACE(extension);
      const fs::path file = folder.path() / (std::string(run ? "saw" : "bur") + extension);
      const auto written = writeMesh(file, exported->post_op.mesh);
      ASSERT_TRUE(written) << written.error().message();
      auto back = readMesh(file);
      ASSERT_TRUE(back) << back.error().message();
      // Text reads back as the double nearest to the digits.
      for (Vec3d& p : back->mesh.vertices) p = roundedToFloat(p);
      const MeshReport check = checkMesh(back->mesh);
      EXPECT_TRUE(check.print_ready) << describe(check);
      EXPECT_NEAR(check.volume, r.result_volume_mm3, 1e-6 * r.source_volume_mm3);
      const FarVertices all = compare(*solid, solid_distance, far, back->mesh);
      EXPECT_GT(all.count, 0u);
      EXPECT_EQ(all.missing, 0u) << "of " << all.count << "; pieces " << r.pieces << ", crumbs " << r.crumbs_dropped;
      EXPECT_EQ(all.recoloured, 0u);
      EXPECT_EQ(all.faces_recoloured, 0u);
      // STL has corners instead of vertices, so the vertex order on reading is that of the triangles.
      const bool has_vertices = back->unwelded_vertices == 0;
      EXPECT_TRUE(!has_vertices || all.out_of_order == 0);
      if (std::string(extension) == ".ply") {
        EXPECT_EQ(solid->hasVertexColors(), back->mesh.hasVertexColors());
        EXPECT_TRUE(!solid->hasFaceColors() || all.faces > 0);
        std::set<Place> there;
        for (const Vec3d& p : back->mesh.vertices) there.insert(place(p));
        for (std::size_t v = 0; v < kept_by_closing.size(); ++v)
          if (scan_distance[v] >= far) {
            ++scan_far;
            scan_kept += there.count(place(kept_by_closing[v]));
          }
      }
    }
    // OpenSCAD takes most of the time. By default it checks one run of each mesh, and no large mesh.
    const bool quick = !std::getenv("KERF_OPENSCAD") && (run == 1 || exported_triangles[run] >= 50'000);
    const Verdicts v = askValidators(folder.path() / (run ? "saw.stl" : "bur.stl"), quick);
    EXPECT_EQ(v.failed, 0) << v.failures;
    verdicts.passed += v.passed;
    verdicts.failed += v.failed;
  }
  EXPECT_EQ(scan_kept, scan_far);

  std::string changes;
  for (const std::string& change : baked->manifest.changes) changes += (changes.empty() ? "" : "; ") + change;
  const MeshReport& found = baked->source_checks[0];
  const std::string row = fmt::format(
      "| {} | {} loops, {} nm, {} self, {} pcs | {} | {} -> {} -> {}, {} | {} of {} | {} of {} | {:.4g}, {:.4g} | {} "
      "of {} | {:.1f} + {:.1f} + {:.1f} |\n",
      GetParam(), found.boundary_loops.size(), found.non_manifold_edges, found.self_intersections, found.pieces,
      changes.empty() ? "nothing" : changes, source->mesh.triangles.size(), solid->triangles.size(),
      exported_triangles[0], exported_triangles[1], kept_by_closing.size(), of_source.size(), scan_kept, scan_far,
      removed[0], removed[1], verdicts.passed, verdicts.passed + verdicts.failed, bake_seconds, run_seconds[0],
      run_seconds[1]);
  fmt::print("{}", row);
  if (const char* table = std::getenv("KERF_TABLE")) {
    std::ofstream out(table, std::ios::app);
    out << row;
    out.close();
    EXPECT_TRUE(out) << "KERF_TABLE: cannot write " << table;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, DataWalk, testing::ValuesIn(filesOfFolder(false)), testName);

// A recipe combines enamel, dentin and pulp of a real molar. A hand drills it with 1 N against resistance.
TEST(DataWalk, AMolarOfThreeTissuesIsDrilledAgainstResistance) {
  const fs::path enamel = dataFolder() / "molar-L6-enamel.stl";
  if (!fs::exists(enamel)) GTEST_SKIP() << "no data at " << dataFolder();
  TemporaryFolder scratch;
  const fs::path recipe = scratch.path() / "molar.toml";
  {
    std::ofstream out(recipe);
    out << "format = \"kerf-recipe\"\nversion = 1\nunit = \"mm\"\n";
    for (const char* material : {"pulp", "enamel", "dentin"})
      out << fmt::format("[[part]]\nmaterial = \"{}\"\nmesh = \"{}\"\n", material,
                         (dataFolder() / fmt::format("molar-L6-{}.stl", material)).string());
  }
  BakeOptions options;
  options.voxelize.voxel_mm = 0.1;
  const auto baked = bakeRecipe(recipe, scratch.path() / "molar.case", options);
  ASSERT_TRUE(baked) << baked.error().message();
  // From above the highest enamel straight down.
  const auto solid = readCaseSolid(scratch.path() / "molar.case");
  ASSERT_TRUE(solid);
  Vec3d top = solid->vertices.front();
  for (const Vec3d& p : solid->vertices)
    if (p[2] > top[2]) top = p;
  const Box3 box = bounds(*solid);
  const bool is_crown_up = top[2] - box.center()[2] > 0;
  ASSERT_TRUE(is_crown_up);
  const fs::path path = scratch.path() / "plunge.toml";
  std::ofstream(path) << fmt::format(
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 1.0\n[start]\nposition = [{}, {}, {}]\n"
      "axis = [0, 0, 1]\n[[stroke]]\nkind = \"plunge\"\ndepth = 4.5\n",
      top[0], top[1], top[2] + 0.3);
  const auto tool = findToolFile("round-014", defaultToolFolders());
  ASSERT_TRUE(tool);
  HapticCutOptions hand;
  hand.hand = HandKind::kForce;
  const auto cut = cutCaseByHand(scratch.path() / "molar.case", *tool, path, scratch.path() / "molar.run", hand);
  ASSERT_TRUE(cut) << cut.error().message();
  const HapticSummary& s = cut->summary;
  EXPECT_TRUE(s.is_complete) << s.ended;
  EXPECT_GT(s.removed_mm3, 1);
  EXPECT_GT(s.removed_by_material.count("enamel"), 0u);
  EXPECT_NEAR(s.removed_mm3 + s.remaining_mm3, s.initial_mm3, 1e-6 * s.initial_mm3);
  EXPECT_GT(s.mean_contact_force, 0.9);  // the hand pushes with 1 N
  EXPECT_LT(s.mean_contact_force, 1.05);
  EXPECT_EQ(s.out_of_bricks, 0u);
  const auto again = replayRun(scratch.path() / "molar.run");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same);
  const auto exported = exportBundle(scratch.path() / "molar.run");
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_NEAR(exported->post_op.report.removed_volume_mm3, s.removed_mm3, 0.03 * s.removed_mm3);
}

// A block of a real mandible, compact and spongy bone. A saw cuts 6 mm deep from above, across the block.
TEST(DataWalk, ABlockOfAMandibleIsSawnAgainstResistance) {
  if (!fs::exists(dataFolder() / "mandible-block-L4-L6-cortical.stl")) GTEST_SKIP() << "no data at " << dataFolder();
  TemporaryFolder scratch;
  const fs::path recipe = scratch.path() / "block.toml";
  {
    std::ofstream out(recipe);
    out << "format = \"kerf-recipe\"\nversion = 1\nunit = \"mm\"\n";
    for (const char* material : {"cancellous", "cortical"})
      out << fmt::format("[[part]]\nmaterial = \"{}\"\nmesh = \"{}\"\n", material,
                         (dataFolder() / fmt::format("mandible-block-L4-L6-{}.stl", material)).string());
  }
  BakeOptions options;
  options.voxelize.voxel_mm = 0.15;
  const auto baked = bakeRecipe(recipe, scratch.path() / "block.case", options);
  ASSERT_TRUE(baked) << baked.error().message();
  const auto solid = readCaseSolid(scratch.path() / "block.case");
  ASSERT_TRUE(solid);
  const Box3 box = bounds(*solid);
  // Tool z along the shorter horizontal side, tool x up: the teeth point down.
  const bool along_x = box.size()[0] < box.size()[1];
  const Vec3d axis = along_x ? Vec3d(Vec3d::UnitX()) : Vec3d(Vec3d::UnitY());
  Vec3d top = solid->vertices.front();
  for (const Vec3d& p : solid->vertices)
    if (p[2] > top[2]) top = p;
  const Vec3d start = top + Vec3d(0, 0, 0.2) - 12.5 * axis;
  const fs::path path = scratch.path() / "saw.toml";
  std::ofstream(path) << fmt::format(
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 2.0\n[start]\nposition = [{}, {}, {}]\n"
      "axis = [{}, {}, 0]\nedge = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [0, 0, -6.2]\n",
      start[0], start[1], start[2], axis[0], axis[1]);
  const auto tool = findToolFile("saw-reciprocating-25", defaultToolFolders());
  ASSERT_TRUE(tool);
  HapticCutOptions hand;
  const auto cut = cutCaseByHand(scratch.path() / "block.case", *tool, path, scratch.path() / "block.run", hand);
  ASSERT_TRUE(cut) << cut.error().message();
  const HapticSummary& s = cut->summary;
  EXPECT_TRUE(s.is_complete);
  EXPECT_GT(s.removed_by_material.count("cortical"), 0u);
  EXPECT_NEAR(s.removed_mm3 + s.remaining_mm3, s.initial_mm3, 1e-6 * s.initial_mm3);
  EXPECT_GT(s.removed_mm3, 3);
  EXPECT_GT(s.mean_contact_force, 0.3);
  EXPECT_LT(s.peak_contact_force, 60);  // as published: some newtons to some tens at such feeds
  const auto again = replayRun(scratch.path() / "block.run");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same);
  const auto exported = exportBundle(scratch.path() / "block.run");
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_NEAR(exported->post_op.report.removed_volume_mm3, s.removed_mm3, 0.05 * s.removed_mm3);
  fmt::print("  block: {:.1f} mm3 gone, {:.1f} N mean, {:.1f} N at most, {} piece(s)\n", s.removed_mm3,
             s.mean_contact_force, s.peak_contact_force, s.pieces);
}

// From behind the last molar down to the angle, right through: the ramus separates. At 6 mm/s the drive would stall in
// the compact bone, and the path would move the blade without cutting.
TEST(DataWalk, AWholeMandibleIsSawnThroughAtTheAngle) {
  const fs::path jaw = dataFolder() / "mandible-with-teeth-closed.obj";
  if (!fs::exists(jaw)) GTEST_SKIP() << "no data at " << dataFolder();
  TemporaryFolder scratch;
  BakeOptions options;
  options.voxelize.voxel_mm = 0.2;
  const auto baked = bake({jaw}, scratch.path() / "jaw.case", options);
  ASSERT_TRUE(baked) << baked.error().message();
  const fs::path path = scratch.path() / "angle.toml";
  std::ofstream(path) << "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 2.0\n[start]\n"
                         "position = [19.5, -7, 54]\naxis = [1, 0, 0]\nedge = [0, -0.5, 0.8660254]\n[[stroke]]\n"
                         "kind = \"line\"\nby = [6, 23, -39.837169]\n";
  const auto tool = findToolFile("saw-reciprocating-25", defaultToolFolders());
  ASSERT_TRUE(tool);
  const auto cut = cutCaseByHand(scratch.path() / "jaw.case", *tool, path, scratch.path() / "jaw.run", {});
  ASSERT_TRUE(cut) << cut.error().message();
  const HapticSummary& s = cut->summary;
  EXPECT_TRUE(s.is_complete);
  EXPECT_EQ(s.stalled_s, 0);
  EXPECT_EQ(s.pieces, 2u);
  EXPECT_NEAR(s.removed_mm3 + s.remaining_mm3, s.initial_mm3, 1e-6 * s.initial_mm3);
  const auto again = replayRun(scratch.path() / "jaw.run");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same);
  const auto exported = exportBundle(scratch.path() / "jaw.run");
  ASSERT_TRUE(exported) << exported.error().message();
  const PostOpMesh& result = exported->post_op;
  EXPECT_EQ(result.report.pieces, 2u);
  EXPECT_NEAR(result.report.removed_volume_mm3, s.removed_mm3, 0.05 * s.removed_mm3);
  // Both pieces are large: a jaw and a ramus.
  const Pieces pieces = edgeConnectedPieces(result.mesh);
  std::vector<double> volume(pieces.count, 0);
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
    volume[pieces.label[t]] +=
        result.mesh.corner(t, 0).dot(result.mesh.corner(t, 1).cross(result.mesh.corner(t, 2))) / 6;
  std::sort(volume.begin(), volume.end());
  ASSERT_EQ(volume.size(), 2u);
  EXPECT_GT(volume[0], 4000);
  EXPECT_GT(volume[1], 5 * volume[0] / 2);
  fmt::print("  mandible: {:.1f} mm3 gone in {:.1f} s, {:.1f} N mean, pieces of {:.0f} and {:.0f} mm3\n", s.removed_mm3,
             s.seconds, s.mean_contact_force, volume[1], volume[0]);
}

// Two scanned crowns 0.25 mm apart. A taper that goes between them half a millimetre too far cuts both. Compares the
// run's distance with the distance of the tool's shape to the vertices of the scan.
TEST(DataWalk, ATaperBetweenTwoCrownsIsMeasuredAgainstTheNeighbourItNicks) {
  const fs::path file = dataFolder() / "lower-crowns-16-closed.obj";
  if (!fs::exists(file)) GTEST_SKIP() << "no data at " << dataFolder();
  const auto arch = readMesh(file);
  ASSERT_TRUE(arch) << arch.error().message();
  const Pieces pieces = edgeConnectedPieces(arch->mesh);
  const auto crownAt = [&](const Vec3d& middle) {
    double nearest = 1e9;
    Mesh out;
    for (std::uint32_t p = 0; p < pieces.count; ++p) {
      std::vector<char> keep(pieces.label.size());
      for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = pieces.label[t] == p;
      Mesh crown = subset(arch->mesh, keep);
      if (const double d = (bounds(crown).center() - middle).norm(); crown.triangles.size() > 1000 && d < nearest) {
        nearest = d;
        out = std::move(crown);
      }
    }
    EXPECT_LT(nearest, 1) << "the crown that is meant";
    return out;
  };
  TemporaryFolder scratch;
  BakeOptions options;
  options.unit = "mm";
  options.voxelize.voxel_mm = 0.1;
  std::map<std::string, Mesh> crowns{{"premolar", crownAt({21.9, -1, -2.9})}, {"molar", crownAt({26, -0.2, -9.7})}};
  for (const auto& [name, mesh] : crowns) {
    ASSERT_TRUE(writeMesh(scratch.path() / (name + ".off"), mesh));
    const auto baked = bake({scratch.path() / (name + ".off")}, scratch.path() / (name + ".case"), options);
    ASSERT_TRUE(baked) << baked.error().message();
  }
  const fs::path path = scratch.path() / "between.toml";
  std::ofstream(path) << "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 0.3\n[start]\n"
                         "position = [29.6, -2, -2.43]\naxis = [0, 1, 0]\n[[stroke]]\nkind = \"line\"\n"
                         "by = [-10.56, 0, -5.64]\n";
  const auto tool_file = findToolFile("856-016", defaultToolFolders());
  ASSERT_TRUE(tool_file);
  HapticCutOptions hand;
  hand.drive = "electric";  // a turbine stalls at this feed
  hand.beside = {scratch.path() / "molar.case"};
  const fs::path run = scratch.path() / "between.run";
  const auto cut = cutCaseByHand(scratch.path() / "premolar.case", *tool_file, path, run, hand);
  ASSERT_TRUE(cut) << cut.error().message();
  const HapticSummary& s = cut->summary;
  ASSERT_EQ(s.beside.size(), 1u);
  const HapticSummary::Neighbour& molar = s.beside[0];
  EXPECT_GT(molar.removed_mm3, 0.3);
  EXPECT_GT(s.removed_mm3, 5 * molar.removed_mm3);
  EXPECT_EQ(molar.overlap_mm3, 0);
  EXPECT_NEAR(s.removed_mm3 + s.remaining_mm3, s.initial_mm3, 1e-6 * s.initial_mm3);

  const auto tool = readTool(*tool_file);
  ASSERT_TRUE(tool);
  const Eigen::Quaterniond up = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), Vec3d::UnitY());
  std::ifstream rows(run / "forces.csv");
  std::string row;
  std::getline(rows, row);
  const auto column = [&row](const std::string& name) {
    return std::count(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(row.find("," + name)), ',') + 1;
  };
  const auto distance_column = static_cast<std::size_t>(column("beside_1_mm"));
  double worst = 0, least = 1e9;
  int compared = 0;
  for (int n = 0; std::getline(rows, row); ++n) {
    std::vector<double> cells;
    std::istringstream in(row);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(std::stod(cell));
    least = std::min(least, cells[distance_column]);
    if (n % 100 != 0) continue;
    const Rigid3 T_tool_world = Rigid3{up, Vec3d(cells[1], cells[2], cells[3])}.inverse();
    double exact = 1e9;
    for (const Vec3d& v : crowns["molar"].vertices) exact = std::min(exact, tool->cut->distance(T_tool_world * v));
    if (exact < 0.1 || exact > 4.8) continue;  // inside it: the scan's vertices do not give the depth
    worst = std::max(worst, std::abs(cells[distance_column] - exact));
    ++compared;
  }
  EXPECT_GT(compared, 20);
  EXPECT_LT(worst, 0.12) << "half a voxel, and 0.3 mm from vertex to vertex";
  EXPECT_NEAR(s.least_distance_mm.at("beside_1"), least, 1e-4);
  EXPECT_LT(least, -0.1);

  const auto again = replayRun(run);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same);
  for (const std::size_t beside : {0u, 1u}) {
    const auto exported = exportBundle(run, {}, {}, beside);
    ASSERT_TRUE(exported) << exported.error().message();
    const double gone = beside == 0 ? s.removed_mm3 : molar.removed_mm3;
    EXPECT_NEAR(exported->post_op.report.removed_volume_mm3, gone, 0.05 * gone);
  }
  fmt::print("  crowns: {:.2f} mm3 gone, {:.2f} mm3 of the neighbour, {:.2f} mm deep; distance within {:.3f} mm\n",
             s.removed_mm3, molar.removed_mm3, -least, worst);
}

}  // namespace
}  // namespace kerf::data_walk_test
