// kerf bench: scenes anybody can time on their own machine. Times vary, the state hash does not.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/boolean/removed_solid.h"
#include "geometry/formats/mesh_io.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/bake/bake.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_molar.h"
#include "sim/run/export_bundle.h"
#include "sim/run/geometry_cut.h"
#include "sim/run/sweep_cutter.h"
#include "ui/bench/bench.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

Expected<fs::path> benchMesh(const std::string& asked, const Scratch& scratch) {
  if (!asked.empty()) return fs::path(asked);
  const fs::path molar = scratch.path() / "molar.ply";
  if (!fs::exists(molar)) KERF_CHECK(writeMesh(molar, demoMolar(0.18)));
  return molar;
}

/// Most memory this process has had since clearPeak(), GB; 0 where the system does not tell.
void clearPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }
double peakGigabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::strtod(line.c_str() + 6, nullptr) * 1024 / 1e9;
  return 0;
}

// The whole bake, files included, against the bare library call on the solid it voxelizes.
Expected<Result> benchBakeOf(const std::string& scene, const fs::path& path, int repetitions, const Scratch& scratch,
                             const Progress& progress) {
  Result r{scene, "", {}, "", 0, "meshToVolume alone on the closed mesh, same bands"};
  BakeOptions options;
  options.overwrite = true;
  const fs::path folder = scratch.path() / "bench.case";
  std::vector<double> ratios, voxelize_ratios;
  clearPeak();
  for (int n = 0; n < repetitions; ++n) {
    const double start = now();
    KERF_TRY(report, bake({path}, folder, options, progress));
    r.ms.push_back(now() - start);
    r.peak_gb = peakGigabytes();
    KERF_TRY(solid, readCaseSolid(folder));
    KERF_TRY(bare, timeBareMeshToVolume(solid, options.voxelize));
    ratios.push_back(r.ms.back() / (1e3 * bare));
    voxelize_ratios.push_back(report.times.voxelize / bare);
    r.what = fmt::format("whole bake of {} triangles at 0.1 mm, files included", report.manifest.solid_triangles);
  }
  KERF_TRY(field, readCaseField(folder));
  r.state_hash = fmt::format("{:016x}", field.stateHash());
  std::sort(ratios.begin(), ratios.end());
  std::sort(voxelize_ratios.begin(), voxelize_ratios.end());
  r.ratio = ratios[ratios.size() / 2];
  r.part_ratio = voxelize_ratios[ratios.size() / 2];
  r.part = "field, materials and shell";
  return r;
}

Expected<Result> benchBake(const std::string& mesh, const Scratch& scratch, const Progress& progress) {
  KERF_TRY(path, benchMesh(mesh, scratch));
  return benchBakeOf("bake", path, 5, scratch, progress);
}

Expected<Result> benchBake200k(const Scratch& scratch, const Progress& progress) {
  const fs::path path = scratch.path() / "fine.ply";
  KERF_CHECK(writeMesh(path, demoMolar(0.0945)));
  return benchBakeOf("bake-200k", path, 5, scratch, progress);
}

Expected<Result> benchMandible(const Scratch& scratch, const Progress& progress) {
  KERF_TRY(anatomy, demoMandible(1, progress));
  const fs::path path = scratch.path() / "mandible.ply";
  KERF_CHECK(writeMesh(path, anatomy.mesh(anatomy.outline.front())));
  return benchBakeOf("mandible", path, 1, scratch, progress);
}

