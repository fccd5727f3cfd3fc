#include "sim/live/mesher_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "bench/scenes/carved_field.h"
#include "tests/geometry/sampled_field.h"
#include "tests/support/welded_mesh.h"

namespace kerf::mesher_thread_test {
namespace {

using scenes::ballWithAHole;
using scenes::carve;
using scenes::carveAtRandom;

using ChunkMap = std::map<std::uint64_t, MeshChunkPtr>;

void replace(ChunkMap& mine, const std::vector<MeshChunkPtr>& newer) {
  for (const MeshChunkPtr& c : newer) {
    MeshChunkPtr& slot = mine[coordKey(c->brick)];
    if (slot) {
      EXPECT_GT(c->version, slot->version);
    }
    slot = c;
  }
}
std::vector<MeshChunkPtr> chunksOf(const ChunkMap& map) {
  std::vector<MeshChunkPtr> out;
  for (const auto& [key, c] : map)
    if (!c->isEmpty()) out.push_back(c);
  return out;
}

TEST(BrickFeed, GivesBackWhatWasPushedInOrder) {
  BrickFeed feed(3);  // rounded up
  ASSERT_EQ(feed.capacity(), 4u);
  BrickValues values{};
  BrickEdit edit;
  EXPECT_FALSE(feed.tryPop(edit));
  int pushed = 0, popped = 0;
  for (int round = 0; round < 5; ++round) {
    for (int n = 0; n < 3; ++n) {
      values.fill(static_cast<float>(pushed));
      ASSERT_TRUE(feed.tryPush({pushed++, 0, 0}, values));
    }
    for (int n = 0; n < 3; ++n) {
      ASSERT_TRUE(feed.tryPop(edit));
      EXPECT_EQ(edit.brick[0], popped);
      EXPECT_EQ(edit.phi[511], static_cast<float>(popped++));
    }
  }
}

TEST(BrickFeed, APushIntoAFullFeedChangesNothing) {
  BrickFeed feed(2);
  BrickValues values{};
  ASSERT_TRUE(feed.tryPush({1, 0, 0}, values));
  ASSERT_TRUE(feed.tryPush({2, 0, 0}, values));
  values.fill(7);
  EXPECT_FALSE(feed.tryPush({3, 0, 0}, values));
  std::vector<BrickEdit> out;
  EXPECT_EQ(feed.drain(out), 2u);
  EXPECT_EQ(out[0].brick[0], 1);
  EXPECT_EQ(out[1].brick[0], 2);
  EXPECT_EQ(out[1].phi[0], 0);
  EXPECT_TRUE(feed.tryPush({3, 0, 0}, values));
  EXPECT_EQ(feed.drain(out), 1u);
  EXPECT_EQ(out[2].brick[0], 3);
}

TEST(BrickFeed, BetweenTwoThreadsNothingIsLostTornOrDoubled) {
  BrickFeed feed(8);
  constexpr int kCount = 20'000;
  std::thread producer([&] {
    BrickValues values;
    for (int n = 0; n < kCount;) {
      values.fill(static_cast<float>(n));
      if (feed.tryPush({n, -n, 0}, values))
        ++n;
      else
        std::this_thread::yield();
    }
  });
  std::vector<BrickEdit> edits;
  int next = 0;
  while (next < kCount) {
    edits.clear();
    if (feed.drain(edits) == 0) std::this_thread::yield();
    for (const BrickEdit& e : edits) {
      ASSERT_EQ(e.brick[0], next);
      for (const float v : e.phi) ASSERT_EQ(v, static_cast<float>(next));
      ++next;
    }
  }
  producer.join();
  EXPECT_EQ(feed.drain(edits), 0u);
}

MesherThreadOptions onOneThread() {
  MesherThreadOptions options;
  options.remesher.is_parallel = false;  // ThreadSanitizer cannot see into TBB
  return options;
}

// A producer like the 1 kHz thread: changes that do not fit stay pending and go out later with their current values.
struct Producer {
  OverlayField& field;
  BrickFeed& feed;
  std::set<std::uint64_t> pending{};
  std::uint64_t pushed = 0;
  void tick(const std::vector<BrickEdit>& edits) {
    for (const BrickEdit& e : edits) pending.insert(coordKey(e.brick));
    for (auto it = pending.begin(); it != pending.end();) {
      const auto c = coordOfKey(*it);
      const Vec3i brick{c[0], c[1], c[2]};
      if (!feed.tryPush(brick, *field.valuesAt(brick))) return;
      it = pending.erase(it);
      ++pushed;
    }
  }
};

TEST(MesherThread, ReaderOfAKilohertzOfCarvesEndsWithTheMeshOfTheWholeField) {
  const double r = 1.5;
  const BrickField phi0 = ballWithAHole(r, 0.1);
  OverlayField truth(phi0);
  BrickFeed feed(32);  // small on purpose: sometimes full
  MesherThread mesher(phi0, feed, onOneThread());
  std::atomic<bool> is_done{false};
  std::uint64_t pushed = 0;
  std::thread producer([&] {
    std::mt19937 random(8);
    Producer p{truth, feed};
    auto next = std::chrono::steady_clock::now();
    for (int tick = 0; tick < 1500; ++tick) {
      p.tick(carveAtRandom(truth, r, random));
      std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
    }
    while (!p.pending.empty()) {
      p.tick({});
      std::this_thread::yield();
    }
    pushed = p.pushed;
    is_done = true;
  });
  ChunkMap mine;
  int takes = 0, states = 0;
  while (!is_done) {
    const auto fresh = mesher.take();
    replace(mine, fresh);
    if (!fresh.empty() && takes++ % 16 == 0) {  // the reader's mesh is closed at any moment
      expectClosedManifold(weldedMesh(chunksOf(mine)));
      ++states;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  producer.join();
  mesher.stop();
  replace(mine, mesher.take());
  EXPECT_TRUE(mesher.take().empty());
  EXPECT_EQ(mesher.editsDone(), pushed);
  EXPECT_GT(pushed, 0u);
  EXPECT_GT(states, 0);

  const BrickField whole = truth.flattened();
  const Remesher fresh(whole, onOneThread().remesher);
  const auto wanted = fresh.changedSince(0);
  const auto got = chunksOf(mine);
  ASSERT_EQ(got.size(), wanted.size());
  for (std::size_t n = 0; n < got.size(); ++n) {
    const MeshChunkPtr& w =
        *std::find_if(wanted.begin(), wanted.end(), [&](const MeshChunkPtr& c) { return c->brick == got[n]->brick; });
    EXPECT_EQ(got[n]->vertices, w->vertices);
    EXPECT_EQ(got[n]->triangles, w->triangles);
  }
}

TEST(MesherThread, StopsWhileTheFeedIsFullAndMeshesWhatWasInIt) {
  const BrickField phi0 = ballWithAHole(1.0, 0.1);
  OverlayField truth(phi0);
  BrickFeed feed(1024);
  MesherThread mesher(phi0, feed, onOneThread());
  std::uint64_t pushed = 0;
  for (const BrickEdit& e : carve(truth, {1.0, 0, 0}, 0.4)) pushed += feed.tryPush(e.brick, e.phi);
  mesher.stop();
  mesher.stop();
  EXPECT_EQ(mesher.editsDone(), pushed);
  EXPECT_GT(pushed, 0u);
  const BrickField whole = truth.flattened();
  const Mesh got = weldedMesh(mesher.take()),
             wanted = weldedMesh(Remesher(whole, onOneThread().remesher).changedSince(0));
  EXPECT_EQ(got.vertices, wanted.vertices);
  EXPECT_EQ(got.triangles.size(), wanted.triangles.size());
}

TEST(MesherThread, MayBeDestroyedBeforeAnybodyReads) {
  const BrickField phi0 = ballWithAHole(1.0, 0.05);
  BrickFeed feed;
  for (int n = 0; n < 5; ++n) MesherThread mesher(phi0, feed, onOneThread());
}

// Changes pushed while the thread sleeps, and requested before it wakes, must be in the answer.
TEST(MesherThread, WhatWasPushedBeforeTheChangesAreAskedForIsInThem) {
  const BrickField phi0 = ballWithAHole(1, 0.1);
  BrickFeed feed(4096);
  MesherThreadOptions options = onOneThread();
  options.poll = std::chrono::milliseconds(20);
  MesherThread mesher(phi0, feed, options);
  OverlayField field(phi0);
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(mesher.changedField());  // and it goes to sleep, or drains an empty feed once more
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::size_t pushed = 0;
    for (const BrickEdit& edit : carve(field, {std::cos(1.5 * k), std::sin(1.5 * k), 0}, 0.15)) {
      ASSERT_TRUE(feed.tryPush(edit.brick, edit.phi));
      ++pushed;
    }
    ASSERT_GT(pushed, 0u);
    const auto changed = mesher.changedField();
    ASSERT_TRUE(changed);
    EXPECT_EQ(changed->brickCount(), field.changed().brickCount()) << k;
  }
}

TEST(MesherThread, SeveralThreadsThatAskForTheChangesEachGetThem) {
  const BrickField phi0 = ballWithAHole(2, 0.2);
  BrickFeed feed(4096);
  MesherThread mesher(phi0, feed);
  OverlayField field(phi0);
  const auto edits = carve(field, {2, 0, 0}, 0.6);
  for (const BrickEdit& edit : edits) ASSERT_TRUE(feed.tryPush(edit.brick, edit.phi));

  std::vector<std::thread> askers;
  std::atomic<int> answers{0};
  for (int n = 0; n < 3; ++n)
    askers.emplace_back([&] {
      for (int k = 0; k < 50; ++k) {
        const auto changed = mesher.changedField();
        answers += changed && changed->brickCount() == edits.size() ? 1 : 0;
      }
    });
  for (std::thread& asker : askers) asker.join();
  EXPECT_EQ(answers, 150);
}

}  // namespace
}  // namespace kerf::mesher_thread_test
