#include "ui/app/import/session_file.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/toml_reader.h"
#include "geometry/base/version.h"
#include "geometry/case/case_bundle.h"
#include "geometry/formats/zip_archive.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/files/run_output.h"
#include "sim/run/session/run_branch.h"
#include "ui/app/import/opening.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::ZipArchive;
using internal::ZipEntry;

constexpr const char* kContents = "session.toml";
constexpr const char* kContentsFormat = "kerf-session";
constexpr int kContentsVersion = 1;
constexpr const char* kRunPart = "run/";
constexpr std::size_t kMostContents = 1 << 20;  // bytes of session.toml
constexpr std::uint64_t kMostArchive = std::uint64_t{4} << 30, kMostUnpacked = 2 * kMostArchive;  // bytes
constexpr std::size_t kMostFiles = 2000, kMostParts = 6, kLongestPart = 200;
constexpr const char* kSaveAgain = "copy the file again, or save the session again";

struct PackedFile {
  std::string name, sha256;
  std::uint64_t size = 0;
};

tl::unexpected<Error> badSessionFile(const fs::path& file, std::string place, std::string found, std::string expected,
                                     Error::Code code = Error::Code::kBadFormat) {
  return fail({.code = code,
               .file = file.string(),
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = kSaveAgain});
}

std::string partOfCase(std::size_t n) { return fmt::format("cases/{}/", n); }

// ---- Packing

// Files of a bundle, by name. Without the lock, leftovers, and links.
Expected<void> addFolder(const fs::path& folder, const std::string& part, std::vector<ZipEntry>& out) {
  std::error_code failed;
  std::vector<ZipEntry> found;
  for (fs::recursive_directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with('.') || name == "lock" || at->is_symlink() || !at->is_regular_file()) continue;
    found.push_back({part + at->path().lexically_relative(folder).generic_string(), {}, at->path()});
  }
  if (failed)
    return fail({.code = Error::Code::kNotFound,
                 .file = folder.string(),
                 .found = failed.message(),
                 .expected = "a folder that can be read",
                 .hint = "check its permissions"});
  std::sort(found.begin(), found.end(), [](const ZipEntry& a, const ZipEntry& b) { return a.name < b.name; });
  std::move(found.begin(), found.end(), std::back_inserter(out));
  return {};
}

Expected<std::string> contentsOf(const std::vector<ZipEntry>& entries, const Progress& progress) {
  toml::array files;
  for (const ZipEntry& entry : entries) {
    if (!report(progress, static_cast<double>(files.size()) / static_cast<double>(entries.size()), "reading files"))
      return internal::nothingWritten();
    KERF_TRY(hash, sha256OfFile(entry.file));
    files.push_back(toml::table{
        {"name", entry.name}, {"size", static_cast<std::int64_t>(fs::file_size(entry.file))}, {"sha256", hash}});
  }
  std::ostringstream out;
  out << toml::table{{"format", kContentsFormat},
                     {"version", kContentsVersion},
                     {"kerf_version", kVersion},
                     {"file", std::move(files)}}
      << "\n";
  return out.str();
}

// ---- Unpacking

// Names only a file below run/ or cases/N/.
Expected<void> requireInside(const fs::path& file, const std::string& name) {
  bool is_safe = name.starts_with(kRunPart) || name.starts_with("cases/");
  std::size_t parts = 0;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string_view part = std::string_view(name).substr(begin, end - begin);
    const auto isBad = [](unsigned char c) { return c < 0x20 || c == 0x7f || c == '\\'; };
    is_safe &= !part.empty() && part.front() != '.' && part.size() <= kLongestPart &&
               std::none_of(part.begin(), part.end(), isBad) && ++parts <= kMostParts;
    begin = end + 1;
  }
  if (is_safe) return {};
  return badSessionFile(file, internal::inQuotes(name), "a name that does not belong into a session",
                        "a file below run/ or cases/");
}

