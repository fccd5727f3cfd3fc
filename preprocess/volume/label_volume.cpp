#include "preprocess/volume/label_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>

#include "geometry/base/available_memory.h"
#include "preprocess/volume/slice_trial.h"
#include "preprocess/volume/volume_file.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::bytesOf;
using internal::ValueType;
using internal::VolumeFormat;
using internal::VolumeHeader;

constexpr std::size_t kMostLabels = 256, kFewLabels = 32;
constexpr double kMostRestless = 0.3;

std::string lowerCase(std::string s) {
  for (char& c : s)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return s;
}

std::optional<VolumeFormat> fileFormat(const fs::path& path) {
  const std::string name = lowerCase(path.filename().string());
  if (name.ends_with(".nrrd")) return VolumeFormat::kNrrd;
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) return VolumeFormat::kNifti;
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return VolumeFormat::kMetaImage;
  return {};
}

std::optional<VolumeFormat> sliceFormat(const fs::path& path) {
  const std::string name = lowerCase(path.filename().string());
  if (name.ends_with(".png")) return VolumeFormat::kPng;
  if (name.ends_with(".tif") || name.ends_with(".tiff")) return VolumeFormat::kTiff;
  if (name.ends_with(".bmp")) return VolumeFormat::kBmp;
  return {};
}

const char* nameOf(VolumeFormat format) {
  switch (format) {
    case VolumeFormat::kNrrd:
      return "NRRD";
    case VolumeFormat::kNifti:
      return "NIfTI";
    case VolumeFormat::kMetaImage:
      return "MetaImage";
    case VolumeFormat::kDicom:
      return "DICOM";
    case VolumeFormat::kPng:
      return "PNG slices";
    case VolumeFormat::kTiff:
      return "TIFF slices";
    case VolumeFormat::kBmp:
      return "BMP slices";
  }
  return "";
}

// Runs of digits compare as numbers: slice-2 before slice-10.
bool naturalLess(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto run = [&](const std::string& s, std::size_t& at) {
        while (at < s.size() && s[at] == '0') ++at;
        const std::size_t first = at;
        while (at < s.size() && digit(s[at])) ++at;
        return s.substr(first, at - first);
      };
      const std::string x = run(a, i), y = run(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  const std::size_t left_a = a.size() - i, left_b = b.size() - j;
  return left_a != left_b ? left_a < left_b : a < b;
}

Expected<std::vector<fs::path>> filesOf(const fs::path& folder) {
  std::error_code ec;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    std::error_code ignored;
    if (it->is_regular_file(ignored) && it->path().filename().string()[0] != '.') files.push_back(it->path());
  }
  if (ec) return fail({Error::Code::kUnreadable, folder.string(), "", ec.message(), "a readable folder", ""});
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return naturalLess(a.filename().string(), b.filename().string());
  });
  return files;
}

// "DICM" at byte 128, as every DICOM file on disk has it.
bool hasDicomMark(const fs::path& path) {
  std::array<char, 132> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  return std::memcmp(head.data() + 128, "DICM", 4) == 0;
}

bool isUsable(double spacing) { return std::isfinite(spacing) && spacing > 1e-6 && spacing < 1e6; }

std::string text(const Vec3d& v) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0], v[1], v[2]); }

Error noSpacing(const fs::path& path, std::string found) {
  return {Error::Code::kBadValue,
          path.string(),
          "spacing",
          std::move(found),
          "mm per voxel along each axis",
          "give `spacing = [x, y, z]` in the recipe"};
}

