#include "preprocess/volume/label_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "geometry/base/available_memory.h"
#include "preprocess/volume/volume_file.h"
#include "preprocess/volume/volume_names.h"
#include "preprocess/volume/volume_plan.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::bytesOf;
using internal::ValueType;
using internal::VolumeFormat;
using internal::VolumePlan;

constexpr std::size_t kMostLabels = 256, kFewLabels = 32;
constexpr double kMostRestless = 0.3;

tl::unexpected<Error> notLabels(const fs::path& path, std::string place, std::string found) {
  return fail({.code = Error::Code::kBadValue,
               .file = path.string(),
               .place = std::move(place),
               .found = std::move(found) + ": these look like intensities",
               .expected = "labels: whole numbers, 0 to 65535, at most 256 different ones",
               .hint = "give `threshold = ...` in the recipe to make one label of all values from there on"});
}

// Share of neighbours along x with different labels, both non-zero.
double restless(const LabelVolume& v) {
  std::size_t pairs = 0, differ = 0;
  for (const LabelVolume::Slice& slice : v.slices)
    for (const LabelVolume::Row& row : slice.rows)
      for (auto i = row.first + 1; i < row.first + static_cast<std::uint64_t>(row.end - row.begin); ++i)
        if (slice.labels[i] && slice.labels[i - 1]) {
          ++pairs;
          differ += slice.labels[i] != slice.labels[i - 1];
        }
  return pairs ? static_cast<double>(differ) / static_cast<double>(pairs) : 0;
}

// Properties of the values, found while converting them to labels.
struct Values {
  std::optional<double> threshold;
  std::vector<char> seen = std::vector<char>(65536, 0);
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
};

template <class T>
Expected<void> toLabels(const fs::path& path, const LabelVolume& grid, const std::byte* raw, std::size_t count,
                        Values& values, std::uint16_t* out, std::size_t first) {
  for (std::size_t i = 0; i < count; ++i) {
    T v;
    std::memcpy(&v, raw + i * sizeof(T), sizeof(T));
    if (values.threshold) {
      out[i] = static_cast<double>(v) >= *values.threshold ? 1 : 0;  // not a number: 0
      if (static_cast<double>(v) > values.highest) values.highest = static_cast<double>(v);
      if (static_cast<double>(v) < values.lowest) values.lowest = static_cast<double>(v);
      continue;
    }

    const auto x = static_cast<double>(v);
    if (!(x >= 0 && x <= 65535) || x != std::floor(x)) {
      const std::size_t at = first + i, nx = static_cast<std::size_t>(grid.size[0]),
                        ny = static_cast<std::size_t>(grid.size[1]);
      return notLabels(path, fmt::format("voxel ({}, {}, {})", at % nx, at / nx % ny, at / nx / ny),
                       fmt::format("the value {:g}", x));
    }
    out[i] = static_cast<std::uint16_t>(x);
    values.seen[out[i]] = 1;
  }
  return {};
}

Expected<void> toLabels(ValueType type, const fs::path& path, const LabelVolume& grid, const std::byte* raw,
                        std::size_t count, Values& values, std::uint16_t* out, std::size_t first) {
  const auto as = [&](auto zero) { return toLabels<decltype(zero)>(path, grid, raw, count, values, out, first); };
  switch (type) {
    case ValueType::kU8:
      return as(std::uint8_t{});
    case ValueType::kI8:
      return as(std::int8_t{});
    case ValueType::kU16:
      return as(std::uint16_t{});
    case ValueType::kI16:
      return as(std::int16_t{});
    case ValueType::kU32:
      return as(std::uint32_t{});
    case ValueType::kI32:
      return as(std::int32_t{});
    case ValueType::kU64:
      return as(std::uint64_t{});
    case ValueType::kI64:
      return as(std::int64_t{});
    case ValueType::kF32:
      return as(float{});
    case ValueType::kF64:
      break;
  }
  return as(double{});
}

