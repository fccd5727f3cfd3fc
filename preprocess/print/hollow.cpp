#include "preprocess/print/hollow.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "geometry/base/available_memory.h"
#include "geometry/field/marching_cubes.h"
#include "geometry/field/vdb_bricks.h"
#include "geometry/mesh/float32_cleanup.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/solids.h"
#include "preprocess/voxelize/mesh_field.h"

namespace kerf {
namespace {

constexpr double kVoxelsPerWall = 12, kLeastVoxelsPerWall = 4;
constexpr float kSpare = 3;  // voxels of field beyond a level that is meshed

double voxelOf(const HollowOptions& o) { return o.voxel_mm > 0 ? o.voxel_mm : o.wall_mm / kVoxelsPerWall; }

// ---- Refusals

Error badOption(const char* place, double found, double low, double high, const char* hint) {
  return {.code = Error::Code::kBadValue,
          .place = place,
          .found = fmt::format("{} mm", found),
          .expected = fmt::format("{} to {:.4g} mm", low, high),
          .hint = hint};
}

Expected<void> checkOptions(const HollowOptions& o) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!within(o.wall_mm, kLeastWall, kMostWall))
    return fail(badOption("wall", o.wall_mm, kLeastWall, kMostWall, "2 mm for a model"));
  if (!within(o.rounding_mm, 0, kMostWall)) return fail(badOption("rounding", o.rounding_mm, 0, kMostWall, "0.3 mm"));
  if (o.voxel_mm != 0 && !within(o.voxel_mm, 0.005, o.wall_mm / kLeastVoxelsPerWall))
    return fail(
        badOption("voxel size", o.voxel_mm, 0.005, o.wall_mm / kLeastVoxelsPerWall, "0 for a twelfth of the wall"));
  if (!within(o.least_cavity_mm3, 0, 1e9))
    return fail({.code = Error::Code::kBadValue,
                 .place = "least cavity",
                 .found = fmt::format("{} mm3", o.least_cavity_mm3),
                 .expected = "0 mm3 or more",
                 .hint = "30 mm3"});
  return {};
}

Expected<void> checkMemory(const Mesh& solid, const HollowOptions& options) {
  const std::uint64_t most = std::min(options.max_bytes, internal::availableMemory() / 5 * 4);
  const std::uint64_t need = estimateHollowBytes(solid, options);
  if (need > most) {
    HollowOptions fits = options;
    fits.voxel_mm = voxelOf(options);
    while (estimateHollowBytes(solid, fits) > most && fits.voxel_mm < kMostWall) fits.voxel_mm *= 1.02;
    const double size = std::ceil(fits.voxel_mm * 1000) / 1000;
    const bool is_usable = size <= options.wall_mm / kLeastVoxelsPerWall;
    return fail({.code = Error::Code::kBadValue,
                 .place = "voxel size",
                 .found = fmt::format("{:.3g} mm would need about {:.1f} GB", voxelOf(options),
                                      static_cast<double>(need) / 1e9),
                 .expected = fmt::format("at most {:.1f} GB", static_cast<double>(most) / 1e9),
                 .hint = is_usable ? fmt::format("a voxel of {:.3f} mm", size)
                                   : std::string("a thicker wall, or kerf check on the unit of the mesh")});
  }
  const Box3 box = bounds(solid);
  if ((box.max.cwiseAbs().cwiseMax(box.min.cwiseAbs()) / voxelOf(options)).maxCoeff() > (1 << 20) * 7.0)
    return fail({.code = Error::Code::kBadValue,
                 .place = "position",
                 .found = "coordinates too far from the origin for this voxel size",
                 .hint = "move the solid to the origin"});
  return {};
}

Error noCavity(const HollowOptions& o, std::string found, double wall_that_fits) {
  const double fits = std::floor(10 * wall_that_fits) / 10;
  return {.code = Error::Code::kEmpty,
          .place = "hollow",
          .found = std::move(found),
          .expected = fmt::format("room for a cavity of {} mm3", o.least_cavity_mm3),
          .hint = fits >= kLeastWall ? fmt::format("a wall of {:.1f} mm", fits) : std::string("print it solid")};
}

double ballRadius(double mm3) { return std::cbrt(mm3 * 3 / (4 * std::numbers::pi)); }

Error tooThin(const HollowOptions& o, const BrickField& phi) {
  double deepest = 0;
  Vec3d at = Vec3d::Zero();
  for (std::size_t b = 0; b < phi.brickCount(); ++b)
    for (int n = 0; n < kBrickNodes; ++n)
      if (const double v = phi.brick(b)[static_cast<std::size_t>(n)]; v < deepest) {
        deepest = v;
        at = phi.position(kBrickSide * phi.brickCoord(b) + Vec3i{n >> 6, n >> 3 & 7, n & 7});
      }
  const double ball = std::max(ballRadius(o.least_cavity_mm3), o.rounding_mm);
  return noCavity(o,
                  fmt::format("no cavity behind a wall of {} mm: the thickest place, at ({:.1f}, {:.1f}, {:.1f}), is "
                              "{:.2f} mm below the surface",
                              o.wall_mm, at[0], at[1], at[2], -deepest),
                  -deepest - ball - phi.voxel());
}

