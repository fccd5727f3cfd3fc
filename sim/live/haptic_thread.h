// The 1 kHz thread: device in, Session::step(), force out. It publishes to all other threads and waits for none.
//
//   device ──sample──▶ ┌────────┐ ──bricks──▶ BrickFeed ──▶ MesherThread
//   device ◀──force─── │ haptic │ ──samples, commands, checks──▶ SessionRecorder
//   send() ──queue───▶ │ thread │ ──newest report──▶ report(), times()
//          keeper ───▶ └────────┘   brick pools, made by the keeper's thread before they are needed
//
// A tick neither allocates nor locks, makes no system call but the sleep between ticks, and throws nothing. It drops or
// defers excess work, and counts it.
//
// Time: ticks are due every millisecond of CLOCK_MONOTONIC. A tick that ends after the next one was due is an overrun.
// The missed periods are skipped, since a burst of ticks would strike the hand. The simulated clock stands still
// meanwhile: ticks in the log follow each other, and a replay is bit-identical however late they came. The hand's
// motion over a skipped period counts as that of one tick.
//
// Rest: half a second after the last motion, with a device at rest (DeviceSource::isAtRest()), ticks come in bursts of
// 40 instead of one by one. No tick is left out, so the session's clock, its log and its heat go on. A command ends the
// sleep at once.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/hand/device_source.h"
#include "sim/live/live_heat.h"
#include "sim/live/piece_maker.h"
#include "sim/live/realtime.h"
#include "sim/live/stroke_peaks.h"
#include "sim/live/time_histogram.h"
#include "sim/monitor/felt_vibration.h"
#include "sim/object/brick_feed.h"
#include "sim/session/command.h"
#include "sim/session/session.h"
#include "sim/session/session_recorder.h"

namespace kerf {

struct HapticOptions {
  RealTimeRequest real_time;
  /// A tick that begins later than this after the previous one, ms, is a stall: the hand was without guidance for that
  /// long. Its sample counts as bad: zero force, latched until ClearLatch. Below 30 an ordinary system latches now and
  /// then; above 200 an outdated force would meet the hand.
  double stall_ms = 100;
  PieceMakerOptions pieces;
  /// In lockstep, called by the constructor: splits and moves at the start of the session. It returns the commands it
  /// has done, which are recorded before the first tick and cannot be undone. Empty: none.
  std::function<std::vector<Command>(Session& session)> begin;
  /// Vibration of the model's tools, one source each: added to the device's force, within the coupling's limit of
  /// force. No log has it: a replay needs no hand. Empty: none.
  std::vector<FeltSource> felt;
};

/// Counts since the start. Only the haptic thread writes them.
struct HapticCounts {
  std::uint64_t ticks = 0;
  std::uint64_t overruns = 0;        ///< ticks that ended after the next one was due
  std::uint64_t missed_periods = 0;  ///< periods skipped by overruns
  std::uint64_t stalls = 0;          ///< see HapticOptions::stall_ms
  std::uint64_t pauses = 0;          ///< for undo, redo or free bricks: see HapticThread
  double longest_pause_ms = 0;
  std::uint64_t commands_done = 0;
  std::uint64_t commands_refused = 0;
  std::uint64_t edits_pushed = 0;   ///< into all feeds
  std::uint64_t edits_waiting = 0;  ///< now: changed bricks that are in no feed yet
  std::uint64_t records_lost = 0;   ///< lost by the recorder: the log has a gap, and a replay ends there
  /// Ticks with kStepBricksRanOut or kStepNearRanOut: they needed more than Session::reserveFor() / 2 bricks. A replay
  /// may differ.
  std::uint64_t out_of_bricks = 0;
  std::uint64_t pools_taken = 0;  ///< of Session::kReserve bricks at most
  PieceMaker::Counts pieces;
};

struct ObjectReport {
  std::uint32_t id = 0;      ///< CutObject::id
  std::uint32_t loaded = 0;  ///< Session::loadedIndexOf(): 0 is the object to cut, others are neighbours
  Rigid3 T_world_object;
  /// Removed volume since loading, without undone strokes. The first piece of an object also counts the volume removed
  /// from that object.
  double removed_mm3 = 0;
};

/// State at the newest tick.
struct HapticReport {
  StepOutput output;
  double vibration = 0;    ///< N: vibration of HapticOptions::felt, added to output.force for the device
  std::uint64_t tick = 0;  ///< ticks so far, as State::tick
  HapticCounts counts;
  bool is_latched = false;             ///< force is zero until ClearLatch
  bool is_waiting_for_bricks = false;  ///< paused until there is memory for the next cut
  std::size_t object_count = 0;
  std::array<ObjectReport, kMostObjects> objects;  ///< in the scene, by number
  std::array<double, 256> removed_by_material{};   ///< mm^3, of the object to cut and its pieces
  UndoList undo;                                   ///< the steps that Undo and Redo take
  HeatReport heat;                                 ///< of the first object
};

struct HapticTimes {
  TimeHistogram cost;      ///< of a tick, from wake-up to end
  TimeHistogram lateness;  ///< from the due time of a tick to its wake-up
  TimeHistogram jitter;    ///< of the period: deviation of two wake-ups from 1 ms
};

/// Fills a report with a session's scene between two ticks: tick, latch, objects, volumes, undo. @rt
void describeScene(const Session& session, HapticReport& report) noexcept;

/// Owns a Session and runs it.
///
/// Pauses: undo and redo take some µs a brick, more than a tick for a large stroke. And a tick must not run without
/// free bricks for its changes, or the cut would differ from its replay. In both cases an invalid sample (in the log
/// like any other) first sets the device's force to zero. After the work ClearLatch follows: the force fades in again,
/// the drive restarts, and a running stroke has ended. A device that was latched before stays latched. After an undo
/// the tool may be inside restored tissue; the coupling keeps the force within its limit as in any other contact.
///
/// Pieces: a part that splits off becomes an object of its own (PieceMaker). Until the pieces are made, the object is
/// felt but not cut, about 30 ms for a mandible at 0.1 mm, and commands wait. A feed stays with its object through
/// moves, splits and undo; HapticOptions::pieces tells subscribers of the feeds of pieces.
class HapticThread {
 public:
  /// Like Session's constructor. Allocates all memory of the ticks; starts nothing.
  HapticThread(Model model, std::vector<std::shared_ptr<const BakedObject>> objects, const Rigid3& start,
               const HapticOptions& options = {});
  ~HapticThread();  ///< as stop()
  HapticThread(const HapticThread&) = delete;
  HapticThread& operator=(const HapticThread&) = delete;