// Rejects a volume beyond the memory limits, before any allocation.
Expected<void> checkMemory(const fs::path& path, const LabelReadOptions& options, const VolumePlan& plan) {
  const auto value_bytes = static_cast<double>(bytesOf(plan.header.type));
  double voxels = 1;
  for (const int s : plan.grid.size) voxels *= s;
  const double slice = voxels / plan.grid.size[2] * value_bytes;
  // Two bytes for a label, if every voxel has one. While ITK decompresses, memory holds the values twice.
  const double needed = 2 * voxels + (plan.files.size() > 1 || plan.packed.is_plain ? slice : 2 * voxels * value_bytes);

  const auto tooLarge = [&](std::string expected, std::string hint) {
    return fail({.code = Error::Code::kUnsupported,
                 .file = path.string(),
                 .found = fmt::format("{} x {} x {} voxels, {:.1f} GB to read them", plan.grid.size[0],
                                      plan.grid.size[1], plan.grid.size[2], needed / 1e9),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  };

  if (needed > static_cast<double>(options.max_bytes))
    return tooLarge(fmt::format("at most {:.1f} GB", static_cast<double>(options.max_bytes) / 1e9),
                    "crop the volume to the jaw, or save it with 8 or 16 bits per voxel");
  const std::uint64_t available = options.available_bytes ? *options.available_bytes : internal::availableMemory();
  if (needed > 0.8 * static_cast<double>(available))
    return tooLarge(
        fmt::format("at most 4/5 of the {:.1f} GB of memory that are free", static_cast<double>(available) / 1e9),
        "close other programs, crop the volume to the jaw, or save it with 8 or 16 bits per voxel");
  return {};
}

// All values, made labels. Throws std::bad_alloc.
Expected<void> readLabels(const fs::path& path, const VolumePlan& plan, const Progress& progress, LabelVolume& volume,
                          Values& values) {
  const auto slices = static_cast<std::size_t>(volume.size[2]);
  const std::size_t per_slice = static_cast<std::size_t>(volume.size[0]) * static_cast<std::size_t>(volume.size[1]);
  const std::size_t value_bytes = bytesOf(plan.header.type);
  std::vector<std::uint16_t> labels(per_slice);
  const auto take = [&](const fs::path& file, std::size_t slice, std::span<const std::byte> raw) -> Expected<void> {
    if (!report(progress, 0.2 + 0.8 * static_cast<double>(slice) / static_cast<double>(slices), "reading voxels"))
      return cancelled(path.string());
    KERF_CHECK(
        toLabels(plan.header.type, file, volume, raw.data(), per_slice, values, labels.data(), slice * per_slice));
    volume.addSlice(labels);
    return {};
  };

  if (plan.packed.is_plain)
    return internal::readSlices(
        plan.packed, slices, per_slice, value_bytes,
        [&](std::size_t slice, std::span<const std::byte> raw) { return take(path, slice, raw); }, progress);

  KERF_CHECK(internal::requireWholeValues(plan.packed, slices * per_slice, bytesOf(plan.stored_type), progress));
  const std::size_t per_file = slices / plan.files.size();
  std::vector<std::byte> raw(per_file * per_slice * value_bytes);
  for (std::size_t f = 0; f < plan.files.size(); ++f) {
    KERF_CHECK(internal::readVolumeValues(plan.files[f], plan.format, raw.data(), raw.size()));
    for (std::size_t s = 0; s < per_file; ++s)
      KERF_CHECK(take(plan.files[f], f * per_file + s,
                      std::span(raw).subspan(s * per_slice * value_bytes, per_slice * value_bytes)));
  }
  return {};
}

// A segmentation has few values, and regions; in a picture of densities neighbours differ nearly everywhere.
Expected<void> requireLabels(const fs::path& path, const LabelVolume& volume, const Values& values) {
  const auto different = static_cast<std::size_t>(std::count(values.seen.begin(), values.seen.end(), 1));
  if (different > kMostLabels) return notLabels(path, "", fmt::format("{} different values", different));
  if (const double share = restless(volume); different > kFewLabels && share > kMostRestless)
    return notLabels(path, "",
                     fmt::format("{} different values, and {:.0f} % of neighbours differ", different, 100 * share));
  if (values.threshold && values.highest < *values.threshold)
    return fail({.code = Error::Code::kEmpty,
                 .file = path.string(),
                 .place = "threshold",
                 .found = fmt::format("no value reaches {:g}; the highest is {:g}", *values.threshold, values.highest),
                 .expected = "a threshold inside the range of the values"});
  return {};
}

}  // namespace

double LabelVolume::voxelVolume() const { return std::abs(axes().determinant()); }

void LabelVolume::addSlice(std::span<const std::uint16_t> labels) {
  const auto nx = static_cast<std::size_t>(size[0]);
  Slice& slice = slices.emplace_back();
  std::vector<Row> rows;
  rows.reserve(static_cast<std::size_t>(size[1]));
  std::uint64_t held = 0;
  for (std::size_t at = 0; at < labels.size(); at += nx) {
    std::size_t begin = 0, end = nx;
    while (begin < nx && labels[at + begin] == 0) ++begin;
    while (end > begin && labels[at + end - 1] == 0) --end;
    rows.push_back({held, static_cast<int>(begin), static_cast<int>(end)});
    held += end - begin;
  }
  if (held == 0) return;

  slice.rows = std::move(rows);
  slice.labels.reserve(held);
  for (std::size_t j = 0; j < slice.rows.size(); ++j) {
    const auto line = labels.subspan(j * nx, nx);
    slice.labels.insert(slice.labels.end(), line.begin() + slice.rows[j].begin, line.begin() + slice.rows[j].end);
  }
}

std::vector<LabelCount> countLabels(const LabelVolume& volume) {
  std::vector<std::uint64_t> count(65536, 0);
  std::uint64_t held = 0;
  for (const LabelVolume::Slice& slice : volume.slices) {
    for (const std::uint16_t l : slice.labels) ++count[l];
    held += slice.labels.size();
  }
  std::uint64_t voxels = 1;
  for (const int s : volume.size) voxels *= static_cast<std::uint64_t>(s);
  count[0] += voxels - held;
  std::vector<LabelCount> out;
  for (std::size_t l = 0; l < count.size(); ++l)
    if (count[l]) out.push_back({static_cast<std::uint16_t>(l), count[l]});
  return out;
}

namespace {

Expected<LabelVolume> readValues(const fs::path& path, const LabelReadOptions& options, const Progress& progress,
                                 Values& values) {
  KERF_TRY(plan, internal::planVolume(path, options, progress));
  KERF_CHECK(internal::chooseSpacing(path, options, plan));
  KERF_CHECK(checkMemory(path, options, plan));

  LabelVolume volume = std::move(plan.grid);
  volume.format = internal::nameOf(plan.format);
  try {
    KERF_CHECK(readLabels(path, plan, progress, volume, values));
  } catch (const std::bad_alloc&) {
    return fail({.code = Error::Code::kUnsupported,
                 .file = path.string(),
                 .found = "more voxels than memory can hold",
                 .expected = "a smaller volume",
                 .hint = "crop the volume to the jaw"});
  }
  return volume;
}

}  // namespace

Expected<LabelVolume> readLabelVolume(const fs::path& path, const LabelReadOptions& options, const Progress& progress) {
  if (options.threshold && !std::isfinite(*options.threshold))
    return fail({.code = Error::Code::kBadValue,
                 .file = path.string(),
                 .place = "threshold",
                 .found = "not a finite number",
                 .expected = "a number"});

  Values values;
  values.threshold = options.threshold;
  KERF_TRY(volume, readValues(path, options, progress, values));
  KERF_CHECK(requireLabels(path, volume, values));
  return std::move(volume);
}

Expected<VolumeSummary> summariseVolume(const fs::path& path, const LabelReadOptions& options,
                                        const Progress& progress) {
  Values values;
  values.threshold = std::numeric_limits<double>::infinity();  // no label
  KERF_TRY(grid, readValues(path, options, progress, values));
  grid.slices.clear();
  return VolumeSummary{std::move(grid), values.lowest, values.highest};
}

std::string textOfSliceFolders(const fs::path& folder) {
  constexpr std::size_t kMostFiles = 20000, kMostNamed = 8;
  constexpr int kDeepest = 3;
  std::vector<std::pair<std::string, std::size_t>> found;
  std::error_code ec;
  std::size_t seen = 0;
  for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, ec), end;
       !ec && at != end && seen < kMostFiles; at.increment(ec)) {
    if (at.depth() >= kDeepest) at.disable_recursion_pending();
    if (!at->is_directory(ec)) continue;
    const auto files = internal::filesOf(at->path());
    if (!files) continue;
    seen += 1 + files->size();
    const auto slices = static_cast<std::size_t>(std::count_if(files->begin(), files->end(), [](const fs::path& f) {
      return internal::sliceFormat(f).has_value() || internal::hasDicomMark(f);
    }));
    if (slices > 0) found.emplace_back(at->path().lexically_relative(folder).string(), slices);
  }

  std::sort(found.begin(), found.end());
  std::string text;
  for (std::size_t n = 0; n < std::min(found.size(), kMostNamed); ++n)
    text += fmt::format("{}{} ({} slice{})", n == 0 ? ", but in its sub-folders: " : ", ", found[n].first,
                        found[n].second, found[n].second == 1 ? "" : "s");
  if (found.size() > kMostNamed) text += fmt::format(" and {} more", found.size() - kMostNamed);
  return text;
}

