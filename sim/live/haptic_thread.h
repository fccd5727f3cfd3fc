// The 1 kHz thread: device in, Session::step(), force out. All other threads are told, and none is waited for.
//
//   device ──sample──▶ ┌────────┐ ──bricks──▶ BrickFeed ──▶ MesherThread
//   device ◀──force─── │ haptic │ ──samples, commands, checks──▶ SessionRecorder
//   send() ──queue───▶ │ thread │ ──newest report──▶ report(), times()
//          keeper ───▶ └────────┘   brick pools, made by the keeper's thread before they are needed
//
// A tick neither allocates nor locks, makes no system call but the sleep between ticks, and throws nothing; what does
// not fit is dropped or deferred, and counted.
//
// Time: ticks are scheduled every millisecond of CLOCK_MONOTONIC. A tick that ends after the next one was due is an
// overrun; the periods it missed are skipped and never caught up, since a burst of ticks would strike the hand. So the
// simulated clock stands still meanwhile: ticks in the log follow each other, and a replay is the same bit for bit
// however late they came. The hand's motion over a skipped period is taken for that of one tick.
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
  /// A tick that begins later than this after the one before, ms, is a stall: the hand was without guidance for that
  /// long. Its sample counts as bad: force zero, latched until ClearLatch. Below 30 an ordinary system latches now and
  /// then; above 200 the hand would be met by a force it has long forgotten.
  double stall_ms = 100;
  PieceMakerOptions pieces;
  /// Called by the constructor, in lockstep: splits and moves with which the session begins. It returns what it has
  /// done, which is recorded before the first tick and can not be undone. Empty: none.
  std::function<std::vector<Command>(Session& session)> begin;
  /// How the tools of the model are felt, one each: their vibration is added to the force that the device gets, within
  /// the coupling's limit of force. It is in no log: a replay needs no hand. Empty: none.
  std::vector<FeltSource> felt;
};

/// Since the start. Every field is written by the haptic thread alone.
struct HapticCounts {
  std::uint64_t ticks = 0;
  std::uint64_t overruns = 0;        ///< ticks that ended after the next one was due
  std::uint64_t missed_periods = 0;  ///< skipped because of them
  std::uint64_t stalls = 0;          ///< see HapticOptions::stall_ms
  std::uint64_t pauses = 0;          ///< for undo, redo or free bricks: see HapticThread
  double longest_pause_ms = 0;
  std::uint64_t commands_done = 0;
  std::uint64_t commands_refused = 0;
  std::uint64_t edits_pushed = 0;   ///< into all feeds
  std::uint64_t edits_waiting = 0;  ///< now: bricks that changed and are in no feed yet
  std::uint64_t records_lost = 0;   ///< not taken by the recorder: the log has a gap, and replays no further than that
  /// Ticks with kStepBricksRanOut or kStepNearRanOut: they needed more than Session::reserveFor() / 2 bricks. A replay
  /// may differ.
  std::uint64_t out_of_bricks = 0;
  std::uint64_t pools_taken = 0;  ///< of Session::kReserve bricks at most
  PieceMaker::Counts pieces;
};

struct ObjectReport {
  std::uint32_t id = 0;      ///< CutObject::id
  std::uint32_t loaded = 0;  ///< Session::loadedIndexOf(): 0 is worked on, the others stand beside it
  Rigid3 T_world_object;
  /// Since it was loaded, what was taken back left out. The first of the pieces of an object has what was taken from
  /// that one, too.
  double removed_mm3 = 0;
};

/// The newest tick.
struct HapticReport {
  StepOutput output;
  double vibration = 0;    ///< N: what of HapticOptions::felt was added to output.force for the device
  std::uint64_t tick = 0;  ///< how many there were, as State::tick
  HapticCounts counts;
  bool is_latched = false;             ///< force is zero until ClearLatch
  bool is_waiting_for_bricks = false;  ///< paused until there is memory for the next cut
  std::size_t object_count = 0;
  std::array<ObjectReport, kMostObjects> objects;  ///< those in the scene, by their number
  std::array<double, 256> removed_by_material{};   ///< mm^3, of the one that is worked on and its pieces
  UndoList undo;                                   ///< the steps that Undo and Redo take
  HeatReport heat;                                 ///< of the first object
};

