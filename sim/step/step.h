// The 1 kHz step: device in, force out, contact and erosion in between. One function, for the haptic thread and for
// headless programs alike: same model, same state, same samples, same bits.
//
// A tick, in order:
//   1. Latch. A sample that is late, not finite or out of range latches the state: zero force, the tool stands still,
//      and nothing else happens until State::clearLatch(). A hand that comes back must not be struck.
//   2. Follow the device. Its velocity is low-passed, v += (1 - exp(-2 pi f dt)) (measured - v), f =
//      CouplingSettings::filter_hz. The force fades in over StepSettings::ramp_s. The path of the tool in this tick is
//      cut into n equal parts of dt = kTick / n, none longer than longestSubstep(): no wall is jumped over.
//   3. Evaluate contact n times. In each evaluation, object by object: find the bricks near the tool; sum the force and
//      the drag of the shell's nodes; erode; repair the shells of what changed. Force and erosion see the same pose and
//      the same field. Then the tool moves. Laws of pressure, drag and erosion: sim/step/contact.h. How contact moves
//      the tool: by the response, sim/step/response.h.
//   4. Run the drive. Its speed follows pedal and mean load of the tick: see ToolDrive.
//   5. Render to the hand: the wrench of the coupling (sim/step/coupling.h) or of contact, by StepSettings::rendering;
//      times the fade-in; limited in size and in change per tick.
//
// While the state adds material (State::adds), an evaluation fills instead of steps "sum" and "erode": the drive stands
// still and nothing is felt.
//
// Units: mm, N, s, rad. World frame: that of the scene; every object and the tool have poses in it.
// Thread: the one that State belongs to. Model is const and may be shared.
// @rt: step() allocates nothing, takes no lock, makes no system call and throws nothing. What runs out or is left out
// sets a bit in StepOutput::status.
#pragma once

#include <vector>

#include "sim/object/cut_object.h"
#include "sim/step/contact.h"
#include "sim/step/contact_turns.h"
#include "sim/step/core_contact.h"
#include "sim/step/coupling.h"
#include "sim/step/device_sample.h"
#include "sim/step/response.h"
#include "sim/step/tissue.h"
#include "sim/step/tool_model.h"

namespace kerf {

struct StepSettings {
  CouplingSettings coupling;
  Rendering rendering = Rendering::kCoupled;
  /// Without effect for Rendering::kRigid, whose tool is where its machine says. With Rendering::kDirect the hand gets
  /// the force of contact, but for the constraint: there it gets the spring of the coupling alone.
  Response response = Response::kPenalty;
  double restitution = 0;      ///< how much of the speed of approach comes back, 0 to 1: Response::kImpulse
  bool geometry_only = false;  ///< cut whatever the tool sweeps, without resistance
  int most_substeps = 8;       ///< contact evaluations within a tick, for fast motion
  bool takes_turns = true;     ///< contacts too large for a tick: sim/step/contact_turns.h. False: to compare with
  double ramp_s = 0.2;         ///< force fades in over this long after the start

  /// The response that takes effect. @rt
  Response effectiveResponse() const { return rendering == Rendering::kRigid ? Response::kPenalty : response; }
  /// What ties the tool to the device. @rt
  Attachment attachment() const {
    const ResponseRow& row = rowOf(effectiveResponse());
    return rendering == Rendering::kCoupled ? row.coupled : row.direct;
  }
};

/// Never changes during a session; may be shared.
struct Model {
  std::vector<ToolModel> tools;
  TissueTable tissues;
  StepSettings settings;
};

/// Belongs to the thread that calls step(). Everything is reserved when it is made.
struct State {
  State() : turns(kMostObjects) {}
  std::vector<CutObject> objects;
  std::uint32_t next_id = 0;  ///< CutObject::id of the next object that comes into being
  std::size_t tool = 0;       ///< index into Model::tools; change it by selectTool()
  ToolBody body;
  double speed = 0;  ///< of the drive, as in ToolDrive
  /// Not kNone: while the pedal is pressed the tool's cutting part adds this material to object `adds_to`. Its drive
  /// stands still, and nothing is felt: paste gives way, and what lies below it has no surface of its own any more.
  Material adds = Material::kNone;
  std::size_t adds_to = 0;
  DeviceMotion device;
  CoreDrag core_drag;                ///< of the last evaluation
  Vector6d grip = Vector6d::Zero();  ///< of friction at rest: advance()
  Wrench last_force;                 ///< what went to the hand
  std::uint64_t tick = 0;            ///< how many there were
  bool has_device = false, is_latched = false;
  double ramp = 0;  ///< of the force that fades in, 0 to 1
  NearBricks near, near_in_turn;
  std::vector<ContactTurns> turns;  ///< by object