std::string textOfCutLabels(const LabelVolume& volume, std::span<const std::uint16_t> wanted) {
  std::vector<std::array<bool, 6>> touches(65536);
  std::vector<std::uint16_t> labels;
  const auto touch = [&](std::uint16_t label, std::size_t face) {
    if (label == 0) return;
    if (touches[label] == std::array<bool, 6>{}) labels.push_back(label);
    touches[label][face] = true;
  };
  const auto [nx, ny, nz] = volume.size;
  for (int k = 0; k < static_cast<int>(volume.slices.size()); ++k)
    for (int j = 0; j < ny; ++j) {
      touch(volume.at(0, j, k), 0);
      touch(volume.at(nx - 1, j, k), 1);
      for (int i = 0; i < nx && (j == 0 || j == ny - 1 || k == 0 || k == nz - 1); ++i) {
        const std::uint16_t label = volume.at(i, j, k);
        if (j == 0) touch(label, 2);
        if (j == ny - 1) touch(label, 3);
        if (k == 0) touch(label, 4);
        if (k == nz - 1) touch(label, 5);
      }
    }

  constexpr const char* kFaces[] = {"x low", "x high", "y low", "y high", "z low", "z high"};
  std::sort(labels.begin(), labels.end());
  std::string text;
  for (const std::uint16_t label : labels) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), label) == wanted.end()) continue;
    std::string faces;
    for (std::size_t f = 0; f < 6; ++f)
      if (touches[label][f]) faces += (faces.empty() ? "" : ", ") + std::string(kFaces[f]);
    text += fmt::format("{}label {} ({})", text.empty() ? "" : ", ", label, faces);
  }
  return text;
}

Expected<std::vector<fs::path>> filesOfVolume(const fs::path& path) {
  std::vector<fs::path> files{path};
  if (internal::fileFormat(path) != VolumeFormat::kMetaImage) return files;
  KERF_TRY(stated, internal::checkVolumeHeader(path, VolumeFormat::kMetaImage));
  if (!stated.data_file.empty() && stated.data_file.filename() != path.filename()) files.push_back(stated.data_file);
  return files;
}

bool isLabelVolume(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_directory(path, ec)) return internal::fileFormat(path).has_value();
  const auto files = internal::filesOf(path);
  return files && std::any_of(files->begin(), files->end(), [](const fs::path& f) {
           return internal::sliceFormat(f).has_value() || internal::hasDicomMark(f);
         });
}

}  // namespace kerf