// What will be read: where every slice (or the one file) is, and the grid they make.
struct Plan {
  VolumeFormat format = VolumeFormat::kNrrd;
  std::vector<fs::path> files;  // along the last axis; one: the whole volume
  VolumeHeader header;          // of each file
  LabelVolume grid;             // without labels
  std::optional<Vec3d> stated_spacing{};
  std::string unusable;  // why there is no stated_spacing
  // Without stated_spacing, what the file says all the same; not a number on the axes of which it says nothing.
  Vec3d known_spacing = Vec3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

Expected<void> checkOneValue(const fs::path& path, const VolumeHeader& h) {
  if (h.components != 1)
    return fail({Error::Code::kUnsupported, path.string(), "", fmt::format("{} values per voxel", h.components),
                 "one: a label or an intensity", "export the labels as one channel; colours and vectors are none"});
  return {};
}

// Three axes of those the file has, by dropping axes of one voxel: trailing ones first.
Expected<void> setGrid(const fs::path& path, const VolumeHeader& h, Plan& plan) {
  const std::size_t n = h.size.size();
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < n; ++a) axes.push_back(a);
  while (axes.size() > 3) {
    std::size_t drop = axes.size();
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (h.size[axes[i]] == 1 && (drop == axes.size() || i + 1 == axes.size())) drop = i;
    if (drop == axes.size())
      return fail({Error::Code::kUnsupported, path.string(), "",
                   fmt::format("{} axes of more than one voxel", axes.size()), "three",
                   "export one time step or one layer of labels"});
    axes.erase(axes.begin() + static_cast<std::ptrdiff_t>(drop));
  }
  if (axes.size() < 3)
    return fail({Error::Code::kUnsupported, path.string(), "", fmt::format("{} axes", axes.size()),
                 "a volume of three axes", "put slices into a folder and give the folder"});
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint64_t s = h.size[axes[i]];
    if (s < 1 || s > 1000000)
      return fail(
          {Error::Code::kBadFormat, path.string(), "", fmt::format("{} voxels along an axis", s), "1 to 1000000", ""});
    plan.grid.size[i] = static_cast<int>(s);
    const auto at = static_cast<Eigen::Index>(i);
    plan.grid.origin[at] = h.origin[axes[i]];
    plan.grid.spacing[at] = h.spacing[axes[i]];
    for (std::size_t row = 0; row < 3; ++row)
      plan.grid.direction(static_cast<Eigen::Index>(row), at) = h.direction[axes[row] * n + axes[i]];
  }
  return {};
}

Expected<Plan> planFile(const fs::path& path, VolumeFormat format, const LabelReadOptions& options) {
  KERF_TRY(stated, internal::checkVolumeHeader(path, format));
  Plan plan;
  plan.format = format;
  plan.files = {path};
  // One bad number spoils them all: a program that wrote it did not know the others either.
  const auto wrong = std::find_if_not(stated.spacing.begin(), stated.spacing.end(), isUsable);
  if (stated.spacing.size() < 3)
    plan.unusable = "no spacing";
  else if (wrong != stated.spacing.end())
    plan.unusable = fmt::format("a spacing of {}", *wrong);
  if (!plan.unusable.empty() && !options.spacing_mm) return fail(noSpacing(path, plan.unusable));
  KERF_TRY(header, internal::readVolumeHeader(path, format));
  plan.header = header;
  KERF_CHECK(checkOneValue(path, header));
  KERF_CHECK(setGrid(path, header, plan));
  double claimed = static_cast<double>(bytesOf(header.type));
  for (const auto s : header.size) claimed *= static_cast<double>(s);
  const double most = static_cast<double>(stated.stored_bytes) * stated.most_per_byte;
  if (claimed > most)
    return fail({Error::Code::kBadFormat, path.string(), "", fmt::format("{} bytes of values", stated.stored_bytes),
                 fmt::format("enough for the {:.0f} bytes its header claims", claimed),
                 "copy the file again: it is cut short"});
  if (!plan.unusable.empty()) return plan;
  if (!(isUsable(plan.grid.spacing[0]) && isUsable(plan.grid.spacing[1]) && isUsable(plan.grid.spacing[2])))
    plan.unusable = "a spacing of " + text(plan.grid.spacing);
  else
    plan.stated_spacing = plan.grid.spacing;
  return plan;
}

