#include "ui/app/workbench/saw_picking.h"

#include "ui/app/base/language.h"
#include "ui/app/workbench/sawing.h"

namespace kerf {

void SawPicking::begin(What what) {
  what_ = what;
  rays_.clear();
  points_.clear();
  from_.reset();
}

std::string SawPicking::hint() const {
  static constexpr const char* kPoints[] = {"Click the first of three points on the bone.",
                                            "Click the second point, far from the first.",
                                            "Click the third point, off the line through the first two."};
  switch (what_) {
    case What::kNothing:
      return {};
    case What::kPoints:
      return shownText(kPoints[std::min<std::size_t>(rays_.size(), 2)]) + shownText("  Esc: cancel.");
    case What::kLine:
      return "Draw a line across the bone. The blade goes in along the viewing direction.  Esc: cancel.";
    case What::kDie:
      return shownText("Click the tooth that becomes a die.") + shownText("  Esc: cancel.");
    case What::kFace:
      return "Click a face. The plane lies 1 mm under it.  Esc: cancel.";
  }
  return {};
}

Expected<void> SawPicking::press(Sawing& saw, const Ray& ray) {
  constexpr double kUnderFace = 1;  // mm
  switch (what_) {
    case What::kNothing:
      return {};
    case What::kLine:
      from_ = to_ = ray;
      return {};
    case What::kFace: {
      KERF_CHECK(saw.addAlongFace(ray, kUnderFace));
      begin(What::kNothing);
      return {};
    }
    case What::kDie: {
      KERF_CHECK(saw.die.plan(ray));
      begin(What::kNothing);
      return {};
    }
    case What::kPoints:
      break;
  }
  KERF_TRY(at, saw.hit(ray));
  rays_.push_back(ray);
  points_.push_back(at.point);
  if (rays_.size() < 3) return {};

  auto added = saw.addThrough({rays_[0], rays_[1], rays_[2]});
  begin(added ? What::kNothing : What::kPoints);
  return added;
}

void SawPicking::move(const Ray& ray) {
  if (from_) to_ = ray;
}

Expected<void> SawPicking::release(Sawing& saw, const Ray& ray) {
  if (!from_) return {};
  const Ray from = *from_;
  from_.reset();
  KERF_CHECK(saw.addAlongLine(from, ray));
  begin(What::kNothing);
  return {};
}

}  // namespace kerf