Expected<std::string> readContentsText(ZipArchive& archive, const fs::path& file) {
  const auto at = archive.find(kContents);
  if (!at) return badSessionFile(file, kContents, "it is missing", "a session saved by Kerf");
  std::string out;
  KERF_CHECK(archive.read(*at, [&](std::string_view piece) -> Expected<void> {
    out += piece;
    if (out.size() <= kMostContents) return {};
    return badSessionFile(file, kContents, "more than 1 MiB", "a list of files");
  }));
  return out;
}

struct Contents {
  std::map<std::string, PackedFile> files;  // by name
  std::uint64_t bytes = 0;
};

// @param copy  of session.toml, for the reader of TOML files.
Expected<Contents> readContents(const fs::path& copy, const fs::path& file) {
  KERF_TRY(root, parseToml(copy));
  TomlTable top(root, file, kContents);
  if (top.get<std::string>("format", kContentsFormat) != kContentsFormat)
    top.reject("format", "another format", kContentsFormat);
  const auto version = top.get<std::int64_t>("version", "1");
  if (version != kContentsVersion)
    return badSessionFile(file, kContents, fmt::format("version {}", version), "version 1: a newer Kerf saved it",
                          Error::Code::kUnsupported);
  Contents out;
  (void)top.get<std::string>("kerf_version", "a version");
  const toml::array* const tables = top.tables("file");
  for (std::size_t n = 0; tables && n < tables->size(); ++n) {
    const toml::table* const row = (*tables)[n].as_table();
    if (!row) continue;
    TomlTable t(*row, file, fmt::format("file {}", n + 1));
    PackedFile packed;
    packed.name = t.get<std::string>("name", "a name");
    packed.size = static_cast<std::uint64_t>(t.number("size", 0, static_cast<double>(kMostUnpacked), "bytes"));
    packed.sha256 = t.get<std::string>("sha256", "64 hexadecimal digits");
    KERF_CHECK(t.finish());
    KERF_CHECK(requireInside(file, packed.name));
    out.bytes += packed.size;
    if (out.bytes > kMostUnpacked || out.files.size() >= kMostFiles)
      return badSessionFile(file, kContents, "too many or too large files", "at most 8 GiB in 2000 files",
                            Error::Code::kUnsupported);
    const std::string name = packed.name;
    if (!out.files.emplace(name, std::move(packed)).second)
      return badSessionFile(file, internal::inQuotes(name), "it is listed twice", "each file once");
  }
  KERF_CHECK(top.finish());
  return out;
}

// The archive holds just the listed files, each once.
Expected<void> requireListed(const ZipArchive& archive, const Contents& contents, const fs::path& file) {
  std::set<std::string> seen;
  for (std::uint64_t n = 0; n < archive.count(); ++n) {
    const std::string name = archive.nameOf(n);
    if (archive.isLink(n)) return badSessionFile(file, internal::inQuotes(name), "a link", "only files");
    if (!seen.insert(name).second)
      return badSessionFile(file, internal::inQuotes(name), "it is there twice", "each file once");
    if (name != kContents && !contents.files.contains(name))
      return badSessionFile(file, internal::inQuotes(name), "a file that session.toml does not list",
                            "only listed files");
  }
  for (const auto& [name, packed] : contents.files)
    if (!seen.contains(name))
      return badSessionFile(file, internal::inQuotes(name), "it is missing", "all listed files");
  return {};
}

Expected<void> requireSpace(const fs::path& data, const Contents& contents) {
  std::error_code failed;
  const fs::space_info space = fs::space(data, failed);
  if (failed || space.available > contents.bytes + (std::uintmax_t{64} << 20)) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = data.string(),
               .found = fmt::format("{} MB free", space.available / 1000000),
               .expected = fmt::format("{} MB for the unpacked session", contents.bytes / 1000000),
               .hint = "free some space, or use another --data FOLDER"});
}