Expected<Plan> planSlices(const fs::path& folder, std::vector<fs::path> files, VolumeFormat format) {
  Plan plan;
  plan.format = format;
  plan.unusable = "pictures, which state no spacing in mm";
  for (const fs::path& f : files) {
    KERF_TRY(h, internal::readVolumeHeader(f, format));
    KERF_CHECK(checkOneValue(f, h));
    for (std::size_t a = 2; a < h.size.size(); ++a)
      if (h.size[a] != 1)
        return fail({Error::Code::kUnsupported, f.string(), "", fmt::format("{} pages", h.size[a]),
                     "one slice per picture", ""});
    if (h.size.size() < 2) return fail({Error::Code::kBadFormat, f.string(), "", "no picture", "two axes", ""});
    h.size.resize(2);
    if (&f == &files.front()) {
      plan.header = h;
    } else if (h.size != plan.header.size || h.type != plan.header.type) {
      return fail({Error::Code::kBadValue, f.string(), "",
                   fmt::format("{} x {} pixels of {} bytes", h.size[0], h.size[1], bytesOf(h.type)),
                   fmt::format("{} x {} of {} bytes, as in {}", plan.header.size[0], plan.header.size[1],
                               bytesOf(plan.header.type), files.front().filename().string()),
                   "keep only the slices of one volume in the folder"});
    }
  }
  const std::uint64_t most = 1000000;
  if (plan.header.size[0] > most || plan.header.size[1] > most || plan.header.size[0] < 1 || plan.header.size[1] < 1)
    return fail(
        {Error::Code::kBadFormat, folder.string(), "", "slices of a size out of range", "1 to 1000000 pixels", ""});
  plan.grid.size = {static_cast<int>(plan.header.size[0]), static_cast<int>(plan.header.size[1]),
                    static_cast<int>(files.size())};
  plan.files = std::move(files);
  return plan;
}

