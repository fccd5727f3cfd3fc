#include "preprocess/bake/trim_file.h"

#include <fmt/format.h>

#include <cmath>

#include "geometry/base/atomic_file.h"
#include "geometry/base/toml_reader.h"
#include "geometry/case/case_bundle.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

Vec3d vectorOf(TomlTable& t, const char* key) {
  const auto n = t.numbers(key, 3);
  return t.failed() ? Vec3d::Zero() : Vec3d(n[0], n[1], n[2]);
}

Vec3d directionOf(TomlTable& t, const char* key) {
  const Vec3d v = vectorOf(t, key);
  const double length = v.norm();
  if (!t.failed() && !(length > 1e-9 && length < 1e9))
    t.reject(key, "no direction", "a direction that is not zero, as [0, 0, 1]");
  if (t.failed()) return Vec3d::UnitZ();
  return std::abs(length - 1) < 1e-12 ? v : Vec3d(v / length);
}

Expected<ScanTrim> readTrim(const toml::table& table, const fs::path& file) {
  TomlTable t(table, file, "trim");
  ScanTrim out;
  if (t.has("normal")) {
    out = PlaneTrim{vectorOf(t, "point"), directionOf(t, "normal")};
  } else {
    OutlineTrim outline;
    const auto what = t.get<std::string>("remove", "\"inside\" or \"outside\"");
    if (!t.failed() && what != "inside" && what != "outside")
      t.reject("remove", "\"" + what + "\"", "\"inside\" or \"outside\"");
    outline.keeps_inside = what == "outside";
    outline.direction = directionOf(t, "direction");
    if (t.has("eye")) outline.eye = vectorOf(t, "eye");
    t.allow("eye");
    outline.outline = t.points("outline");
    out = std::move(outline);
  }
  KERF_CHECK(t.finish());
  if (auto checked = checkTrim(out); !checked) {
    checked.error().file = file.string();
    return fail(std::move(checked.error()));
  }
  return out;
}

}  // namespace

Expected<std::vector<ScanTrim>> readTrims(const fs::path& given) {
  const fs::path file = isCase(given) ? given / kCaseTrim : given;
  std::error_code ignored;
  if (isCase(given) && !fs::exists(file, ignored))
    return fail({.code = Error::Code::kNotFound,
                 .file = given.string(),
                 .found = "a case of a whole scan",
                 .expected = fmt::format("a case with a {}, or a trim file", kCaseTrim)});
  KERF_TRY(root, parseToml(file));
  TomlTable top(root, file, "");
  const auto format = top.get<std::string>("format", "\"kerf-trim\"");
  if (!top.failed() && format != "kerf-trim") top.reject("format", "\"" + format + "\"", "\"kerf-trim\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (!top.failed() && version != 1) top.reject("version", fmt::format("{}", version), "1");
  const toml::array* const tables = top.tables("trim");
  KERF_CHECK(top.finish());

  std::vector<ScanTrim> out;
  std::size_t corners = 0;
  for (const toml::node& node : *tables) {
    KERF_TRY(trim, readTrim(*node.as_table(), file));
    if (const auto* const outline = std::get_if<OutlineTrim>(&trim)) corners += outline->outline.size();
    out.push_back(std::move(trim));
  }
  constexpr std::size_t kMostTrims = 100;
  if (out.size() > kMostTrims || corners > kMostCorners)
    return fail({.code = Error::Code::kBadValue,
                 .file = file.string(),
                 .found = fmt::format("{} cuts with {} corners", out.size(), corners),
                 .expected = fmt::format("at most {} cuts and {} corners", kMostTrims, kMostCorners)});
  return out;
}

Expected<void> writeTrims(const fs::path& path, std::span<const ScanTrim> trims) {
  KERF_TRY(file, AtomicFile::create(path));
  file.stream() << "# Kerf: parts of the scan cut away before closing. mm, in its coordinates.\n"
                << "format = \"kerf-trim\"\nversion = 1\n\n"
                << textOf(trims);
  return file.commit();
}

}  // namespace kerf