// A cavity grows at least as a ball of its volume does (Brunn-Minkowski).
Error tooSmall(const HollowOptions& o, double largest_mm3, const Vec3d& at) {
  return noCavity(o,
                  fmt::format("the largest cavity behind a wall of {} mm, at ({:.1f}, {:.1f}, {:.1f}), has {:.1f} mm3",
                              o.wall_mm, at[0], at[1], at[2], largest_mm3),
                  o.wall_mm - (ballRadius(o.least_cavity_mm3) - ballRadius(largest_mm3)) - voxelOf(o));
}

// ---- The cavity

// The field plus a constant, only near its zero: bricks farther than kSpare voxels from it become constants.
BrickField levelOf(const BrickField& field, double by) {
  const auto shift = static_cast<float>(by), far = static_cast<float>(kSpare * field.voxel());
  BrickField out(field.voxel(), far);
  for (std::size_t b = 0; b < field.brickCount(); ++b) {
    BrickValues values = field.brick(b);
    for (float& v : values) v += shift;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    if (*high <= -far)
      out.markInterior(field.brickCoord(b));
    else if (*low < far)
      out.add(field.brickCoord(b), values);
  }
  for (const Vec3i& brick : field.interiorBricks()) out.markInterior(brick);
  return out;
}

struct KeptCavities {
  Mesh cavities;  // as solids: outward
  std::size_t count = 0, dropped = 0;
  double dropped_mm3 = 0, largest_mm3 = 0;
  Vec3d largest_at = Vec3d::Zero();
  bool had_islands = false;
};

// Keeps the outer shells of the cavities that are large enough. An island, material that floats in a cavity, goes.
KeptCavities keptOf(const Mesh& opened, double least_mm3) {
  const Pieces shells = edgeConnectedPieces(opened);
  std::vector<double> volume(shells.count, 0);
  const Vec3d c = bounds(opened).center();
  for (std::size_t t = 0; t < opened.triangles.size(); ++t)
    volume[shells.label[t]] +=
        (opened.corner(t, 0) - c).dot((opened.corner(t, 1) - c).cross(opened.corner(t, 2) - c)) / 6;
  KeptCavities out;
  for (const double v : volume) {
    if (v < 0) {
      out.had_islands = true;
    } else if (v < least_mm3) {
      ++out.dropped;
      out.dropped_mm3 += v;
    } else {
      ++out.count;
    }
  }
  std::vector<char> keep(opened.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) {
    const double v = volume[shells.label[t]];
    keep[t] = v > 0 && v >= least_mm3;
    if (v > out.largest_mm3) {
      out.largest_mm3 = v;
      out.largest_at = opened.corner(t, 0);
    }
  }
  out.cavities = subset(opened, keep);
  return out;
}