// A block of h = 0.05 mm nodes, and a tool drawn through it along a wavy line.
Expected<Result> benchCut(const std::string& scene, const std::string& tool_id, double h,
                          const Eigen::Quaterniond& attitude, const Progress& progress) {
  KERF_TRY(tool, toolOfRack(tool_id));
  Box3 box;
  box.add(Vec3d(-6, -4, -5));
  box.add(Vec3d(6, 4, 0));
  const BoxShape block(box);
  BrickField phi0(h, static_cast<float>(3 * h), static_cast<float>(-4 * h));
  const Vec3i low = brickOf((box.min / h).array().floor().cast<int>().matrix() - Vec3i::Constant(4));
  const Vec3i high = brickOf((box.max / h).array().ceil().cast<int>().matrix() + Vec3i::Constant(4));
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        BrickValues& v = phi0.brick(phi0.touch({x, y, z}));
        for (int n = 0; n < kBrickNodes; ++n)
          v[static_cast<std::size_t>(n)] = static_cast<float>(std::clamp(
              block.distance(h * Vec3d(8 * x + (n >> 6), 8 * y + (n >> 3 & 7), 8 * z + (n & 7))), -4 * h, 3 * h));
      }
  Result r{scene, fmt::format("one motion of 0.02 mm of {} in a block at {} mm", tool_id, h), {}, "", 0, ""};
  SweepCutter cutter(phi0);
  const auto pose = [&](int n) {
    const double x = -4 + 0.02 * n;
    return Rigid3{attitude, Vec3d(x, 0.6 * std::sin(x), -0.6)};
  };
  for (int n = 0; n < 400; ++n) {
    if (n % 16 == 0 && !report(progress, n / 400.0, "cutting")) return cancelled();
    const double start = now();
    cutter.advance(SweptTool(*tool.cut, pose(n), pose(n + 1)));
    r.ms.push_back(now() - start);
  }
  r.state_hash = fmt::format("{:016x}", cutter.sweep().stateHash());
  return r;
}

// Bake once, cut a groove over the top, export five times.
Expected<Result> benchExport(const std::string& mesh, const Scratch& scratch, const Progress& progress) {
  KERF_TRY(path, benchMesh(mesh, scratch));
  BakeOptions options;
  options.overwrite = true;
  const fs::path folder = scratch.path() / "export.case", run = scratch.path() / "export.run",
                 csv = scratch.path() / "groove.csv";
  KERF_TRY(baked, bake({path}, folder, options, progress));
  const Box3& box = baked.manifest.box;
  const Vec3d c = box.center();
  {
    std::ofstream out(csv);
    out << "t,x,y,z,qw,qx,qy,qz\n";
    for (int n = 0; n <= 60; ++n)
      out << fmt::format("{},{},{},{},1,0,0,0\n", 0.05 * n, c[0] + (n - 30) * box.size()[0] / 60, c[1], c[2]);
  }
  KERF_TRY(tool, findToolFile("round-014", defaultToolFolders()));
  KERF_TRY(manifest, cutCase(folder, tool, csv, run, {.overwrite = true}, progress));
  Result r{"export", fmt::format("exact export of a groove through {} triangles", baked.manifest.solid_triangles),
           {},       manifest.state_hash,
           0,        ""};
  for (int n = 0; n < 5; ++n) {
    const double start = now();
    KERF_TRY(result, exportBundle(run, {}, progress));
    KERF_CHECK(writeMesh(scratch.path() / "export.stl", result.post_op.mesh));
    r.ms.push_back(now() - start);
  }
  return r;
}

constexpr const char* kOnlyByName = "passivity-large";
struct SceneRow {
  const char* name;
  const char* what;
};
constexpr SceneRow kScenes[] = {
    {"bake", "mesh to case, against the bare library call"},
    {"bake-200k", "the same, the demo molar in 200 000 triangles"},
    {"mandible", "the same, the demo mandible: time and memory"},
    {"cut-bur", "motions of a round bur in a block at 0.05 mm"},
    {"cut-blade", "motions of a reciprocating blade in a block at 0.1 mm"},
    {"export", "run to printable STL"},
    {"points", "shell nodes against a tool's fields: 50 000 and 200 000 of them"},
    {"tick-bur", "whole ticks: taper 016 in the demo molar at 0.05 mm"},
    {"tick-saw", "whole ticks: a 25 mm blade in the demo mandible at 0.1 mm"},
    {"tick-sizes", "the same contact in three sizes of object"},
    {"realtime", "the same on the clock, on its thread, with mesher and recorder; --seconds says how long"},
    {"invariance", "force and removal over voxels, attitudes, time: no times, the same anywhere"},
    {"forces", "constant force and constant feed per material: no times"},
    {"saw", "kerf, plane and side force over attitudes: no times"},
    {"response", "penalty, constraint and impulse, coupled and direct: a table"},
    {"tunnelling", "a wall of 0.3 mm at 0.1 to 1 m/s: whether anything passes"},
    {"pieces", "planes, rings, bridges, crumbs: how many pieces, how soon known"},
    {"sever", "a mandible sawn through on the clock: how soon its pieces are objects of their own"},
    {"passivity", "energy a simulated device is given, over hands and stiffnesses: no times"},
    {"passivity-large", "the same over 11 664 devices and hands: minutes; only when asked for by name"}};

