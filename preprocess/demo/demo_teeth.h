// The lower teeth 1 to 7 of Kerf's demo anatomy as implicit solids, each in its own frame, and their row.
#pragma once

#include <algorithm>
#include <array>

#include "geometry/base/types.h"

namespace kerf::internal {

// Tooth frame, mm: origin at the centre of the plane of the cemento-enamel junction (CEJ), +z along the long axis to
// the occlusal side, +x mesial, +y buccal. The detailed first molar; see demo_molar.h. Negative inside, pure.
double molarTooth(const Vec3d& p);
double molarEnamel(const Vec3d& p);
double molarPulp(const Vec3d& p);

/// Averages of lower teeth, mm: Wheeler, "Dental Anatomy, Physiology and Occlusion".
struct ToothDimensions {
  int position;  ///< second digit of the FDI number: 1 central incisor ... 7 second molar
  double crown, root;
  double mesiodistal, cervix_mesiodistal;
  double buccolingual, cervix_buccolingual;
};
inline constexpr std::array<ToothDimensions, 7> kLowerTeeth = {{
    {1, 9.0, 12.5, 5.0, 3.5, 6.0, 5.3},
    {2, 9.5, 14.0, 5.5, 4.0, 6.5, 5.8},
    {3, 11.0, 16.0, 7.0, 5.5, 7.5, 7.0},
    {4, 8.5, 14.0, 7.0, 5.0, 7.5, 6.5},
    {5, 8.0, 14.5, 7.0, 5.0, 8.0, 7.0},
    {6, 7.5, 14.0, 11.0, 9.0, 10.5, 9.0},
    {7, 7.0, 13.0, 10.5, 8.0, 10.0, 9.0},
}};

/// One tissue of a tooth in its frame.
enum class ToothTissue { kTooth, kEnamel, kPulp };
double toothValue(const ToothDimensions& tooth, ToothTissue tissue, const Vec3d& p);

/// A place on the left half of the dental arch, at the level of the CEJ.
struct ToothPose {
  Rigid3 T_tooth_jaw;
  const ToothDimensions* tooth;
  Vec3d middle;   ///< centre of a ball around the tooth, jaw frame, mm
  double radius;  ///< radius of that ball, mm, with 2 mm to spare
};
/// The left row in the jaw's frame (demo_jaw.h). The right row is its mirror image: pass |x|.
const std::array<ToothPose, 7>& lowerRow();

/// Union over all teeth of a value whose body extends at most 1 mm beyond the tooth, at a point of the jaw.
/// @param reach  teeth further away than this, mm, only give a lower bound of their distance.
/// @param value  function of (tooth, point in the frame of the tooth), mm.
template <class Value>
double rowUnion(const Vec3d& p, double reach, const Value& value) {
  double nearest = 1e9;
  for (const ToothPose& pose : lowerRow()) {
    const double off = (p - pose.middle).norm() - pose.radius;
    if (off >= nearest) continue;
    nearest = std::min(nearest, off > reach ? off : value(*pose.tooth, Vec3d(pose.T_tooth_jaw * p)));
  }
  return nearest;
}
/// The same for one tissue.
inline double rowValue(ToothTissue tissue, const Vec3d& p, double reach) {
  return rowUnion(p, reach, [&](const ToothDimensions& t, const Vec3d& local) { return toothValue(t, tissue, local); });
}
/// Height over the junction of enamel and cementum of the tooth nearest to a point, mm.
double heightOnNearestTooth(const Vec3d& p);

/// Middle line of the row at the crest of the jaw, mm: x > 0 left, y posterior, from the midline backwards.
inline constexpr std::array<std::array<double, 2>, 10> kArch = {{{0, 0.5},
                                                                 {5.1, 1.3},
                                                                 {10.2, 4.0},
                                                                 {14.5, 8.3},
                                                                 {17.6, 14.2},
                                                                 {20.1, 21.2},
                                                                 {22.4, 29.0},
                                                                 {24.4, 37.5},
                                                                 {26.8, 45.5},
                                                                 {30.5, 52.5}}};

}  // namespace kerf::internal
