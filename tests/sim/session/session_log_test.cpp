#include "sim/session/session_log.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "tests/sim/session_samples.h"
#include "tests/support/temporary_folder.h"

namespace kerf::session_log_test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

Bytes bytesOf(const fs::path& path) {
  const std::string text = contentOf(path);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Bytes someState(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * i >> 5);
  return bytes;
}

// A log with every kind of record. `ends`: end of the header and of each record.
struct SmallLog {
  Bytes bytes;
  std::vector<std::size_t> ends;
  SessionLog whole;

  SmallLog() {
    const TemporaryFolder folder;
    auto log = SessionLogWriter::create(folder.path() / "s.kerflog", kSomeHeader);
    EXPECT_TRUE(log) << log.error().message();
    const auto written = [&] {
      EXPECT_TRUE(log->write());
      ends.push_back(log->bytesWritten());
    };
    written();
    log->add(0, SessionCommand{"tool.select round-014"});
    written();
    log->add(0, SessionCommand{""});
    written();
    log->addSamples(0, std::array{sampleOf(0), sampleOf(1)});
    written();
    log->add(1, checkOf(1));
    written();
    log->add(2, StrokeMark::kBegin);
    written();
    log->addSamples(2, std::array{sampleOf(2)});
    written();
    log->add(3, StrokeMark::kEnd);
    written();
    log->add(2, *packSnapshot(someState(100)));
    written();
    log->add(7, SessionGap{5});
    written();
    log->addRecord(internal::kMaySkip | 12, 7, someState(3));
    written();
    log->addSamples(8, std::array{sampleOf(8)});
    written();
    EXPECT_TRUE(log->close(8));
    ends.push_back(log->bytesWritten());
    bytes = bytesOf(folder.path() / "s.kerflog");
    const auto read = parseSessionLog(bytes, "s.kerflog");
    EXPECT_TRUE(read) << read.error().message();
    whole = *read;
  }
};

const SmallLog& smallLog() {
  static const SmallLog log;
  return log;
}

TEST(SessionLog, ReadsBackEveryBitInOrder) {
  const SessionLog& log = smallLog().whole;
  EXPECT_EQ(log.header, kSomeHeader);
  EXPECT_EQ(log.value("tool"), "round-014");
  EXPECT_EQ(log.value("saw"), "");
  EXPECT_TRUE(log.is_closed);
  EXPECT_FALSE(log.damage);
  EXPECT_EQ(log.skipped, 1u);

  const std::vector<std::uint64_t> ticks = {0, 1, 2, 8};
  ASSERT_EQ(log.samples.size(), ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    EXPECT_EQ(log.samples[i].tick, ticks[i]);
    EXPECT_TRUE(sameBits(log.samples[i].sample, sampleOf(ticks[i]))) << i;
  }
  const std::vector<SessionEvent> events = {{0, 0, SessionCommand{"tool.select round-014"}},
                                            {0, 0, SessionCommand{""}},
                                            {1, 2, checkOf(1)},
                                            {2, 2, StrokeMark::kBegin},
                                            {3, 3, StrokeMark::kEnd},
                                            {2, 3, *packSnapshot(someState(100))},
                                            {7, 3, SessionGap{5}}};
  ASSERT_EQ(log.events.size(), events.size());
  for (std::size_t i = 0; i < events.size(); ++i) EXPECT_TRUE(sameEvent(log.events[i], events[i])) << i;
  EXPECT_EQ(*unpackSnapshot(std::get<SessionSnapshot>(log.events[5].what)), someState(100));
}