struct HapticTimes {
  TimeHistogram cost;      ///< of a tick, from its wake-up to its end
  TimeHistogram lateness;  ///< from when a tick was due to its wake-up
  TimeHistogram jitter;    ///< of the period: how far two wake-ups are from 1 ms apart
};

/// What a report says of a session's scene between two ticks: tick, latch, objects, volumes, undo. @rt
void describeScene(const Session& session, HapticReport& report) noexcept;

/// Owns a Session and runs it.
///
/// Pauses: undo and redo take some µs a brick, more than a tick for a large stroke. And a tick must not run without
/// free bricks for what it may change, or the cut would differ from its replay. In both cases the device gets a zero
/// force first, by a sample that is not valid (in the log like any other). Then the work is done, then ClearLatch
/// follows: the force fades in again, the drive starts anew, and a stroke that was under way has ended. A device that
/// was latched before stays latched. After an undo the tool may be inside tissue that came back; the coupling keeps
/// that within the force limit as it does any other contact.
///
/// Pieces: what splits off becomes an object of its own (PieceMaker). Until the pieces are made the object is felt but
/// not cut, about 30 ms for a mandible at 0.1 mm, and commands wait. The feed of an object stays with it when it is
/// moved, split off or brought back; HapticOptions::pieces tells subscribers of the feeds of pieces.
class HapticThread {
 public:
  /// As Session's. Allocates all that the ticks need; starts nothing.
  HapticThread(Model model, std::vector<std::shared_ptr<const BakedObject>> objects, const Rigid3& start,
               const HapticOptions& options = {});
  ~HapticThread();  ///< as stop()
  HapticThread(const HapticThread&) = delete;
  HapticThread& operator=(const HapticThread&) = delete;

  /// Before start(), for the log's header (describe()), and after stop().
  const Session& session() const noexcept;

  /// Starts the threads; returns when the first tick is about to come. Once.
  /// Without PieceMakerOptions::on_piece pieces have no feed: that of an object ends where it splits.
  /// @param device  kept by reference, must outlive this.
  /// @param feeds  one an object, null for those without a subscriber and for pieces; or none at all. The haptic thread
  /// is their
  ///   producer. Kept by reference, must outlive this.
  /// @param recorder  kept by reference, must outlive this; may be null.
  /// Error kBadValue: more feeds than objects, or the system has no thread left.
  Expected<void> start(DeviceSource& device, std::span<BrickFeed* const> feeds, SessionRecorder* recorder);
  /// What the system granted; after start().
  const RealTimeGrant& grant() const noexcept;

  /// Pulp and nerve canals of the first object: their temperature is told, too. Before start().
  void watchHeatOf(std::shared_ptr<const Structures> structures);
  /// From now on the report tells how warm this tool of the model makes what it cuts; the thread may run. For the one
  /// thread that sends commands.   @param samples  of the tool.   @cost  some ms.
  void heatBy(std::size_t tool, const ToolSamples& samples, const HeatSource& source);

  /// Asks for a command between two ticks, in the order sent; the report counts whether it was done. What
  /// CommandSender::kUser may not send (freezing and splitting are the PieceMaker's) is refused there, too. For one
  /// thread. False: more than kMostCommands wait.
  bool send(const Command& command) noexcept;
  static constexpr std::size_t kMostCommands = 64;

  /// Fetches the newest report; false: none since the last call. For one thread.
  bool update() noexcept;
  const HapticReport& report() const noexcept;
  /// The same for times, which come every tenth of a second and at the end.
  bool updateTimes() noexcept;
  const HapticTimes& times() const noexcept;
  /// Of all ticks. After stop().
  SessionPeaks peaks() const;

  /// Ends after the tick under way: force zero, device disarmed, the session finished and recorded, the last changed
  /// bricks pushed into the feeds. Waits for a full feed for two seconds at most; what is left then is in
  /// unsentBricks(). May be called again.
  void stop();
  std::size_t unsentBricks() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