Expected<Plan> planDicom(const fs::path& folder, const std::vector<fs::path>& files, const Progress& progress) {
  struct Slice {
    fs::path path;
    VolumeHeader header;
    double height = 0;
  };
  std::vector<Slice> slices;
  std::set<std::string> series;
  for (const fs::path& f : files) {
    if (!report(progress, 0.2 * static_cast<double>(slices.size()) / static_cast<double>(files.size()),
                "reading headers"))
      return fail({Error::Code::kCancelled, folder.string(), "", "cancelled", "", ""});
    if (!internal::isDicom(f)) continue;
    KERF_TRY(h, internal::readVolumeHeader(f, VolumeFormat::kDicom));
    KERF_CHECK(checkOneValue(f, h));
    series.insert(h.series);
    slices.push_back({f, h, 0});
  }
  if (slices.empty())
    return fail({Error::Code::kUnsupported, folder.string(), "", "no slices",
                 "a DICOM series, or .png, .tif or .bmp slices", "the folder that holds the slices themselves"});
  if (series.size() > 1) {
    std::string uids;
    for (const std::string& s : series) uids += (uids.empty() ? "" : ", ") + s;
    return fail({Error::Code::kUnsupported, folder.string(), "",
                 fmt::format("{} series: {}", series.size(), uids.substr(0, 400)), "one",
                 "move the series you want into a folder of its own"});
  }
  Plan plan;
  plan.format = VolumeFormat::kDicom;
  Slice& first = slices.front();
  if (first.header.size.size() != 3)
    return fail({Error::Code::kUnsupported, first.path.string(), "", fmt::format("{} axes", first.header.size.size()),
                 "a slice", ""});
  if (slices.size() == 1 && first.header.size[2] > 1) {  // all frames in one file
    plan.files = {first.path};
    plan.header = first.header;
    KERF_CHECK(setGrid(first.path, first.header, plan));
  } else {
    if (slices.size() == 1)
      return fail({Error::Code::kEmpty, folder.string(), "", "one slice", "two or more", "export the whole series"});
    const auto column = [](const VolumeHeader& h, std::size_t a) {
      return Vec3d(h.direction[a], h.direction[3 + a], h.direction[6 + a]);
    };
    const Vec3d x = column(first.header, 0), y = column(first.header, 1), up = x.cross(y).normalized();
    for (Slice& s : slices) {
      const VolumeHeader& h = s.header;
      if (h.size != first.header.size || h.size[2] != 1 || h.type != first.header.type ||
          h.states_pixel_spacing != first.header.states_pixel_spacing || (column(h, 0) - x).norm() > 1e-3 ||
          (column(h, 1) - y).norm() > 1e-3 ||
          std::abs(h.spacing[0] - first.header.spacing[0]) > 1e-3 * first.header.spacing[0] ||
          std::abs(h.spacing[1] - first.header.spacing[1]) > 1e-3 * first.header.spacing[1])
        return fail({Error::Code::kUnsupported, s.path.string(), "", "a slice of another size, spacing or orientation",
                     "the same in all slices", "leave scout images and other series out of the folder"});
      s.height = up.dot(Vec3d(h.origin[0], h.origin[1], h.origin[2]));
    }
    std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) {
      return a.height != b.height ? a.height < b.height : a.path < b.path;
    });
    const auto last = slices.size() - 1;
    const double step = (slices[last].height - slices[0].height) / static_cast<double>(last);
    for (std::size_t i = 0; i < last; ++i) {
      const double gap = slices[i + 1].height - slices[i].height;
      // Positions are decimal strings, rounded: 2 % of a step is far above that and far below a missing slice.
      if (!(std::abs(gap - step) <= 0.02 * step + 1e-3) || !(gap > 1e-4))
        return fail({Error::Code::kBadValue, slices[i + 1].path.string(), "",
                     fmt::format("{:.4g} mm above {}", gap, slices[i].path.filename().string()),
                     fmt::format("evenly spaced slices, {:.4g} mm apart", step),
                     "export the series again: a slice is missing or there twice"});
    }
    plan.header = slices[0].header;
    plan.header.size.resize(2);
    VolumeHeader whole = slices[0].header;
    whole.size[2] = slices.size();
    whole.spacing[2] = step;
    // The slices may be shifted against each other (a tilted gantry): the third axis runs from slice to slice.
    const auto origin = [](const VolumeHeader& h) { return Vec3d(h.origin[0], h.origin[1], h.origin[2]); };
    const Vec3d rise = (origin(slices[last].header) - origin(slices[0].header)) / static_cast<double>(last);
    whole.spacing[2] = rise.norm();
    for (std::size_t row = 0; row < 3; ++row)
      whole.direction[3 * row + 2] = rise[static_cast<Eigen::Index>(row)] / rise.norm();
    KERF_CHECK(setGrid(folder, whole, plan));
    for (Slice& s : slices) plan.files.push_back(s.path);
  }
  const bool frames = plan.files.size() == 1;  // otherwise the positions of the slices say how far apart they are
  const bool pixel = first.header.states_pixel_spacing, frame = !frames || first.header.states_frame_spacing;
  if (!pixel || !frame) {
    if (pixel) plan.known_spacing.head<2>() = plan.grid.spacing.head<2>();
    if (frame) plan.known_spacing[2] = plan.grid.spacing[2];
    plan.unusable = pixel   ? "no spacing between the frames"
                    : frame ? "no pixel spacing"
                            : "no spacing, neither of pixels nor between the frames";
    if (frame) plan.unusable += fmt::format(" ({:.6g} mm along z)", plan.grid.spacing[2]);
    if (pixel)
      plan.unusable += fmt::format(" ({:.6g} and {:.6g} mm along x and y)", plan.grid.spacing[0], plan.grid.spacing[1]);
  } else if ((plan.grid.spacing.array() > 1e-6).all() && (plan.grid.spacing.array() < 1e6).all()) {
    plan.stated_spacing = plan.grid.spacing;
  } else {
    plan.unusable = "a spacing of " + text(plan.grid.spacing);
  }
  return plan;
}

