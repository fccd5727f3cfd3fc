#include "preprocess/close/wrap.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "preprocess/close/poll.h"

namespace kerf::internal {
namespace {

constexpr double kMostFacets = 1e6;  // of a wrap around the box of the object: 1 GB, some 10 minutes

struct Stopped : std::exception {};

/// Called by CGAL before every facet it treats; the only way out is to throw.
struct StopWhenAsked : CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor {
  explicit StopWhenAsked(Poll& p) : poll(&p) {}
  template <class Wrapper, class Gate>
  void before_facet_treatment(const Wrapper&, const Gate&) const {
    if (poll->stop()) throw Stopped();
  }
  Poll* poll;
};

/// The first of the triangles with the same corners, whichever way round. CGAL takes the square of the copies in time.
std::vector<std::uint32_t> eachOnce(const std::vector<Triangle>& triangles) {
  std::vector<std::pair<Triangle, std::uint32_t>> sorted;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    Triangle f = triangles[t];
    std::sort(f.begin(), f.end());
    sorted.emplace_back(f, t);
  }
  std::sort(sorted.begin(), sorted.end());

  std::vector<std::uint32_t> out;
  for (std::size_t n = 0; n < sorted.size(); ++n)
    if (n == 0 || sorted[n].first != sorted[n - 1].first) out.push_back(sorted[n].second);
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

Expected<Mesh> wrapSoup(const Mesh& soup, double alpha_mm, double offset_mm, const Progress& progress) {
  const Vec3d size = bounds(soup).size() / alpha_mm;
  const double facets = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
  if (!(facets < kMostFacets))
    return fail({.code = Error::Code::kBadValue,
                 .place = "--wrap-alpha",
                 .found = fmt::format("{:g} mm, for an object of {:g} x {:g} x {:g} mm", alpha_mm, size[0] * alpha_mm,
                                      size[1] * alpha_mm, size[2] * alpha_mm),
                 .expected = fmt::format("{:.2g} mm or more", alpha_mm * std::sqrt(facets / kMostFacets)),
                 .hint = "a wrap bridges gaps of that width; or check the unit"});
  Poll poll(progress, 0.5, "shrink-wrapping");
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::string why = "an empty result";
  try {
    std::vector<Point> points;
    for (const Vec3d& p : soup.vertices) points.push_back({p.x(), p.y(), p.z()});
    std::vector<std::array<std::size_t, 3>> faces;
    for (const std::uint32_t t : eachOnce(soup.triangles)) {
      const Triangle& f = soup.triangles[t];
      faces.push_back({f[0], f[1], f[2]});
    }

    CGAL::Surface_mesh<Point> wrap;
    // CGAL 5 takes the visitor from the parameters of the output, CGAL 6 from those of the input.
    const StopWhenAsked visitor(poll);
    CGAL::alpha_wrap_3(points, faces, alpha_mm, offset_mm, wrap, CGAL::parameters::visitor(visitor),
                       CGAL::parameters::visitor(visitor));

    Mesh mesh;
    for (const auto v : wrap.vertices())
      mesh.vertices.push_back({wrap.point(v).x(), wrap.point(v).y(), wrap.point(v).z()});
    for (const auto f : wrap.faces()) {
      Triangle t{};
      std::size_t k = 0;
      for (const auto v : wrap.vertices_around_face(wrap.halfedge(f))) t[k++] = v.idx();
      mesh.triangles.push_back(t);
    }
    if (!mesh.triangles.empty()) return mesh;
  } catch (const Stopped&) {
    return cancelled();
  } catch (const std::exception& e) {
    why = e.what();
  }
  return fail({.code = Error::Code::kGeometry,
               .found = "a mesh that could not be wrapped (" + why + ")",
               .hint = "a coarser wrap (--wrap-alpha), or repair the mesh in a mesh editor"});
}

}  // namespace kerf::internal
