#include "geometry/formats/zip_archive.h"

#include <zip.h>

#include <algorithm>
#include <array>
#include <ostream>

namespace kerf::internal {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kFreeSize = 64 * kMiB, kMostRatio = 100, kMostInflated = 8192 * kMiB;
constexpr const char* kDamagedArchive = "the file is cut short or damaged; export or copy it again";

struct ZipError {
  zip_error_t error;
  ZipError() { zip_error_init(&error); }
  ~ZipError() { zip_error_fini(&error); }
  ZipError(const ZipError&) = delete;
  ZipError& operator=(const ZipError&) = delete;
};

}  // namespace

void ZipArchive::Closer::operator()(zip* archive) const { zip_discard(archive); }

tl::unexpected<Error> ZipArchive::bad(std::string_view name, std::string found) const {
  return fail({.code = Error::Code::kBadFormat,
               .file = source_->file,
               .place = name.empty() ? "zip archive" : inQuotes(name),
               .found = std::move(found),
               .expected = "a whole zip archive",
               .hint = kDamagedArchive});
}

Expected<ZipArchive> ZipArchive::open(const MeshSource& source) {
  ZipArchive out(source);
  ZipError why;
  zip_source_t* bytes = zip_source_buffer_create(source.bytes.get(), source.size, 0, &why.error);
  if (!bytes) return out.bad("", zip_error_strerror(&why.error));
  out.archive_.reset(zip_open_from_source(bytes, ZIP_RDONLY, &why.error));
  if (!out.archive_) {
    zip_source_free(bytes);
    return out.bad("", zip_error_strerror(&why.error));
  }
  out.budget_ = std::min(kMostInflated, kFreeSize + kMostRatio * source.size);
  return out;
}

std::optional<std::uint64_t> ZipArchive::find(std::string_view part) const {
  if (part.starts_with('/')) part.remove_prefix(1);
  const zip_int64_t at = zip_name_locate(archive_.get(), std::string(part).c_str(), ZIP_FL_NOCASE | ZIP_FL_ENC_GUESS);
  if (at < 0) return std::nullopt;
  return static_cast<std::uint64_t>(at);
}

std::uint64_t ZipArchive::count() const {
  return static_cast<std::uint64_t>(std::max<zip_int64_t>(0, zip_get_num_entries(archive_.get(), 0)));
}

std::string ZipArchive::nameOf(std::uint64_t n) const {
  const char* const name = zip_get_name(archive_.get(), n, ZIP_FL_ENC_GUESS);
  return name ? name : "";
}

bool ZipArchive::isLink(std::uint64_t n) const {
  constexpr zip_uint32_t kKind = 0170000, kRegular = 0100000;  // of a Unix file mode, in the upper half
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  if (zip_file_get_external_attributes(archive_.get(), n, 0, &system, &attributes) != 0) return true;
  const zip_uint32_t kind = (attributes >> 16) & kKind;
  return system == ZIP_OPSYS_UNIX && kind != 0 && kind != kRegular;
}

