#include "ui/app/saw/plane_words.h"

#include <charconv>
#include <cmath>

#include "preprocess/close/occlusal_plane.h"
#include "ui/app/saw/saw_plan.h"
#include "ui/app/view/upright.h"

namespace kerf {
namespace {

std::vector<std::string_view> partsOf(std::string_view word, char between) {
  std::vector<std::string_view> out;
  while (true) {
    const std::size_t at = word.find(between);
    out.push_back(word.substr(0, at));
    if (at == word.npos) return out;
    word.remove_prefix(at + 1);
  }
}

std::optional<double> numberOfWord(std::string_view word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
  return value;
}

tl::unexpected<Error> wrongPlane(const std::string& option, const std::string& word, const char* expected,
                                 const char* hint) {
  return fail({.code = Error::Code::kBadValue,
               .place = option,
               .found = "\"" + word + "\"",
               .expected = expected,
               .hint = hint});
}

Expected<Plane> aboveOcclusalPlane(const std::string& word, std::string_view height, const Mesh& mesh,
                                   const std::string& option) {
  const auto mm = numberOfWord(height);
  if (!mm)
    return wrongPlane(option, word, "a height in mm after occlusal@; negative is below the plane", "occlusal@-12");
  const auto up = occlusalNormalOf(mesh);
  if (!up)
    return fail({.code = Error::Code::kGeometry,
                 .place = option,
                 .found = "no occlusal plane: no base and no cusp tips to find the upper side from",
                 .expected = "a jaw",
                 .hint = "a plane by normal and point: 0,0,1@0,0,12"});
  auto found = findOcclusalPlane(mesh, *up);
  if (!found) {
    found.error().place = option + " occlusal";
    found.error().hint = "a plane by normal and point: 0,0,1@0,0,12";
    return fail(std::move(found).error());
  }
  return Plane{found->point + *mm * found->normal, found->normal};
}

}  // namespace

std::optional<Vec3d> vectorOfWord(std::string_view word) {
  const auto parts = partsOf(word, ',');
  if (parts.size() != 3) return {};
  Vec3d out;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = numberOfWord(parts[k]);
    if (!value) return {};
    out[static_cast<int>(k)] = *value;
  }
  return out;
}

std::optional<NormalAndPoint> normalAndPointOfWord(std::string_view word) {
  const auto parts = partsOf(word, '@');
  const auto normal = vectorOfWord(parts.front());
  if (!normal || !(normal->norm() > 0) || parts.size() > 2) return {};
  if (parts.size() == 1) return NormalAndPoint{*normal, {}};
  const auto point = vectorOfWord(parts.back());
  if (!point) return {};
  return NormalAndPoint{*normal, point};
}

Expected<Plane> planeOfWord(const std::string& word, const Mesh& mesh, const std::string& option) {
  constexpr std::string_view kOcclusal = "occlusal@";
  if (word.starts_with(kOcclusal))
    return aboveOcclusalPlane(word, std::string_view(word).substr(kOcclusal.size()), mesh, option);

  if (const auto given = normalAndPointOfWord(word); given && given->point)
    return Plane{*given->point, given->normal.normalized()};

  const auto parts = partsOf(word, '/');
  std::array<Vec3d, 3> points;
  bool has_points = parts.size() == 3;
  for (std::size_t k = 0; has_points && k < 3; ++k) {
    const auto point = vectorOfWord(parts[k]);
    has_points = point.has_value();
    if (point) points[k] = *point;
  }
  if (!has_points)
    return wrongPlane(option, word, "normal@point, three points separated by /, or occlusal@MM",
                      "0,0,1@0,0,12 or 0,0,12/10,0,12/0,10,12 or occlusal@-12");
  auto through = planeThrough(points, Vec3d::UnitZ());
  if (!through) {
    through.error().place = option;
    return fail(std::move(through).error());
  }
  return Plane{through->point, through->normal};
}

Expected<std::array<Vec3d, 2>> twoPointsOfWord(const std::string& word, const std::string& option) {
  const auto parts = partsOf(word, '/');
  const auto first = vectorOfWord(parts.front()), second = vectorOfWord(parts.back());
  if (parts.size() != 2 || !first || !second)
    return wrongPlane(option, word, "two points separated by /, mm", "-8,40,3/2,42,3");
  return std::array<Vec3d, 2>{*first, *second};
}

}  // namespace kerf
