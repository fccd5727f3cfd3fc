#include "preprocess/voxelize.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <thread>
#include <vector>

#include "geometry/internal/vdb_writer.h"

namespace kerf {

struct Anatomy::Grids {
  openvdb::FloatGrid::Ptr phi;
  openvdb::Int32Grid::Ptr material;
  openvdb::points::PointDataGrid::Ptr shell;
  AnatomyStats stats;
};

Anatomy::Anatomy(std::unique_ptr<Grids> grids) : grids_(std::move(grids)) {}
Anatomy::Anatomy(Anatomy&&) noexcept = default;
Anatomy& Anatomy::operator=(Anatomy&&) noexcept = default;
Anatomy::~Anatomy() = default;
const AnatomyStats& Anatomy::stats() const { return grids_->stats; }

Expected<void> Anatomy::write(const std::filesystem::path& path) const {
  // Blosc: half the time of zip on these grids, a fifth larger.
  return internal::writeGrids(path, {grids_->phi, grids_->material, grids_->shell}, {},
                              openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
}

namespace {

using openvdb::FloatGrid;
using openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

// Lets OpenVDB read our mesh in place, in voxel units.
struct MeshAdapter {
  const Mesh& mesh;
  std::span<const std::uint32_t> triangles;
  bool reversed;
  double voxel;

  std::size_t polygonCount() const { return triangles.size(); }
  std::size_t pointCount() const { return mesh.vertices.size(); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t n, std::size_t v, openvdb::Vec3d& pos) const {
    const Triangle& t = mesh.triangles[triangles[n]];
    const Vec3d& p = mesh.vertices[t[reversed && v > 0 ? 3 - v : v]];
    pos = openvdb::Vec3d(p[0], p[1], p[2]) / voxel;
  }
};

// Forwards cancellation into the library's long loops, which ask from all threads. The progress callback is only for
// the thread that called us; it works along in every loop, so it hears of a cancellation in time.
struct Interrupter {
  std::atomic<bool>* cancelled;
  const Progress& progress;
  double fraction = 0;  // of the last step()
  std::string_view what{};
  std::thread::id caller = std::this_thread::get_id();
  void start(const char* = nullptr) {}
  void end() {}
  bool wasInterrupted(int = -1) {
    if (std::this_thread::get_id() == caller && std::chrono::steady_clock::now() >= next_question) ask();
    return cancelled->load(std::memory_order_relaxed);
  }
  void ask() {
    if (!report(progress, fraction, what)) *cancelled = true;
    next_question = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
  }
  std::chrono::steady_clock::time_point next_question{};
};

// Nesting of closed pieces: 0 = outermost, 1 = void in one, 2 = solid in a void ... and its parity against orientation.
struct Level {
  std::vector<std::uint32_t> triangles;
  bool is_void = false;
};

// Signed volume of one piece decides what it is: a piece of a crossing-free solid is a void exactly if it is negative.
// Its depth is 0 or 1 for nearly every scan; deeper nesting is found by alternating.
std::vector<Level> nestingLevels(const Mesh& mesh) {
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<double> volume(pieces.count, 0);
  std::vector<Box3> box(pieces.count);
  const Vec3d c = bounds(mesh).center();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    volume[pieces.label[t]] += (mesh.corner(t, 0) - c).dot((mesh.corner(t, 1) - c).cross(mesh.corner(t, 2) - c)) / 6;
    for (int k = 0; k < 3; ++k) box[pieces.label[t]].add(mesh.corner(t, k));
  }
  // Depth by boxes: a void's depth is one more than the smallest solid box around it, and so on. Boxes are a safe order
  // here: pieces do not cross, and a level is applied as a whole, so siblings do not matter.
  std::vector<std::uint32_t> order(pieces.count);
  for (std::uint32_t p = 0; p < pieces.count; ++p) order[p] = p;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double va = std::abs(volume[a]), vb = std::abs(volume[b]);
    return va != vb ? va > vb : a < b;
  });
  std::vector<int> depth(pieces.count, 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t p = order[i];
    const bool is_void = volume[p] < 0;
    int deepest_around = is_void ? 0 : -1;
    for (std::size_t j = 0; j < i; ++j) {
      const std::uint32_t q = order[j];
      if ((volume[q] < 0) != is_void && box[q].contains(box[p].min) && box[q].contains(box[p].max) &&
          (is_void || depth[q] > 0))
        deepest_around = std::max(deepest_around, depth[q]);
    }
    depth[p] = is_void ? (deepest_around % 2 == 0 ? deepest_around + 1 : deepest_around)
                       : (deepest_around < 0 ? 0 : deepest_around + 1);
  }
  std::map<int, Level> levels;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) levels[depth[pieces.label[t]]].triangles.push_back(t);
  std::vector<Level> out;
  for (auto& [d, level] : levels) {
    level.is_void = d % 2 == 1;
    out.push_back(std::move(level));
  }
  return out;
}

