#include "preprocess/bake/pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_io.h"
#include "preprocess/bake/bake_job.h"
#include "preprocess/unit/unit.h"

namespace kerf {
namespace {

struct Jaw {
  UnitChoice unit;
  std::string sha256;
  Mesh mesh_mm;
};

constexpr double kMostDegrees = 15;   // between the occlusal planes of jaws that meet; 1 to 5 on scans in occlusion
constexpr double kMostApart = 15;     // mm between the boxes: more than an open mouth that was scanned so
constexpr double kMostOverlap = 0.5;  // of the lower of the two heights; an overbite is 2 to 5 mm of 15 to 25
constexpr double kMostPlanesGap = 5;  // mm between the planes: farther apart each jaw's height counts from its own

double extent(const Mesh& mesh, const Vec3d& n, double& low, double& high) {
  low = 1e300;
  high = -1e300;
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) {
      const double h = mesh.vertices[v].dot(n);
      low = std::min(low, h);
      high = std::max(high, h);
    }
  return high - low;
}

// How the jaws lie to each other, and the plane for each base where one is to be found and can be shared.
struct Fitted {
  PairCheck check;
  std::array<std::optional<GivenPlane>, 2> planes;
};

// Two occlusal planes found apart: made one for both bases if they agree. Returns the direction between the jaws.
Vec3d sharePlane(const OcclusalPlane& p, const OcclusalPlane& q, Fitted& out) {
  const double angle = std::acos(std::clamp(-p.normal.dot(q.normal), -1.0, 1.0)) * 180 / std::numbers::pi;
  out.check.planes_disagree_deg = angle;
  if (angle > kMostDegrees) {
    out.check.warnings.push_back(
        fmt::format("the occlusal planes differ by {:.0f} degrees, more than the {:.0f} of jaws in occlusion: the jaws "
                    "are probably not in one frame. Each base follows its own plane",
                    angle, kMostDegrees));
    return p.normal;
  }

  const double wp = static_cast<double>(p.tips), wq = static_cast<double>(q.tips);
  const Vec3d normal = (wp * p.normal - wq * q.normal).normalized();
  const Vec3d point = (wp * p.point + wq * q.point) / (wp + wq);
  const double between = std::abs((p.point - q.point).dot(normal));
  const bool one_point = between <= kMostPlanesGap;
  out.planes = {GivenPlane{normal, one_point ? point : p.point}, GivenPlane{normal, one_point ? point : q.point}};
  out.check.notes.push_back(fmt::format(
      "one occlusal plane for both bases: normal ({:.4f}, {:.4f}, {:.4f}), the mean of two that disagree by "
      "{:.1f} degrees and {:.1f} mm{}",
      normal.x(), normal.y(), normal.z(), angle, between,
      one_point ? "" : "; heights count from each jaw's own cusp tips"));
  return p.normal;
}

Fitted fitTogether(const std::array<const Mesh*, 2>& jaws, const CloseOptions& close) {
  Fitted out;
  PairCheck& check = out.check;

  // The boxes.
  const Box3 a = bounds(*jaws[0]), b = bounds(*jaws[1]);
  const Vec3d gap = (a.min - b.max).cwiseMax(b.min - a.max);
  check.boxes_apart_mm = gap.cwiseMax(0).norm();
  if (check.boxes_apart_mm > kMostApart)
    check.warnings.push_back(fmt::format(
        "the jaws are {:.0f} mm apart and probably not in one frame. Export both from the scanner in occlusion",
        check.boxes_apart_mm));

  // The direction from one jaw to the other: roughly, or along the occlusal normal.
  int axis = 0;
  (a.center() - b.center()).cwiseAbs().maxCoeff(&axis);
  Vec3d n = Vec3d::Unit(axis);
  if (close.find_occlusal_plane) {
    const auto p = findOcclusalPlaneOfScan(*jaws[0], close), q = findOcclusalPlaneOfScan(*jaws[1], close);
    if (p && q) n = sharePlane(*p, *q, out);  // otherwise closing reports the reason
  }

  // How far they reach into each other.
  if (gap.maxCoeff() < 0) {
    std::array<double, 2> low{}, high{};
    const double least = std::min(extent(*jaws[0], n, low[0], high[0]), extent(*jaws[1], n, low[1], high[1]));
    check.overlap_mm = std::max(0.0, std::min(high[0], high[1]) - std::max(low[0], low[1]));
    if (check.overlap_mm > kMostOverlap * least)
      check.warnings.push_back(fmt::format(
          "the jaws reach {:.1f} mm into each other, of {:.1f} mm height, and are probably not in one frame",
          check.overlap_mm, least));
  }
  return out;
}

Expected<Jaw> readJaw(const std::filesystem::path& path, const std::string& asked_unit) {
  KERF_TRY(file, readMesh(path));
  auto unit = chooseUnit(bounds(file.mesh), asked_unit, file.declared_unit);
  if (!unit) {
    unit.error().file = path.string();
    return fail(unit.error());
  }
  KERF_TRY(hash, sha256OfFile(path));
  for (Vec3d& p : file.mesh.vertices) p *= unit->scale_to_mm;
  return Jaw{*unit, hash, std::move(file.mesh)};
}

}  // namespace

