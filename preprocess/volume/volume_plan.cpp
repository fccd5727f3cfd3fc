#include "preprocess/volume/volume_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "preprocess/volume/dicom_pixels.h"
#include "preprocess/volume/slice_trial.h"
#include "preprocess/volume/tiff_strips.h"
#include "preprocess/volume/volume_names.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostAlongAxis = 1000000;  // voxels

tl::unexpected<Error> noSpacing(const fs::path& path, std::string found) {
  return fail({.code = Error::Code::kBadValue,
               .file = path.string(),
               .place = "spacing",
               .found = std::move(found),
               .expected = "mm per voxel along each axis",
               .hint = "give `spacing = [x, y, z]` in the recipe"});
}

Expected<void> requireAllValues(const fs::path& path, const VolumeHeader& header, const StatedHeader& stated) {
  double claimed = static_cast<double>(bytesOf(stated.type.value_or(header.type)));
  for (const auto s : header.size) claimed *= static_cast<double>(s);
  const double most = static_cast<double>(stated.stored_bytes) * stated.most_per_byte;
  if (!(claimed > most)) return {};
  return fail({.code = Error::Code::kBadFormat,
               .file = path.string(),
               .found = fmt::format("{} bytes of values", stated.stored_bytes),
               .expected = fmt::format("enough for the {:.0f} bytes its header claims", claimed),
               .hint = "copy the file again: it is cut short"});
}

Expected<VolumePlan> planFile(const fs::path& path, VolumeFormat format, const LabelReadOptions& options) {
  KERF_TRY(stated, checkVolumeHeader(path, format));
  VolumePlan plan;
  plan.format = format;
  plan.files = {path};
  plan.packed = stated.packed;
  // One bad number spoils them all: a program that wrote it did not know the others either.
  const auto wrong = std::find_if_not(stated.spacing.begin(), stated.spacing.end(), isUsableSpacing);
  if (stated.spacing.size() < 3)
    plan.unusable = "no spacing";
  else if (wrong != stated.spacing.end())
    plan.unusable = fmt::format("a spacing of {}", *wrong);
  if (!plan.unusable.empty() && !options.spacing_mm) return noSpacing(path, plan.unusable);

  KERF_TRY(header, readVolumeHeader(path, format));
  plan.header = header;
  KERF_CHECK(requireOneValue(path, header));
  KERF_CHECK(setGrid(path, header, plan));
  KERF_CHECK(requireAllValues(path, header, stated));
  plan.stored_type = stated.type.value_or(header.type);
  // Where ITK makes other values of those that are stored (NIfTI's slope), it reads them itself.
  plan.packed.is_plain = plan.packed.is_plain && plan.stored_type == header.type;

  if (!plan.unusable.empty()) return plan;
  const Vec3d& spacing = plan.grid.spacing;
  if (!(isUsableSpacing(spacing[0]) && isUsableSpacing(spacing[1]) && isUsableSpacing(spacing[2])))
    plan.unusable = "a spacing of " + textOf(spacing);
  else
    plan.stated_spacing = spacing;
  return plan;
}

// The header of one picture, of two axes.
Expected<VolumeHeader> readPictureHeader(const fs::path& file, VolumeFormat format) {
  KERF_TRY(h, readVolumeHeader(file, format));
  KERF_CHECK(requireOneValue(file, h));
  for (std::size_t a = 2; a < h.size.size(); ++a)
    if (h.size[a] != 1)
      return fail({.code = Error::Code::kUnsupported,
                   .file = file.string(),
                   .found = fmt::format("{} pages", h.size[a]),
                   .expected = "one slice per picture"});
  if (h.size.size() < 2)
    return fail(
        {.code = Error::Code::kBadFormat, .file = file.string(), .found = "no picture", .expected = "two axes"});
  h.size.resize(2);
  return std::move(h);
}

Expected<VolumePlan> planPictures(const fs::path& folder, std::vector<fs::path> files, VolumeFormat format) {
  VolumePlan plan;
  plan.format = format;
  plan.unusable = "pictures, which state no spacing in mm";

  for (const fs::path& f : files) {
    KERF_TRY(h, readPictureHeader(f, format));
    if (&f == &files.front()) {
      plan.header = h;
    } else if (h.size != plan.header.size || h.type != plan.header.type) {
      return fail({.code = Error::Code::kBadValue,
                   .file = f.string(),
                   .found = fmt::format("{} x {} pixels of {} bytes", h.size[0], h.size[1], bytesOf(h.type)),
                   .expected = fmt::format("{} x {} of {} bytes, as in {}", plan.header.size[0], plan.header.size[1],
                                           bytesOf(plan.header.type), files.front().filename().string()),
                   .hint = "keep only the slices of one volume in the folder"});
    }
  }

  const std::vector<std::uint64_t>& size = plan.header.size;
  if (size[0] > kMostAlongAxis || size[1] > kMostAlongAxis || size[0] < 1 || size[1] < 1)
    return fail({.code = Error::Code::kBadFormat,
                 .file = folder.string(),
                 .found = "slices of a size out of range",
                 .expected = "1 to 1000000 pixels"});
  plan.grid.size = {static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(files.size())};
  plan.files = std::move(files);
  return plan;
}