Expected<Plan> planFor(const fs::path& path, const LabelReadOptions& options, const Progress& progress) {
  std::error_code ec;
  if (!fs::exists(path, ec))
    return fail({Error::Code::kNotFound, path.string(), "", "no such file or folder",
                 "a volume file, or a folder of slices", ""});
  if (!fs::is_directory(path, ec)) {
    if (const auto format = fileFormat(path)) return planFile(path, *format, options);
    return fail({Error::Code::kUnsupported, path.string(), "", "'" + path.extension().string() + "'",
                 ".nrrd, .nii, .nii.gz, .mha, .mhd, or a folder of slices",
                 "for DICOM or pictures give the folder they are in"});
  }
  KERF_TRY(files, filesOf(path));
  std::set<VolumeFormat> kinds;
  std::vector<fs::path> pictures;
  for (const fs::path& f : files)
    if (const auto kind = sliceFormat(f)) {
      kinds.insert(*kind);
      pictures.push_back(f);
    }
  if (kinds.size() > 1)
    return fail({Error::Code::kUnsupported, path.string(), "", "pictures of different formats", "one of PNG, TIFF, BMP",
                 "keep only the slices in the folder"});
  if (const auto dicom = std::find_if(files.begin(), files.end(), hasDicomMark);
      dicom != files.end() && !pictures.empty())
    return fail(
        {Error::Code::kUnsupported, path.string(), "",
         fmt::format("{} beside the DICOM file {}", pictures.front().filename().string(), dicom->filename().string()),
         "a DICOM series, or slices as pictures", "move the pictures (or the DICOM files) out of the folder"});
  if (!report(progress, 0, "trying the slices"))
    return fail({Error::Code::kCancelled, path.string(), "", "cancelled", "", ""});
  const bool are_pictures = kinds.size() == 1;
  if (!internal::survivesReading(are_pictures ? pictures : files, are_pictures ? *kinds.begin() : VolumeFormat::kDicom,
                                 options.max_bytes))
    return fail({Error::Code::kBadFormat, path.string(), "", "a slice that the library reading it can not bear",
                 "a folder of sound slices", "export the series again, and leave other files out of the folder"});
  if (are_pictures) return planSlices(path, std::move(pictures), *kinds.begin());
  return planDicom(path, files, progress);
}

Expected<void> chooseSpacing(const fs::path& path, const LabelReadOptions& options, Plan& plan) {
  if (options.spacing_mm) {
    const Vec3d given = *options.spacing_mm;
    for (int a = 0; a < 3; ++a)
      if (!isUsable(given[a]))
        return fail({Error::Code::kBadValue, path.string(), "spacing", text(given), "three numbers above 0, mm", ""});
    if (plan.stated_spacing) {
      if (((given - *plan.stated_spacing).array().abs() > 1e-3 * plan.stated_spacing->array()).any())
        return fail({Error::Code::kBadValue, path.string(), "spacing",
                     fmt::format("{} given, but the file says {} mm", text(given), text(*plan.stated_spacing)),
                     "one that agrees with the file", "leave the spacing out; if the file is wrong, correct the file"});
    } else {
      for (int a = 0; a < 3; ++a)
        if (isUsable(plan.known_spacing[a]) &&
            std::abs(given[a] - plan.known_spacing[a]) > 1e-3 * plan.known_spacing[a])
          return fail({Error::Code::kBadValue, path.string(), "spacing",
                       fmt::format("{} mm given along {}, but the file says {:.6g} mm", given[a], "xyz"[a],
                                   plan.known_spacing[a]),
                       "one that agrees with the file", "the file states none along the other axes: give those"});
      plan.grid.spacing = given;
      plan.grid.is_spacing_given = true;
    }
  } else if (!plan.stated_spacing) {
    return fail(noSpacing(path, plan.unusable));
  }
  LabelVolume& g = plan.grid;
  for (int a = 0; a < 3; ++a) {
    const double length = g.direction.col(a).norm();
    if (std::isfinite(length) && length > 1e-6) g.direction.col(a) /= length;
  }
  if (!g.direction.allFinite() || std::abs(g.direction.determinant()) < 0.1)
    return fail({Error::Code::kBadValue, path.string(), "direction", "axes that lie in one plane, or are not numbers",
                 "three independent directions", "save the volume again with a regular orientation"});
  if (!g.origin.allFinite() || g.origin.cwiseAbs().maxCoeff() > 1e6)
    return fail({Error::Code::kBadValue, path.string(), "origin", text(g.origin), "within 1 km of zero, mm", ""});
  return {};
}

