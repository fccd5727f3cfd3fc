#include "sim/device/hid/device_watch.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace kerf {

struct DeviceWatch::State {
  void watch();
  void look();

  std::string name;
  std::chrono::milliseconds every{};
  mutable std::mutex mutex;
  std::condition_variable ended;
  bool is_stopping = false;  // guarded by mutex, like the next two
  std::shared_ptr<HidDevice> device;
  std::string trouble;
  std::thread thread;
};

void DeviceWatch::State::watch() {
  std::unique_lock lock(mutex);
  while (!is_stopping) {
    if (!device || !device->isConnected()) {
      std::shared_ptr<HidDevice> gone = std::move(device);
      lock.unlock();
      gone.reset();  // ends its threads: without the lock
      look();
      lock.lock();
    }
    ended.wait_for(lock, every, [&] { return is_stopping; });
  }
}

void DeviceWatch::State::look() {
  std::vector<FoundDevice> there = findDevices();
  std::erase_if(there, [](const FoundDevice& found) { return found.isArm(); });
  std::shared_ptr<HidDevice> opened;
  std::string wrong;
  if (const auto meant = chooseDevice(there, name)) {
    auto one = HidDevice::open(*meant);
    if (one)
      opened = std::move(*one);
    else
      wrong = one.error().message();
  } else if (!there.empty()) {
    wrong = meant.error().message();
  }

  const std::lock_guard lock(mutex);
  device = std::move(opened);
  trouble = device ? std::string() : std::move(wrong);
}

DeviceWatch::DeviceWatch(std::string name, int every_ms) : state_(std::make_unique<State>()) {
  state_->name = std::move(name);
  state_->every = std::chrono::milliseconds(every_ms);
  state_->thread = std::thread([this] { state_->watch(); });
}

DeviceWatch::~DeviceWatch() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->is_stopping = true;
  }
  state_->ended.notify_one();
  state_->thread.join();
}

std::shared_ptr<HidDevice> DeviceWatch::device() const {
  const std::lock_guard lock(state_->mutex);
  return state_->device;
}

std::string DeviceWatch::trouble() const {
  const std::lock_guard lock(state_->mutex);
  return state_->trouble;
}

}  // namespace kerf
