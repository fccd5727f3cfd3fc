// Perceived difference of two pictures, as one number.
//
// Pictures of one scene by two graphics drivers are never equal: smoothing and rounding differ. So both are halved
// twice in linear light, which averages edges away, and then compared in CIELAB (D65, CIE 1976). The number is the mean
// colour difference over all pixels, of the coarser or the finer level, whichever is larger; 2.3 would be a just
// noticeable difference everywhere.
#pragma once

#include "geometry/base/types.h"
#include "ui/window/gl/image.h"

namespace kerf::test {

/// CIELAB of an sRGB colour: L* 0 to 100, a*, b*.
Vec3d labOf(const std::uint8_t* srgb);

/// 0: equal. Pictures of different sizes, or empty: 100.
double pictureDifference(const Image& a, const Image& b);

/// Allowed difference between two drivers, and Mesa's versions.
inline constexpr double kSamePicture = 0.35;

}  // namespace kerf::test