// Every TIFF picture is followed to the end of its strips. Takes 0 to 0.1 of the progress.
Expected<void> requireWholeTiffs(const std::vector<fs::path>& files, const Progress& progress) {
  for (std::size_t n = 0; n < files.size(); ++n) {
    const double done = 0.1 * static_cast<double>(n) / static_cast<double>(files.size());
    const Progress within = [&](double, std::string_view) { return report(progress, done, "trying the slices"); };
    if (!within(0, "")) return cancelled(files[n].string());
    KERF_CHECK(requireWholeStrips(files[n], within));
  }
  return {};
}

// Slices: pictures of one format, or a DICOM series.
Expected<VolumePlan> planFolder(const fs::path& folder, const LabelReadOptions& options, const Progress& progress) {
  KERF_TRY(files, filesOf(folder));
  std::set<VolumeFormat> kinds;
  std::vector<fs::path> pictures;
  for (const fs::path& f : files)
    if (const auto kind = sliceFormat(f)) {
      kinds.insert(*kind);
      pictures.push_back(f);
    }

  if (kinds.size() > 1)
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = "pictures of different formats",
                 .expected = "one of PNG, TIFF, BMP",
                 .hint = "keep only the slices in the folder"});
  if (const auto dicom = std::find_if(files.begin(), files.end(), hasDicomMark);
      dicom != files.end() && !pictures.empty())
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .found = fmt::format("{} beside the DICOM file {}", pictures.front().filename().string(),
                                      dicom->filename().string()),
                 .expected = "a DICOM series, or slices as pictures",
                 .hint = "move the pictures (or the DICOM files) out of the folder"});

  if (!report(progress, 0, "trying the slices")) return cancelled(folder.string());
  const bool are_pictures = kinds.size() == 1;
  if (!are_pictures)
    for (const fs::path& f : files)
      if (hasDicomMark(f)) KERF_CHECK(requireWholePixels(f));
  if (kinds.contains(VolumeFormat::kTiff)) KERF_CHECK(requireWholeTiffs(pictures, progress));
  KERF_TRY(survives,
           survivesReading(are_pictures ? pictures : files, are_pictures ? *kinds.begin() : VolumeFormat::kDicom,
                           options.max_bytes, progress));
  if (!survives)
    return fail({.code = Error::Code::kBadFormat,
                 .file = folder.string(),
                 .found = "a slice that crashes the reader library",
                 .expected = "a folder of sound slices",
                 .hint = "export the series again, and leave other files out of the folder"});
  if (are_pictures) return planPictures(folder, std::move(pictures), *kinds.begin());
  return planDicom(folder, files, progress);
}

// Uses the caller's spacing, if it does not contradict the file.
Expected<void> takeGivenSpacing(const fs::path& path, const Vec3d& given, VolumePlan& plan) {
  for (int a = 0; a < 3; ++a)
    if (!isUsableSpacing(given[a]))
      return fail({.code = Error::Code::kBadValue,
                   .file = path.string(),
                   .place = "spacing",
                   .found = textOf(given),
                   .expected = "three numbers above 0, mm"});

  if (plan.stated_spacing) {
    if (((given - *plan.stated_spacing).array().abs() > 1e-3 * plan.stated_spacing->array()).any())
      return fail(
          {.code = Error::Code::kBadValue,
           .file = path.string(),
           .place = "spacing",
           .found = fmt::format("{} given, but the file says {} mm", textOf(given), textOf(*plan.stated_spacing)),
           .expected = "one that agrees with the file",
           .hint = "leave the spacing out; if the file is wrong, correct the file"});
    return {};
  }

  for (int a = 0; a < 3; ++a)
    if (isUsableSpacing(plan.known_spacing[a]) &&
        std::abs(given[a] - plan.known_spacing[a]) > 1e-3 * plan.known_spacing[a])
      return fail({.code = Error::Code::kBadValue,
                   .file = path.string(),
                   .place = "spacing",
                   .found = fmt::format("{} mm given along {}, but the file says {:.6g} mm", given[a], "xyz"[a],
                                        plan.known_spacing[a]),
                   .expected = "one that agrees with the file",
                   .hint = "the file states none along the other axes: give those"});

  plan.grid.spacing = given;
  plan.grid.is_spacing_given = true;
  return {};
}

}  // namespace