// The source without the closed pieces that lie in a cavity.
Mesh withoutSwallowed(const Mesh& source, const Mesh& cavities, std::size_t& swallowed) {
  const Pieces shells = edgeConnectedPieces(source);
  std::vector<char> goes(shells.count, 0), seen(shells.count, 0);
  for (std::size_t t = 0; t < source.triangles.size(); ++t) {
    const std::uint32_t s = shells.label[t];
    if (seen[s]) continue;
    seen[s] = 1;
    goes[s] = isInside(cavities, source.corner(t, 0));
    swallowed += goes[s];
  }
  if (swallowed == 0) return source;
  std::vector<char> keep(source.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = !goes[shells.label[t]];
  return subset(source, keep);
}

// ---- The wall

// Moves vertices that lie too near to the surface, or within `snap_mm` of the wall, onto the exact wall. Vertices that
// the rounding placed deeper stay.
void moveOntoWall(Mesh& cavities, const MeshDistance& surface, double wall_mm, double snap_mm) {
  tbb::parallel_for(std::size_t{0}, cavities.vertices.size(), [&](std::size_t v) {
    Vec3d& p = cavities.vertices[v];
    // A move away from one triangle may bring another nearer.
    for (int round = 0; round < 3; ++round) {
      const NearestOnMesh near = surface.nearest(p, 2 * wall_mm);
      if (!near.isFound() || near.distance_mm < 0.5 * wall_mm || near.distance_mm > wall_mm + snap_mm) break;
      const double off = wall_mm - near.distance_mm;
      if (std::abs(off) < 1e-6) break;
      p += off / near.distance_mm * (p - near.point);
      if (std::abs(off) < 0.1 * snap_mm) break;
    }
  });
}

struct WallSample {
  double mm, area;
};

WallNumbers measured(const Mesh& mesh, std::size_t first_inner, const MeshDistance& surface, double wall_mm) {
  const std::size_t inner = mesh.triangles.size() - first_inner;
  std::vector<double> area(mesh.vertices.size(), 0);
  std::vector<WallSample> samples(inner);
  for (std::size_t t = 0; t < inner; ++t) {
    const double a = 0.5 * doubleAreaVector(mesh, first_inner + t).norm();
    samples[t].area = 0.75 * a;  // exact for quadratic functions
    for (const std::uint32_t v : mesh.triangles[first_inner + t]) area[v] += a / 12;
  }
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < area.size(); ++v)
    if (area[v] > 0) {
      vertices.push_back(v);
      samples.push_back({0, area[v]});
    }

  const auto place = [&](std::size_t n) -> Vec3d {
    if (n >= inner) return mesh.vertices[vertices[n - inner]];
    const std::size_t t = first_inner + n;
    return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
  };
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t n) {
    const NearestOnMesh near = surface.nearest(place(n), 2 * wall_mm);
    samples[n].mm = near.isFound() ? near.distance_mm : surface.nearest(place(n)).distance_mm;
  });

  WallNumbers out;
  std::size_t least = 0;
  double total = 0, within = 0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (samples[n].mm < samples[least].mm) least = n;
    total += samples[n].area;
    out.mean_mm += samples[n].area * samples[n].mm;
    if (std::abs(samples[n].mm - wall_mm) <= kWallTolerance) within += samples[n].area;
  }
  out.least_mm = samples[least].mm;
  out.least_at = place(least);
  out.mean_mm /= total;
  out.share_within = within / total;
  std::sort(samples.begin(), samples.end(),
            [](const WallSample& a, const WallSample& b) { return a.mm != b.mm ? a.mm < b.mm : a.area < b.area; });
  double below = 0;
  out.p05_mm = out.p95_mm = samples.back().mm;
  for (const WallSample& s : samples) {
    if (below <= 0.05 * total) out.p05_mm = s.mm;
    if (below <= 0.95 * total) out.p95_mm = s.mm;
    below += s.area;
  }
  return out;
}

// Cavities on the exact wall, in float32. A move may make triangles cross: then with smaller moves, at last without.
Expected<Mesh> finished(const Mesh& cavities, const MeshDistance& surface, double wall_mm, double voxel_mm) {
  std::size_t crossings = 0;
  for (const double snap : {0.3, 0.05, -1.0}) {
    Mesh tried = cavities;
    if (snap >= 0) moveOntoWall(tried, surface, wall_mm, snap * voxel_mm);
    std::vector<char> fixed(tried.vertices.size(), 0);
    KERF_TRY(cleaned, cleanUpForFloat32(tried, fixed, nullptr, 0.01 * voxel_mm));
    crossings = cleaned.crossings_left;
    if (crossings == 0) return tried;
  }
  return fail({.code = Error::Code::kGeometry,
               .place = "hollow",
               .found = fmt::format("{} pairs of triangles of the cavity cross after rounding to float32", crossings),
               .expected = "a printable mesh",
               .hint = "another voxel size"});
}

Expected<Hollowed> assembled(const Mesh& solid, const Mesh& source, Mesh cavities, const MeshDistance& surface,
                             const HollowOptions& options, Hollowed out) {
  for (Triangle& t : cavities.triangles) std::swap(t[1], t[2]);
  out.mesh = source;
  append(out.mesh, cavities, options.inner_color);
  const std::size_t first_inner = source.triangles.size();
  out.is_inner.assign(out.mesh.triangles.size(), 1);
  std::fill_n(out.is_inner.begin(), first_inner, 0);
  out.solid_mm3 = signedVolume(solid);
  out.resin_mm3 = signedVolume(out.mesh);
  out.wall = measured(out.mesh, first_inner, surface, options.wall_mm);
  if (out.wall.least_mm < options.wall_mm - 0.5 * out.voxel_mm)
    return fail({.code = Error::Code::kGeometry,
                 .place = fmt::format("({:.2f}, {:.2f}, {:.2f})", out.wall.least_at[0], out.wall.least_at[1],
                                      out.wall.least_at[2]),
                 .found = fmt::format("a wall of {:.3f} mm", out.wall.least_mm),
                 .expected = fmt::format("{} mm less half a voxel of {:.3g} mm", options.wall_mm, out.voxel_mm),
                 .hint = "a smaller voxel, or a thicker wall"});
  // The cavities are free of crossings, and everywhere a wall away from the source.
  if (const MeshReport verdict = checkMesh(out.mesh, {.known_free_of_crossings = true}); !verdict.print_ready)
    return fail({.code = Error::Code::kGeometry,
                 .place = "hollow",
                 .found = "the hollow mesh is not ready to print: " +
                          (verdict.reasons.empty() ? std::string("no reason") : verdict.reasons.front()),
                 .expected = "a printable mesh",
                 .hint = "another voxel size"});
  return out;
}

