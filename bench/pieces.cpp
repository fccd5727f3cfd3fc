// Whether pieces are found after a cut through an object, how many, and how soon.
#include <fmt/format.h>

#include <cmath>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "sim/pieces/pieces.h"
#include "sim/run/scene/load_scene.h"
#include "sim/step/step.h"

namespace kerf::cli {
namespace {

using namespace scenes;

struct Tally {
  int cases = 0, wrong = 0, unbalanced = 0;
  double ledger = 0;             // worst of |initial - removed - left| / initial
  std::vector<double> find_ms;   // every tick with a change: export, apply, find
  std::vector<double> split_ms;  // the tick of the last bridge
};

std::size_t partCount(const PieceList& list) { return list.pieces.size() + list.crumbs.size(); }

// The volumes of all parts sum to the whole, bit for bit.
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

double total(const std::array<double, 256>& volumes) {
  double sum = 0;
  for (const double v : volumes) sum += v;
  return sum;
}

// A straight path of the tool, in the object's frame.
struct Way {
  Vec3d from, to;
};

// Sweeps one path at 20 mm/s and finds the pieces after every tick with a change.
// @param known  known parts before, and after.   @return ms of the last tick that added parts; 0: none.
double sweepAndFind(const Model& model, State& state, const Eigen::Quaterniond& turn, const Rigid3& frame,
                    const Way& way, PieceFinder& finder, std::size_t& known, Tally& tally) {
  CutObject& cut = state.objects[0];
  const int ticks = static_cast<int>(std::ceil((way.to - way.from).norm() / 0.02));
  state.place(frame * Rigid3{turn, way.from});
  std::vector<BrickEdit> edits;
  StepOutput tick;
  double last = 0;
  for (int n = 0; n <= ticks; ++n) {
    reserveForTicks(cut);
    step(model, state, sampleAt(frame * Rigid3{turn, way.from + (way.to - way.from) * n / ticks}), tick);

    const double start = now();
    edits.clear();
    cut.changes(BrickSubscriber::kMesher).take([&](const CutObject::Slot& slot) {
      appendEdit(edits, slot);
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
  return last;
}

// Cuts along each of `ways`; `expected[n]` pieces after path n.
void splitAlong(const std::shared_ptr<const BakedObject>& object, const ToolModel& tool, const Eigen::Quaterniond& turn,
                const Rigid3& frame, const std::vector<Way>& ways, const std::vector<std::size_t>& expected,
                Tally& tally, std::uint64_t& hash) {
  Model model;
  model.tools = {tool};
  model.tissues = oneTissue(200, 0.5, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  State state;
  state.objects.emplace_back(object, 8192);
  CutObject& cut = state.objects[0];
  const double initial = total(cut.bricks().countVolumes());

  PieceFinder finder(object->phi0());
  std::size_t known = partCount(finder.find());
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const double last = sweepAndFind(model, state, turn, frame, ways[w], finder, known, tally);
    const PieceList& list = finder.find();
    if (list.pieces.size() > (w > 0 ? expected[w - 1] : 1) && last > 0) tally.split_ms.push_back(last);
    count(tally, list, expected[w], 0);
  }
  tally.ledger =
      std::max(tally.ledger, std::abs(initial - total(cut.removed_mm3) - total(cut.bricks().countVolumes())) / initial);
  hash = hash * 0x100000001b3ull ^ state.hash();
}

// Two blocks of nodes and the nodes between them. `is_inside` selects the inside nodes.
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

// A bridge is a node with a face neighbour on either side. Edges and corners do not connect.
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
    // Found in the whole field, and after edits of a different field.
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

// A ring of 8 mm, 2 mm thick, its middle 1.5 mm below the frame's origin.
Expected<std::shared_ptr<const BakedObject>> practiceRing(const Rigid3& frame) {
  Box3 box;
  box.add(Vec3d(-5.2, -5.2, -2.7));
  box.add(Vec3d(5.2, 5.2, -0.3));
  Box3 in_world;
  for (int c = 0; c < 8; ++c)
    in_world.add(frame *
                 Vec3d((c & 1 ? box.max : box.min)[0], (c & 2 ? box.max : box.min)[1], (c & 4 ? box.max : box.min)[2]));
  const Rigid3 inverse = frame.inverse();
  return bakedFrom(
      [&](const Vec3d& p) {
        const Vec3d q = inverse * p;
        return std::hypot(std::hypot(q[0], q[1]) - 4, q[2] + 1.5) - 1;
      },
      in_world, 0.1);
}

// The blade goes straight down at y, to a depth below z = 0.
Way downAt(double y, double deep) { return {{-12.5, y, 0.1}, {-12.5, y, -deep - 0.1}}; }

// Bars and rings at one attitude.
Expected<void> splitSmallObjects(const ToolModel& blade, const Rigid3& frame, Tally& tally, std::uint64_t& hash) {
  KERF_TRY(bar, practiceBlock({3, 9, 3}, 0.1, frame));
  splitAlong(bar, blade, teethDown(), frame, {downAt(0.03, 3)}, {2}, tally, hash);
  splitAlong(bar, blade, teethDown(), frame, {downAt(-2, 3), downAt(1.7, 3)}, {2, 3}, tally, hash);
  // Not through: a floor of 0.3 mm remains.
  splitAlong(bar, blade, teethDown(), frame, {downAt(0.03, 2.6)}, {1}, tally, hash);

  // The blade on one side of the ring, then on the other. (A ball would leave feather edges, and those crumbs.)
  KERF_TRY(ring, practiceRing(frame));
  const auto across = [](double x) { return Way{{x, 0.03, 0}, {x, 0.03, -3}}; };
  splitAlong(ring, blade, teethDown(), frame, {across(2.5), across(-27.5)}, {1, 2}, tally, hash);
  return {};
}

}  // namespace

Expected<Result> benchPieces(const Bench& bench) {
  Result r(SceneId::kPieces, "planes, rings, bridges and crumbs; from the last bridge's tick to the list of pieces");
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(blades, makeModel(std::span(&saw, 1)));
  const ToolModel& blade = blades.tools[0];
  Tally small;
  std::uint64_t hash = 0;
  countBridges(small);
  for (int n = 0; n < 6; ++n) {
    if (!report(bench.progress, 0.1 * n, "small objects")) return cancelled();
    const Rigid3 frame = turned(0.61 * n, {std::cos(2.0 * n), std::sin(3.0 * n), 0.7}, 0.017 * n * Vec3d(1, -2, 0.5));
    KERF_CHECK(splitSmallObjects(blade, frame, small, hash));
  }

  // As large as a mandible: the cost of the list grows with the object.
  if (!report(bench.progress, 0.7, "a large block")) return cancelled();
  Tally large;
  KERF_TRY(block, practiceBlock({20, 50, 20}, 0.1));
  splitAlong(block, blade, teethDown(), {}, {downAt(-9.97, 20), downAt(10.03, 20)}, {2, 3}, large, hash);

  r.ms = large.split_ms;
  r.state_hash = fmt::format("{:016x}", hash);
  r.add("cases", small.cases + large.cases);
  r.add("cases counted wrong", small.wrong + large.wrong);
  r.add("lists whose volumes do not sum to the whole, to the bit", small.unbalanced + large.unbalanced);
  r.add("removed + left against before", std::max(small.ledger, large.ledger));

  const auto addTimes = [&](const std::string& name, const std::vector<double>& ms) {
    r.add(name + ", p50", percentile(ms, 0.5), "ms");
    r.add(name + ", max", percentile(ms, 1), "ms");
  };
  const std::string bricks = fmt::format("{} bricks", block->slots().size());
  addTimes("last bridge to list, bars and rings", small.split_ms);
  addTimes("any change to list, bars and rings", small.find_ms);
  addTimes("last bridge to list, " + bricks, large.split_ms);
  addTimes("any change to list, " + bricks, large.find_ms);
  return r;
}

}  // namespace kerf::cli
