#include "ui/cli/device_probe.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "sim/device/hid/hid_device.h"
#include "sim/device/record/arm_opener.h"
#include "sim/device/record/device_recording.h"
#include "ui/cli/command.h"
#include "ui/cli/device_words.h"
#include "ui/cli/interruption.h"

namespace kerf::cli {
namespace {

using std::chrono::duration;
using std::chrono::steady_clock;

constexpr auto kBetweenLines = std::chrono::milliseconds(50);  // 20 lines a second at most

class Stopwatch {
 public:
  double seconds() const { return duration<double>(steady_clock::now() - began_).count(); }
  bool isOver(const ProbeOptions& options) const {
    return isInterrupted() || (options.seconds > 0 && seconds() >= options.seconds);
  }

 private:
  steady_clock::time_point began_ = steady_clock::now();
};

// Takes messages from the reader's thread: keeps them for a recording, and measures their gaps.
class Ear {
 public:
  Ear(DeviceRecording head, bool records) : tape_(std::move(head), records), records_(records) {}

  void hear(std::int64_t time_ns, int interface, std::span<const std::uint8_t> report) {
    const std::lock_guard lock(mutex_);
    tape_.add(time_ns, interface, report);
  }
  TimeHistogram gaps() const {
    const std::lock_guard lock(mutex_);
    return tape_.gaps();
  }
  // To call after the last message.
  int write(const ProbeOptions& options) const {
    if (!records_) return kOk;
    if (const auto written = writeRecording(options.record, tape_.recording()); !written)
      return complain(written.error());
    if (!options.json)
      printText("written: {} ({})\n", options.record, counted(tape_.recording().reports.size(), "report"));
    if (tape_.lost() > 0)
      printText(stderr, "kerf: {}: the recording is full, {} lost\n", options.record, counted(tape_.lost(), "report"));
    return kOk;
  }

 private:
  mutable std::mutex mutex_;
  DeviceTape tape_;
  const bool records_;
};

int complainOfUnplugged(const std::string& path) {
  return complain({.code = Error::Code::kNotFound,
                   .file = path,
                   .found = "the device was unplugged",
                   .expected = "a connected device",
                   .hint = "plug the device in and start again"});
}

// ---- Devices with axes

// Prints changes until the time is over. False: the device was unplugged.
bool watch(HidDevice& device, const ProbeOptions& options) {
  const Stopwatch watch;
  const bool prints = options.prints && !options.json;
  bool has_warned = false;
  std::string last;
  while (!watch.isOver(options)) {
    if (!device.isConnected()) return false;
    const std::array<double, 6> axes = device.axes();
    const DeviceReading& r = device.reading();
    const bool has_come = r.reports + r.unknown + r.malformed > 0;
    if (const std::string text = textOf(r, axes); prints && has_come && text != last) {
      printText("{:8.3f} s  {}\n", watch.seconds(), text);
      std::fflush(stdout);
      last = text;
    }
    if (!has_warned && watch.seconds() > 2 && !has_come) {
      printText(stderr, "kerf: {}: no data for 2 s. Move the device. Another driver may be using it.\n",
                device.what().path());
      has_warned = true;
    }
    std::this_thread::sleep_for(kBetweenLines);
  }
  return true;
}

DeviceRecording headOf(const FoundDevice& found) {
  DeviceRecording out;
  out.driver = found.driver;
  out.device = idOf(found.interfaces.front()) + " " + found.name;
  return out;
}

int probeAxes(const FoundDevice& found, const ProbeOptions& options) {
  Ear ear(headOf(found), !options.record.empty());
  const Interruption interruption;
  auto device = HidDevice::open(
      found, [&](std::int64_t t, int interface, std::span<const std::uint8_t> r) { ear.hear(t, interface, r); });
  if (!device) return complain(device.error());

  if (!options.json) printText("{}: {}\n", found.path(), found.name);
  const bool is_connected = watch(**device, options);
  (*device)->update();
  const DeviceReading last = (*device)->reading();
  device->reset();  // ends the messages

  if (const int code = ear.write(options); code != kOk) return code;
  if (options.json) {
    nlohmann::json out = jsonOf(last, last.axes);
    out["device"] = jsonOf(found);
    out["connected"] = is_connected;
    printJson(out);
  }
  return is_connected ? kOk : complainOfUnplugged(found.path());
}

// ---- Arms

double ageMs(const ArmCounts& counts) {
  return 1e-6 * static_cast<double>(std::int64_t{deviceClock() - counts.newest_came_ns});
}

struct LastHand {
  HandFrame hand;
  Vec3d velocity = Vec3d::Zero();
  double age_ms = 0;
  bool has_come = false;
};

// As watch(). False: the device was unplugged.
bool watchArm(const ForceArm& arm, const ProbeOptions& options, LastHand& out) {
  const Stopwatch watch;
  const bool prints = options.prints && !options.json;
  bool has_warned = false;
  HandSpeed speed;
  std::string last;
  while (!watch.isOver(options)) {
    if (arm.isGone()) return false;
    if (arm.isOver()) return true;
    const ArmCounts counts = arm.counts();
    if (HandFrame hand; arm.lastHand(hand)) {
      out.has_come = true;
      out.hand = hand;
      out.velocity = speed.at(counts.newest_came_ns / 1000, hand);
      out.age_ms = ageMs(counts);
    }
    std::string text = counts.is_talking ? textOf(out.hand, out.velocity) : "silent: " + counts.trouble;
    if (counts.refused > 0) text += fmt::format(", {} rejected: {}", counts.refused, counts.last_fault);
    if (prints && out.has_come && text != last) {
      printText("{:8.3f} s  {}, {:.1f} ms old\n", watch.seconds(), text, out.age_ms);
      std::fflush(stdout);
      last = text;
    }
    if (!has_warned && watch.seconds() > 2 && !out.has_come) {
      printText(stderr, "kerf: {}: no data for 2 s; {}\n", arm.what(), counts.trouble);
      has_warned = true;
    }
    std::this_thread::sleep_for(kBetweenLines);
  }
  return true;
}

void sayHow(const ArmCounts& counts, const TimeHistogram& gaps) {
  printText("{} from the hand, {} rejected", counted(counts.hands, "message"), counts.refused);
  if (gaps.count() > 0)
    printText("; interval p50 {:.2f} ms, p99 {:.2f} ms, max {:.2f} ms", gaps.percentileMs(0.5), gaps.percentileMs(0.99),
              gaps.maxMs());
  printText("; {} sent to the arm, all without force\n", counted(counts.forces, "message"));
}

// @param id  of the device, for the recording: "cafe:4004 RawHID arm"; empty: the arm's own name.
int probeArm(const std::string& name, const std::string& id, const std::string& language, const ProbeOptions& options) {
  DeviceRecording head;
  head.arm = language;
  head.device = id.empty() ? name : id;
  Ear ear(std::move(head), !options.record.empty());
  const Interruption interruption;
  auto opened =
      openArm(name, {}, {}, [&](std::int64_t t, std::span<const std::uint8_t> message) { ear.hear(t, 0, message); });
  if (!opened && opened.error().code == Error::Code::kBadValue) return complainOfUsage(opened.error());
  if (!opened) return complain(opened.error());

  // It is never enabled: all frames sent to it are without force.
  const std::string what = opened->arm->what();
  if (!options.json) printText("{}: no force while it is probed\n", what);
  std::fflush(stdout);
  LastHand last;
  const bool is_connected = watchArm(*opened->arm, options, last);
  const ArmCounts counts = opened->arm->counts();
  opened->arm.reset();  // ends the messages

  if (const int code = ear.write(options); code != kOk) return code;
  const TimeHistogram gaps = ear.gaps();
  if (options.json) {
    nlohmann::json out = {
        {"device", {{"name", what}, {"driver", language}}},
        {"connected", is_connected},
        {"hands", counts.hands},
        {"refused", counts.refused},
        {"force_N", 0},
        {"apart_ms", {{"p50", gaps.percentileMs(0.5)}, {"p99", gaps.percentileMs(0.99)}, {"most", gaps.maxMs()}}}};
    out["hand"] = last.has_come ? jsonOf(last.hand, last.velocity) : nlohmann::json();
    out["age_ms"] = last.has_come ? nlohmann::json(last.age_ms) : nlohmann::json();
    printJson(out);
  } else {
    sayHow(counts, gaps);
  }
  return is_connected ? kOk : complainOfUnplugged(what);
}

}  // namespace

int probeDevice(const ProbeOptions& options) {
  if (options.device.starts_with("replay:"))
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .place = "DEVICE",
                            .found = "a recording",
                            .expected = "a device",
                            .hint = "kerf devices --replay FILE"});
  if (namesTransport(options.device)) return probeArm(options.device, "", "bridge", options);

  const auto found = chooseDevice(findDevices(), options.device);
  if (!found) return complain(found.error());
  if (!found->isArm()) return probeAxes(*found, options);
  return probeArm(found->path(), idOf(found->interfaces.front()) + " " + found->name, found->driver->id, options);
}

