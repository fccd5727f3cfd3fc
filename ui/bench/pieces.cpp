// Whether what is cut through is known to be in pieces, how many, and how soon.
#include <fmt/format.h>

#include <cmath>

#include "sim/pieces/pieces.h"
#include "sim/run/load_scene.h"
#include "sim/run/practice_block.h"
#include "sim/step/step.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

struct Tally {
  int cases = 0, wrong = 0, unbalanced = 0;
  double ledger = 0;               // worst of |initial - removed - left| / initial
  std::vector<double> find_ms;     // every tick that changed something: export, apply, find
  std::vector<double> severed_ms;  // the tick of the last bridge
};

std::size_t partCount(const PieceList& list) { return list.pieces.size() + list.crumbs.size(); }

// Every part's volume, to the bit.
bool isBalanced(const PieceList& list) {
  SolidMeasure sum;
  for (const auto* parts : {&list.pieces, &list.crumbs})
    for (const Piece& piece : *parts) sum.add(piece.measure);
  return sum == list.whole;
}

void count(Tally& tally, const PieceList& list, std::size_t pieces, std::size_t crumbs) {
  ++tally.cases;
  tally.wrong += list.pieces.size() != pieces || list.crumbs.size() != crumbs;
  tally.unbalanced += !isBalanced(list);
}

// Cuts whatever the tool sweeps along each of `ways` (from, to; the object's frame), the pieces found after every tick;
// `expected[n]` of them after way n.
Expected<void> sever(const std::shared_ptr<const BakedObject>& object, const ToolModel& tool,
                     const Eigen::Quaterniond& turn, const Rigid3& frame,
                     const std::vector<std::pair<Vec3d, Vec3d>>& ways, const std::vector<std::size_t>& expected,
                     Tally& tally, std::uint64_t& hash) {
  Model model;
  model.tools = {tool};
  model.tissues.fill({200, 0.5f, 1e-3f, true});
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  State state;
  state.objects.emplace_back(object, 8192);
  CutObject& cut = state.objects[0];
  const auto total = [](const std::array<double, 256>& volumes) {
    double sum = 0;
    for (const double v : volumes) sum += v;
    return sum;
  };
  const double initial = total(cut.bricks().countVolumes());
  PieceFinder finder(object->phi0());
  std::size_t known = partCount(finder.find());
  std::vector<BrickEdit> edits;
  StepOutput tick;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const auto& [from, to] = ways[w];
    const int ticks = static_cast<int>(std::ceil((to - from).norm() / 0.02));  // 20 mm/s
    state.place(frame * Rigid3{turn, from});
    double last = 0;
    for (int n = 0; n <= ticks; ++n) {
      DeviceSample sample;
      sample.T_world_device = frame * Rigid3{turn, from + (to - from) * n / ticks};
      sample.pedal = 1;
      if (cut.freeBricks() < 2048) cut.reserve(4096);
      step(model, state, sample, tick);
      const double start = now();
      edits.clear();
      cut.changes(BrickSubscriber::kMesher).take([&](const CutObject::Slot& slot) {
        BrickEdit& edit = edits.emplace_back();
        edit.brick = slot.brick;
        std::copy_n(slot.phi, kBrickNodes, edit.phi.begin());
        return true;
      });
      if (edits.empty()) continue;
      finder.apply(edits);
      const std::size_t parts = partCount(finder.find());
      const double took = now() - start;
      tally.find_ms.push_back(took);
      if (parts > known) last = took;
      known = parts;
    }
    const PieceList& list = finder.find();
    if (list.pieces.size() > (w > 0 ? expected[w - 1] : 1) && last > 0) tally.severed_ms.push_back(last);
    count(tally, list, expected[w], 0);
  }
  tally.ledger =
      std::max(tally.ledger, std::abs(initial - total(cut.removed_mm3) - total(cut.bricks().countVolumes())) / initial);
  hash = hash * 0x100000001b3ull ^ state.hash();
  return {};
}