Error notLabels(const fs::path& path, std::string place, std::string found) {
  return {Error::Code::kBadValue,
          path.string(),
          std::move(place),
          std::move(found) + ": these look like intensities",
          "labels: whole numbers, 0 to 65535, at most 256 different ones",
          "give `threshold = ...` in the recipe to make one label of all values from there on"};
}

// Share of neighbours along x, neither of them nothing, that have different labels.
double restless(const LabelVolume& v) {
  std::size_t pairs = 0, differ = 0;
  for (std::size_t row = 0; row < v.labels.size(); row += static_cast<std::size_t>(v.size[0]))
    for (std::size_t i = row + 1; i < row + static_cast<std::size_t>(v.size[0]); ++i)
      if (v.labels[i] && v.labels[i - 1]) {
        ++pairs;
        differ += v.labels[i] != v.labels[i - 1];
      }
  return pairs ? static_cast<double>(differ) / static_cast<double>(pairs) : 0;
}

// What became known of the values while they were made labels.
struct Values {
  std::optional<double> threshold;
  std::vector<char> seen = std::vector<char>(65536, 0);
  double highest = -std::numeric_limits<double>::infinity();
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
      continue;
    }
    const auto x = static_cast<double>(v);
    if (!(x >= 0 && x <= 65535) || x != std::floor(x)) {
      const std::size_t at = first + i, nx = static_cast<std::size_t>(grid.size[0]),
                        ny = static_cast<std::size_t>(grid.size[1]);
      return fail(notLabels(path, fmt::format("voxel ({}, {}, {})", at % nx, at / nx % ny, at / nx / ny),
                            fmt::format("the value {:g}", x)));
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

}  // namespace

double LabelVolume::voxelVolume() const { return std::abs(axes().determinant()); }

std::vector<LabelCount> countLabels(const LabelVolume& volume) {
  std::vector<std::uint64_t> count(65536, 0);
  for (const std::uint16_t l : volume.labels) ++count[l];
  std::vector<LabelCount> out;
  for (std::size_t l = 0; l < count.size(); ++l)
    if (count[l]) out.push_back({static_cast<std::uint16_t>(l), count[l]});
  return out;
}