Expected<std::array<std::filesystem::path, 2>> pairFolders(const std::array<std::filesystem::path, 2>& meshes,
                                                           const std::string& name) {
  if (meshes[0].stem() == meshes[1].stem())
    return fail({.code = Error::Code::kBadValue,
                 .file = meshes[1].string(),
                 .place = "--pair",
                 .found = fmt::format("two files named \"{}\"", meshes[0].stem().string()),
                 .expected = "two names, because the cases get these names",
                 .hint = "rename one, for example to lower" + meshes[1].extension().string()});
  std::filesystem::path base = name;
  if (base.extension() == ".case") base.replace_extension();
  std::array<std::filesystem::path, 2> folders;
  for (std::size_t k = 0; k < 2; ++k)
    folders[k] = base.parent_path() / (base.filename().string() + "-" + meshes[k].stem().string() + ".case");
  return folders;
}

Expected<std::array<BakeReport, 2>> bakePair(const std::array<std::filesystem::path, 2>& meshes,
                                             const std::array<std::filesystem::path, 2>& case_folders,
                                             const BakeOptions& options, const Progress& progress) {
  KERF_TRY(first, readJaw(meshes[0], options.unit));
  KERF_TRY(second, readJaw(meshes[1], options.unit));
  if (first.unit.scale_to_mm != second.unit.scale_to_mm)
    return fail({.code = Error::Code::kBadValue,
                 .file = meshes[1].string(),
                 .place = "unit",
                 .found = fmt::format("{} ({}), but {} for {} ({})", second.unit.unit, second.unit.reason,
                                      first.unit.unit, meshes[0].string(), first.unit.reason),
                 .expected = "one unit for both jaws of a pair",
                 .hint = "set the unit, for example --unit mm"});

  std::string text = "kerf-frame 1\n";
  for (const Jaw* jaw : {&first, &second}) text += fmt::format("{} {}\n", jaw->sha256, jaw->unit.scale_to_mm);
  const std::string frame = sha256(std::as_bytes(std::span(text.data(), text.size())));
  if (!report(progress, 0, "comparing the jaws")) return cancelled();

  const Fitted fitted = fitTogether({&first.mesh_mm, &second.mesh_mm}, options.close);

  std::error_code ignored;
  const bool replaced = std::filesystem::exists(case_folders[0], ignored);
  std::array<BakeReport, 2> reports;
  for (std::size_t k = 0; k < 2; ++k) {
    BakeOptions one = options;
    one.pair = CasePair{frame, case_folders[1 - k].filename().string()};
    if (fitted.planes[k]) {
      one.close.find_occlusal_plane = false;
      one.close.occlusal_plane = fitted.planes[k];
    }

    const double from = 0.5 * static_cast<double>(k);
    auto baked = bake({meshes[k]}, case_folders[k], one, partOf(progress, from, from + 0.5));
    if (!baked) {
      if (k == 1 && !replaced) std::filesystem::remove_all(case_folders[0], ignored);
      if (k == 1 && replaced && !reports[0].was_up_to_date)
        baked.error().hint += fmt::format("{}; {} was written, bake the pair again",
                                          baked.error().hint.empty() ? "" : " ", case_folders[0].string());
      return fail(std::move(baked).error());
    }
    reports[k] = std::move(*baked);
    reports[k].pair_check = fitted.check;
  }
  return reports;
}

}  // namespace kerf
