#include "sim/session/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <system_error>

#include "geometry/base/atomic_file.h"
#include "sim/session/session_format.h"

namespace kerf {
namespace {

using namespace internal;
namespace fs = std::filesystem;

constexpr std::array<char, 8> kMagic = {'K', 'E', 'R', 'F', 'C', 'H', 'K', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHead = 8 + 2 * 4 + 4 * 8;  // magic, version, flags, samples, events, state hash, size
constexpr std::size_t kVolumes = 256 * 8;         // of an object: CutObject::removed_before_mm3

// The volumes removed before splits, then the state.
std::vector<std::byte> contentOf(const Session& session) {
  const State& state = session.state();
  std::vector<std::byte> out(8 + state.objects.size() * kVolumes);
  BytePacker to(out.data());
  to.u64(state.objects.size());
  for (const CutObject& object : state.objects)
    for (const double volume : object.removed_before_mm3) to.f64(volume);
  const std::vector<std::byte> bytes = packState(state, session.loaded());
  out.resize(out.size() + bytes.size());
  std::copy(bytes.begin(), bytes.end(), out.end() - static_cast<std::ptrdiff_t>(bytes.size()));
  return out;
}

}  // namespace

Expected<std::uintmax_t> writeCheckpoint(const fs::path& run_folder, Session& session, std::size_t samples,
                                         std::size_t events) {
  KERF_TRY(content, packSnapshot(contentOf(session)));
  std::vector<std::byte> bytes(kHead);
  std::copy_n(reinterpret_cast<const std::byte*>(kMagic.data()), kMagic.size(), bytes.begin());
  const SessionRest rest = session.rest();
  BytePacker(bytes.data() + kMagic.size())
      .u32(kVersion)
      .u32((rest.is_in_stroke ? 1u : 0u) | (rest.has_steps ? 2u : 0u))
      .u64(samples)
      .u64(events)
      .u64(session.hashNow())
      .u64(content.size);
  bytes.insert(bytes.end(), content.packed.begin(), content.packed.end());
  std::array<std::byte, kChecksum> check;
  BytePacker(check.data()).u32(checksum(0, bytes));
  bytes.insert(bytes.end(), check.begin(), check.end());

  std::error_code failed;
  const fs::path file = run_folder / fmt::format("{}{:012}.kerfstate", kCheckpointName, samples);
  const fs::space_info space = fs::space(run_folder, failed);
  if (!failed && space.available < bytes.size() + kCheckpointSpares)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = file.string(),
                 .found = fmt::format("{} MB free on the disk", space.available / 1'000'000),
                 .expected = fmt::format("{} MB", (bytes.size() + kCheckpointSpares) / 1'000'000),
                 .hint = "free some space; the log is not affected"});
  KERF_TRY(out, AtomicFile::create(file));
  out.stream().write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  KERF_CHECK(out.commit());
  return bytes.size();
}

std::vector<fs::path> findCheckpoints(const fs::path& run_folder) {
  std::vector<fs::path> out;
  std::error_code ended;
  for (fs::directory_iterator at(run_folder, ended), end; !ended && at != end; at.increment(ended))
    if (at->path().filename().string().starts_with(kCheckpointName)) out.push_back(at->path());
  std::sort(out.begin(), out.end(), std::greater<>());
  return out;
}

void removeCheckpoints(const fs::path& run_folder) {
  std::error_code ignored;
  for (const fs::path& file : findCheckpoints(run_folder)) fs::remove(file, ignored);
}

Expected<Checkpoint> readCheckpoint(const fs::path& file, const LoadedObjects& loaded) {
  const auto refuse = [&](Error::Code code, std::string found, std::string expected) {
    return fail({.code = code,
                 .file = file.string(),
                 .place = "checkpoint",
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = "recovery uses an older one, or the whole log"});
  };
  const auto damaged = [&](std::string found) {
    return refuse(Error::Code::kBadFormat, std::move(found), "a whole checkpoint");
  };

  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  std::vector<char> read(error ? 0 : size);
  in.read(read.data(), static_cast<std::streamsize>(read.size()));
  const auto bytes = std::as_bytes(std::span(read));
  if (error || !in) return refuse(Error::Code::kUnreadable, "it cannot be read", "a readable file");
  if (bytes.size() < kHead + kChecksum || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return damaged(fmt::format("{} other bytes", bytes.size()));
  const auto body = bytes.first(bytes.size() - kChecksum);
  if (ByteUnpacker(body.data() + body.size()).u32() != checksum(0, body)) return damaged("a wrong checksum");

  ByteUnpacker head(bytes.data() + kMagic.size());
  if (const std::uint32_t version = head.u32(); version != kVersion)
    return refuse(Error::Code::kUnsupported, fmt::format("version {}", version), fmt::format("version {}", kVersion));
  const std::uint32_t flags = head.u32();
  Checkpoint out;
  out.rest = {.is_in_stroke = (flags & 1) != 0, .has_steps = (flags & 2) != 0};
  out.samples = head.u64();
  out.events = head.u64();
  const std::uint64_t hash = head.u64();
  const auto packed = body.subspan(kHead);
  KERF_TRY(content, unpackSnapshot({head.u64(), {packed.begin(), packed.end()}}));

  ByteUnpacker from(content.data());
  const std::uint64_t objects = content.size() < 8 ? kMostObjects + 1 : from.u64();
  if (objects > kMostObjects || content.size() < 8 + objects * kVolumes) return damaged("no volumes of objects");
  KERF_TRY(state, unpackState(std::span(content).subspan(8 + objects * kVolumes), loaded, file.string()));
  if (state.objects.size() != objects || state.hash() != hash) return damaged("a state with another hash");
  for (CutObject& object : state.objects)
    for (double& volume : object.removed_before_mm3) volume = from.f64();
  out.state = std::move(state);
  return out;
}

}  // namespace kerf