TEST(SessionLog, BytesAreThoseOfTheDocumentedFormat) {
  // By hand from docs/reference/file-formats.md, so that the format cannot change unnoticed.
  const Bytes& bytes = smallLog().bytes;
  const auto text = [&](std::size_t at, std::size_t size) {
    return std::string(reinterpret_cast<const char*>(bytes.data()) + at, size);
  };
  using namespace std::string_literals;
  EXPECT_EQ(text(0, 24), "KERFLOG\n\2\0\0\0\x41\0\0\0\4\0\0\0kerf"s);
  const std::size_t samples = smallLog().ends[2];
  EXPECT_EQ(text(samples, 4), "\x8\0\0\0"s);
  // Sample 2: all its numbers differ from sample 1, except its validity.
  EXPECT_EQ(text(smallLog().ends[5] + 20, 4), "\1\0\xff\1"s) << "one sample, nine numbers that move";
}

// Format before version 2: by hand from docs/reference/file-formats.md.
TEST(SessionLog, ALogOfVersionOneIsRead) {
  using namespace internal;
  Bytes bytes;
  std::uint32_t sum = 0;
  const auto add = [&](std::span<const std::byte> part) {
    bytes.insert(bytes.end(), part.begin(), part.end());
    sum = checksum(sum, part);
  };
  const auto seal = [&] {
    std::array<std::byte, 4> out;
    BytePacker(out.data()).u32(sum);
    bytes.insert(bytes.end(), out.begin(), out.end());
  };
  std::array<std::byte, 16> head;
  std::copy_n(std::as_bytes(std::span(kLogMagic)).begin(), 8, head.begin());
  BytePacker(head.data() + 8).u32(1).u32(0);
  add(head);
  seal();
  BytePacker(head.data()).u32(kSamplesRecord).u32(2 * kSampleBytes).u64(5);
  add(head);
  seal();
  for (const std::uint64_t tick : {5, 6}) {
    std::array<std::byte, kSampleBytes> sample;
    pack(sampleOf(tick), sample);
    add(sample);
  }
  seal();

  const auto log = parseSessionLog(bytes, "old.kerflog");
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_FALSE(log->damage);
  ASSERT_EQ(log->samples.size(), 2u);
  for (const std::size_t n : {0u, 1u}) {
    EXPECT_EQ(log->samples[n].tick, 5 + n);
    EXPECT_TRUE(sameBits(log->samples[n].sample, sampleOf(5 + n)));
  }

  // That version has no packed samples.
  BytePacker(head.data()).u32(kPackedSamplesRecord).u32(0).u64(7);
  add(head);
  seal();
  seal();
  const auto refused = parseSessionLog(bytes, "old.kerflog");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().found, "a record of kind 8");
  EXPECT_NE(refused.error().expected.find("1 to 7"), std::string::npos);
}

TEST(SessionLog, CutOffAtAnyByteReadsUpToTheLastWholeRecord) {
  const auto& [bytes, ends, whole] = smallLog();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Bytes part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    const auto log = parseSessionLog(part, "part.kerflog");
    if (size < ends.front()) {
      ASSERT_FALSE(log) << size;
      EXPECT_EQ(log.error().code, Error::Code::kBadFormat);
      EXPECT_EQ(log.error().file, "part.kerflog");
      EXPECT_FALSE(log.error().place.empty());
      continue;
    }
    ASSERT_TRUE(log) << size << ": " << log.error().message();
    EXPECT_TRUE(isBeginning(*log, whole)) << size;
    EXPECT_FALSE(log->is_closed) << size;
    const std::size_t last_end = *(std::upper_bound(ends.begin(), ends.end(), size) - 1);
    ASSERT_EQ(log->damage.has_value(), last_end != size) << size;
    if (!log->damage) continue;
    EXPECT_EQ(log->damage->kind, LogDamage::Kind::kCutShort) << size;
    EXPECT_EQ(log->damage->at_byte, last_end);
    EXPECT_EQ(log->damage->lost_bytes, size - last_end);
    const auto until_there = parseSessionLog(std::span(bytes).first(last_end), "");
    EXPECT_EQ(log->samples.size(), until_there->samples.size()) << size;
    EXPECT_EQ(log->events.size(), until_there->events.size()) << size;
  }
}

