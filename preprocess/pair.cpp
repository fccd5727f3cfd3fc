#include "preprocess/pair.h"

#include <fmt/format.h>

#include "geometry/hash.h"
#include "geometry/mesh_io.h"
#include "preprocess/unit.h"

namespace kerf {
namespace {

struct Jaw {
  UnitChoice unit;
  std::string sha256;
};

Expected<Jaw> lookAt(const std::filesystem::path& path, const std::string& asked_unit) {
  KERF_TRY(file, readMesh(path));
  auto unit = chooseUnit(bounds(file.mesh), asked_unit, file.declared_unit);
  if (!unit) {
    unit.error().file = path.string();
    return fail(unit.error());
  }
  KERF_TRY(hash, sha256OfFile(path));
  return Jaw{*unit, hash};
}

}  // namespace

Expected<std::array<std::filesystem::path, 2>> pairFolders(const std::array<std::filesystem::path, 2>& meshes,
                                                           const std::string& name) {
  if (meshes[0].stem() == meshes[1].stem())
    return fail({Error::Code::kBadValue, meshes[1].string(), "--pair",
                 fmt::format("two files named \"{}\"", meshes[0].stem().string()),
                 "two names: the cases are called after them",
                 "rename one, for example to lower" + meshes[1].extension().string()});
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
  KERF_TRY(first, lookAt(meshes[0], options.unit));
  KERF_TRY(second, lookAt(meshes[1], options.unit));
  if (first.unit.scale_to_mm != second.unit.scale_to_mm)
    return fail({Error::Code::kBadValue, meshes[1].string(), "unit",
                 fmt::format("{} ({}), but {} for {} ({})", second.unit.unit, second.unit.reason, first.unit.unit,
                             meshes[0].string(), first.unit.reason),
                 "one unit for both jaws of a pair", "--unit mm, or whichever it is"});
  std::string text = "kerf-frame 1\n";
  for (const Jaw* jaw : {&first, &second}) text += fmt::format("{} {}\n", jaw->sha256, jaw->unit.scale_to_mm);
  const std::string frame = sha256(std::as_bytes(std::span(text.data(), text.size())));
  std::error_code ignored;
  const bool replaced = std::filesystem::exists(case_folders[0], ignored);
  std::array<BakeReport, 2> reports;
  for (std::size_t k = 0; k < 2; ++k) {
    BakeOptions one = options;
    one.pair = CasePair{frame, case_folders[1 - k].filename().string()};
    const double from = 0.5 * static_cast<double>(k);
    Progress part;
    if (progress) part = [&](double f, std::string_view what) { return progress(from + 0.5 * f, what); };
    auto report = bake({meshes[k]}, case_folders[k], one, part);
    if (!report) {
      if (k == 1 && !replaced) std::filesystem::remove_all(case_folders[0], ignored);
      if (k == 1 && replaced && !reports[0].was_up_to_date)
        report.error().hint += fmt::format("{}; {} was written, bake the pair again",
                                           report.error().hint.empty() ? "" : " ", case_folders[0].string());
      return fail(std::move(report).error());
    }
    reports[k] = std::move(*report);
  }
  return reports;
}

}  // namespace kerf
