#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/device/pid_device.h"

namespace kerf {
namespace {

constexpr HidUsage kPage = 0x0F0000, kOrdinals = 0x0A0000;
using enum HidReportKind;

// Collections, and usages within them. Names as in the class definition.
constexpr std::uint16_t kSetEffect = 0x21, kBlockIndex = 0x22, kType = 0x25, kDuration = 0x50, kSamplePeriod = 0x51,
                        kGainOf = 0x52, kTriggerButton = 0x53, kTriggerRepeat = 0x54, kDirectionEnable = 0x56,
                        kDirection = 0x57, kSetCondition = 0x5F, kOffset = 0x23, kCentre = 0x60, kPositive = 0x61,
                        kNegative = 0x62, kPositiveMost = 0x63, kNegativeMost = 0x64, kDeadBand = 0x65,
                        kSetPeriodic = 0x6E, kPeriodicOffset = 0x6F, kMagnitude = 0x70, kPhase = 0x71, kPeriod = 0x72,
                        kSetConstant = 0x73, kOperation = 0x77, kOperate = 0x78, kLoops = 0x7C, kDeviceGain = 0x7D,
                        kGainValue = 0x7E, kBlockLoad = 0x89, kLoadStatus = 0x8B, kSuccess = 0x8C, kFull = 0x8D,
                        kBlockFree = 0x90, kDeviceControl = 0x96, kStartDelay = 0xA7, kCreate = 0xAB;

bool isIn(const HidField& field, std::uint16_t within) {
  return std::find(field.collections.begin(), field.collections.end(), kPage | within) != field.collections.end();
}

}  // namespace

PidReports::Slot PidReports::find(HidReportKind kind, std::uint16_t within, HidUsage usage) const {
  for (const HidField& field : layout_.fields) {
    if (field.kind != kind || field.is_constant || !isIn(field, within)) continue;
    const auto at = std::find(field.usages.begin(), field.usages.end(), usage);
    if (at != field.usages.end()) return {&field, static_cast<std::uint32_t>(at - field.usages.begin())};
  }
  return {};
}

// The field whose values are places in a list of usages.
const HidField* PidReports::choice(HidReportKind kind, std::uint16_t within, std::uint16_t of) const {
  for (const HidField& field : layout_.fields)
    if (field.kind == kind && !field.is_constant && isIn(field, within) && isIn(field, of)) return &field;
  return nullptr;
}

std::optional<std::uint8_t> PidReports::numberOf(HidReportKind kind, std::uint16_t within) const {
  for (const HidField& field : layout_.fields)
    if (field.kind == kind && isIn(field, within)) return field.report;
  return {};
}

PidReports::Report PidReports::begin(HidReportKind kind, std::uint16_t within) const {
  const std::uint8_t number = numberOf(kind, within).value_or(0);
  Report out(std::max<std::size_t>(layout_.bytesOf(kind, number), 1));
  if (layout_.has_numbers) out[0] = number;
  return out;
}

void PidReports::put(Report& report, HidReportKind kind, std::uint16_t within, std::uint16_t usage,
                     std::int64_t value) const {
  if (const Slot slot = find(kind, within, kPage | usage); slot.field)
    putHidValue(report, layout_.has_numbers, *slot.field, slot.n, value);
}

void PidReports::putShare(Report& report, std::uint16_t within, std::uint16_t usage, double share) const {
  const Slot slot = find(kOutput, within, kPage | usage);
  if (!slot.field || !std::isfinite(share)) return;
  const double most = slot.field->logical_max;
  putHidValue(report, layout_.has_numbers, *slot.field, slot.n, std::lround(std::clamp(share, -1.0, 1.0) * most));
}

// Of an array the value is a place in its list; of single bits the bit.
void PidReports::choose(Report& report, HidReportKind kind, std::uint16_t within, std::uint16_t of,
                        std::uint16_t usage) const {
  const HidField* const field = choice(kind, within, of);
  if (!field) return;
  const auto at = std::find(field->usages.begin(), field->usages.end(), kPage | usage);
  if (at == field->usages.end()) return;
  const auto place = static_cast<std::int64_t>(at - field->usages.begin());
  if (field->is_array)
    putHidValue(report, layout_.has_numbers, *field, 0, field->logical_min + place);
  else
    putHidValue(report, layout_.has_numbers, *field, static_cast<std::uint32_t>(place), 1);
}

Expected<PidReports> PidReports::of(HidLayout layout) {
  PidReports out(std::move(layout));
  const std::pair<HidReportKind, std::uint16_t> needed[] = {
      {kOutput, kSetEffect},     {kOutput, kSetConstant}, {kOutput, kOperation}, {kOutput, kBlockFree},
      {kOutput, kDeviceControl}, {kFeature, kCreate},     {kFeature, kBlockLoad}};
  for (const auto& [kind, usage] : needed)
    if (!out.numberOf(kind, usage))
      return fail({.code = Error::Code::kUnsupported,
                   .place = "HID descriptor",
                   .found = fmt::format("no report of usage {:02X} of page 0F", usage),
                   .expected = "a device with force feedback of the class PID, whose pool it manages itself"});
  if (!out.has(PidEffect::kConstant))
    return fail({.code = Error::Code::kUnsupported,
                 .place = "HID descriptor",
                 .found = "no constant force among its effects",
                 .expected = "one"});
  return out;
}

bool PidReports::has(PidEffect effect) const {
  const HidField* const types = choice(kFeature, kCreate, kType);
  if (!types) return false;
  const HidUsage usage = kPage | static_cast<std::uint16_t>(effect);
  return std::find(types->usages.begin(), types->usages.end(), usage) != types->usages.end();
}

bool PidReports::hasDuration() const { return find(kOutput, kSetEffect, kPage | kDuration).field != nullptr; }

// The unit of a field is a second times ten to its exponent; most say -3.
std::int64_t PidReports::unitsOf(const HidField& field, double seconds) const {
  const int exponent = field.unit_exponent == 0 ? -3 : field.unit_exponent;
  return std::lround(std::clamp(seconds * std::pow(10.0, -exponent), 1.0, 1e6));
}

PidReports::Report PidReports::control(PidControl what) const {
  Report out = begin(kOutput, kDeviceControl);
  choose(out, kOutput, kDeviceControl, kDeviceControl, static_cast<std::uint16_t>(what));
  return out;
}

std::optional<PidReports::Report> PidReports::gain(double share) const {
  if (!numberOf(kOutput, kDeviceGain)) return {};
  Report out = begin(kOutput, kDeviceGain);
  putShare(out, kDeviceGain, kGainValue, share);
  return out;
}

PidReports::Report PidReports::create(PidEffect effect) const {
  Report out = begin(kFeature, kCreate);
  choose(out, kFeature, kCreate, kType, static_cast<std::uint16_t>(effect));
  return out;
}

PidReports::Report PidReports::askLoad() const { return begin(kFeature, kBlockLoad); }

PidLoad PidReports::loadOf(std::span<const std::uint8_t> report) const {
  PidLoad out;
  const Slot block = find(kFeature, kBlockLoad, kPage | kBlockIndex);
  const HidField* const status = choice(kFeature, kBlockLoad, kLoadStatus);
  if (!block.field || !status) return out;
  const auto place = getHidValue(report, layout_.has_numbers, *status, 0) - status->logical_min;
  if (place < 0 || static_cast<std::size_t>(place) >= status->usages.size()) return out;
  const HidUsage said = status->usages[static_cast<std::size_t>(place)];
  out.status = said == (kPage | kSuccess) ? PidLoad::Status::kSuccess
               : said == (kPage | kFull)  ? PidLoad::Status::kFull
                                          : PidLoad::Status::kError;
  const auto number = getHidValue(report, layout_.has_numbers, *block.field, block.n);
  if (out.status == PidLoad::Status::kSuccess && number > 0 && number < 256)
    out.block = static_cast<std::uint8_t>(number);
  return out;
}

PidReports::Report PidReports::set(PidEffect effect, std::uint8_t block, double angle) const {
  Report out = begin(kOutput, kSetEffect);
  put(out, kOutput, kSetEffect, kBlockIndex, block);
  choose(out, kOutput, kSetEffect, kType, static_cast<std::uint16_t>(effect));
  // The largest duration means an endless one: never that.
  if (const Slot slot = find(kOutput, kSetEffect, kPage | kDuration); slot.field) {
    const std::int64_t most = std::max<std::int64_t>(slot.field->logical_max - 1, 1);
    putHidValue(out, layout_.has_numbers, *slot.field, slot.n, std::min(unitsOf(*slot.field, kLasts), most));
  }
  for (const std::uint16_t usage : {kGainOf, kTriggerButton})
    if (const Slot slot = find(kOutput, kSetEffect, kPage | usage); slot.field)
      putHidValue(out, layout_.has_numbers, *slot.field, slot.n, slot.field->logical_max);
  for (const std::uint16_t usage : {kTriggerRepeat, kSamplePeriod, kStartDelay})
    put(out, kOutput, kSetEffect, usage, 0);
  put(out, kOutput, kSetEffect, kDirectionEnable, 1);

  // Clockwise from away, as a share of a turn.
  const double clockwise = std::numbers::pi / 2 - angle, turn = clockwise / (2 * std::numbers::pi);
  for (const HidField& field : layout_.fields) {
    if (field.kind != kOutput || field.is_constant || !isIn(field, kSetEffect) || !isIn(field, kDirection)) continue;
    const double share = turn - std::floor(turn);
    putHidValue(out, layout_.has_numbers, field, 0, std::lround(share * field.logical_max));
    break;  // the first of them; those behind it are for a third axis
  }
  return out;
}

PidReports::Report PidReports::constant(std::uint8_t block, double share) const {
  Report out = begin(kOutput, kSetConstant);
  put(out, kOutput, kSetConstant, kBlockIndex, block);
  putShare(out, kSetConstant, kMagnitude, share);
  return out;
}

PidReports::Report PidReports::damper(std::uint8_t block, double share, int axis) const {
  Report out = begin(kOutput, kSetCondition);
  put(out, kOutput, kSetCondition, kBlockIndex, block);
  put(out, kOutput, kSetCondition, kOffset, axis);
  put(out, kOutput, kSetCondition, kCentre, 0);
  putShare(out, kSetCondition, kPositive, share);
  putShare(out, kSetCondition, kNegative, share);
  putShare(out, kSetCondition, kPositiveMost, 1);
  putShare(out, kSetCondition, kNegativeMost, 1);
  put(out, kOutput, kSetCondition, kDeadBand, 0);
  return out;
}

PidReports::Report PidReports::sine(std::uint8_t block, double share, double hertz) const {
  Report out = begin(kOutput, kSetPeriodic);
  put(out, kOutput, kSetPeriodic, kBlockIndex, block);
  putShare(out, kSetPeriodic, kMagnitude, share);
  put(out, kOutput, kSetPeriodic, kPeriodicOffset, 0);
  put(out, kOutput, kSetPeriodic, kPhase, 0);
  const Slot period = find(kOutput, kSetPeriodic, kPage | kPeriod);
  if (!period.field || !(hertz > 0)) return out;
  putHidValue(out, layout_.has_numbers, *period.field, period.n, unitsOf(*period.field, 1 / hertz));
  return out;
}

PidReports::Report PidReports::operate(std::uint8_t block, PidOperation what) const {
  Report out = begin(kOutput, kOperation);
  put(out, kOutput, kOperation, kBlockIndex, block);
  choose(out, kOutput, kOperation, kOperate, static_cast<std::uint16_t>(what));
  put(out, kOutput, kOperation, kLoops, what == PidOperation::kStart ? 1 : 0);
  return out;
}

PidReports::Report PidReports::free(std::uint8_t block) const {
  Report out = begin(kOutput, kBlockFree);
  put(out, kOutput, kBlockFree, kBlockIndex, block);
  return out;
}

}  // namespace kerf
