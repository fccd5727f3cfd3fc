// The 1 kHz thread: device in, Session::step(), force out, and everybody else told without being waited for.
//
//   device ──sample──▶ ┌────────┐ ──bricks──▶ BrickFeed ──▶ MesherThread
//   device ◀──force─── │ haptic │ ──samples, commands, checks──▶ SessionRecorder
//   send() ──queue───▶ │ thread │ ──newest report──▶ report(), times()
//          keeper ───▶ └────────┘   room for bricks, made by the keeper's thread before it is needed
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
#include <memory>
#include <span>
#include <string_view>

#include "sim/hand/device_source.h"
#include "sim/live/piece_maker.h"
#include "sim/live/realtime.h"
#include "sim/live/time_histogram.h"
#include "sim/object/brick_feed.h"
#include "sim/session/session.h"
#include "sim/session/session_recorder.h"

namespace kerf {

struct HapticOptions {
  RealTimeRequest real_time;
  /// A tick that begins later than this after the one before, ms, is a stall: the hand was without guidance for that
  /// long. Its sample counts as bad: force zero, latched until "latch.clear". Below 30 an ordinary system latches now
  /// and then; above 200 the hand would be met by a force it has long forgotten.
  double stall_ms = 100;
  PieceMakerOptions pieces;
};

/// Since the start. Every field is written by the haptic thread alone.
struct HapticCounts {
  std::uint64_t ticks = 0;
  std::uint64_t overruns = 0;        ///< ticks that ended after the next one was due
  std::uint64_t missed_periods = 0;  ///< skipped because of them
  std::uint64_t stalls = 0;          ///< see HapticOptions::stall_ms
  std::uint64_t pauses = 0;          ///< for undo, redo or room: see HapticThread
  double longest_pause_ms = 0;
  std::uint64_t commands_done = 0, commands_refused = 0;
  std::uint64_t edits_pushed = 0;  ///< into all feeds
  std::uint64_t records_lost = 0;  ///< the recorder did not take them: the log has a gap, and ends to be a replay there
  std::uint64_t out_of_bricks = 0;  ///< ticks with kStepBricksRanOut or kStepNearRanOut. More than Session::reserveFor
                                    ///< / 2 bricks in one tick: a replay may differ
  std::uint64_t pools_taken = 0;    ///< of Session::kReserve bricks at most
  PieceMaker::Counts pieces;
};

struct ObjectReport {
  std::uint32_t id = 0;  ///< CutObject::id
  Rigid3 T_world_object;
};

/// The newest tick.
struct HapticReport {
  StepOutput output;
  std::uint64_t tick = 0;  ///< how many there were, as State::tick
  HapticCounts counts;
  bool is_latched = false;             ///< force is zero until "latch.clear"
  bool is_waiting_for_bricks = false;  ///< paused until there is memory for the next cut
  std::size_t object_count = 0;
  std::array<ObjectReport, kMostObjects> objects;  ///< those in the scene, by their number
};

struct HapticTimes {
  TimeHistogram cost;      ///< of a tick, from its wake-up to its end
  TimeHistogram lateness;  ///< from when a tick was due to its wake-up
  TimeHistogram jitter;    ///< of the period: how far two wake-ups are from 1 ms apart
};

/// Owns a Session and runs it.
///
/// Pauses: undo and redo take some microseconds a brick, more than a tick for a large stroke; and without room for what
/// the next tick may change it must not run, or the cut would differ from its replay. In both cases the device gets a
/// zero force first, by a sample that is not valid (in the log like any other), then the work is done, then
/// "latch.clear" follows: the force fades in again, the drive starts anew, and a stroke that was under way has ended. A
/// device that was latched before stays latched. After an undo the tool may be inside tissue that came back; the
/// coupling keeps that within the force limit as it does any other contact.
///
/// Pieces: what is severed becomes objects of its own (PieceMaker). Until they are made the object is felt but not cut,
/// some 30 ms for a mandible at 0.1 mm, and commands wait. Who follows an object's bricks follows them wherever it
/// goes; whoever wants to follow pieces is told of them by HapticOptions::pieces.
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
  /// Without HapticOptions::pieces.follow nobody follows pieces: the feed of an object ends where it comes apart.
  /// @param device, feeds, recorder  kept by reference, must outlive this. A feed an object, or null: nobody follows
  /// it;
  ///   none at all: nobody follows any. The haptic thread is their producer. `recorder` may be null.
  /// Error kBadValue: more feeds than objects, or the system has no thread left.
  Expected<void> start(DeviceSource& device, std::span<BrickFeed* const> feeds, SessionRecorder* recorder);
  /// What the system granted; after start().
  const RealTimeGrant& grant() const noexcept;

  /// Asks for a command of Session between two ticks, in the order sent; counts tell whether it was done. Holding and
  /// splitting are the maker's of pieces, and refused. For one thread. False: more than kMostCommands wait, or the text
  /// is longer than kMaxCommandBytes.
  bool send(std::string_view command) noexcept;
  static constexpr std::size_t kMostCommands = 64;

  /// Fetches the newest report; false: none since the last call. For one thread.
  bool update() noexcept;
  const HapticReport& report() const noexcept;
  /// The same for times, which come every tenth of a second and at the end.
  bool updateTimes() noexcept;
  const HapticTimes& times() const noexcept;

  /// Ends after the tick under way: force zero, device disarmed, the session finished and recorded, what the feeds did
  /// not hold yet pushed. Waits for a full feed for two seconds at most; what is left then is in unsentBricks(). May be
  /// called again.
  void stop();
  std::size_t unsentBricks() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
