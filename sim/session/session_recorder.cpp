#include "sim/session/session_recorder.h"

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cassert>
#include <condition_variable>
#include <mutex>
#include <new>
#include <thread>

#include "sim/session/session_format.h"

namespace kerf {
namespace {

using namespace internal;

constexpr std::size_t kMostPayload = std::max(kSampleBytes, kCheckBytes);

// One entry to record, packed by the calling thread: a fixed size, so that nothing is allocated.
struct Entry {
  RecordKind kind = kSamplesRecord;
  std::uint32_t size = 0;
  std::uint64_t tick = 0;
  std::uint64_t lost_before = 0;                // entries lost to a full queue since the previous one
  std::array<std::byte, kMostPayload> payload;  // `size` bytes are valid
  Command command;                              // of a command record: printed by the recording thread
};
static_assert(sizeof(Entry) == 448, "RecorderOptions::queue_capacity says so");

// One writer: a load and a store are cheaper than fetch_add, and as good.
void countOne(std::atomic<std::uint64_t>& n) noexcept {
  n.store(n.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

struct SessionRecorder::State {
  State(SessionLogWriter writer, const RecorderOptions& recorder_options)
      : options(recorder_options),
        queue(std::max<std::size_t>(1, recorder_options.queue_capacity)),
        log(std::move(writer)) {}

  // Producer's side.
  RecordStatus push(Entry& entry) noexcept;
  RecordStatus lose(RecordStatus why) noexcept;

  // Recording thread.
  void run();
  void take(const Entry& entry);
  void endRun();
  void addGap(std::uint64_t tick, std::uint64_t count);
  void tell(const Entry& entry);
  Expected<void> drain();
  void fail(const Error& why);

  void keepSynced();  // syncing thread

  const RecorderOptions options;
  boost::lockfree::spsc_queue<Entry> queue;
  std::atomic<bool> is_over{false};                 // failed or closed
  std::atomic<std::uint64_t> recorded{0}, lost{0};  // written by the producer

  // Producer only.
  bool has_sample = false;
  std::uint64_t last_sample = 0, last_tick = 0;
  std::uint64_t lost_before = 0;

  // Recording thread only.
  SessionLogWriter log;
  std::vector<std::byte> run_payload;  // consecutive samples
  std::uint64_t run_first = 0;
  std::uint64_t taken = 0;          // entries out of the queue
  std::vector<RecordedEntry> told;  // for on_written

  // Any thread.
  mutable std::mutex mutex;
  std::condition_variable wake;
  bool is_closing = false;
  RecorderStatus published;           // everything but `recorded` and `lost`
  std::uint64_t entries_written = 0;  // before the file failed
  std::thread writing, syncing;
};

RecordStatus SessionRecorder::State::lose(RecordStatus why) noexcept {
  countOne(lost);
  ++lost_before;
  return why;
}

RecordStatus SessionRecorder::State::push(Entry& entry) noexcept {
  if (is_over.load(std::memory_order_acquire)) return lose(RecordStatus::kFailed);
  entry.lost_before = lost_before;
  last_tick = entry.tick;
  if (!queue.push(entry)) return lose(RecordStatus::kQueueFull);
  lost_before = 0;
  countOne(recorded);
  return RecordStatus::kRecorded;
}

void SessionRecorder::State::endRun() {
  log.addSampleBytes(run_first, run_payload);
  run_payload.clear();
}

void SessionRecorder::State::addGap(std::uint64_t tick, std::uint64_t count) {
  endRun();
  log.add(tick, SessionGap{count});
  if (options.on_written) told.push_back({tick, SessionGap{count}});
}

void SessionRecorder::State::tell(const Entry& entry) {
  ByteUnpacker in(entry.payload.data());
  RecordedEntry& out = told.emplace_back();
  out.tick = entry.tick;
  if (entry.kind == kSamplesRecord)
    out.what = unpackSample(entry.payload.data());
  else if (entry.kind == kCommandRecord)
    out.what = entry.command;
  else if (entry.kind == kStrokeRecord)
    out.what = static_cast<StrokeMark>(in.u32());
  else
    out.what = unpackCheck(entry.payload.data());
}

void SessionRecorder::State::take(const Entry& entry) {
  if (entry.lost_before > 0) addGap(entry.tick, entry.lost_before);
  const auto payload = std::span(entry.payload).first(entry.size);

  const bool goes_on = entry.kind == kSamplesRecord && !run_payload.empty() &&
                       entry.tick == run_first + run_payload.size() / kSampleBytes;
  if (!goes_on) endRun();

  if (entry.kind == kSamplesRecord) {
    if (!goes_on) run_first = entry.tick;
    run_payload.insert(run_payload.end(), payload.begin(), payload.end());
  } else if (entry.kind == kCommandRecord) {
    log.add(entry.tick, SessionCommand{printCommand(entry.command)});
  } else {
    log.addRecord(entry.kind, entry.tick, payload);
  }
  if (options.on_written) tell(entry);
}

Expected<void> SessionRecorder::State::drain() {
  // Only the entries present at the beginning: a faster producer must not delay the write forever.
  Entry entry;
  for (std::size_t n = queue.read_available(); n > 0 && queue.pop(entry); --n) {
    take(entry);
    ++taken;
  }
  endRun();
  KERF_CHECK(log.write());
  if (!told.empty()) options.on_written(std::exchange(told, {}));
  return {};
}

void SessionRecorder::State::fail(const Error& why) {
  {
    const std::lock_guard lock(mutex);
    if (!published.error) published.error = why;
  }
  is_over.store(true, std::memory_order_release);
}

void SessionRecorder::State::keepSynced() {
  for (;;) {
    std::uint64_t written = 0;
    {
      std::unique_lock lock(mutex);
      if (wake.wait_for(lock, options.sync_every, [this] { return is_closing; })) return;
      written = published.bytes_written;
      if (written == published.bytes_synced || published.error) continue;
    }

    if (const auto done = log.syncAside(); !done) {
      fail(done.error());
    } else {
      const std::lock_guard lock(mutex);
      published.bytes_synced = written;
    }
  }
}

void SessionRecorder::State::run() {
  for (bool closing = false; !closing;) {
    {
      std::unique_lock lock(mutex);
      closing = wake.wait_for(lock, options.write_every, [this] { return is_closing; });
    }

    Expected<void> done;
    try {
      if (!is_over) done = drain();
      if (closing) syncing.join();  // it may be using the file
      if (!is_over && done && closing) {
        if (lost_before > 0) addGap(last_tick, lost_before);  // the producer is at rest
        done = log.close(last_tick);
        is_over.store(true, std::memory_order_release);
      }
    } catch (const std::bad_alloc&) {
      done = kerf::fail({.code = Error::Code::kWriteFailed,
                         .file = "",
                         .place = "recording",
                         .found = "no memory left",
                         .expected = "",
                         .hint = "close other programs"});
    }
    if (!done) fail(done.error());

    const std::lock_guard lock(mutex);
    published.bytes_written = log.bytesWritten();
    published.bytes_synced = std::max(published.bytes_synced, log.bytesSynced());
    if (!published.error) entries_written = taken;
  }
}

SessionRecorder::SessionRecorder(std::unique_ptr<State> state) : state_(std::move(state)) {}
SessionRecorder::SessionRecorder(SessionRecorder&&) noexcept = default;
SessionRecorder::~SessionRecorder() {
  if (state_) (void)close();
}

Expected<SessionRecorder> SessionRecorder::start(const std::filesystem::path& path, const SessionHeader& header,
                                                 const RecorderOptions& options) {
  KERF_TRY(log, SessionLogWriter::create(path, header));
  try {
    SessionRecorder recorder(std::make_unique<State>(std::move(log), options));
    State& s = *recorder.state_;
    s.published.bytes_written = s.log.bytesWritten();
    s.published.bytes_synced = s.log.bytesSynced();
    s.syncing = std::thread([&s] { s.keepSynced(); });
    s.writing = std::thread([&s] { s.run(); });
    return recorder;
  } catch (const std::exception& e) {  // no memory for the queue, no more threads
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .place = "starting to record",
                 .found = e.what(),
                 .expected = "",
                 .hint = "close other programs"});
  }
}

RecordStatus SessionRecorder::record(const DeviceSample& sample, std::uint64_t tick) noexcept {
  State& s = *state_;
  if (s.has_sample && tick <= s.last_sample) return s.lose(RecordStatus::kRefused);
  s.has_sample = true;
  s.last_sample = tick;
  Entry entry;
  entry.kind = kSamplesRecord;
  entry.tick = tick;
  entry.size = kSampleBytes;
  pack(sample, std::span(entry.payload).first<kSampleBytes>());
  return s.push(entry);
}

RecordStatus SessionRecorder::record(const Command& command, std::uint64_t tick) noexcept {
  Entry entry;
  entry.kind = kCommandRecord;
  entry.tick = tick;
  entry.command = command;
  return state_->push(entry);
}

RecordStatus SessionRecorder::record(StrokeMark mark, std::uint64_t tick) noexcept {
  Entry entry;
  entry.kind = kStrokeRecord;
  entry.tick = tick;
  entry.size = 4;
  BytePacker(entry.payload.data()).u32(static_cast<std::uint32_t>(mark));
  return state_->push(entry);
}

RecordStatus SessionRecorder::record(const StateCheck& check, std::uint64_t tick) noexcept {
  Entry entry;
  entry.kind = kCheckRecord;
  entry.tick = tick;
  entry.size = kCheckBytes;
  pack(check, std::span(entry.payload).first<kCheckBytes>());
  return state_->push(entry);
}

RecorderStatus SessionRecorder::status() const {
  const std::lock_guard lock(state_->mutex);
  RecorderStatus status = state_->published;
  status.recorded = state_->recorded.load(std::memory_order_relaxed);
  status.lost = state_->lost.load(std::memory_order_relaxed);
  // Entries that waited when the file failed are lost as well.
  if (status.error) status.lost += status.recorded - state_->entries_written;
  return status;
}

Expected<void> SessionRecorder::close() {
  State& s = *state_;
  {
    const std::lock_guard lock(s.mutex);
    s.is_closing = true;
  }
  s.wake.notify_all();
  if (s.writing.joinable()) s.writing.join();
  if (s.syncing.joinable()) s.syncing.join();  // the writing thread did not start, or ran out of memory
  const std::lock_guard lock(s.mutex);
  if (s.published.error) return fail(*s.published.error);
  return {};
}

}  // namespace kerf