TEST(SessionLog, EveryFlippedBitIsFoundWhereItIs) {
  const auto& [bytes, ends, whole] = smallLog();
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    Bytes flipped = bytes;
    flipped[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    const auto log = parseSessionLog(flipped, "flipped.kerflog");
    if (bit / 8 < ends.front()) {
      EXPECT_FALSE(log) << bit;
      continue;
    }
    ASSERT_TRUE(log) << bit << ": " << log.error().message();
    ASSERT_TRUE(log->damage) << bit;
    EXPECT_EQ(log->damage->kind, LogDamage::Kind::kDamaged) << bit;
    EXPECT_EQ(log->damage->at_byte, *(std::upper_bound(ends.begin(), ends.end(), bit / 8) - 1)) << bit;
    EXPECT_TRUE(isBeginning(*log, whole)) << bit;
  }
}

TEST(SessionLog, ATailOfZerosIsFoundWhereItBegins) {
  // Remains of a power failure on some file systems: the length was on the disk, the bytes were not.
  Bytes bytes = smallLog().bytes;
  const std::size_t whole = smallLog().ends[5];
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(whole), bytes.end(), std::byte{0});
  const auto log = parseSessionLog(bytes, "");
  ASSERT_TRUE(log);
  EXPECT_EQ(log->damage->at_byte, whole);
  EXPECT_EQ(log->damage->lost_bytes, bytes.size() - whole);
  EXPECT_TRUE(isBeginning(*log, smallLog().whole));
}

TEST(SessionLog, ARecordLeftOutDoubledOrSwappedIsFound) {
  const auto& [bytes, ends, whole] = smallLog();
  const auto part = [&, &all = bytes, &e = ends](std::size_t i) {  // record i; 0 is the header
    return std::span(all).subspan(i == 0 ? 0 : e[i - 1], e[i] - (i == 0 ? 0 : e[i - 1]));
  };
  const auto joined = [&](std::initializer_list<std::size_t> parts) {
    Bytes all;
    for (const std::size_t i : parts) all.insert(all.end(), part(i).begin(), part(i).end());
    return all;
  };
  EXPECT_FALSE(parseSessionLog(joined({0, 1, 2, 3}), "")->damage);
  EXPECT_TRUE(parseSessionLog(joined({0, 1, 3}), "")->damage) << "left out";
  EXPECT_TRUE(parseSessionLog(joined({0, 1, 1, 2}), "")->damage) << "doubled";
  EXPECT_TRUE(parseSessionLog(joined({0, 2, 1}), "")->damage) << "swapped";
  Bytes longer = bytes;
  longer.push_back({});
  EXPECT_EQ(parseSessionLog(longer, "")->damage->at_byte, bytes.size());
}

TEST(SessionLog, LengthsThatTheFileDoesNotCoverCostNoMemory) {
  // The checksum of the head is right, so the reader uses the length until it meets the size of the file.
  Bytes bytes(smallLog().bytes.begin(), smallLog().bytes.begin() + static_cast<std::ptrdiff_t>(smallLog().ends[0]));
  std::array<std::byte, 20> head;
  const std::uint32_t before = internal::ByteUnpacker(bytes.data() + bytes.size() - 4).u32();
  internal::BytePacker(head.data()).u32(internal::kCommandRecord).u32(0xffffffffu).u64(0);
  internal::BytePacker(head.data() + 16).u32(internal::checksum(before, std::span(head).first(16)));
  bytes.insert(bytes.end(), head.begin(), head.end());
  const auto log = parseSessionLog(bytes, "");
  ASSERT_TRUE(log);
  EXPECT_EQ(log->damage->kind, LogDamage::Kind::kCutShort);
  EXPECT_EQ(log->damage->at_byte, smallLog().ends[0]);
}