Expected<void> unpackFile(ZipArchive& archive, std::uint64_t entry, const PackedFile& packed, const fs::path& to,
                          const fs::path& file) {
  std::error_code failed;
  fs::create_directories(to.parent_path(), failed);
  std::ofstream out(to, std::ios::binary);
  std::uint64_t done = 0;
  const auto take = [&](std::string_view piece) -> Expected<void> {
    done += piece.size();
    if (done > packed.size)
      return badSessionFile(file, internal::inQuotes(packed.name), "more bytes than session.toml lists",
                            fmt::format("{} bytes", packed.size));
    out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
    return {};
  };
  KERF_CHECK(archive.read(entry, take));
  out.close();
  if (!out)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = to.string(),
                 .found = "it cannot be written",
                 .expected = "a writable folder with room",
                 .hint = "free some space, or use another --data FOLDER"});
  KERF_TRY(hash, sha256OfFile(to));
  if (done == packed.size && hash == packed.sha256) return {};
  return badSessionFile(file, internal::inQuotes(packed.name), "other bytes than those that were saved",
                        "SHA-256 " + packed.sha256.substr(0, 12));
}

// @param part  "run/": unpacks the files below it.
Expected<void> unpackPart(ZipArchive& archive, const Contents& contents, const std::string& part, const fs::path& to,
                          const fs::path& file, const Progress& progress) {
  std::uint64_t done = 0;
  for (std::uint64_t n = 0; n < archive.count(); ++n) {
    const std::string name = archive.nameOf(n);
    if (!name.starts_with(part)) continue;
    const PackedFile& packed = contents.files.at(name);
    const double share = static_cast<double>(done) / static_cast<double>(std::max<std::uint64_t>(1, contents.bytes));
    if (!report(progress, share, "unpacking")) return internal::nothingWritten();
    KERF_CHECK(unpackFile(archive, n, packed, to / name.substr(part.size()), file));
    done += packed.size;
  }
  return {};
}

// A folder that holds just the files of a part.
bool holdsPart(const fs::path& folder, const Contents& contents, const std::string& part) {
  std::error_code failed;
  for (const auto& [name, packed] : contents.files) {
    if (!name.starts_with(part)) continue;
    const fs::path known = folder / name.substr(part.size());
    if (fs::file_size(known, failed) != packed.size || failed) return false;
    if (const auto hash = sha256OfFile(known); !hash || *hash != packed.sha256) return false;
  }
  return true;
}

// A new folder of the case, or the same one from earlier.
Expected<fs::path> unpackCase(ZipArchive& archive, const Contents& contents, std::size_t n, const std::string& id,
                              const fs::path& cases, const fs::path& file, const Progress& progress) {
  std::error_code ignored;
  fs::create_directories(cases, ignored);
  for (int number = 1;; ++number) {
    const fs::path folder = cases / fmt::format("{}-{}.case", id.substr(0, 12), number);
    if (fs::exists(fs::symlink_status(folder, ignored))) {
      if (holdsPart(folder, contents, partOfCase(n))) return folder;
      continue;
    }
    KERF_TRY(staged, AtomicFolder::create(folder, false, "case.toml"));
    KERF_CHECK(unpackPart(archive, contents, partOfCase(n), staged.staging(), file, progress));
    KERF_TRY(manifest, readCaseManifest(staged.staging()));
    if (manifest.id != id)
      return badSessionFile(file, partOfCase(n), "case " + internal::inQuotes(manifest.id), "the case of the run");
    KERF_CHECK(staged.commit());
    return folder;
  }
}

bool isHash(const std::string& id) {
  const auto isDigit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  return id.size() >= 12 && std::all_of(id.begin(), id.end(), isDigit);
}

}  // namespace

bool isSessionFile(const fs::path& path) {
  std::error_code ignored;
  if (path.extension() != ".kerf" || !fs::is_regular_file(path, ignored)) return false;
  char begin[4] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof(begin));
  return std::string_view(begin, sizeof(begin)) == std::string_view("PK\3\4", 4);
}