struct Bands {
  float exterior, interior;  // voxels
};
Bands bandsOf(const VoxelizeOptions& o) {
  return {static_cast<float>(o.exterior_voxels),
          static_cast<float>(std::max(o.interior_voxels, o.interior_mm / o.voxel_mm))};
}

FloatGrid::Ptr meshToField(const Mesh& mesh, const Level& level, const VoxelizeOptions& options,
                           Interrupter& interrupter) {
  const Bands bands = bandsOf(options);
  const MeshAdapter adapter{mesh, level.triangles, level.is_void, options.voxel_mm};
  const auto transform = openvdb::math::Transform::createLinearTransform(options.voxel_mm);
  // A void is made as a solid and subtracted: its exterior band is the tissue around it.
  return openvdb::tools::meshToVolume<FloatGrid>(interrupter, adapter, *transform,
                                                 level.is_void ? bands.interior : bands.exterior,
                                                 level.is_void ? bands.exterior : bands.interior);
}

// Smoothed delta of Engquist, Tornberg & Tsai 2005 in its polynomial form, and the step it is the slope of.
double smoothDelta(double phi, double e) {
  const double u = phi / e, w = 1 - u * u;
  return std::abs(u) < 1 ? w * w * 15 / (16 * e) : 0;
}
double smoothInside(double phi, double e) {  // 1 inside, 0 outside
  const double u = std::clamp(phi / e, -1.0, 1.0);
  return 0.5 - (15 * u - 10 * u * u * u + 3 * u * u * u * u * u) / 16;
}

namespace pts = openvdb::points;
using ShellLeaf = pts::PointDataTree::LeafNodeType;
using PositionCodec = pts::FixedPointCodec<false, pts::PositionRange>;

/// One leaf of the shell (null when the surface is not near) and what it adds to the sums.
struct LeafShell {
  std::unique_ptr<ShellLeaf> leaf;
  std::uint64_t points = 0;
  double area = 0, inside_nodes = 0;
};

// One point per node |phi| < 1.5 h, exactly on the node: the position in its voxel is zero everywhere and costs no
// room, as does a material that is the same all over the leaf.
LeafShell shellOfLeaf(const FloatLeaf& leaf, const FloatGrid::ConstUnsafeAccessor& accessor,
                      const pts::AttributeSet::DescriptorPtr& descriptor,
                      const pts::AttributeArray::ScopedRegistryLock& lock, double h, std::int32_t material) {
  const double e = 1.5 * h;
  const float* v = leaf.buffer().data();
  LeafShell out;
  std::vector<openvdb::Vec3f> normals;
  std::vector<float> areas;
  std::vector<ShellLeaf::ValueType> offsets(kBrickNodes);
  for (int n = 0; n < kBrickNodes; ++n) {
    const double value = v[n];
    out.inside_nodes += smoothInside(value, e);
    if (std::abs(value) < e) {
      constexpr std::array<int, 3> kStep{64, 8, 1};
      const openvdb::Coord c = leaf.offsetToGlobalCoord(static_cast<openvdb::Index>(n));
      openvdb::Vec3d gradient;
      for (int axis = 0; axis < 3; ++axis) {
        const int step = kStep[static_cast<std::size_t>(axis)], local = n / step % kBrickSide;
        openvdb::Coord up = c, down = c;
        ++up[axis], --down[axis];
        const double high = local < kBrickSide - 1 ? v[n + step] : accessor.getValue(up);
        const double low = local > 0 ? v[n - step] : accessor.getValue(down);
        gradient[axis] = (high - low) / (2 * h);
      }
      const double length = gradient.length(), area = smoothDelta(value, e) * length * h * h * h;
      if (area > 0) {
        normals.emplace_back(-gradient / length);
        areas.push_back(static_cast<float>(area));
        out.area += area;
      }
    }
    offsets[static_cast<std::size_t>(n)] = static_cast<ShellLeaf::ValueType>(areas.size());
  }
  out.points = areas.size();
  if (areas.empty()) return out;
  const auto count = static_cast<openvdb::Index>(areas.size());
  out.leaf = std::make_unique<ShellLeaf>(leaf.origin());
  auto set = std::make_unique<pts::AttributeSet>(descriptor, count, &lock);
  pts::AttributeWriteHandle<openvdb::Vec3f, PositionCodec>(*set->get("P")).collapse(openvdb::Vec3f(0));
  pts::AttributeWriteHandle<std::int32_t>(*set->get("material")).collapse(material);
  pts::AttributeWriteHandle<openvdb::Vec3f, pts::UnitVecCodec> normal(*set->get("N"));
  pts::AttributeWriteHandle<float> area(*set->get("area"));
  for (openvdb::Index i = 0; i < count; ++i) normal.set(i, normals[i]), area.set(i, areas[i]);
  out.leaf->replaceAttributeSet(set.release(), true);
  out.leaf->setOffsets(offsets);
  return out;
}

