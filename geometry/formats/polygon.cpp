// Triangulation of the polygons in PLY, OBJ and OFF files.
#include <algorithm>
#include <cmath>

#include "geometry/formats/mesh_source.h"

namespace kerf::internal {
namespace {

using Point2 = Eigen::Vector2d;

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

class PolygonCutter {
 public:
  explicit PolygonCutter(Mesh& mesh) : mesh_(mesh) {}

  void cut(const std::uint32_t* corner, std::size_t n) {
    if (n == 3) {
      mesh_.triangles.push_back({corner[0], corner[1], corner[2]});
      return;
    }
    project(corner, n);
    rest_.resize(n);
    for (std::size_t i = 0; i < n; ++i) rest_[i] = i;
    if (!isConvex()) clipEars(corner);
    for (std::size_t i = 1; i + 1 < rest_.size(); ++i)
      mesh_.triangles.push_back({corner[rest_[0]], corner[rest_[i]], corner[rest_[i + 1]]});
  }

 private:
  // Onto the plane of the Newell normal, dropping its largest component; mirrored if need be, so that the polygon turns
  // counter-clockwise.
  void project(const std::uint32_t* corner, std::size_t n) {
    Vec3d normal = Vec3d::Zero();
    const Vec3d origin = mesh_.vertices[corner[0]];
    for (std::size_t i = 0; i < n; ++i)
      normal += (mesh_.vertices[corner[i]] - origin).cross(mesh_.vertices[corner[(i + 1) % n]] - origin);

    int drop = 0;
    normal.cwiseAbs().maxCoeff(&drop);
    const int x = (drop + 1) % 3, y = (drop + 2) % 3;

    flat_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3d p = mesh_.vertices[corner[i]] - origin;
      flat_[i] = normal[drop] < 0 ? Point2(p[y], p[x]) : Point2(p[x], p[y]);
    }
  }

  double turnAt(std::size_t i) const {
    const std::size_t n = rest_.size();
    return turn(flat_[rest_[(i + n - 1) % n]], flat_[rest_[i]], flat_[rest_[(i + 1) % n]]);
  }

  bool isConvex() const {
    for (std::size_t i = 0; i < rest_.size(); ++i)
      if (turnAt(i) < 0) return false;
    return true;
  }

  bool isEar(std::size_t i) const {
    const std::size_t n = rest_.size();
    const Point2 &a = flat_[rest_[(i + n - 1) % n]], &b = flat_[rest_[i]], &c = flat_[rest_[(i + 1) % n]];
    if (turn(a, b, c) <= 0) return false;
    for (std::size_t k = 0; k < n; ++k) {
      const Point2& p = flat_[rest_[k]];
      if (k == i || k == (i + n - 1) % n || k == (i + 1) % n || p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  // Stops without another ear (convex rest, or a polygon that crosses itself): the caller fans out the rest.
  // In a simple polygon, cutting off an ear affects only its two neighbours, so that n corners cost n^2. Without an ear
  // the search examines other corners again, up to a limit: a hostile file could need n^3.
  void clipEars(const std::uint32_t* corner) {
    constexpr int kMostSearches = 8;
    findEars();
    for (int searches = 1; rest_.size() > 3;) {
      const std::size_t n = rest_.size();
      const auto ear = static_cast<std::size_t>(std::find(is_ear_.begin(), is_ear_.end(), 1) - is_ear_.begin());
      if (ear == n) {
        if (searches++ == kMostSearches) return;
        findEars();
        if (std::find(is_ear_.begin(), is_ear_.end(), 1) == is_ear_.end()) return;
        continue;
      }

      mesh_.triangles.push_back({corner[rest_[(ear + n - 1) % n]], corner[rest_[ear]], corner[rest_[(ear + 1) % n]]});
      rest_.erase(rest_.begin() + static_cast<std::ptrdiff_t>(ear));
      is_ear_.erase(is_ear_.begin() + static_cast<std::ptrdiff_t>(ear));

      const std::size_t before = (ear + n - 2) % (n - 1), after = ear % (n - 1);
      is_ear_[before] = isEar(before);
      is_ear_[after] = isEar(after);
    }
  }

  void findEars() {
    is_ear_.resize(rest_.size());
    for (std::size_t i = 0; i < rest_.size(); ++i) is_ear_[i] = isEar(i);
  }

  Mesh& mesh_;
  std::vector<Point2> flat_;
  std::vector<std::size_t> rest_;  // positions in the polygon not cut off yet
  std::vector<char> is_ear_;       // of rest_
};

}  // namespace

void triangulate(const Polygons& polygons, MeshFile& file) {
  Mesh& mesh = file.mesh;
  std::size_t total = 0, too_small = 0;
  for (const std::uint32_t n : polygons.sizes) total += n >= 3 ? n - 2 : 0;
  mesh.triangles.reserve(total);
  if (!polygons.colors.empty()) mesh.face_colors.reserve(total);

  PolygonCutter cutter(mesh);
  const std::uint32_t* corner = polygons.corners.data();
  for (std::size_t f = 0; f < polygons.sizes.size(); ++f) {
    const std::size_t n = polygons.sizes[f];
    if (n >= 3) {
      cutter.cut(corner, n);
      if (!polygons.colors.empty()) mesh.face_colors.resize(mesh.triangles.size(), polygons.colors[f]);
      if (n > 3) ++file.polygons_triangulated;
    } else {
      ++too_small;
    }
    corner += n;
  }

  if (too_small > 0)
    file.notes.emplace_back(std::to_string(too_small) + " faces with fewer than three corners were left out.");
  if (file.polygons_triangulated > 0)
    file.notes.emplace_back(std::to_string(file.polygons_triangulated) + " polygons were split into triangles.");
}

}  // namespace kerf::internal