// Two blocks of nodes and what stands between them, node by node: inside where `is_inside` says so.
template <class Inside>
BrickField fieldOf(const Inside& is_inside) {
  constexpr float kVoxel = 0.1f;
  BrickField field(static_cast<double>(kVoxel), 3 * kVoxel);
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z) {
        BrickValues& v = field.brick(field.touch({x, y, z}));
        for (int n = 0; n < kBrickNodes; ++n)
          v[static_cast<std::size_t>(n)] =
              is_inside(8 * x + (n >> 6), 8 * y + (n >> 3 & 7), 8 * z + (n & 7)) ? -0.5f * kVoxel : 0.5f * kVoxel;
      }
  return field;
}

// What counts as a bridge: a node with a face neighbour on either side. Edges and corners do not hold.
void countBridges(Tally& tally) {
  const auto blocks = [](int x, int y, int z) {
    return y > 1 && y < 14 && z > 1 && z < 14 && ((x > 1 && x < 12) || (x > 19 && x < 30));
  };
  struct Bridge {
    bool (*is_inside)(int x, int y, int z);
    std::size_t pieces, crumbs;
  };
  // At x from 12 to 19, across the border of two bricks at 16.
  const Bridge bridges[] = {
      {[](int, int, int) { return false; }, 2, 0},
      {[](int x, int y, int z) { return x > 11 && x < 20 && y == 7 && z == 8; }, 1, 0},             // one voxel thick
      {[](int x, int y, int z) { return x > 11 && x < 20 && x != 16 && y == 7 && z == 8; }, 2, 0},  // and broken
      {[](int x, int y, int z) { return x > 11 && x < 20 && y == (x < 16 ? 7 : 8) && z == 8; }, 2, 0},  // edges meet
      {[](int x, int y, int z) { return x > 11 && x < 20 && y == (x < 16 ? 7 : 8) && z == (x < 16 ? 8 : 7); }, 2,
       0},  // corners meet
      {[](int x, int y, int z) {
         return x > 11 && x < 20 && z == 8 && (x < 16 ? y == 7 : y == 8 || (x == 16 && y == 7));
       },
       1, 0},                                                                            // a step
      {[](int x, int y, int z) { return x > 13 && x < 18 && y == 7 && z == 8; }, 2, 1},  // a crumb between
      {[](int x, int y, int z) { return (x == 14 || x == 17) && (y == 4 || y == 9) && z == 8; }, 2, 4}};
  for (const Bridge& bridge : bridges) {
    const BrickField field = fieldOf([&](int x, int y, int z) { return blocks(x, y, z) || bridge.is_inside(x, y, z); });
    // Of the whole, and arrived at by edits of a field that had it otherwise.
    PieceFinder fresh(field);
    count(tally, fresh.find(), bridge.pieces, bridge.crumbs);
    const BrickField before =
        fieldOf([&](int x, int y, int z) { return blocks(x, y, z) || (y == 3 && x > 5 && x < 25); });
    PieceFinder edited(before);
    edited.find();
    std::vector<BrickEdit> edits;
    for (std::size_t b = 0; b < field.brickCount(); ++b) edits.push_back({field.brickCoord(b), field.brick(b)});
    edited.apply(edits);
    count(tally, edited.find(), bridge.pieces, bridge.crumbs);
  }
}

}  // namespace

