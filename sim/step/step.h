// The 1 kHz step: device in, force out, contact and erosion in between. One function for the haptic thread and for
// headless programs: same model, same state, same samples, same bits.
//
// A tick, in order:
//   1. Latch. A sample that is late, not finite or out of range latches the state: zero force, the tool stands still,
//      and nothing else happens until State::clearLatch(). The force must not strike a hand that comes back.
//   2. Follow the device. Its velocity is low-passed, v += (1 - exp(-2 pi f dt)) (measured - v), f =
//      CouplingSettings::filter_hz. The force fades in over StepSettings::ramp_s. The path of the tool in this tick is
//      cut into n equal parts of dt = kTick / n, none longer than longestSubstep(): the tool cannot jump over a wall.
//   3. Evaluate contact n times. In each evaluation, object by object: find the bricks near the tool; sum the force and
//      the drag of the shell's nodes; erode; repair the changed shells. Force and erosion see the same pose and field.
//      Then the tool moves. Laws of pressure, drag and erosion: sim/step/contact.h. Motion of the tool by contact: the
//      response, sim/step/response.h.
//   4. Run the drive. Its speed follows pedal and mean load of the tick: see ToolDrive.
//   5. Render to the hand: the wrench of the coupling (sim/step/coupling.h) or of contact, by StepSettings::rendering;
//      times the fade-in; limited in size and in change per tick.
//
// While the state adds material (State::adds), an evaluation fills instead of steps "sum" and "erode": the drive stands
// still and the hand feels nothing.
//
// Units: mm, N, s, rad. World frame: that of the scene; every object and the tool have poses in it.
// Thread: the owner of State. Model is const and may be shared.
// @rt: step() allocates nothing, takes no lock, makes no system call and throws nothing. A limit or omission sets a bit
// in StepOutput::status.
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
  /// No effect for Rendering::kRigid, whose machine places the tool. With Rendering::kDirect the hand gets the force of
  /// contact. Exception: with the constraint it gets the spring of the coupling alone.
  Response response = Response::kPenalty;
  double restitution = 0;      ///< returned fraction of the speed of approach, 0 to 1: Response::kImpulse
  bool geometry_only = false;  ///< remove the tool's swept volume, without resistance
  int most_substeps = 8;       ///< contact evaluations within a tick, for fast motion
  bool takes_turns = true;     ///< contacts too large for a tick: sim/step/contact_turns.h. False: for comparison
  double ramp_s = 0.2;         ///< force fades in over this long after the start

  /// The response that takes effect. @rt
  Response effectiveResponse() const { return rendering == Rendering::kRigid ? Response::kPenalty : response; }
  /// How the tool is tied to the device. @rt
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

/// Belongs to the thread that calls step(). The constructor reserves everything.
struct State {
  State() : turns(kMostObjects) {}
  std::vector<CutObject> objects;
  std::uint32_t next_id = 0;  ///< CutObject::id of the next new object
  std::size_t tool = 0;       ///< index into Model::tools; change it by selectTool()
  ToolBody body;
  double speed = 0;  ///< of the drive, as in ToolDrive
  /// Not kNone: while the pedal is pressed, the tool's cutting part adds this material to object `adds_to`. Its drive
  /// stands still, and the hand feels nothing: paste gives way, and covered tissue has no surface of its own any more.
  Material adds = Material::kNone;
  std::size_t adds_to = 0;
  DeviceMotion device;
  CoreDrag core_drag;                ///< of the last evaluation
  Vector6d grip = Vector6d::Zero();  ///< of friction at rest: advance()
  Wrench last_force;                 ///< last output to the hand
  std::uint64_t tick = 0;            ///< number of ticks
  bool has_device = false, is_latched = false;
  double ramp = 0;  ///< of the fade-in, 0 to 1
  NearBricks near, near_in_turn;
  std::vector<ContactTurns> turns;  ///< by object

  /// Call after objects have changed their places. @rt
  void forgetTurns() noexcept {
    for (ContactTurns& turn : turns) turn.forget();
    grip.setZero();
  }
  /// Clears load and drag of the cores, and the grip.
  void forgetCore() noexcept {
    core_drag = {};
    grip.setZero();
    for (CutObject& object : objects) object.forgetCore();
  }
  /// Places the tool at the hand, at rest: at the start, and after a pause. No force until contact.
  void place(const Rigid3& T_world_tool) noexcept;
  /// The same for a tool carried elsewhere: its drive keeps turning, and the force needs no fade-in. @rt
  void moveTool(const Rigid3& T_world_tool) noexcept;
  /// Takes another tool, at rest. All bricks wake up. @rt
  void selectTool(std::size_t index) noexcept;
  /// Call after a fault, when the device is back. @rt
  void clearLatch() noexcept {
    is_latched = false;
    forgetCore();
    has_device = false;
    ramp = 0;
  }
  /// Hash of fields, tool and force: same inputs, same number on any build.
  std::uint64_t hash() const;
  /// The same number, from the known hashes of CutObject::hashNow(). @rt with the same exception.
  std::uint64_t hashNow() noexcept;
};

/// Bits; each names a limit to raise, or an event.
enum StepStatus : std::uint32_t {
  kStepOk = 0,
  /// CutObject::reserve: memory ran out, and some bricks were not cut in this tick.
  kStepBricksRanOut = 1,
  /// More bricks are near the tool than NearBricks holds.
  kStepNearRanOut = 2,
  /// The hand is faster than most_substeps evaluations follow: the tool lags, and nothing was jumped over. A machine
  /// (Rendering::kRigid) still follows its path to the end.
  kStepTooFast = 4,
  /// No usable sample: force is zero from now on, see State::clearLatch().
  kStepBadSample = 8,
  /// The hand got less force than the coupling required.
  kStepForceClamped = 16,
  /// Part of the fill was omitted: farther out than kAirAround, or after CutObject::kMostAdded bricks.
  kStepFillClipped = 32,
  /// An object is frozen (CutObject::isFrozen): it is neither cut nor filled.
  kStepFrozen = 64
};

struct StepOutput {
  DeviceForce force;  ///< to the hand
  /// On the tool, world axes, about the tip: pressure and drag, mean over the tick. For a tool on the coupling, the
  /// force that moved it: see advance().
  Wrench contact;
  Rigid3 T_world_tool;
  double normal_load = 0;   ///< N = integral of p dA, N
  double cutting_load = 0;  ///< its part on the cutting part, N
  double removed_mm3 = 0, added_mm3 = 0;
  double drive_load = 0;                ///< of the spindle, N mm; of a stroke, N
  double power = 0;                     ///< of the drive into the tissue, N mm/s
  double speed = 0;                     ///< of the drive after the tick
  double area = 0, deepest = 0;         ///< mm^2, mm
  int tested = 0, touching = 0;         ///< nodes
  std::uint64_t objects_touched = 0;    ///< objectBit() of each touched object, by neck or shank too
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