  /// Before start(), for the log's header (describe()), and after stop().
  const Session& session() const noexcept;

  /// Starts the threads; returns when the first tick is about to come. Once.
  /// Without PieceMakerOptions::on_piece pieces have no feed: the feed of an object ends at its split.
  /// @param device  kept by reference, must outlive this.
  /// @param feeds  one an object, null for pieces and objects without a subscriber; or none at all. The haptic thread
  ///   is their producer. Kept by reference, must outlive this.
  /// @param recorder  kept by reference, must outlive this; may be null.
  /// Error kBadValue: more feeds than objects, or the system has no thread left.
  Expected<void> start(DeviceSource& device, std::span<BrickFeed* const> feeds, SessionRecorder* recorder);
  /// Granted privileges; after start().
  const RealTimeGrant& grant() const noexcept;

  /// Pulp and nerve canals of the first object: the report includes their temperature. Before start().
  void watchHeatOf(std::shared_ptr<const Structures> structures);
  /// From now on the report includes the heat of this tool of the model; the thread may run. For the one thread that
  /// sends commands.   @param samples  of the tool.   @cost  some ms.
  void heatBy(std::size_t tool, const ToolSamples& samples, const HeatSource& source);

  /// Queues a command to run between two ticks, in the order sent; the report counts its outcome. The haptic thread
  /// rejects a command that CommandSender::kUser may not send (freezing and splitting are the PieceMaker's), and counts
  /// it in commands_refused. For one thread. False: more than kMostCommands wait.
  bool send(const Command& command) noexcept;
  static constexpr std::size_t kMostCommands = 64;

  /// Fetches the newest report; false: none since the last call. For one thread.
  bool update() noexcept;
  const HapticReport& report() const noexcept;
  /// The same for times, published every tenth of a second and at the end.
  bool updateTimes() noexcept;
  const HapticTimes& times() const noexcept;
  /// Peaks over all ticks. After stop().
  SessionPeaks peaks() const;

  /// Ends after the running tick: zero force, device disarmed, the session finished and recorded, the last changed
  /// bricks pushed into the feeds. Waits for a full feed for two seconds at most; unsentBricks() has the rest. May be
  /// called again.
  void stop();
  std::size_t unsentBricks() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
