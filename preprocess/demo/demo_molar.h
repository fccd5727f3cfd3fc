// Kerf's own demo anatomy: a lower left first molar (FDI 36), an implicit solid made from textbook dimensions. No scan,
// no patient.
//
// Frame, mm: origin at the centre of the plane of the cemento-enamel junction (CEJ), +z along the long axis to the
// occlusal side, +x mesial, +y buccal.
// Crown 7.5 high, 11.0 mesio-distal (9.0 at the cervix), 10.5 bucco-lingual; root 14.0: Wheeler's averages. Five cusps
// (MB, DB, D, ML, DL), the lingual ones higher, the crown leaning to the lingual side; central, buccal and lingual
// fissures with pits; a mesial root wide and grooved, a distal one narrower, parting 3 to 4 mm below the CEJ.
#pragma once

#include "geometry/mesh/mesh.h"

namespace kerf {

/// Signed distance to the molar's surface, mm, negative inside: the implicit function over the length of its gradient.
/// The sign is exact everywhere; the value is first-order near the surface (0.1 mm off: 2 % in the median, under 10 %
/// at 95 of 100 places), a rough guide further away than 0.5 mm. Pure, any thread; about 7 us.
double demoMolarDistance(const Vec3d& p);

/// The molar's surface with a mean edge of about `edge_mm`, which must lie in [0.05, 2]: closed, 2-manifold, without
/// self-intersections, outward-oriented; ivory crown, darker and yellower roots (vertex colours), shading into each
/// other at the CEJ. The same mesh every time. 0.18 gives about 55 000 triangles.
Mesh demoMolar(double edge_mm = 0.18);

}  // namespace kerf