pts::PointDataGrid::Ptr makeShell(const FloatGrid& phi, const VoxelizeOptions& options, AnatomyStats& stats,
                                  Interrupter& interrupter) {
  std::vector<const FloatLeaf*> leaves;
  leaves.reserve(phi.tree().leafCount());
  phi.tree().getNodes(leaves);
  const auto descriptor =
      pts::AttributeSet::Descriptor::create(pts::TypedAttributeArray<openvdb::Vec3f, PositionCodec>::attributeType())
          ->duplicateAppend("N", pts::TypedAttributeArray<openvdb::Vec3f, pts::UnitVecCodec>::attributeType())
          ->duplicateAppend("area", pts::TypedAttributeArray<float>::attributeType())
          ->duplicateAppend("material", pts::TypedAttributeArray<std::int32_t>::attributeType());
  const pts::AttributeArray::ScopedRegistryLock lock;
  std::vector<LeafShell> made(leaves.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 32),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      if (interrupter.wasInterrupted()) return;
                      const FloatGrid::ConstUnsafeAccessor accessor(phi.tree());
                      for (std::size_t l = range.begin(); l != range.end(); ++l)
                        made[l] = shellOfLeaf(*leaves[l], accessor, descriptor, lock, options.voxel_mm,
                                              static_cast<std::int32_t>(options.material));
                    });
  auto grid = pts::PointDataGrid::create();
  grid->setName("shell");
  grid->setTransform(phi.transform().copy());
  double inside = 0;
  for (LeafShell& leaf : made) {  // in the tree's own order: the sums do not depend on threads
    stats.shell_points += leaf.points;
    stats.shell_area_mm2 += leaf.area;
    inside += leaf.inside_nodes;
    if (leaf.leaf) grid->tree().addLeaf(leaf.leaf.release());
  }
  auto tile = phi.tree().cbeginValueOff();
  tile.setMaxDepth(FloatTree::ValueOffCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile)
    if (tile.getValue() < 0) inside += static_cast<double>(tile.getVoxelCount());
  stats.volume_mm3 = inside * options.voxel_mm * options.voxel_mm * options.voxel_mm;
  return grid;
}

openvdb::Int32Grid::Ptr makeMaterial(const FloatGrid& phi, Material material) {
  // Active where there is tissue; interior tiles stay tiles, so a jaw's inside costs nothing.
  const auto mask = openvdb::tools::sdfInteriorMask(phi);
  auto grid = openvdb::Int32Grid::create(static_cast<int>(Material::kNone));
  grid->setTree(std::make_shared<openvdb::Int32Tree>(mask->tree(), static_cast<int>(Material::kNone),
                                                     static_cast<int>(material), openvdb::TopologyCopy()));
  grid->setName("material");
  grid->setTransform(phi.transform().copy());
  grid->insertMeta("labels",
                   openvdb::StringMetadata("0 none, 1 enamel, 2 dentin, 3 pulp, 4 caries, 5 cortical, 6 cancellous, "
                                           "7 nerve canal, 8 gingiva, 9 generic"));
  return grid;
}

}  // namespace

std::uint64_t estimateBakeBytes(double surface_area_mm2, const VoxelizeOptions& options) {
  // Per mm^2 of surface a band of leaves about (bands + 8) voxels thick; field, library's working copy of it (distance,
  // nearest triangle), material and shell together cost about 26 bytes a voxel.
  const Bands bands = bandsOf(options);
  const double h = options.voxel_mm, layers = static_cast<double>(bands.exterior + bands.interior) + 8;
  return static_cast<std::uint64_t>(surface_area_mm2 / (h * h) * layers * 26);
}