Expected<void> ZipArchive::read(std::uint64_t entry, const std::function<Expected<void>(std::string_view)>& take,
                                const Progress& progress) {
  const char* stored_name = zip_get_name(archive_.get(), entry, ZIP_FL_ENC_GUESS);
  const std::string name = stored_name ? stored_name : "";
  const auto failed = [&](zip_error_t* error) { return bad(name, zip_error_strerror(error)); };
  struct CloseEntry {
    void operator()(zip_file_t* opened) const { zip_fclose(opened); }
  };

  const std::unique_ptr<zip_file_t, CloseEntry> file(zip_fopen_index(archive_.get(), entry, 0));
  if (!file) return failed(zip_get_error(archive_.get()));

  zip_stat_t stat;
  const bool has_size = zip_stat_index(archive_.get(), entry, 0, &stat) == 0 && (stat.valid & ZIP_STAT_SIZE) != 0;
  const double size = has_size ? static_cast<double>(stat.size) : 0;
  const std::unique_ptr<char[]> piece(new char[1 << 16]);
  for (std::uint64_t done = 0;;) {
    const zip_int64_t n = zip_fread(file.get(), piece.get(), 1 << 16);
    if (n < 0) return failed(zip_file_get_error(file.get()));
    if (n == 0) return {};

    if (static_cast<std::uint64_t>(n) > budget_)
      return fail({.code = Error::Code::kUnsupported,
                   .file = source_->file,
                   .place = inQuotes(name),
                   .found = "more than " + std::to_string(done / kMiB) + " MiB from an archive of " +
                            std::to_string(source_->size) + " bytes: a zip bomb",
                   .expected = "at most 100 times the size of the archive",
                   .hint = "unpack it by hand, if you trust it, and export again"});

    budget_ -= static_cast<std::uint64_t>(n);
    done += static_cast<std::uint64_t>(n);
    KERF_CHECK(take({piece.get(), static_cast<std::size_t>(n)}));

    const double fraction = size > 0 ? std::min(1.0, static_cast<double>(done) / size) : 0;
    if (done % (4 * kMiB) < static_cast<std::uint64_t>(n) && !report(progress, fraction, "unpacking"))
      return cancelled(*source_);
  }
}

Expected<void> writeZip(std::ostream& out, const std::vector<ZipEntry>& entries) {
  constexpr zip_uint16_t kMidnight = 0, kFirstOf1980 = 1 << 5 | 1;  // MS-DOS: (year - 1980) << 9 | month << 5 | day
  constexpr zip_uint32_t kLevel = 4;  // 9, libzip's own choice, takes a mesh sixteen times as long for a tenth less
  ZipError why;
  const auto failed = [](zip_error_t* error) {
    return fail({.code = Error::Code::kWriteFailed,
                 .place = "zip archive",
                 .found = zip_error_strerror(error),
                 .hint = "close other programs, or write PLY instead"});
  };

  zip_source_t* target = zip_source_buffer_create(nullptr, 0, 0, &why.error);
  if (!target) return failed(&why.error);
  zip_source_keep(target);  // zip_close() gives one reference back, the bytes are read through the other
  const struct Release {
    zip_source_t* source;
    ~Release() { zip_source_free(source); }
  } release{target};

  zip_t* archive = zip_open_from_source(target, ZIP_CREATE | ZIP_TRUNCATE, &why.error);
  if (!archive) {
    zip_source_free(target);
    return failed(&why.error);
  }

  for (const ZipEntry& entry : entries) {
    zip_source_t* bytes = entry.file.empty() ? zip_source_buffer(archive, entry.bytes.data(), entry.bytes.size(), 0)
                                             : zip_source_file(archive, entry.file.c_str(), 0, -1);
    const zip_int64_t at = bytes ? zip_file_add(archive, entry.name.c_str(), bytes, ZIP_FL_ENC_UTF_8) : -1;
    const auto index = static_cast<zip_uint64_t>(at);
    if (at < 0 || zip_file_set_dostime(archive, index, kMidnight, kFirstOf1980, 0) != 0 ||
        zip_set_file_compression(archive, index, ZIP_CM_DEFLATE, kLevel) != 0) {
      if (at < 0) zip_source_free(bytes);
      auto error = failed(zip_get_error(archive));
      zip_discard(archive);
      return error;
    }
  }

  if (zip_close(archive) != 0) {
    auto error = failed(zip_get_error(archive));
    zip_discard(archive);
    return error;
  }

  if (zip_source_open(target) != 0) return failed(zip_source_error(target));
  const std::unique_ptr<char[]> piece(new char[1 << 16]);
  zip_int64_t n = 0;
  while ((n = zip_source_read(target, piece.get(), 1 << 16)) > 0) out.write(piece.get(), n);
  zip_source_close(target);
  if (n < 0) return failed(zip_source_error(target));
  return {};
}

}  // namespace kerf::internal