Expected<LabelVolume> readLabelVolume(const fs::path& path, const LabelReadOptions& options, const Progress& progress) {
  if (options.threshold && !std::isfinite(*options.threshold))
    return fail({Error::Code::kBadValue, path.string(), "threshold", "not a finite number", "a number", ""});
  KERF_TRY(plan, planFor(path, options, progress));
  KERF_CHECK(chooseSpacing(path, options, plan));

  const std::uint64_t value_bytes = bytesOf(plan.header.type);
  double voxels = 1;
  for (const int s : plan.grid.size) voxels *= s;
  // While ITK decompresses, the values are there twice.
  const double per_voxel = plan.files.size() == 1 ? 2.0 * static_cast<double>(value_bytes) + 2 : 2;
  const double needed =
      voxels * per_voxel +
      (plan.files.size() > 1 ? voxels / static_cast<double>(plan.files.size()) * static_cast<double>(value_bytes) : 0);
  if (needed > static_cast<double>(options.max_bytes))
    return fail({Error::Code::kUnsupported, path.string(), "",
                 fmt::format("{} x {} x {} voxels, {:.1f} GB to read them", plan.grid.size[0], plan.grid.size[1],
                             plan.grid.size[2], needed / 1e9),
                 fmt::format("at most {:.1f} GB", static_cast<double>(options.max_bytes) / 1e9),
                 "crop the volume to the jaw, or save it with 8 or 16 bits per voxel"});
  const std::uint64_t available = options.available_bytes ? *options.available_bytes : internal::availableMemory();
  if (needed > 0.8 * static_cast<double>(available))
    return fail(
        {Error::Code::kUnsupported, path.string(), "",
         fmt::format("{} x {} x {} voxels, {:.1f} GB to read them", plan.grid.size[0], plan.grid.size[1],
                     plan.grid.size[2], needed / 1e9),
         fmt::format("at most 4/5 of the {:.1f} GB of memory that are free", static_cast<double>(available) / 1e9),
         "close other programs, crop the volume to the jaw, or save it with 8 or 16 bits per voxel"});
  LabelVolume volume = std::move(plan.grid);
  volume.format = nameOf(plan.format);
  try {
    volume.labels.resize(static_cast<std::size_t>(voxels));
    const std::size_t per_file = volume.labels.size() / plan.files.size();
    std::vector<std::byte> raw(per_file * value_bytes);
    Values values;
    values.threshold = options.threshold;
    for (std::size_t f = 0; f < plan.files.size(); ++f) {
      if (!report(progress, 0.2 + 0.8 * static_cast<double>(f) / static_cast<double>(plan.files.size()),
                  "reading voxels"))
        return fail({Error::Code::kCancelled, path.string(), "", "cancelled", "", ""});
      KERF_CHECK(internal::readVolumeValues(plan.files[f], plan.format, raw.data(), raw.size()));
      KERF_CHECK(toLabels(plan.header.type, plan.files[f], volume, raw.data(), per_file, values,
                          volume.labels.data() + f * per_file, f * per_file));
    }
    const auto different = static_cast<std::size_t>(std::count(values.seen.begin(), values.seen.end(), 1));
    if (different > kMostLabels) return fail(notLabels(path, "", fmt::format("{} different values", different)));
    // A segmentation has regions; in a picture of densities neighbours differ nearly everywhere.
    if (const double share = restless(volume); different > kFewLabels && share > kMostRestless)
      return fail(notLabels(
          path, "", fmt::format("{} different values, and {:.0f} % of neighbours differ", different, 100 * share)));
    if (options.threshold && values.highest < *options.threshold)
      return fail({Error::Code::kEmpty, path.string(), "threshold",
                   fmt::format("no value reaches {:g}; the highest is {:g}", *options.threshold, values.highest),
                   "a threshold inside the range of the values", ""});
  } catch (const std::bad_alloc&) {
    return fail({Error::Code::kUnsupported, path.string(), "", "more voxels than memory can hold", "a smaller volume",
                 "crop the volume to the jaw"});
  }
  return volume;
}

Expected<std::vector<fs::path>> filesOfVolume(const fs::path& path) {
  std::vector<fs::path> files{path};
  if (fileFormat(path) != VolumeFormat::kMetaImage) return files;
  KERF_TRY(stated, internal::checkVolumeHeader(path, VolumeFormat::kMetaImage));
  if (!stated.data_file.empty() && stated.data_file.filename() != path.filename()) files.push_back(stated.data_file);
  return files;
}

bool isLabelVolume(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_directory(path, ec)) return fileFormat(path).has_value();
  const auto files = filesOf(path);
  return files && std::any_of(files->begin(), files->end(),
                              [](const fs::path& f) { return sliceFormat(f).has_value() || hasDicomMark(f); });
}

}  // namespace kerf
