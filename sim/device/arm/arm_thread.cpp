#include "sim/device/arm/arm_thread.h"

#include <system_error>

#include "sim/device/hid/device_driver.h"

namespace kerf::internal {

Expected<void> ArmThread::start(std::function<void()> run, std::string file, std::string place) {
  try {
    thread_ = std::thread(std::move(run));
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue,
                 .file = std::move(file),
                 .place = std::move(place),
                 .found = e.what(),
                 .expected = "a thread",
                 .hint = "close other programs, or raise the limit nproc"});
  }
  return {};
}

void ArmThread::stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

ArmCounts ArmThread::told() const {
  const std::lock_guard lock(mutex);
  ArmCounts out = counts;
  const double age = 1e-9 * static_cast<double>(deviceClock() - out.newest_came_ns);
  out.is_talking = out.newest_came_ns != 0 && age <= ForceArm::kDeadMan;
  return out;
}

}  // namespace kerf::internal