bool isUsableSpacing(double spacing) { return std::isfinite(spacing) && spacing > 1e-6 && spacing < 1e6; }

std::string textOf(const Vec3d& v) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0], v[1], v[2]); }

Expected<void> requireOneValue(const fs::path& path, const VolumeHeader& h) {
  if (h.components == 1) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .found = fmt::format("{} values per voxel", h.components),
               .expected = "one: a label or an intensity",
               .hint = "export the labels as one channel; colours and vectors are none"});
}

Expected<void> setGrid(const fs::path& path, const VolumeHeader& h, VolumePlan& plan) {
  const std::size_t n = h.size.size();
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < n; ++a) axes.push_back(a);
  while (axes.size() > 3) {
    std::size_t drop = axes.size();
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (h.size[axes[i]] == 1 && (drop == axes.size() || i + 1 == axes.size())) drop = i;
    if (drop == axes.size())
      return fail({.code = Error::Code::kUnsupported,
                   .file = path.string(),
                   .found = fmt::format("{} axes of more than one voxel", axes.size()),
                   .expected = "three",
                   .hint = "export one time step or one layer of labels"});
    axes.erase(axes.begin() + static_cast<std::ptrdiff_t>(drop));
  }
  if (axes.size() < 3)
    return fail({.code = Error::Code::kUnsupported,
                 .file = path.string(),
                 .found = fmt::format("{} axes", axes.size()),
                 .expected = "a volume of three axes",
                 .hint = "put slices into a folder and give the folder"});

  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint64_t s = h.size[axes[i]];
    if (s < 1 || s > kMostAlongAxis)
      return fail({.code = Error::Code::kBadFormat,
                   .file = path.string(),
                   .found = fmt::format("{} voxels along an axis", s),
                   .expected = "1 to 1000000"});
    plan.grid.size[i] = static_cast<int>(s);

    const auto at = static_cast<Eigen::Index>(i);
    plan.grid.origin[at] = h.origin[axes[i]];
    plan.grid.spacing[at] = h.spacing[axes[i]];
    for (std::size_t row = 0; row < 3; ++row)
      plan.grid.direction(static_cast<Eigen::Index>(row), at) = h.direction[axes[row] * n + axes[i]];
  }
  return {};
}

Expected<VolumePlan> planVolume(const fs::path& path, const LabelReadOptions& options, const Progress& progress) {
  std::error_code ec;
  if (!fs::exists(path, ec))
    return fail({.code = Error::Code::kNotFound,
                 .file = path.string(),
                 .found = "no such file or folder",
                 .expected = "a volume file, or a folder of slices"});

  KERF_CHECK(loadVolumeReader());
  if (fs::is_directory(path, ec)) return planFolder(path, options, progress);
  if (const auto format = fileFormat(path)) return planFile(path, *format, options);
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .found = fmt::format("'{}'", path.extension().string()),
               .expected = ".nrrd, .nii, .nii.gz, .mha, .mhd, or a folder of slices",
               .hint = "for DICOM or pictures give the folder they are in"});
}

Expected<void> chooseSpacing(const fs::path& path, const LabelReadOptions& options, VolumePlan& plan) {
  if (options.spacing_mm) {
    KERF_CHECK(takeGivenSpacing(path, *options.spacing_mm, plan));
  } else if (!plan.stated_spacing) {
    return noSpacing(path, plan.unusable);
  }

  LabelVolume& g = plan.grid;
  for (int a = 0; a < 3; ++a) {
    const double length = g.direction.col(a).norm();
    if (std::isfinite(length) && length > 1e-6) g.direction.col(a) /= length;
  }

  if (!g.direction.allFinite() || std::abs(g.direction.determinant()) < 0.1)
    return fail({.code = Error::Code::kBadValue,
                 .file = path.string(),
                 .place = "direction",
                 .found = "axes that lie in one plane, or are not numbers",
                 .expected = "three independent directions",
                 .hint = "save the volume again with a regular orientation"});
  if (!g.origin.allFinite() || g.origin.cwiseAbs().maxCoeff() > 1e6)
    return fail({.code = Error::Code::kBadValue,
                 .file = path.string(),
                 .place = "origin",
                 .found = textOf(g.origin),
                 .expected = "within 1 km of zero, mm"});
  return {};
}

}  // namespace kerf::internal