  /// Objects have changed their places. @rt
  void forgetTurns() noexcept {
    for (ContactTurns& turn : turns) turn.forget();
    grip.setZero();
  }
  /// No load and no drag of a core, and no grip.
  void forgetCore() noexcept {
    core_drag = {};
    grip.setZero();
    for (CutObject& object : objects) object.forgetCore();
  }
  /// Puts the tool where a hand is, at rest: at the start, and after a pause. No force until contact.
  void place(const Rigid3& T_world_tool) noexcept;
  /// The same for a tool that is carried elsewhere: its drive goes on turning, and the force needs no fade-in. @rt
  void moveTool(const Rigid3& T_world_tool) noexcept;
  /// Another tool, at rest. All bricks wake up. @rt
  void selectTool(std::size_t index) noexcept;
  /// After a fault, when the device is back. @rt
  void clearLatch() noexcept {
    is_latched = false;
    forgetCore();
    has_device = false;
    ramp = 0;
  }
  /// Of fields, tool and force: same inputs, same number on any build.
  std::uint64_t hash() const;
  /// The same number, from what CutObject::hashNow() knows already. @rt as that is.
  std::uint64_t hashNow() noexcept;
};

/// Bits; each says which limit to raise or what happened.
enum StepStatus : std::uint32_t {
  kStepOk = 0,
  /// CutObject::reserve: some bricks were not cut in this tick.
  kStepBricksRanOut = 1,
  /// More bricks are near the tool than NearBricks holds.
  kStepNearRanOut = 2,
  /// The hand is faster than most_substeps evaluations follow: the tool lags, nothing was jumped over. A machine
  /// (Rendering::kRigid) is followed to the end of its path all the same.
  kStepTooFast = 4,
  /// No usable sample: force is zero from now on, see State::clearLatch().
  kStepBadSample = 8,
  /// The hand got less than the coupling wanted.
  kStepForceClamped = 16,
  /// Something was not added: farther out than kAirAround, or after CutObject::kMostAdded bricks.
  kStepFillClipped = 32,
  /// An object is frozen (CutObject::isFrozen): nothing of it is cut, nothing added.
  kStepFrozen = 64
};

struct StepOutput {
  DeviceForce force;  ///< to the hand
  /// On the tool, world axes, about the tip: pressure and drag, mean over the tick. What moved it, for a tool on the
  /// coupling: see advance().
  Wrench contact;
  Rigid3 T_world_tool;
  double normal_load = 0;   ///< N = integral of p dA, N
  double cutting_load = 0;  ///< the part of it on what cuts, N
  double removed_mm3 = 0, added_mm3 = 0;
  double drive_load = 0;                ///< of the spindle, N mm; of a stroke, N
  double power = 0;                     ///< of the drive into the tissue, N mm/s
  double speed = 0;                     ///< of the drive after the tick
  double area = 0, deepest = 0;         ///< mm^2, mm
  int tested = 0, touching = 0;         ///< nodes
  std::uint64_t objects_touched = 0;    ///< objectBit() of each that the tool touched, with neck or shank, too
  Material material = Material::kNone;  ///< the one with most of the area in contact
  int bricks_near = 0, bricks_cut = 0;
  int substeps = 0;  ///< contact evaluations
  std::uint32_t status = kStepOk;
};

/// The bit of an object in StepOutput::objects_touched.
constexpr std::uint64_t objectBit(std::size_t index) { return index < kMostObjects ? std::uint64_t{1} << index : 0; }
static_assert(kMostObjects <= 64);

/// One tick of kTick seconds: see the top of this file. @rt
/// @cost  tens to hundreds of microseconds, with the area in contact, not with the object.
void step(const Model& model, State& state, const DeviceSample& input, StepOutput& output) noexcept;

/// Longest motion between two contact evaluations, mm: min(d / 2, sqrt(0.4 h r)). d = ToolModel::finest_mm: half of the
/// thinnest part cannot pass through a wall. h the voxel, r = ToolModel::smallest_radius_mm: scallops between two poses
/// stay below 0.05 h.
double longestSubstep(const ToolModel& tool, double voxel) noexcept;

}  // namespace kerf
