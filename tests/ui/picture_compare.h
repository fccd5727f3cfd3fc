// How different two pictures look to a person, as one number.
//
// Pictures of one scene by two graphics drivers are never equal: edges are smoothed otherwise, colours rounded. So both
// are halved twice in linear light, which averages edges away, and then compared as CIELAB sees them (D65, CIE 1976).
// The number is the mean over all pixels of the colour difference, of the coarser or the finer level, whichever is
// more; 2.3 would be a just noticeable difference everywhere.
#pragma once

#include "geometry/base/types.h"
#include "ui/window/image.h"

namespace kerf::test {

/// CIELAB of an sRGB colour: L* 0 to 100, a*, b*.
Vec3d labOf(const std::uint8_t* srgb);

/// 0: the same. Pictures of other sizes, or empty: 100.
double pictureDifference(const Image& a, const Image& b);

/// What two drivers may differ by, and Mesa's versions do.
inline constexpr double kSamePicture = 0.35;

}  // namespace kerf::test
