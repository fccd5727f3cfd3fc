// The lower jaw of Kerf's demo anatomy as implicit solids.
//
// Frame, mm: x to the patient's left, y backwards, z up (LPS); origin in the midline at the edges of the incisors, z =
// 0 the occlusal plane. Symmetric: the model covers x >= 0; callers pass |x|. Negative inside, pure, any thread.
#pragma once

#include <span>

#include "preprocess/demo/implicit.h"

namespace kerf::internal {

/// Compact and spongy bone together, the sockets filled, the foramina not yet opened.
double jawBone(const Vec3d& p);
/// The same without the bone that bulges over the roots.
double jawCore(const Vec3d& p);
/// Thickness of the compact bone near a point, mm.
double cortexThickness(const Vec3d& p);
/// The nerve canal, from outside the mandibular foramen to outside the mental foramen.
double nerveCanal(const Vec3d& p);
/// Its axis on the left side, from the mandibular to the mental foramen: beads with the radius of the canal.
std::span<const Bead> nervePath();
/// Surface of bone and teeth together, with the foramina open.
double jawOutline(const Vec3d& p);
/// Sockets with their ligament (PDL): the roots and 0.2 mm around.
double ligament(const Vec3d& p);
/// Spongy bone: the core less cortex, socket walls and canal walls.
double spongyBone(const Vec3d& p);

/// Gums: mucosa over the jaw, with a collar and papillae around the teeth.
double gingiva(const Vec3d& p);
/// Gums and teeth together, as seen by an intraoral scanner.
double archSurface(const Vec3d& p);

}  // namespace kerf::internal
