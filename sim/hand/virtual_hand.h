// Virtual hands: they hold the tool in headless cutting, in tests and in benchmarks. None of them needs a person.
#pragma once

#include <cstdint>
#include <memory>

#include "sim/hand/path.h"
#include "sim/step/step.h"

namespace kerf {

/// Gives the sample of the next tick from the last tick's output. Deterministic. Not for the 1 kHz thread.
class VirtualHand {
 public:
  virtual ~VirtualHand() = default;
  /// False: at the end, and `sample` is not set.
  virtual bool next(const StepOutput& last, DeviceSample& sample) = 0;
  /// 0 to 1.
  virtual double progress() const = 0;
  /// Rest of the path, mm.
  virtual double left() const = 0;
};

/// Pose of a path at a time, s after its first pose; later the last pose. Straight and by the shorter turn between
/// poses. Sets `cuts`, if given, to whether that motion cuts.
Rigid3 poseAt(const CutPath& path, double t, bool* cuts = nullptr);

/// Constant feed: the path in its own time, for any force. The tool turns while the path cuts. For Rendering::kRigid.
class FeedHand final : public VirtualHand {
 public:
  explicit FeedHand(const CutPath& path) : path_(path) {}
  bool next(const StepOutput& last, DeviceSample& sample) override;
  double progress() const override;
  double left() const override;

 private:
  const CutPath& path_;
  double t_ = 0;
  bool is_over_ = false;
};

/// Constant force: pulls the tool with `force`, sideways with the part that holds the tool on its line, and along the
/// path with the rest, no faster than `feed_limit`. A pushed tool overlaps with the tissue until that is eroded, and
/// leaves a film when it moves on. The hand leads it deeper by an estimate of that film. It waits for a tool off its
/// line. Turns on the spot take their time. It waits for the drive to reach half of its speed, and lets go when it
/// stalls. Parts of a path that cannot be cut are skipped, not cut elsewhere. For Rendering::kCoupled with a coupling
/// of kStiffness: a softer one lets the tool off its line. Gives up when nothing has moved for `patience` seconds.
class ForceHand final : public VirtualHand {
 public:
  struct Options {
    double force = 1;         ///< N
    double feed_limit = 20;   ///< mm/s, in air
    double patience = 5;      ///< s
    double stillness = 0.01;  ///< mm: less progress in `patience` seconds counts as none
    double free_speed = 0;    ///< of the drive, as StepOutput::speed; 0: unknown, uses the fastest so far
  };
  static constexpr double kStiffness = 100;  ///< N/mm: no device needs to hold it
  ForceHand(const CutPath& path, const CouplingSettings& coupling, const Options& options);
  bool next(const StepOutput& last, DeviceSample& sample) override;
  double progress() const override;
  double left() const override { return length_.back() - at_; }
  bool gaveUp() const { return gave_up_; }

 private:
  static Vec3d overlapOf(const StepOutput& last);
  double feelFilm(const StepOutput& last, const Vec3d& along, const Vec3d& moved);
  bool settle(const StepOutput& last, DeviceSample& sample);
  bool moves(bool is_turning, double off);

  const CutPath& path_;
  Options options_;
  double stiffness_;                 // N/mm
  double lead_;                      // mm from tool to hand that pull with the force
  Vec3d tip_;                        // of the tool, a tick ago
  std::vector<double> length_;       // of the way up to each pose, mm
  std::size_t stretch_ = 0;          // from this pose to the next
  double at_ = 0, ahead_ = 0;        // mm of the way: the tool; where it is pulled to
  Vec3d lean_ = Vec3d::Zero();       // mm: offset of the hand beside its line that holds the tool
  double leaves_ = 0, removed_ = 0;  // means of a tick, mm^3
  Vec3d overlap_ = Vec3d::Zero(),
        film_ = Vec3d::Zero();           // mm, out of the tissue: the mean overlap; the film across the way
  double watched_ = 0, waited_ = 0;      // mm of the way, s
  double off_early_ = 0, off_late_ = 0;  // mm beside it, at most, while waiting
  double turned_ = 0;                    // rad of a turn on the spot
  double fastest_ = 0, last_speed_ = 0;  // StepOutput::speed
  bool has_begun_ = false, gave_up_ = false, is_stalled_ = false, has_come_up_ = false;
};

/// A force-feedback device in a person's hand: a mass on a spring and damper to the hand's target (the path). Its
/// position is read through an encoder. Its force arrives one tick late and stays the same for a tick. Turns are
/// prescribed, as on a device without torque.
class DeviceHand final : public VirtualHand {
 public:
  struct Options {
    double mass_kg = 0.08;        ///< of the device at its tip
    double damping = 0.0005;      ///< N s/mm, of the device
    double friction = 0.05;       ///< N, Coulomb, of the device
    double encoder_mm = 0.02;     ///< resolution; 0: perfect
    int delay_ticks = 1;          ///< from sample to force
    double hand_stiffness = 0.3;  ///< N/mm: loose 0.3, firm 2
    double hand_damping = 0.003;  ///< N s/mm
  };
  DeviceHand(const CutPath& path, const Options& options);
  bool next(const StepOutput& last, DeviceSample& sample) override;
  double progress() const override;
  double left() const override;

  /// True place of the device, mm.
  const Vec3d& position() const { return position_; }
  /// Work of the force on the device so far, less the losses to the device's own damping and friction, N mm. Above zero
  /// the simulation has given energy to the hand.
  double portEnergy() const { return work_ - lost_; }

 private:
  const CutPath& path_;
  Options options_;
  double t_ = 0;
  Vec3d position_, velocity_ = Vec3d::Zero();
  std::vector<Vec3d> late_;  // forces on their way to the device, oldest first
  double work_ = 0, lost_ = 0;
  bool is_over_ = false;
};

}  // namespace kerf