Expected<Result> benchPieces(const Progress& progress) {
  Result r{"pieces", "planes, rings, bridges and crumbs; from the last bridge's tick to the list of pieces", {}, "", 0,
           ""};
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(blades, makeModel(std::span(&saw, 1)));
  Eigen::Matrix3d axes;
  axes.col(0) = Vec3d::UnitZ();
  axes.col(1) = -Vec3d::UnitY();
  axes.col(2) = Vec3d::UnitX();
  const Eigen::Quaterniond teeth_down(axes);
  const auto plane = [](double y, double deep) {
    return std::pair(Vec3d(-12.5, y, 0.1), Vec3d(-12.5, y, -deep - 0.1));
  };
  Tally small;
  std::uint64_t hash = 0;
  countBridges(small);
  for (int n = 0; n < 6; ++n) {
    if (!report(progress, 0.1 * n, "small objects")) return cancelled();
    const Rigid3 frame{
        Eigen::Quaterniond(Eigen::AngleAxisd(0.61 * n, Vec3d(std::cos(2.0 * n), std::sin(3.0 * n), 0.7).normalized())),
        0.017 * n * Vec3d(1, -2, 0.5)};
    KERF_TRY(bar, practiceBlock({3, 9, 3}, 0.1, frame));
    KERF_CHECK(sever(bar, blades.tools[0], teeth_down, frame, {plane(0.03, 3)}, {2}, small, hash));
    KERF_CHECK(sever(bar, blades.tools[0], teeth_down, frame, {plane(-2, 3), plane(1.7, 3)}, {2, 3}, small, hash));
    // Not through: a floor of 0.3 mm holds.
    KERF_CHECK(sever(bar, blades.tools[0], teeth_down, frame, {plane(0.03, 2.6)}, {1}, small, hash));
    Box3 box;
    box.add(Vec3d(-5.2, -5.2, -2.7));
    box.add(Vec3d(5.2, 5.2, -0.3));
    Box3 turned;
    for (int c = 0; c < 8; ++c)
      turned.add(frame *
                 Vec3d((c & 1 ? box.max : box.min)[0], (c & 2 ? box.max : box.min)[1], (c & 4 ? box.max : box.min)[2]));
    const Rigid3 inverse = frame.inverse();
    KERF_TRY(ring, bakedFrom(
                       [&](const Vec3d& p) {
                         const Vec3d q = inverse * p;
                         return std::hypot(std::hypot(q[0], q[1]) - 4, q[2] + 1.5) - 1;
                       },
                       turned, 0.1));
    // The blade on one side of the ring, then on the other. (A ball would leave feather edges, and those crumbs.)
    const auto across = [](double x) { return std::pair(Vec3d(x, 0.03, 0), Vec3d(x, 0.03, -3)); };
    KERF_CHECK(sever(ring, blades.tools[0], teeth_down, frame, {across(2.5), across(-27.5)}, {1, 2}, small, hash));
  }
  // As large as a mandible: what the list costs grows with the object.
  if (!report(progress, 0.7, "a large block")) return cancelled();
  Tally large;
  KERF_TRY(block, practiceBlock({20, 50, 20}, 0.1));
  KERF_CHECK(sever(block, blades.tools[0], teeth_down, {}, {plane(-9.97, 20), plane(10.03, 20)}, {2, 3}, large, hash));
  r.ms = large.severed_ms;
  r.state_hash = fmt::format("{:016x}", hash);
  const auto times = [&](const std::string& name, const std::vector<double>& ms, double goal) {
    Result part;
    part.ms = ms;
    r.measured.push_back({name + ", p50", part.percentile(0.5), "ms", 0, false});
    r.measured.push_back({name + ", max", part.percentile(1), "ms", goal, goal > 0});
  };
  r.measured.push_back({"cases", static_cast<double>(small.cases + large.cases), "", 0, false});
  r.measured.push_back({"cases counted wrong", static_cast<double>(small.wrong + large.wrong), "", 0});
  r.measured.push_back({"lists whose volumes do not sum to the whole, to the bit",
                        static_cast<double>(small.unbalanced + large.unbalanced), "", 0});
  r.measured.push_back({"removed + left against before", std::max(small.ledger, large.ledger), "", 1e-6});
  times("last bridge to list, bars and rings", small.severed_ms, 50);
  times("any change to list, bars and rings", small.find_ms, 0);
  times(fmt::format("last bridge to list, {} bricks", block->slots().size()), large.severed_ms, 50);
  times(fmt::format("any change to list, {} bricks", block->slots().size()), large.find_ms, 0);
  return r;
}

}  // namespace kerf::cli