Expected<void> checkVoxelSize(double voxel_mm) {
  if (voxel_mm >= 0.005 && voxel_mm <= 5) return {};
  return fail({Error::Code::kBadValue, "", "voxel size", fmt::format("{} mm", voxel_mm), "0.005 to 5 mm",
               "0.1 for an arch, 0.05 for a tooth"});
}

Expected<Anatomy> voxelize(const Mesh& solid, const VoxelizeOptions& options, const Progress& progress) {
  const double h = options.voxel_mm;
  KERF_CHECK(checkVoxelSize(h));
  const double area = surfaceArea(solid);
  if (const std::uint64_t need = estimateBakeBytes(area, options); need > options.max_bytes) {
    VoxelizeOptions fits = options;
    while (estimateBakeBytes(area, fits) > options.max_bytes) fits.voxel_mm *= 1.02;
    return fail({Error::Code::kBadValue, "", "voxel size",
                 fmt::format("{} mm would need about {:.1f} GB for {:.0f} mm2 of surface", h,
                             static_cast<double>(need) / 1e9, area),
                 fmt::format("at most {:.1f} GB", static_cast<double>(options.max_bytes) / 1e9),
                 fmt::format("--voxel {:.3f}", std::ceil(fits.voxel_mm * 1000) / 1000)});
  }
  const Box3 box = bounds(solid);
  if ((box.max.cwiseAbs().cwiseMax(box.min.cwiseAbs()) / h).maxCoeff() > (1 << 20) * 7.0)
    return fail({Error::Code::kBadValue, "", "position", "coordinates too far from the origin for this voxel size", "",
                 "a coarser --voxel"});
  try {
    openvdb::initialize();
    std::atomic<bool> cancelled{false};
    Interrupter interrupter{&cancelled, progress};
    const auto step = [&](double fraction, std::string_view what) {
      interrupter.fraction = fraction, interrupter.what = what;
      interrupter.ask();
      return !cancelled;
    };
    const auto cancelError = [] { return fail({Error::Code::kCancelled, "", "", "cancelled", "", ""}); };
    auto grids = std::make_unique<Anatomy::Grids>();
    if (!step(0.0, "distance field")) return cancelError();
    for (const Level& level : nestingLevels(solid)) {
      FloatGrid::Ptr field = meshToField(solid, level, options, interrupter);
      if (cancelled) return cancelError();
      if (!grids->phi)
        grids->phi = field;
      else if (level.is_void)
        openvdb::tools::csgDifference(*grids->phi, *field);
      else
        openvdb::tools::csgUnion(*grids->phi, *field);
    }
    if (!grids->phi || grids->phi->tree().leafCount() == 0)
      return fail({Error::Code::kEmpty, "", "", "no surface at this voxel size", "a mesh larger than a voxel",
                   "a finer --voxel"});
    grids->phi->setName("phi");
    grids->phi->setGridClass(openvdb::GRID_LEVEL_SET);
    if (!step(0.7, "point shell")) return cancelError();
    grids->shell = makeShell(*grids->phi, options, grids->stats, interrupter);
    if (!step(0.9, "materials")) return cancelError();
    grids->material = makeMaterial(*grids->phi, options.material);
    grids->stats.active_voxels = grids->phi->activeVoxelCount();
    grids->stats.bytes = grids->phi->memUsage() + grids->material->memUsage() + grids->shell->memUsage();
    if (!step(1.0, "field, shell and materials")) return cancelError();
    return Anatomy(std::move(grids));
  } catch (const std::bad_alloc&) {
    return fail({Error::Code::kBadValue, "", "voxel size", "out of memory", "", "a coarser --voxel"});
  } catch (const std::exception& e) {
    return fail({Error::Code::kGeometry, "", "distance field", e.what(), "a closed mesh", "kerf check on the mesh"});
  }
}

Expected<double> timeBareMeshToVolume(const Mesh& solid, const VoxelizeOptions& options) {
  openvdb::initialize();
  std::atomic<bool> cancelled{false};
  const Progress silent;
  Interrupter interrupter{&cancelled, silent};
  Level all;
  all.triangles.resize(solid.triangles.size());
  for (std::uint32_t t = 0; t < all.triangles.size(); ++t) all.triangles[t] = t;
  const auto start = std::chrono::steady_clock::now();
  const auto field = meshToField(solid, all, options, interrupter);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!field || field->empty()) return fail({Error::Code::kEmpty, "", "", "meshToVolume gave nothing", "", ""});
  return seconds;
}

}  // namespace kerf
