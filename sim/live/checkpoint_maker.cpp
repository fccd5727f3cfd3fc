#include "sim/live/checkpoint_maker.h"

#include <time.h>

#include <algorithm>
#include <bit>
#include <new>
#include <system_error>
#include <utility>

#include "sim/live/realtime.h"
#include "sim/session/checkpoint.h"

namespace kerf {
namespace {

double cpuSeconds() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

CheckpointMaker::CheckpointMaker(std::filesystem::path run_folder, Model model, LoadedObjects loaded,
                                 const Rigid3& start, const CheckpointOptions& options)
    : folder_(std::move(run_folder)),
      options_(options),
      model_(std::move(model)),
      loaded_(std::move(loaded)),
      start_(start),
      thread_([this] { run(); }) {}

CheckpointMaker::~CheckpointMaker() { stop(); }

void CheckpointMaker::stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

CheckpointStatus CheckpointMaker::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void CheckpointMaker::add(std::vector<RecordedEntry> records) {
  {
    const std::lock_guard lock(mutex_);
    if (status_.ended || is_stopping_) return;
    waiting_count_ += records.size();
    if (waiting_count_ > options_.most_waiting) {
      status_.ended = "the machine is too slow to follow the session";
      waiting_.clear();
    } else {
      waiting_.push_back(std::move(records));
    }
  }
  wake_.notify_one();
}

void CheckpointMaker::end(std::string why) {
  const std::lock_guard lock(mutex_);
  if (!status_.ended) status_.ended = std::move(why);
  waiting_.clear();
}

void CheckpointMaker::run() {
  lowerPriority();
  try {
    double since = 0;  // CPU seconds of replay since the last checkpoint
    for (;;) {
      std::vector<RecordedEntry> records;
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [this] { return is_stopping_ || status_.ended || !waiting_.empty(); });
        if (is_stopping_ || status_.ended) break;
        records = std::move(waiting_.front());
        waiting_.pop_front();
        waiting_count_ -= records.size();
      }

      if (!session_) session_.emplace(model_, loaded_, start_);
      const double begin = cpuSeconds();
      for (const RecordedEntry& record : records)
        if (!follow(record)) return;
      const double took = cpuSeconds() - begin;
      since += took;
      {
        const std::lock_guard lock(mutex_);
        status_.replay_s += took;
      }
      if (since < options_.replay_s || since < 4 * last_write_s_) continue;
      write();
      since = 0;
    }
  } catch (const std::bad_alloc&) {
    end("no memory left");
  } catch (const std::exception& e) {  // the session goes on without checkpoints
    end(e.what());
  }
}

bool CheckpointMaker::follow(const RecordedEntry& record) {
  if (const auto* const sample = std::get_if<DeviceSample>(&record.what)) {
    session_->tick(*sample, output_);
    ++samples_;
    return true;
  }
  ++events_;
  std::string why;
  if (const auto* const command = std::get_if<Command>(&record.what)) {
    if (!session_->apply(*command)) why = "an undo reached back behind the kept steps";
  } else if (const auto* const check = std::get_if<StateCheck>(&record.what)) {
    const Wrench& force = session_->state().last_force;
    if (check->state_hash != session_->hashNow() || check->force.force != force.force ||
        check->force.torque != force.torque)
      why = "the replay differs from the session";
  } else if (std::holds_alternative<SessionGap>(record.what)) {
    why = "the log has a gap";
  }
  if (why.empty()) return true;
  end(std::move(why));
  return false;
}

void CheckpointMaker::write() {
  const double begin = cpuSeconds();
  const auto bytes = writeCheckpoint(folder_, *session_, samples_, events_);
  if (!bytes) return end(bytes.error().message());

  const std::uint64_t number = files_.empty() ? 1 : files_.front().number + 1;
  const auto written = findCheckpoints(folder_);
  if (written.empty()) return end("its folder cannot be listed");
  files_.insert(files_.begin(), {number, written.front(), *bytes});
  thinOut();
  if (session_->historyBytes() > options_.most_history) {
    auto again = readCheckpoint(files_.front().path, loaded_);
    if (!again) return end(again.error().message());
    session_.emplace(std::move(again->state), model_, loaded_, nullptr, again->rest);
  }

  last_write_s_ = cpuSeconds() - begin;
  const std::lock_guard lock(mutex_);
  ++status_.written;
  status_.last_bytes = *bytes;
  status_.write_s += last_write_s_;
}

// The ages of the files kept are about 1, 2, 4, 8, ... checkpoints.
void CheckpointMaker::thinOut() {
  const std::uint64_t newest = files_.front().number;
  std::uintmax_t bytes = 0;
  std::erase_if(files_, [&](const File& file) {
    const int lives = std::min(std::countr_zero(file.number), static_cast<int>(kMostFiles) - 3);
    const bool is_young = newest - file.number < std::uint64_t{2} << lives;
    const bool is_kept = file.number == newest || (is_young && bytes + file.bytes <= kMostBytes);
    std::error_code ignored;
    if (!is_kept) std::filesystem::remove(file.path, ignored);
    bytes += is_kept ? file.bytes : 0;
    return !is_kept;
  });
}

}  // namespace kerf