// ---- Recordings

namespace {

int printHands(const DeviceRecording& recording, bool json) {
  const RecordedHands replayed = replayHands(recording);
  HandSpeed speed;
  nlohmann::json list = nlohmann::json::array();
  if (!json)
    printText("{}, driver {}: {}, {} from the hand, {} rejected\n", recording.device, recording.arm,
              counted(recording.reports.size(), "message"), replayed.hands.size(), replayed.refused);
  for (const RecordedHand& next : replayed.hands) {
    const Vec3d velocity = speed.at(next.time_us, next.hand);
    if (json) {
      list.push_back(jsonOf(next.hand, velocity));
      list.back()["time_us"] = next.time_us;
    } else {
      printText("{:8.3f} s  {}\n", 1e-6 * static_cast<double>(next.time_us), textOf(next.hand, velocity));
    }
  }
  if (json)
    printJson(
        {{"device", recording.device}, {"driver", recording.arm}, {"hands", list}, {"refused", replayed.refused}});
  return kOk;
}

int printReadings(const DeviceRecording& recording, bool json) {
  const std::vector<DeviceReading> readings = replayRecording(recording);
  if (json) {
    nlohmann::json list = nlohmann::json::array();
    for (std::size_t n = 0; n < readings.size(); ++n) {
      list.push_back(jsonOf(readings[n], readings[n].axes));
      list.back()["time_us"] = recording.reports[n].time_us;
    }
    printJson({{"device", recording.device}, {"driver", recording.driver->id}, {"readings", list}});
    return kOk;
  }
  printText("{}, driver {}: {}\n", recording.device, recording.driver->id, counted(readings.size(), "report"));
  for (std::size_t n = 0; n < readings.size(); ++n)
    printText("{:8.3f} s  {}\n", 1e-6 * static_cast<double>(recording.reports[n].time_us),
              textOf(readings[n], readings[n].axes));
  return kOk;
}

}  // namespace

int printRecording(const std::string& file, bool json) {
  const auto recording = readRecording(file);
  if (!recording) return complain(recording.error());
  return recording->arm.empty() ? printReadings(*recording, json) : printHands(*recording, json);
}

}  // namespace kerf::cli