Expected<Result> runScene(const std::string& name, const std::string& mesh, double seconds, const Scratch& scratch,
                          const Progress& progress) {
  if (name == "bake") return benchBake(mesh, scratch, progress);
  if (name == "bake-200k") return benchBake200k(scratch, progress);
  if (name == "mandible") return benchMandible(scratch, progress);
  if (name == "cut-bur") return benchCut(name, "round-014", 0.05, Eigen::Quaterniond::Identity(), progress);
  // The blade lies across the groove, teeth down: its -x is the object's -z.
  if (name == "cut-blade")
    return benchCut(name, "saw-reciprocating-25", 0.1,
                    Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * M_PI, Vec3d::UnitY())), progress);
  if (name == "export") return benchExport(mesh, scratch, progress);
  if (name == "points") return benchPoints(progress);
  if (name == "tick-bur") return benchTickBur(scratch, progress);
  if (name == "tick-saw") return benchTickSaw(scratch, progress);
  if (name == "tick-sizes") return benchTickSizes(progress);
  if (name == "realtime") return benchRealtime(seconds, scratch, progress);
  if (name == "invariance") return benchInvariance(progress);
  if (name == "forces") return benchForces(progress);
  if (name == "saw") return benchSaw(progress);
  if (name == "tunnelling") return benchTunnelling(progress);
  if (name == "pieces") return benchPieces(progress);
  if (name == "sever") return benchSever(scratch, progress);
  if (name == "passivity") return benchPassivity(progress);
  if (name == "response") return benchResponse(progress);
  if (name == "passivity-large") return benchPassivityLarge(progress);
  std::string known;
  for (const SceneRow& row : kScenes) known += (known.empty() ? "" : ", ") + std::string(row.name);
  return fail({Error::Code::kBadValue, "", "SCENE", "\"" + name + "\"", "one of " + known, ""});
}

// Columns and rows in the order in which they come first. A number that misses its goal is marked.
void printTable(const Result& r) {
  std::vector<std::string> columns, rows;
  const auto place = [](std::vector<std::string>& in, const std::string& what) {
    if (std::find(in.begin(), in.end(), what) == in.end()) in.push_back(what);
  };
  const auto split = [](const Measured& m) {
    const std::size_t at = m.name.find(": ");
    return std::pair(m.name.substr(0, at), m.name.substr(at + 2) + (m.unit.empty() ? "" : ", " + m.unit));
  };
  for (const Measured& m : r.measured) {
    place(columns, split(m).first);
    place(rows, split(m).second);
  }
  fmt::print("{:<44}", "");
  for (const std::string& column : columns) fmt::print(" {:>18}", column);
  fmt::print("\n");
  bool missed = false;
  for (const std::string& row : rows) {
    fmt::print("{:<44}", row);
    for (const std::string& column : columns)
      for (const Measured& m : r.measured)
        if (split(m) == std::pair(column, row)) {
          fmt::print(" {:>17.4g}{}", m.value, m.passed() ? " " : "!");
          missed |= !m.passed();
        }
    fmt::print("\n");
  }
  if (missed) fmt::print("!: more than the goal\n");
}

}  // namespace