Expected<Hollowed> hollowed(const Mesh& solid, const HollowOptions& options, const Progress& progress) {
  openvdb::initialize();
  internal::Interrupter interrupter(progress);
  const double h = voxelOf(options), r = options.rounding_mm;
  const auto voxels = [h](double mm) { return static_cast<float>(std::ceil(mm / h)) + kSpare; };

  if (!interrupter.step(0.05, "distance field")) return cancelled();
  BrickField phi;
  {
    const auto grid = internal::meshField(solid, h, {kSpare, voxels(options.wall_mm + r)}, interrupter);
    if (!grid || !interrupter.step(0.4, "cavity")) return cancelled();
    phi = internal::toBricks(*grid);
  }
  Mesh opened = marchingCubes(levelOf(phi, options.wall_mm + r));
  if (opened.triangles.empty()) return fail(tooThin(options, phi));
  phi = {};
  if (r > 0) {
    const auto grid = internal::meshField(opened, h, {voxels(r), kSpare}, interrupter);
    if (!grid || !interrupter.step(0.6, "cavity")) return cancelled();
    opened = marchingCubes(levelOf(internal::toBricks(*grid), -r));
  }
  KeptCavities kept = keptOf(opened, options.least_cavity_mm3);
  if (kept.count == 0) return fail(tooSmall(options, kept.largest_mm3, kept.largest_at));

  if (!interrupter.step(0.7, "wall")) return cancelled();
  Hollowed out;
  out.cavities = kept.count;
  out.cavities_dropped = kept.dropped;
  out.dropped_mm3 = kept.dropped_mm3;
  out.voxel_mm = h;
  std::optional<Mesh> rest;
  if (kept.had_islands) rest = withoutSwallowed(solid, kept.cavities, out.shells_swallowed);
  const Mesh& source = rest ? *rest : solid;
  const MeshDistance surface(source);
  KERF_TRY(cavities, finished(kept.cavities, surface, options.wall_mm, h));
  if (!interrupter.step(0.85, "measuring the wall")) return cancelled();
  auto done = assembled(solid, source, std::move(cavities), surface, options, std::move(out));
  if (!interrupter.step(1, "hollow")) return cancelled();
  return done;
}

}  // namespace

std::uint64_t estimateHollowBytes(const Mesh& solid, const HollowOptions& options) {
  const double h = voxelOf(options), area = surfaceArea(solid) / (h * h), r = options.rounding_mm / h;
  const double volume = std::max(0.0, signedVolume(solid)) / (h * h * h);
  // Leaves of the first field: the band, at most the whole solid. As in estimateBakeBytes(), and a copy as bricks.
  const double first = std::min(area * (options.wall_mm / h + r + 2 * kSpare + 8), volume + area * (kSpare + 8)) * 14;
  // The cavity has at most about the solid's surface: its field, mesh and the surfaces of the bricks.
  const double second = area * ((r + 2 * kSpare + 8) * 14 + 2 * 140);
  return static_cast<std::uint64_t>(first + second) + 900 * solid.triangles.size();
}

Expected<Hollowed> hollow(const Mesh& solid, const HollowOptions& options, const Progress& progress) {
  KERF_CHECK(checkOptions(options));
  if (!report(progress, 0, "checking the solid")) return cancelled();
  if (const MeshReport verdict = checkMesh(solid); !verdict.print_ready)
    return fail({.code = Error::Code::kGeometry,
                 .place = "hollow",
                 .found = "a solid that is not ready to print: " +
                          (verdict.reasons.empty() ? std::string("no reason") : verdict.reasons.front()),
                 .expected = "a closed solid without crossings",
                 .hint = "kerf bake closes a scan, kerf export writes its solid"});
  KERF_CHECK(checkMemory(solid, options));
  try {
    return hollowed(solid, options, progress);
  } catch (const std::bad_alloc&) {
    return fail({.code = Error::Code::kBadValue,
                 .place = "voxel size",
                 .found = "out of memory",
                 .hint = "a coarser voxel, or a thicker wall"});
  } catch (const std::exception& e) {
    return fail({.code = Error::Code::kGeometry,
                 .place = "distance field",
                 .found = e.what(),
                 .expected = "a closed mesh",
                 .hint = "kerf check on the mesh"});
  }
}

}  // namespace kerf