Expected<void> packSession(const fs::path& run_folder, const fs::path& file, const Progress& progress) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireEnded(run_folder, manifest));
  KERF_TRY(case_folder, caseOfRun(run_folder));
  KERF_TRY(cases, casesBesideRun(run_folder));
  cases.insert(cases.begin(), case_folder);

  std::vector<ZipEntry> entries;
  KERF_CHECK(addFolder(run_folder, kRunPart, entries));
  for (std::size_t n = 0; n < cases.size(); ++n) KERF_CHECK(addFolder(cases[n], partOfCase(n), entries));
  KERF_TRY(contents, contentsOf(entries, partOf(progress, 0, 0.3)));
  entries.insert(entries.begin(), {kContents, std::move(contents), {}});

  KERF_TRY(out, AtomicFile::create(file));
  if (!report(progress, 0.3, "packing")) return internal::nothingWritten();
  if (auto written = internal::writeZip(out.stream(), entries); !written) {
    written.error().file = file.string();
    written.error().hint = "free some memory or disk space";
    return written;
  }
  return out.commit();
}

Expected<fs::path> unpackSession(const fs::path& file, const fs::path& data, const Progress& progress) {
  KERF_TRY(source, internal::loadMeshSource(file, kMostArchive));
  KERF_TRY(archive, ZipArchive::open(source));
  KERF_TRY(text, readContentsText(archive, file));

  std::error_code failed;
  const fs::path home = fs::absolute(data, failed).lexically_normal();
  fs::create_directories(home / "sessions", failed);
  const fs::path run_folder = newSessionFolder(home, file.stem().string());
  KERF_TRY(staged, AtomicFolder::create(run_folder, false, kRunManifest));
  const fs::path copy = staged.staging() / kContents;
  std::ofstream(copy, std::ios::binary) << text;
  KERF_TRY(contents, readContents(copy, file));
  fs::remove(copy, failed);
  KERF_CHECK(requireListed(archive, contents, file));
  KERF_CHECK(requireSpace(home, contents));

  KERF_CHECK(unpackPart(archive, contents, kRunPart, staged.staging(), file, partOf(progress, 0, 0.5)));
  KERF_TRY(manifest, readRunManifest(staged.staging()));
  if (manifest.is_open)
    return badSessionFile(file, "run/run.toml", "a session that has not ended", "an ended session",
                          Error::Code::kUnsupported);
  for (std::size_t n = 0; n <= manifest.beside.size(); ++n) {
    const std::string& id = n == 0 ? manifest.case_id : manifest.beside[n - 1].case_id;
    if (!isHash(id)) return badSessionFile(file, kRunManifest, "a case id that is no hash", "hexadecimal digits");
    KERF_TRY(case_folder,
             unpackCase(archive, contents, n, id, home / "unpacked-cases", file, partOf(progress, 0.5, 1)));
    KERF_TRY(path, internal::relativeCasePath(case_folder, run_folder));
    (n == 0 ? manifest.case_path : manifest.beside[n - 1].case_path) = path;
  }
  KERF_CHECK(writeRunManifest(staged.staging(), manifest));
  KERF_CHECK(staged.commit());
  return run_folder;
}

Expected<void> saveSession(const fs::path& live, const fs::path& from, const fs::path& data, const fs::path& file,
                           const Progress& progress) {
  const fs::path folder = data / "saving";
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  const fs::path state = folder / live.filename();
  fs::remove_all(state, ignored);  // of a killed program
  const auto branch = branchRun(live, {}, state, partOf(progress, 0, 0.8));
  if (!branch && (branch.error().code != Error::Code::kEmpty || from.empty())) return fail(branch.error());

  auto packed = packSession(branch ? state : from, file, partOf(progress, 0.8, 1));
  fs::remove_all(state, ignored);
  return packed;
}

}  // namespace kerf