void addBench(CLI::App& app, int& exit_code) {
  struct Arguments {
    std::string scene, mesh;
    double seconds = 20;
    bool json = false;
  };
  auto a = std::make_shared<Arguments>();
  CLI::App* c = &app;  // the command itself: ui/cli/commands.h
  std::string scenes = "Scenes:";
  for (const SceneRow& row : kScenes) scenes += fmt::format("\n  {:<15} {}", row.name, row.what);
  c->footer(scenes + "\nExample: kerf bench bake --mesh scan.stl");
  c->add_option("SCENE", a->scene, "one scene; all but the last without");
  c->add_option("--mesh", a->mesh, "mesh for bake and export (default: the demo molar)");
  c->add_option("--seconds", a->seconds, "length of realtime")->check(CLI::Range(1.0, 3600.0))->capture_default_str();
  c->add_flag("--json", a->json, "as JSON on standard output");
  c->callback([a, &exit_code] {
    const Scratch scratch;
    std::vector<std::string> names;
    if (a->scene.empty()) {
      for (const SceneRow& row : kScenes)
        if (std::string(row.name) != kOnlyByName) names.emplace_back(row.name);
    } else {
      names.push_back(a->scene);
    }
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& name : names) {
      const auto r = [&] {
        TerminalProgress progress;
        return runScene(name, a->mesh, a->seconds, scratch, progress.callback());
      }();
      if (!r) {
        exit_code = complain(r.error());
        return;
      }
      if (a->json) {
        nlohmann::json j{{"scene", r->scene},
                         {"what", r->what},
                         {"count", r->ms.size()},
                         {"p50_ms", r->percentile(0.5)},
                         {"p99_ms", r->percentile(0.99)},
                         {"p99.9_ms", r->percentile(0.999)},
                         {"max_ms", r->percentile(1)},
                         {"state_hash", r->state_hash}};
        if (r->ratio > 0) {
          j["ratio"] = r->ratio;
          j["ratio_to"] = r->ratio_to;
        }
        if (!r->part.empty()) {
          j["part"] = r->part;
          j["part_ratio"] = r->part_ratio;
        }
        if (r->peak_gb > 0) j["peak_gb"] = r->peak_gb;
        if (!r->notes.empty()) j["notes"] = r->notes;
        for (const Measured& m : r->measured) {
          nlohmann::json number{{"value", m.value}, {"unit", m.unit}};
          if (m.has_goal) {
            number["at_most"] = m.goal;
            number["passed"] = m.passed();
          }
          j["measured"][m.name] = number;
        }
        all.push_back(j);
      } else {
        if (r->ms.empty())
          fmt::print("{:<10} {}\n", r->scene, r->what);
        else
          fmt::print("{:<10} p50 {:9.3f}  p99 {:9.3f}  max {:9.3f} ms  x{:<4} {}  {}\n", r->scene, r->percentile(0.5),
                     r->percentile(0.99), r->percentile(1), r->ms.size(), r->state_hash, r->what);
        for (const std::string& note : r->notes) fmt::print("           {}\n", note);
        if (r->is_table) printTable(*r);
        for (const Measured& m : r->measured) {
          if (r->is_table) break;
          fmt::print("           {:<44} {:10.4g} {}", m.name, m.value, m.unit);
          if (m.has_goal)
            fmt::print("{}(at most {:g}: {})", m.unit.empty() ? "" : " ", m.goal, m.passed() ? "met" : "MISSED");
          fmt::print("\n");
        }
        if (r->ratio > 0) fmt::print("           {:.2f} x {}", r->ratio, r->ratio_to);
        if (!r->part.empty()) fmt::print("; {} {:.2f} x", r->part, r->part_ratio);
        if (r->peak_gb > 0) fmt::print("; {:.2f} GB at most", r->peak_gb);
        if (r->ratio > 0) fmt::print("\n");
        std::fflush(stdout);
      }
    }
    if (a->json) printJson(all);
    exit_code = kOk;
  });
}

}  // namespace kerf::cli
