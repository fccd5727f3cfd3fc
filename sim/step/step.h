// The 1 kHz step: device in, contact, force out, erosion, shell repair. One function, for the haptic thread and for
// headless programs alike: same model, same state, same samples, same bits.
//
// World frame: that of the scene; every object and the tool have poses in it. mm, N, s, rad.
#pragma once

#include <vector>

#include "sim/object/cut_object.h"
#include "sim/step/contact.h"
#include "sim/step/coupling.h"
#include "sim/step/device_sample.h"
#include "sim/step/tissue.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// What stands between hand and tool.
enum class Rendering {
  kCoupled,  ///< virtual coupling: the default
  kDirect,   ///< the tool is where the device is, the hand gets the contact's force: unstable when stiff
  kRigid     ///< as kDirect, but nobody holds the device: a machine that follows its path whatever the force
};

/// What keeps the tool out of the tissue: the classical methods, for comparison on one scene. sim/step/response.h.
enum class Response {
  kPenalty,     ///< force of the overlap: the default, the one the goals are for
  kConstraint,  ///< god-object: the tool is the pose nearest to the device that does not overlap
  kImpulse      ///< the tool is a free body on the coupling; contact changes its velocity at once
};

struct StepSettings {
  CouplingSettings coupling;
  Rendering rendering = Rendering::kCoupled;
  /// Without effect for Rendering::kRigid, whose tool is where its machine says. With the others' kDirect the tool is
  /// still a body of its own: the hand gets the proxy's spring alone (constraint), or contact's force (impulse).
  Response response = Response::kPenalty;
  double restitution = 0;      ///< of the speed of approach, 0 to 1, how much comes back: Response::kImpulse
  bool geometry_only = false;  ///< cut whatever the tool sweeps, without resistance
  int most_substeps = 8;       ///< looks at contact within a tick, for fast motion
  double ramp_s = 0.2;         ///< force fades in over this long after the start
};

/// Never changes during a session; may be shared.
struct Model {
  std::vector<ToolModel> tools;
  TissueTable tissues;
  StepSettings settings;
};

/// Belongs to the thread that calls step(). Everything is reserved when it is made.
struct State {
  State() : near(1 << 16) {}
  std::vector<CutObject> objects;
  std::uint32_t next_id = 0;  ///< CutObject::id of the next object that comes into being
  std::size_t tool = 0;       ///< index into Model::tools; change it by selectTool()
  ToolBody body;
  double speed = 0;  ///< of the drive, as in ToolDrive
  /// Not kNone: while the pedal is pressed the tool's cutting part adds this material to object `adds_to`; its drive
  /// stands still, and nothing is felt: paste gives way, and what lies below it has no surface of its own any more.
  Material adds = Material::kNone;
  std::size_t adds_to = 0;
  DeviceMotion device;
  Wrench last_force;       ///< what went to the hand
  std::uint64_t tick = 0;  ///< how many there were
  bool has_device = false, is_latched = false;
  double ramp = 0;  ///< 0 to 1
  NearBricks near;

  /// Puts the tool where a hand is, at rest: at the start, and after a pause. No force until contact.
  void place(const Rigid3& T_world_tool) noexcept;
  /// Another tool, at rest. All bricks wake up. @rt
  void selectTool(std::size_t index) noexcept;
  /// After a fault, when the device is back. @rt
  void clearLatch() noexcept {
    is_latched = false;
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
  kStepBricksRanOut = 1,   ///< CutObject::reserve: some bricks were not cut in this tick
  kStepNearRanOut = 2,     ///< more bricks near the tool than NearBricks holds
  kStepTooFast = 4,        ///< the hand is faster than most_substeps follow; the tool lags, nothing was jumped over
  kStepBadSample = 8,      ///< no usable sample: force is zero from now on, see State::clearLatch
  kStepForceClamped = 16,  ///< the hand got less than the coupling wanted
  kStepFillClipped = 32,   ///< something was not added: farther than kAirAround, or after CutObject::kMostAdded bricks
  kStepFrozen = 64         ///< an object is held (CutObject::isFrozen): nothing of it is cut, nothing added
};

struct StepOutput {
  DeviceForce force;  ///< to the hand
  Wrench contact;     ///< on the tool, world axes, about the tip: pressure and drag, mean over the tick
  Rigid3 T_world_tool;
  double normal_load = 0;   ///< N = integral of p dA, N
  double cutting_load = 0;  ///< of it, on what cuts
  double removed_mm3 = 0, added_mm3 = 0;
  double drive_load = 0;                ///< N mm, of a stroke N
  double power = 0;                     ///< of the drive into the tissue, N mm/s
  double speed = 0;                     ///< of the drive after the tick
  double area = 0, deepest = 0;         ///< mm^2, mm
  int tested = 0, touching = 0;         ///< nodes
  std::uint64_t objects_touched = 0;    ///< objectBit() of each that the tool touched, with neck or shank, too
  Material material = Material::kNone;  ///< of most of the area in contact
  int bricks_near = 0, bricks_cut = 0, substeps = 0;
  std::uint32_t status = kStepOk;
};

/// The bit of an object in StepOutput::objects_touched.
constexpr std::uint64_t objectBit(std::size_t index) { return index < kMostObjects ? std::uint64_t{1} << index : 0; }
static_assert(kMostObjects <= 64);

/// One tick of kTick seconds. @rt @cost tens to hundreds of microseconds, with the area in contact, not the object.
/// Contact and erosion are evaluated at the same pose and field, force first; then the tool moves.
void step(const Model& model, State& state, const DeviceSample& input, StepOutput& output) noexcept;

/// Longest motion between two looks at contact, mm: min(finest / 2, sqrt(0.4 h r)).
double longestSubstep(const ToolModel& tool, double voxel) noexcept;

}  // namespace kerf