TEST(SessionLog, SamplesThatTakeNextToNoBytesAreBoundByTheSizeOfTheFile) {
  using namespace internal;
  const TemporaryFolder folder;
  auto log = SessionLogWriter::create(folder.path() / "s.kerflog", {});
  ASSERT_TRUE(log) << log.error().message();
  const std::vector<std::byte> at_rest = [] {
    SampleHistory zeros;
    return packSamples(std::vector<SampleBits>(kMostPackedSamples), zeros);
  }();
  const std::uint64_t record = kRecordHead + at_rest.size() + kChecksum;
  // The first record that no longer fits: n records of so many samples, in a file of n of those bytes.
  const std::uint64_t memory = kMostPackedSamples * sizeof(TimedSample);
  const std::uint64_t most = kSampleMemory / (memory - kSampleMemoryPerByte * record);
  std::uint64_t tick = 0;
  for (; tick < (most - 5) * kMostPackedSamples; tick += kMostPackedSamples)
    log->addRecord(kPackedSamplesRecord, tick, at_rest);
  ASSERT_TRUE(log->write());
  {
    const auto read = readSessionLog(folder.path() / "s.kerflog");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->samples.size(), tick) << "as many as there may be";
  }

  for (int n = 0; n < 10; ++n, tick += kMostPackedSamples) log->addRecord(kPackedSamplesRecord, tick, at_rest);
  ASSERT_TRUE(log->write());
  EXPECT_LT(log->bytesWritten(), 500'000u) << "half a megabyte stated more than 256";
  const auto refused = readSessionLog(folder.path() / "s.kerflog");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kBadValue);
  EXPECT_NE(refused.error().message().find("256 MiB"), std::string::npos) << refused.error().message();
}

std::string place_of_it;  // of the record that withRecord() adds

Expected<SessionLog> withRecord(std::uint32_t kind, std::uint64_t tick, const Bytes& payload) {
  const TemporaryFolder folder;
  auto log = SessionLogWriter::create(folder.path() / "s.kerflog", {});
  log->addSamples(10, std::array{sampleOf(0)});
  EXPECT_TRUE(log->write());
  place_of_it = "byte " + std::to_string(log->bytesWritten());
  log->addRecord(kind, tick, payload);
  EXPECT_TRUE(log->write());
  return readSessionLog(folder.path() / "s.kerflog");
}

TEST(SessionLog, UnknownKindsAreRefusedUnlessTheyMayBeSkipped) {
  const auto refused = withRecord(9, 10, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kUnsupported);
  EXPECT_EQ(refused.error().found, "a record of kind 9");
  const auto skipped = withRecord(internal::kMaySkip | 9, 10, someState(9));
  ASSERT_TRUE(skipped);
  EXPECT_EQ(skipped->skipped, 1u);
  EXPECT_FALSE(skipped->damage);
}

TEST(SessionLog, RecordsThatMakeNoSenseAreRefusedByKindAndPlace) {
  using namespace internal;
  const std::vector<std::tuple<std::uint32_t, std::uint64_t, std::size_t>> cases = {
      {kSamplesRecord, 11, 0},  {kSamplesRecord, 11, 75},      {kSamplesRecord, 11, 77},     {kSamplesRecord, 10, 76},
      {kSamplesRecord, 9, 76},  {kSamplesRecord, ~0ull, 152},  {kCheckRecord, 10, 55},       {kCheckRecord, 10, 57},
      {kSnapshotRecord, 10, 7}, {kStrokeRecord, 10, 3},        {kStrokeRecord, 10, 0},       {kGapRecord, 10, 4},
      {kEndRecord, 10, 1},      {kPackedSamplesRecord, 11, 0}, {kPackedSamplesRecord, 11, 4}};
  for (const auto& [kind, tick, size] : cases) {
    const auto log = withRecord(kind, tick, Bytes(size));
    ASSERT_FALSE(log) << kind << ' ' << size;
    EXPECT_EQ(log.error().code, Error::Code::kBadFormat);
    EXPECT_EQ(log.error().place, place_of_it) << "after the header and a sample";
  }
  Bytes third_mark(4);
  third_mark[0] = std::byte{2};
  EXPECT_FALSE(withRecord(kStrokeRecord, 10, third_mark));
  EXPECT_TRUE(withRecord(kSamplesRecord, ~0ull, Bytes(76))) << "the last tick there is";
}

