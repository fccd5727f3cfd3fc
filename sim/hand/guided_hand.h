// A hand that saws a planned cut by itself, like a cutting guide with a depth stop; otherwise it passes on a person's
// hand.
//
// A cut is a list of straight ways of the tool's tip; the tool keeps its attitude. On a way that cuts the hand pushes
// with a bounded force, reduced when the tool exceeds its feed. It waits for a lagging tool, since the felt force never
// exceeds its own. It stops at the end of the way. Sideways it holds the tool like a guide: it leans against forces
// that push the tool off its line and torques that turn it out of its plane.
//
//   tool       x = h - felt / K                         h: the hand along the way, K: of the coupling
//   push       F' = kGovern (feed - x'), 0 to the force, at most K (left + past)
//   hand       h' = kGives (F - felt), at most kFastest, back at most kLetsGo
//   beside     a' = -kLean (tool - line), at most kMostAside; the attitude: ToolLean
//
// A stuck tool is drawn back a little and pushed again; after kMostTries the rest of that way is skipped. The samples
// are in the session log like any device's: a replay gives the same bits.
#pragma once

#include <array>
#include <cstdint>

#include "sim/hand/device_source.h"
#include "sim/hand/tool_lean.h"
#include "sim/hand/triple_buffer.h"

namespace kerf {

/// One straight way of the tip, from the end of the previous one. World frame, mm.
struct GuidedWay {
  Vec3d to = Vec3d::Zero();
  bool cuts = false;  ///< pushed by force, at the feed; else carried through air or its own kerf
};

struct GuidedCut {
  static constexpr std::size_t kMostWays = 96;

  std::uint64_t id = 0;         ///< rises with every cut: a cut begins when the tool was placed for it, at `start`
  bool is_wanted = false;       ///< false: aborted, the tool drawn back to the height of `start`
  Rigid3 start;                 ///< of the tool, in air
  Vec3d back = Vec3d::UnitZ();  ///< unit: out of the tissue
  std::array<GuidedWay, kMostWays> ways{};
  std::size_t count = 0;  ///< of ways
  double force = 4;       ///< N, at most: 0.1 to 8
  double feed = 1;        ///< mm/s, in tissue
  double irrigation = 1;  ///< 0 to 1
  /// mm that the hand may stand beyond the end of a way that cuts. A drill needs its thrust to the end.
  double past = 0.3;
};

enum class GuidedStage : std::uint8_t {
  kNone,     ///< no order yet, or a person holds the tool
  kCutting,  ///< on its ways
  kBack,     ///< aborted, on its way out
  kOver      ///< out of the tissue; the drive runs down
};

struct GuidedReport {
  std::uint64_t id = 0;
  GuidedStage stage = GuidedStage::kNone;
  std::size_t way = 0;         ///< current way
  std::uint32_t tries = 0;     ///< retries after drawing back
  std::uint32_t given_up = 0;  ///< ways skipped before their end
};

/// The window's thread orders and reads reports, the haptic thread calls the rest. Before a cut the window orders it
/// and sends PlaceTool with its start; the next PlaceTool for another purpose gives the tool back to the person's hand.
class GuidedHand final : public DeviceSource {
 public:
  static constexpr double kThroughAir = 5;  ///< mm/s, on a way that cuts, without contact
  static constexpr double kCarried = 15;    ///< mm/s, on other ways
  static constexpr double kPast = 0.3;      ///< mm that the hand may stand beyond the end of other ways
  static constexpr double kMostAside = 3;   ///< mm that it leans sideways
  static constexpr int kMostTries = 6;      ///< at the same place

  /// @param free  the person's hand; must outlive this.   @param stiffness, turn_stiffness  of the coupling, N/mm and
  ///   N mm/rad.
  GuidedHand(DeviceSource& free, double stiffness, double turn_stiffness)
      : free_(free), stiffness_(stiffness), turn_stiffness_(turn_stiffness) {}

  /// The newest order. One thread, as update() and report().
  void order(const GuidedCut& cut) noexcept;
  bool update() noexcept { return reports_.update(); }
  const GuidedReport& report() const noexcept { return reports_.front(); }

  void arm() noexcept override { free_.arm(); }
  DeviceSample read() noexcept override;
  void write(const DeviceForce& force) noexcept override;
  void placed(const Rigid3& T_world_tool) noexcept override;
  void disarm() noexcept override { free_.disarm(); }
  bool isAtRest() const noexcept override { return is_mine_ ? now_.stage == GuidedStage::kOver : free_.isAtRest(); }

 private:
  void takeNewest() noexcept;
  Vec3d hand() const noexcept { return from_ + h_ * direction_ + aside_; }
  void begin(const Vec3d& from, const Vec3d& to, const Vec3d& hand) noexcept;
  void backOut() noexcept;
  void followWay() noexcept;
  void endWay(bool gives_up) noexcept;
  double feedOf(double left, double resists) const noexcept;
  bool isStuck(double at) noexcept;
  void leanAgainst() noexcept;
  void publish() noexcept;

  DeviceSource& free_;
  double stiffness_, turn_stiffness_;
  TripleBuffer<GuidedCut> orders_;
  TripleBuffer<GuidedReport> reports_;

  // Haptic thread.
  GuidedCut cut_;
  GuidedReport now_;
  std::uint64_t begun_ = 0;     // the current or last cut
  bool is_mine_ = false;        // else the person's
  Vec3d from_ = Vec3d::Zero();  // of the way: its line is from_ + h direction_
  Vec3d direction_ = Vec3d::UnitZ();
  double length_ = 0;
  double h_ = 0;                 // of the hand along it, mm
  Vec3d aside_ = Vec3d::Zero();  // of the hand beside it, mm
  ToolLean lean_;
  Vec3d felt_ = Vec3d::Zero();    // N, of the last tick
  Vec3d torque_ = Vec3d::Zero();  // N mm
  double wanted_ = 0;             // N
  double at_ = 0, speed_ = 0;     // of the tool along the way, mm, mm/s
  double watched_ = 0;            // mm: position at the last progress
  double waited_ = 0;             // s since
  double recoil_ = 0;             // s left of drawing back
  int tries_here_ = 0;
  int paused_ = 0;    // ticks left without action: the force fades in
  double still_ = 0;  // mm that the hand has moved since a force was felt
  bool was_touching_ = false;
};

}  // namespace kerf