TEST(SessionLog, ANewerVersionIsRefusedByName) {
  Bytes bytes = smallLog().bytes;
  bytes[8] = std::byte{3};
  const auto log = parseSessionLog(bytes, "new.kerflog");
  ASSERT_FALSE(log);
  EXPECT_EQ(log.error().code, Error::Code::kUnsupported);
  EXPECT_EQ(
      log.error().message(),
      "new.kerflog: byte 8: a session log of version 3; expected version 1 or 2. Try: read it with the newer Kerf that "
      "recorded it");
}

TEST(SessionLog, WhatIsNoLogIsRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(readSessionLog(folder.path() / "none").error().code, Error::Code::kNotFound);
  EXPECT_EQ(readSessionLog(folder.path()).error().found, "not a regular file");
  EXPECT_EQ(readSessionLog(folder.write("empty", "")).error().found, "an empty file");
  EXPECT_EQ(readSessionLog(folder.write("text", "solid tooth\n")).error().found, "another kind of file");
  ASSERT_EQ(::mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(readSessionLog(folder.path() / "pipe").error().found, "not a regular file");
}

TEST(SessionLog, AnExistingFileIsNeverOverwritten) {
  const TemporaryFolder folder;
  const fs::path path = folder.write("s.kerflog", "precious");
  const auto log = SessionLogWriter::create(path, {});
  ASSERT_FALSE(log);
  EXPECT_EQ(log.error().code, Error::Code::kWriteFailed);
  EXPECT_NE(log.error().hint.find("never overwritten"), std::string::npos);
  EXPECT_EQ(contentOf(path), "precious");
  EXPECT_EQ(SessionLogWriter::create(folder.path() / "no" / "s", {}).error().hint, "make the folder first");
}

TEST(SessionLog, WithoutCloseItReadsAndIsNotClosed) {
  const TemporaryFolder folder;
  {
    auto log = SessionLogWriter::create(folder.path() / "s.kerflog", kSomeHeader);
    log->addSamples(0, std::array{sampleOf(0)});
    ASSERT_TRUE(log->write());
    log->addSamples(1, std::array{sampleOf(1)});  // never written
  }
  const auto log = readSessionLog(folder.path() / "s.kerflog");
  ASSERT_TRUE(log);
  EXPECT_EQ(log->samples.size(), 1u);
  EXPECT_FALSE(log->is_closed);
  EXPECT_FALSE(log->damage);
}

TEST(SessionLog, SnapshotsComeBackAndFalseOnesAreRefused) {
  for (const std::size_t size : {0u, 1u, 100'000u}) {
    const auto snapshot = packSnapshot(someState(size));
    ASSERT_TRUE(snapshot);
    const auto state = unpackSnapshot(*snapshot);
    ASSERT_TRUE(state) << state.error().message();
    EXPECT_EQ(*state, someState(size));
  }
  EXPECT_TRUE(unpackSnapshot(*packSnapshot(Bytes(10'000'000)))) << "as good as deflate gets";

  const SessionSnapshot good = *packSnapshot(someState(1000));
  SessionSnapshot bad = good;
  ++bad.size;
  EXPECT_FALSE(unpackSnapshot(bad));
  bad.size -= 2;
  EXPECT_FALSE(unpackSnapshot(bad));
  bad.size = kMaxSnapshotBytes;  // more than the bytes can hold: refused before memory is allocated
  EXPECT_FALSE(unpackSnapshot(bad));
  bad = good;
  bad.packed.push_back({});
  EXPECT_FALSE(unpackSnapshot(bad)) << "bytes after the end";
  bad = good;
  bad.packed.pop_back();
  EXPECT_FALSE(unpackSnapshot(bad));
  EXPECT_FALSE(unpackSnapshot({10, {}}));
}

}  // namespace
}  // namespace kerf::session_log_test
