#include "preprocess/volume/label_volume.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <limits>
#include <random>

#include "tests/preprocess/label_volume_samples.h"
#include "tests/support/places.h"
#include "tests/support/temporary_file.h"
#include "tests/support/temporary_folder.h"

namespace kerf::label_volume_test {
namespace {

Expected<LabelVolume> readBytes(const std::string& name, const std::string& bytes, const LabelReadOptions& o = {}) {
  const TemporaryFile file(name, bytes);
  return readLabelVolume(file.path(), o);
}

std::vector<std::uint16_t> labelsOf(const LabelVolume& v) {
  std::vector<std::uint16_t> out;
  for (int k = 0; k < v.size[2]; ++k)
    for (int j = 0; j < v.size[1]; ++j)
      for (int i = 0; i < v.size[0]; ++i) out.push_back(v.at(i, j, k));
  return out;
}

void expectCounting(const Expected<LabelVolume>& v) {
  if (!v) throw std::runtime_error(v.error().message());
  EXPECT_EQ(v->size, (std::array<int, 3>{4, 3, 2}));
  const std::vector<std::uint16_t> labels = labelsOf(*v);
  ASSERT_EQ(labels.size(), 24u);
  for (std::uint16_t i = 0; i < 24; ++i) EXPECT_EQ(labels[i], i);
  EXPECT_EQ(v->at(3, 2, 1), 23);
}

void expectNear(const Vec3d& got, const Vec3d& wanted) { EXPECT_LT((got - wanted).norm(), 1e-5) << got.transpose(); }

std::string messageOf(const Expected<LabelVolume>& v) { return v ? "(it was read)" : v.error().message(); }
void expectRefusal(const Expected<LabelVolume>& v, const std::string& words) {
  EXPECT_NE(messageOf(v).find(words), std::string::npos) << messageOf(v);
}

LabelReadOptions spacing(double x, double y, double z) {
  LabelReadOptions o;
  o.spacing_mm = Vec3d(x, y, z);
  return o;
}

TEST(LabelVolume, NrrdKeepsSpacingOriginAndOrder) {
  const auto v = readBytes("a.nrrd", nrrd(std::string(kNrrdGrid) + kNrrdSpace, countingLabels()));
  expectCounting(v);
  expectNear(v->spacing, {0.5, 0.25, 2});
  expectNear(v->toWorld({1, 1, 1}), {1.5, 2.25, 5});
  EXPECT_NEAR(v->voxelVolume(), 0.25, 1e-12);
}

TEST(LabelVolume, NrrdInRasIsTurnedToLps) {
  const auto v = readBytes(
      "a.nrrd", nrrd(std::string(kNrrdGrid) + "space: right-anterior-superior\nspace directions: (0,0.5,0) (0.5,0,0) "
                                              "(0,0,2)\nspace origin: (1,2,3)\n",
                     countingLabels()));
  expectCounting(v);
  expectNear(v->toWorld({2, 0, 0}), {-1, -3, 3});
  EXPECT_LT(v->direction.determinant(), 0) << "x and y exchanged: a mirrored grid";
}

TEST(LabelVolume, MetaImageKeepsItsGrid) {
  const std::string grid = "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 0.5 0.25 2\n";
  const auto v = readBytes("a.mha", metaImage(grid, countingLabels()));
  expectCounting(v);
  expectNear(v->spacing, {0.5, 0.25, 2});
  expectNear(v->toWorld({2, 0, 0}), {1, 3, 3});
}

TEST(LabelVolume, NiftiIsTurnedToLps) {
  const auto v = readBytes("a.nii", nifti(countingLabels()));
  expectCounting(v);
  expectNear(v->spacing, {0.5, 0.25, 2});
  expectNear(v->toWorld({0, 0, 0}), {1, 2, 3});
  expectNear(v->toWorld({1, 1, 1}), {1.5, 2.25, 5});
}

TEST(LabelVolume, DicomSeriesIsSortedByPosition) {
  const TemporaryFolder folder;
  folder.write("a.dcm", dicomSlice(countingLabels().substr(12), 2));  // the upper slice first
  folder.write("b.dcm", dicomSlice(countingLabels().substr(0, 12), 0));
  folder.write("README.txt", "not a slice");
  const auto v = readLabelVolume(folder.path());
  expectCounting(v);
  expectNear(v->spacing, {0.5, 0.25, 2});
  expectNear(v->origin, {1, 2, 0});
  EXPECT_TRUE(isLabelVolume(folder.path()));
}

TEST(LabelVolume, DicomSeriesWithAMissingSliceOrASecondSeriesIsRefused) {
  const TemporaryFolder folder;
  for (const double z : {0.0, 2.0, 4.0, 8.0})
    folder.write("z" + std::to_string(z) + ".dcm", dicomSlice(countingLabels().substr(0, 12), z));
  expectRefusal(readLabelVolume(folder.path()), "a slice is missing or duplicate");
  folder.write("other.dcm", dicomSlice(countingLabels().substr(0, 12), 6, "9.9.9"));
  expectRefusal(readLabelVolume(folder.path()), "2 series");
}

TEST(LabelVolume, AMissingSliceIsNamedBetweenItsNeighbours) {
  for (const auto& [missing, count] : {std::pair{1, 10}, {2, 10}, {8, 10}, {1, 4}, {2, 4}}) {
    const TemporaryFolder folder;
    for (int k = 0; k < count; ++k)
      if (k != missing) folder.write(fmt::format("s{}.dcm", k), dicomSlice(countingLabels().substr(0, 12), 2.0 * k));
    const auto v = readLabelVolume(folder.path());
    ASSERT_FALSE(v);
    EXPECT_TRUE(v.error().file.ends_with(fmt::format("s{}.dcm", missing + 1))) << v.error().message();
    EXPECT_EQ(v.error().found, fmt::format("4 mm above s{}.dcm: 1 missing between them", missing - 1));
    EXPECT_EQ(v.error().expected, "evenly spaced slices, 2 mm apart");
  }
}

TEST(LabelVolume, AFolderOfFoldersNamesThoseThatHoldSlices) {
  const TemporaryFolder folder;
  const auto slice = [&](const std::string& name, double z) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    folder.write(name, dicomSlice(countingLabels().substr(0, 12), z));
  };
  slice("study/axial/a", 0);
  slice("study/axial/b", 2);
  slice("scout/a", 0);
  std::filesystem::create_directory(folder.path() / "notes");
  expectRefusal(readLabelVolume(folder.path()), "in its sub-folders: scout (1 slice), study/axial (2 slices)");
  const TemporaryFolder empty;
  EXPECT_EQ(textOfSliceFolders(empty.path()), "");
}

TEST(LabelVolume, LabelsAtTheFacesOfAVolumeAreNamed) {
  LabelVolume v;
  v.size = {4, 4, 4};
  for (int k = 0; k < 4; ++k) {
    std::vector<std::uint16_t> slice(16, 0);
    if (k == 1 || k == 2) slice[5] = 7;  // inside
    if (k == 1) slice[4] = 2;            // x = 0
    if (k == 3) slice[15] = 9;           // a corner
    v.addSlice(slice);
  }
  EXPECT_EQ(textOfCutLabels(v), "label 2 (x low), label 9 (x high, y high, z high)");
  const std::uint16_t inside[] = {7};
  EXPECT_EQ(textOfCutLabels(v, inside), "");
}

TEST(LabelVolume, DicomSlicesWithoutPixelSpacingNeedAGivenOne) {
  const TemporaryFolder folder;
  folder.write("a.dcm", dicomSlice(countingLabels().substr(0, 12), 0, "1.2.3", ""));
  folder.write("b.dcm", dicomSlice(countingLabels().substr(12), 2, "1.2.3", ""));
  expectRefusal(readLabelVolume(folder.path()), "no pixel spacing (2 mm along z)");
  const auto v = readLabelVolume(folder.path(), spacing(0.3, 0.3, 2));
  expectCounting(v);
  EXPECT_TRUE(v->is_spacing_given);
  expectNear(v->spacing, {0.3, 0.3, 2});
  expectRefusal(readLabelVolume(folder.path(), spacing(0.3, 0.3, 1)), "along z, but the file says 2 mm");
}

TEST(LabelVolume, DicomFramesInOneFileNeedASpacingBetweenThem) {
  for (const char* pixel : {"", "0.25\\0.5"}) {
    const TemporaryFolder folder;
    folder.write("a.dcm", dicomSlice(countingLabels(), 0, "1.2.3", pixel, 2));
    expectRefusal(readLabelVolume(folder.path()), "give `spacing = [x, y, z]` in the recipe");
    const auto v = readLabelVolume(folder.path(), spacing(0.5, 0.25, 3));
    expectCounting(v);
    expectNear(v->spacing, {0.5, 0.25, 3});
  }
}

TEST(LabelVolume, DicomFramesWithTheirSpacingNeedNone) {
  const TemporaryFolder folder;
  folder.write("a.dcm", dicomSlice(countingLabels(), 0, "1.2.3", "0.25\\0.5", 2, "3"));
  const auto v = readLabelVolume(folder.path());
  expectCounting(v);
  expectNear(v->spacing, {0.5, 0.25, 3});
  EXPECT_FALSE(v->is_spacing_given);
}

TEST(LabelVolume, DicomIsReadWithoutAWordFromTheLibrary) {
  const TemporaryFolder folder;
  folder.write("a.dcm", dicomSlice(countingLabels().substr(0, 12), 0));
  folder.write("b.dcm", dicomSlice(countingLabels().substr(12), 2));
  folder.write("notes.bin", std::string(128, '\0') + "DICM" + std::string(300, '\x37'));
  testing::internal::CaptureStderr();
  const auto v = readLabelVolume(folder.path());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  expectCounting(v);
}

TEST(LabelVolume, PicturesBesideDicomSlicesAreRefusedByName) {
  const TemporaryFolder folder;
  folder.write("a.dcm", dicomSlice(countingLabels().substr(0, 12), 0));
  folder.write("b.dcm", dicomSlice(countingLabels().substr(12), 2));
  folder.write("preview.png", greyPng(4, 3, countingLabels().substr(0, 12)));
  const auto v = readLabelVolume(folder.path(), spacing(0.5, 0.25, 2));
  expectRefusal(v, "preview.png beside the DICOM file a.dcm");
  expectRefusal(v, "move the pictures");
}

TEST(LabelVolume, NrrdUnitsOtherThanMillimetresAreRefusedByName) {
  const std::string grid = std::string(kNrrdGrid) + kNrrdSpace, plain = std::string(kNrrdGrid) + "spacings: 1 1 1\n";
  for (const char* fine : {"space units: \"mm\" \"mm\" \"mm\"\n", "space units: \"\" \"\" \"\"\n"})
    expectCounting(readBytes("a.nrrd", nrrd(grid + fine, countingLabels())));
  expectCounting(readBytes("a.nrrd", nrrd(plain + "units: \"mm\" \"mm\" \"mm\"\n", countingLabels())));
  expectRefusal(readBytes("a.nrrd", nrrd(grid + "space units: \"mm\" \"um\" \"um\"\n", countingLabels())), "'um'");
  expectRefusal(readBytes("a.nrrd", nrrd(plain + "units: \"cm\" \"cm\" \"cm\"\n", countingLabels())), "'cm'");
  expectRefusal(readBytes("a.nrrd", nrrd(plain + "units: m m m\n", countingLabels())), "'m'");
}

TEST(LabelVolume, MoreThanFreeMemoryIsRefusedAndSaysSo) {
  LabelReadOptions o;
  o.available_bytes = 74;  // 24 voxels: two bytes for the label of each, and a slice of 12 values of one byte
  const std::string bytes = nrrd(std::string(kNrrdGrid) + kNrrdSpace, countingLabels());
  expectRefusal(readBytes("a.nrrd", bytes, o), "4/5 of the");
  o.available_bytes = 76;
  expectCounting(readBytes("a.nrrd", bytes, o));
}

TEST(LabelVolume, HeadersOfSeveralFilesAreRefusedByName) {
  std::string meta = metaImage("ElementSpacing = 1 1 1\n", "");
  meta.resize(meta.find("ElementDataFile"));
  for (const char* data : {"LIST", "slice%03d.raw 1 2 1", "../a.raw"}) {
    const auto v = readBytes("a.mhd", meta + "ElementDataFile = " + data + "\n");
    expectRefusal(v, std::string("key ElementDataFile: '") + data + "'");
    expectRefusal(v, "save it as a single .mha");
  }
  expectRefusal(readBytes("a.mhd", meta + "ElementDataFile = gone.raw\n"), "'gone.raw' is not there");
  for (const char* key : {"data file: a.raw\n", "datafile: LIST\n"})
    expectRefusal(readBytes("a.nrrd", nrrd(std::string(kNrrdGrid) + kNrrdSpace + key, "")), "values in another file");
}

TEST(LabelVolume, PictureSlicesStackInNaturalOrder) {
  const TemporaryFolder folder;
  folder.write("slice-10.png", greyPng(4, 3, countingLabels().substr(12)));
  folder.write("slice-2.png", greyPng(4, 3, countingLabels().substr(0, 12)));
  expectRefusal(readLabelVolume(folder.path()), "give `spacing = [x, y, z]` in the recipe");
  const auto v = readLabelVolume(folder.path(), spacing(0.5, 0.5, 1));
  expectCounting(v);
  EXPECT_TRUE(v->is_spacing_given);
  folder.write("slice-11.png", greyPng(3, 4, countingLabels().substr(0, 12)));
  expectRefusal(readLabelVolume(folder.path(), spacing(0.5, 0.5, 1)), "slice-11.png");
}

TEST(LabelVolume, UnusableSpacingIsRefusedAndReplacedByAGivenOne) {
  for (const char* line : {"", "spacings: nan 1 1\n", "spacings: -1 1 1\n"}) {
    const std::string bytes = nrrd(std::string(kNrrdGrid) + line, countingLabels());
    expectRefusal(readBytes("a.nrrd", bytes), "give `spacing = [x, y, z]` in the recipe");
    const auto v = readBytes("a.nrrd", bytes, spacing(0.3, 0.4, 0.5));
    expectCounting(v);
    expectNear(v->spacing, {0.3, 0.4, 0.5});
  }
  expectRefusal(readBytes("a.nrrd", nrrd(std::string(kNrrdGrid) + "spacings: 0 1 1\n", countingLabels())),
                "give `spacing");
  expectRefusal(readBytes("a.mha", metaImage("", countingLabels())), "give `spacing = [x, y, z]`");
  expectRefusal(readBytes("a.nii", nifti(countingLabels(), 0)), "save it again with its voxel size");
  expectRefusal(readBytes("a.nii", nifti(countingLabels(), std::numeric_limits<float>::quiet_NaN())),
                "save it again with its voxel size");
}

TEST(LabelVolume, UsableSpacingIsNeverOverridden) {
  const std::string bytes = nrrd(std::string(kNrrdGrid) + "spacings: 0.5 0.25 2\n", countingLabels());
  expectRefusal(readBytes("a.nrrd", bytes, spacing(0.5, 0.5, 2)), "but the file says [0.5, 0.25, 2] mm");
  const auto v = readBytes("a.nrrd", bytes, spacing(0.5, 0.25, 2));
  expectCounting(v);
  EXPECT_FALSE(v->is_spacing_given);
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::infinity()})
    expectRefusal(readBytes("a.nrrd", bytes, spacing(bad, 1, 1)), "above 0");
}

TEST(LabelVolume, AxesOfOneVoxelAreDroppedAndRealFourDimensionsRefused) {
  const std::string head = "type: unsigned char\nencoding: raw\ndimension: 4\n";
  expectCounting(readBytes("a.nrrd", nrrd(head + "sizes: 1 4 3 2\nspacings: 1 0.5 0.25 2\n", countingLabels())));
  expectCounting(readBytes("a.nrrd", nrrd(head + "sizes: 4 3 2 1\nspacings: 0.5 0.25 2 1\n", countingLabels())));
  expectRefusal(readBytes("a.nrrd", nrrd(head + "sizes: 2 2 3 2\nspacings: 1 1 1 1\n", countingLabels())),
                "4 axes of more than one voxel");
}

TEST(LabelVolume, SeveralValuesPerVoxelAreRefused) {
  const std::string grid = "ElementSpacing = 1 1 1\nElementNumberOfChannels = 3\n";
  expectRefusal(readBytes("a.mha", metaImage(grid, std::string(72, '\1'))), "3 values per voxel");
}

std::string floatNrrd(const std::vector<float>& values) {
  std::string raw(values.size() * 4, '\0');
  std::memcpy(raw.data(), values.data(), raw.size());
  return nrrd("type: float\ndimension: 3\nsizes: " + std::to_string(values.size()) +
                  " 1 1\nendian: little\nencoding: raw\nspacings: 1 1 1\n",
              raw);
}

TEST(LabelVolume, WholeFloatsAreLabelsAndFractionsAreIntensities) {
  const auto v = readBytes("a.nrrd", floatNrrd({0, 1, 7}));
  ASSERT_TRUE(v) << v.error().message();
  EXPECT_EQ(labelsOf(*v), (std::vector<std::uint16_t>{0, 1, 7}));
  expectRefusal(readBytes("a.nrrd", floatNrrd({0, 1.5f})), "threshold = ");
  expectRefusal(readBytes("a.nrrd", floatNrrd({0, -1})), "threshold = ");
  expectRefusal(readBytes("a.nrrd", floatNrrd({0, std::numeric_limits<float>::quiet_NaN()})), "threshold = ");
  std::vector<float> many;
  for (int i = 0; i < 300; ++i) many.push_back(static_cast<float>(i));
  expectRefusal(readBytes("a.nrrd", floatNrrd(many)), "300 different values: these look like intensities");
}

TEST(LabelVolume, IntensitiesHaveAGridAndARange) {
  const TemporaryFile file("a.nrrd", floatNrrd({-1000, 1.5f, 3071, std::numeric_limits<float>::quiet_NaN()}));
  EXPECT_FALSE(readLabelVolume(file.path()));
  const auto summary = summariseVolume(file.path());
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->lowest, -1000);
  EXPECT_EQ(summary->highest, 3071);
  EXPECT_EQ(summary->grid.size[0] * summary->grid.size[1] * summary->grid.size[2], 4);
}

TEST(LabelVolume, ThresholdMakesOneLabelOfAllValuesFromThereOn) {
  LabelReadOptions o;
  o.threshold = 1.5;
  const auto v = readBytes("a.nrrd", floatNrrd({-1000, 1.4f, 1.5f, 3000, std::numeric_limits<float>::quiet_NaN()}), o);
  ASSERT_TRUE(v) << v.error().message();
  EXPECT_EQ(labelsOf(*v), (std::vector<std::uint16_t>{0, 0, 1, 1, 0}));
}

TEST(LabelVolume, AThresholdAboveEveryValueIsRefusedWithTheHighest) {
  LabelReadOptions o;
  o.threshold = 5000;
  expectRefusal(readBytes("a.nrrd", floatNrrd({-1000, 1.4f, 3000, std::numeric_limits<float>::quiet_NaN()}), o),
                "the highest is 3000");
}

TEST(LabelVolume, DensitiesInBytesAreNoLabelsButFortyRegionsAre) {
  std::vector<float> noise, regions;
  for (int i = 0; i < 4000; ++i) noise.push_back(static_cast<float>(i * 37 % 101));
  for (int i = 0; i < 4000; ++i) regions.push_back(static_cast<float>(i / 100));
  expectRefusal(readBytes("a.nrrd", floatNrrd(noise)), "neighbours differ: these look like intensities");
  EXPECT_TRUE(readBytes("a.nrrd", floatNrrd(regions)));
}

TEST(LabelVolume, FilesShorterThanTheirHeaderClaimsAreRefusedBeforeAllocating) {
  const std::string grid = std::string("type: unsigned char\ndimension: 3\nspacings: 1 1 1\n");
  expectRefusal(readBytes("a.nrrd", nrrd(grid + "encoding: raw\nsizes: 4 3 3\n", countingLabels())),
                "enough for the 36");
  expectRefusal(readBytes("a.nrrd", nrrd(grid + "encoding: gzip\nsizes: 9000 9000 9000\n", countingLabels())),
                "its header claims");
  LabelReadOptions small;
  small.max_bytes = 50;  // as above: 60
  expectRefusal(readBytes("a.nrrd", nrrd(std::string(kNrrdGrid) + "spacings: 1 1 1\n", countingLabels()), small),
                "crop the volume");
}

TEST(LabelVolume, ABzip2NrrdIsRefusedWithWhatToDo) {
  for (const char* name : {"bzip2", "bz2"}) {
    const auto v =
        readBytes("a.nrrd", nrrd(std::string("type: unsigned char\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\n") +
                                     "encoding: " + name + "\n",
                                 "BZh9 and more"));
    expectRefusal(v, "which no reader here unpacks");
    expectRefusal(v, "encoding: gzip");
    EXPECT_EQ(v.error().code, Error::Code::kUnsupported);
  }
}

// Compressed volumes of 4 x 3 x 2 counting labels: file name, bytes before the values, the values.
struct Compressed {
  std::string name, head, values;
};

std::string metaImageHead(std::size_t compressed_bytes) {
  return metaImage(
      "ElementSpacing = 1 1 1\nCompressedData = True\nCompressedDataSize = " + std::to_string(compressed_bytes) + "\n",
      "");
}

std::vector<Compressed> compressedVolumes() {
  const std::string gzip = compressed(countingLabels(), Stream::kGzip),
                    zlib = compressed(countingLabels(), Stream::kZlib);
  const std::string grid = "type: unsigned char\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\nencoding: gzip\n";
  return {{"a.nii.gz", "", compressed(nifti(countingLabels()), Stream::kGzip)},
          {"a.nrrd", nrrd(grid, ""), gzip},
          {"b.nrrd", nrrd(grid + "line skip: 1\nbyte skip: 352\n", "a line\n"),
           compressed(nifti(countingLabels()), Stream::kGzip)},
          {"a.mha", metaImageHead(zlib.size()), zlib},
          {"b.mha", metaImageHead(gzip.size()), gzip}};
}

TEST(LabelVolume, CompressedFilesAreReadWhole) {
  for (const auto& [name, head, values] : compressedVolumes()) {
    SCOPED_TRACE(name);
    expectCounting(readBytes(name, head + values));
    expectCounting(readBytes(name, head + values + "what follows"));
  }
  const std::string halves = compressed(nifti(countingLabels()).substr(0, 360), Stream::kGzip) +
                             compressed(countingLabels().substr(8), Stream::kGzip);
  expectCounting(readBytes("two-streams.nii.gz", halves));
}

// The values 256 i + 1, with two significant bytes, in either byte order, raw and compressed.
TEST(LabelVolume, BytesInEitherOrderAreReadAsTheHeaderSays) {
  for (const bool is_big : {false, true})
    for (const bool is_packed : {false, true}) {
      SCOPED_TRACE(std::string(is_big ? "big" : "little") + (is_packed ? ", compressed" : ", raw"));
      std::string raw;
      for (int i = 0; i < 24; ++i) {
        raw += static_cast<char>(is_big ? i : 1);
        raw += static_cast<char>(is_big ? 1 : i);
      }
      const auto expectLabels = [](const Expected<LabelVolume>& v) {
        ASSERT_TRUE(v) << v.error().message();
        for (std::size_t i = 0; i < 24; ++i) EXPECT_EQ(labelsOf(*v)[i], 256 * i + 1);
      };

      expectLabels(readBytes(
          "a.nrrd", nrrd(std::string("type: unsigned short\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\nendian: ") +
                             (is_big ? "big" : "little") + "\nencoding: " + (is_packed ? "gzip" : "raw") + "\n",
                         is_packed ? compressed(raw, Stream::kGzip) : raw)));

      const std::string values = is_packed ? compressed(raw, Stream::kZlib) : raw;
      std::string meta = metaImage(
          std::string("ElementSpacing = 1 1 1\nBinaryData = True\nBinaryDataByteOrderMSB = ") +
              (is_big ? "True" : "False") +
              (is_packed ? "\nCompressedData = True\nCompressedDataSize = " + std::to_string(values.size()) : "") +
              "\n",
          values);
      meta.replace(meta.find("MET_UCHAR"), 9, "MET_USHORT");
      expectLabels(readBytes("a.mha", meta));
    }
}

// A NIfTI file may hold values with a scale factor, which ITK applies.
TEST(LabelVolume, ScaledNiftiValuesAreScaled) {
  std::string bytes = nifti(countingLabels());
  put<float>(bytes, 112, 2);
  put<float>(bytes, 116, 3);
  for (const bool is_packed : {false, true}) {
    const auto v = is_packed ? readBytes("a.nii.gz", compressed(bytes, Stream::kGzip)) : readBytes("a.nii", bytes);
    ASSERT_TRUE(v) << v.error().message();
    for (std::size_t i = 0; i < 24; ++i) EXPECT_EQ(labelsOf(*v)[i], 2 * i + 3);
  }
}

TEST(LabelVolume, OfALineOnlyWhatLiesBetweenItsLabelsIsKept) {
  LabelVolume v;
  v.size = {100, 2, 3};
  std::vector<std::uint16_t> slice(200, 0);
  v.addSlice(slice);
  slice[140] = 7;
  slice[144] = 9;
  v.addSlice(slice);
  v.addSlice(std::vector<std::uint16_t>(200, 0));
  EXPECT_TRUE(v.slices[0].rows.empty() && v.slices[2].rows.empty());
  EXPECT_EQ(v.slices[1].labels, (std::vector<std::uint16_t>{7, 0, 0, 0, 9}));
  std::vector<std::uint16_t> expected(600, 0);
  expected[340] = 7;
  expected[344] = 9;
  EXPECT_EQ(labelsOf(v), expected);
  const std::vector<LabelCount> counts = countLabels(v);
  ASSERT_EQ(counts.size(), 3u);
  EXPECT_EQ(counts[0].voxels, 598u);
}

TEST(LabelVolume, CompressedFilesThatAreCutShortAreRefusedAtEveryByte) {
  testing::internal::CaptureStderr();
  for (const auto& [name, head, values] : compressedVolumes())
    for (std::size_t left = 0; left < values.size(); ++left) {
      SCOPED_TRACE(name + " with " + std::to_string(left) + " bytes of values");
      const auto v = readBytes(name, head + values.substr(0, left));
      ASSERT_FALSE(v);
      if (left > values.size() - 10) expectRefusal(v, "copy the file again: it is cut short");
    }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(LabelVolume, CompressedFilesWithOneByteChangedAreNeverReadWithOtherLabels) {
  testing::internal::CaptureStderr();
  for (const auto& [name, head, values] : compressedVolumes()) {
    const std::size_t least = name.ends_with(".gz") || head.find("352") != std::string::npos ? 60 : 20;
    std::size_t refused = 0;
    for (std::size_t at = 0; at < values.size(); ++at) {
      SCOPED_TRACE(name + ", byte " + std::to_string(at) + " of the values");
      std::string damaged = values;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
      const auto v = readBytes(name, head + damaged);
      if (v) expectCounting(v);  // a header has bytes without meaning, such as the time
      refused += !v;
    }
    EXPECT_GT(refused, least) << name;
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// Uncompressed volumes, and those with other compressions: file name, bytes before the values, the values.
std::vector<Compressed> otherVolumes() {
  const std::string grid = "type: unsigned char\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\n";
  std::string ascii, hex;
  for (const char c : countingLabels()) {
    ascii += fmt::format("{} ", static_cast<int>(c) + 100);
    hex += fmt::format("{:02x}", static_cast<int>(c));
  }
  return {{"raw.nrrd", nrrd(grid + "encoding: raw\n", ""), countingLabels()},
          {"skip.nrrd", nrrd(grid + "encoding: raw\nline skip: 1\nbyte skip: 3\n", "a line\nabc"), countingLabels()},
          {"ascii.nrrd", nrrd(grid + "encoding: ascii\n", ""), ascii},
          {"hex.nrrd", nrrd(grid + "encoding: hex\n", ""), hex},
          {"raw.nii", nifti(""), countingLabels()},
          {"raw.mha", metaImage("ElementSpacing = 1 1 1\n", ""), countingLabels()}};
}

TEST(LabelVolume, FilesOfEveryEncodingThatAreCutShortAreRefusedAtEveryByte) {
  for (const auto& [name, head, values] : otherVolumes()) {
    EXPECT_TRUE(readBytes(name, head + values)) << name;
    const std::size_t last = name == "ascii.nrrd" ? 4 : 0;  // a number without its last digit is a different number
    for (std::size_t left = 0; left + last < values.size(); ++left) {
      SCOPED_TRACE(name + " with " + std::to_string(left) + " bytes of values");
      EXPECT_FALSE(readBytes(name, head + values.substr(0, left)));
    }
  }
}

// GDCM returns uninitialised memory for missing pixels.
TEST(LabelVolume, DicomFilesThatAreCutShortAreRefusedAtEveryByteOfTheirPixels) {
  const std::string lower = dicomSlice(countingLabels().substr(0, 12), 0),
                    upper = dicomSlice(countingLabels().substr(12), 2),
                    frames = dicomSlice(countingLabels(), 0, "1.2.3", "0.25\\0.5", 2, "3");
  for (std::size_t left = 0; left < 24; ++left) {
    SCOPED_TRACE(std::to_string(left) + " bytes of pixels");
    if (left < 12) {
      const TemporaryFolder series;
      series.write("a.dcm", lower);
      series.write("b.dcm", upper.substr(0, upper.size() - 12 + left));
      expectRefusal(readLabelVolume(series.path()),
                    fmt::format("b.dcm: {} bytes of pixels; expected 12, as it claims", left));
    }
    const TemporaryFolder folder;
    folder.write("a.dcm", frames.substr(0, frames.size() - 24 + left));
    expectRefusal(readLabelVolume(folder.path()),
                  fmt::format("a.dcm: {} bytes of pixels; expected 24, as it claims", left));
  }
}

// A length of 1.4 GB in a file of 568 bytes: neither the program nor the process that tries the slices allocates it.
TEST(LabelVolume, LengthsInDicomFilesAreNotTakenAsMemory) {
  const std::filesystem::path seed =
      std::filesystem::path(kSourceFolder) / "tests/data/fuzz/label_slices/a-length-of-gigabytes";
  std::ifstream in(seed, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_GT(bytes.size(), 500u);
  const TemporaryFolder folder;
  folder.write("a.dcm", bytes.substr(1));
  EXPECT_FALSE(readLabelVolume(folder.path()));
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  EXPECT_LT(used.ru_maxrss, 1000 << 10) << "kB";
}

TEST(LabelVolume, DicomFilesWithFewerPixelsThanRowsAndColumnsSayAreRefused) {
  const TemporaryFolder folder;
  folder.write("a.dcm", dicomSlice(countingLabels().substr(0, 12), 0));
  folder.write("b.dcm", dicomSlice(countingLabels().substr(12, 10), 2));
  expectRefusal(readLabelVolume(folder.path()), "b.dcm: 10 bytes of pixels; expected 12: 4 x 3 in 1 frames");
}

TEST(LabelVolume, DicomFilesThatAreCutShortBeforeTheirPixelsAreRefused) {
  const std::string lower = dicomSlice(countingLabels().substr(0, 12), 0),
                    upper = dicomSlice(countingLabels().substr(12), 2);
  for (std::size_t left = 132; left + 12 < upper.size(); ++left) {
    SCOPED_TRACE(std::to_string(left) + " bytes");
    const TemporaryFolder folder;
    folder.write("a.dcm", lower);
    folder.write("b.dcm", upper.substr(0, left));
    EXPECT_FALSE(readLabelVolume(folder.path()));
  }
}

// Pixels in fragments (PS3.5, annex A.4), run-length encoded (annex G): a table of offsets, one fragment, the end.
TEST(LabelVolume, DicomFilesWithCompressedPixelsAreReadWholeOrRefused) {
  const auto number = [](std::uint32_t v) {
    std::string s(4, '\0');
    put(s, 0, v);
    return s;
  };
  const auto runLengths = [&](const std::string& values) {
    const std::string item("\xfe\xff\x00\xe0", 4), end("\xfe\xff\xdd\xe0\0\0\0\0", 8);
    std::string segment(1, static_cast<char>(values.size() - 1));
    segment += values;
    if (segment.size() % 2) segment += '\0';
    std::string header = number(1) + number(64);
    header.resize(64, '\0');
    return item + number(0) + item + number(static_cast<std::uint32_t>(64 + segment.size())) + header + segment + end;
  };
  const auto slice = [&](const std::string& values, double z) {
    std::string bytes = dicomSlice(values, z);
    const std::string plain("1.2.840.10008.1.2.1\0", 20), packed = "1.2.840.10008.1.2.5";
    bytes.replace(bytes.find(plain), 20, packed + '\0');
    bytes.resize(bytes.size() - 12);
    bytes.replace(bytes.size() - 4, 4, "\xff\xff\xff\xff");
    return bytes + runLengths(values);
  };

  const std::string lower = slice(countingLabels().substr(0, 12), 0), upper = slice(countingLabels().substr(12), 2);
  const TemporaryFolder whole;
  whole.write("a.dcm", lower);
  whole.write("b.dcm", upper);
  expectCounting(readLabelVolume(whole.path()));

  const std::size_t pixels = runLengths(countingLabels().substr(12)).size();
  for (std::size_t left = 0; left < pixels; ++left) {
    SCOPED_TRACE(std::to_string(left) + " bytes of pixels");
    const TemporaryFolder folder;
    folder.write("a.dcm", lower);
    folder.write("b.dcm", upper.substr(0, upper.size() - pixels + left));
    expectRefusal(readLabelVolume(folder.path()), fmt::format("pixels that break off after {} bytes", left));
  }
}

// Layout of a TIFF picture.
struct TiffWriting {
  std::uint16_t compression = 1;  // none; 8 and 32946 deflate, 32773 PackBits
  std::size_t rows_per_strip = 3;
  bool is_big_endian = false, is_big_tiff = false, is_in_tiles = false;
};
constexpr std::uint16_t kTiffDeflate = 8, kTiffOldDeflate = 32946, kTiffPackBits = 32773;

// A 4 x 3 slice of 8 bits: its directory, then its strips.
struct TiffSlice {
  std::string head, strips;
  std::string bytes() const { return head + strips; }
};

TiffSlice tiff(const std::string& values, const TiffWriting& writing = {}) {
  constexpr std::size_t kColumns = 4, kRows = 3, kEntries = 9;
  const auto number = [&](std::uint64_t value, std::size_t bytes) {
    std::string s;
    for (std::size_t i = 0; i < bytes; ++i)
      s += static_cast<char>(value >> (8 * (writing.is_big_endian ? bytes - 1 - i : i)));
    return s;
  };
  const auto packed = [&](const std::string& rows) {
    if (writing.compression == kTiffDeflate || writing.compression == kTiffOldDeflate)
      return compressed(rows, Stream::kZlib);
    if (writing.compression != kTiffPackBits) return rows;
    std::string runs;
    for (std::size_t at = 0; at < rows.size(); at += kColumns)
      runs += static_cast<char>(kColumns - 1) + rows.substr(at, kColumns);
    return runs;
  };

  std::vector<std::string> strips;
  for (std::size_t row = 0; row < kRows; row += writing.rows_per_strip)
    strips.push_back(packed(values.substr(kColumns * row, kColumns * writing.rows_per_strip)));

  // Layout: header, directory, the two lists if an entry is too small for them, strips.
  const std::size_t word = writing.is_big_tiff ? 8 : 4, header = writing.is_big_tiff ? 16 : 8;
  const std::size_t directory = writing.is_big_tiff ? 8 + 20 * kEntries + 8 : 2 + 12 * kEntries + 4;
  const std::size_t list = 4 * strips.size(), lists = header + directory;
  std::size_t at = lists + (list > word ? 2 * list : 0);
  std::string offsets, counts;
  for (const std::string& strip : strips) {
    offsets += number(at, 4);
    counts += number(strip.size(), 4);
    at += strip.size();
  }

  constexpr int kShort = 3, kLong = 4;
  const auto entry = [&](int tag, int type, std::size_t count, std::string value) {
    value.resize(word, '\0');
    return number(static_cast<std::uint64_t>(tag), 2) + number(static_cast<std::uint64_t>(type), 2) +
           number(count, word) + value;
  };
  const auto listed = [&](int tag, const std::string& numbers, std::size_t place) {
    return entry(tag, kLong, strips.size(), list > word ? number(place, word) : numbers);
  };
  TiffSlice out;
  out.head = writing.is_big_endian ? "MM" : "II";
  out.head += writing.is_big_tiff ? number(43, 2) + number(8, 2) + number(0, 2) : number(42, 2);
  out.head += number(header, word);
  out.head += number(kEntries, writing.is_big_tiff ? 8 : 2);
  out.head += entry(256, kLong, 1, number(kColumns, 4)) + entry(257, kLong, 1, number(kRows, 4));
  out.head += entry(258, kShort, 1, number(8, 2)) + entry(259, kShort, 1, number(writing.compression, 2));
  out.head += entry(262, kShort, 1, number(1, 2)) + listed(273, offsets, lists);
  out.head += entry(277, kShort, 1, number(1, 2));
  if (writing.is_in_tiles)
    out.head += listed(324, offsets, lists) + listed(325, counts, lists + list);
  else
    out.head += entry(278, kLong, 1, number(writing.rows_per_strip, 4)) + listed(279, counts, lists + list);
  out.head += number(0, word);
  if (list > word) out.head += offsets + counts;
  for (const std::string& strip : strips) out.strips += strip;
  return out;
}

// A folder of two slices: the lower one is sound.
Expected<LabelVolume> readTiffs(const std::string& lower, const std::string& upper) {
  const TemporaryFolder folder;
  folder.write("a.tif", lower);
  folder.write("b.tif", upper);
  return readLabelVolume(folder.path(), spacing(0.5, 0.5, 1));
}

TEST(LabelVolume, TiffSlicesAreReadInEveryWriting) {
  for (const TiffWriting& writing :
       {TiffWriting{}, TiffWriting{.rows_per_strip = 2}, TiffWriting{.is_big_endian = true},
        TiffWriting{.compression = kTiffDeflate}, TiffWriting{.compression = kTiffOldDeflate},
        TiffWriting{.compression = kTiffDeflate, .rows_per_strip = 1, .is_big_endian = true},
        TiffWriting{.compression = kTiffDeflate, .is_big_tiff = true},
        TiffWriting{.compression = kTiffDeflate, .rows_per_strip = 1, .is_big_tiff = true},
        TiffWriting{.compression = kTiffPackBits}}) {
    SCOPED_TRACE(fmt::format("compression {}, {} rows in a strip", writing.compression, writing.rows_per_strip));
    expectCounting(readTiffs(tiff(countingLabels().substr(0, 12), writing).bytes(),
                             tiff(countingLabels().substr(12), writing).bytes()));
  }
  const std::string tiles = tiff(countingLabels().substr(0, 12), {.is_in_tiles = true}).bytes();
  expectRefusal(readTiffs(tiles, tiles), "a.tif: a picture in tiles");
}

// libtiff has all values before it reaches the checksum and would ignore it.
TEST(LabelVolume, DeflatedTiffSlicesWithOneBitChangedAreNeverReadWithOtherLabels) {
  testing::internal::CaptureStderr();
  const TiffWriting deflate{.compression = kTiffDeflate};
  const std::string lower = tiff(countingLabels().substr(0, 12), deflate).bytes();
  const TiffSlice upper = tiff(countingLabels().substr(12), deflate);
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * upper.strips.size(); ++bit) {
    SCOPED_TRACE(fmt::format("bit {}", bit));
    std::string damaged = upper.strips;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const auto v = readTiffs(lower, upper.head + damaged);
    if (v)
      expectCounting(v);  // padding bits of the last byte have no meaning
    else
      expectRefusal(v, "b.tif: strip 1 of 1");
    refused += !v;
  }
  EXPECT_GT(refused + 16, 8 * upper.strips.size());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(LabelVolume, TiffSlicesThatAreCutShortAreRefusedByNameAtEveryByte) {
  testing::internal::CaptureStderr();
  for (const TiffWriting& writing :
       {TiffWriting{}, TiffWriting{.compression = kTiffDeflate}, TiffWriting{.compression = kTiffPackBits},
        TiffWriting{.compression = kTiffDeflate, .rows_per_strip = 2, .is_big_tiff = true}}) {
    const std::string lower = tiff(countingLabels().substr(0, 12), writing).bytes();
    const TiffSlice upper = tiff(countingLabels().substr(12), writing);
    for (std::size_t left = 0; left < upper.bytes().size(); ++left) {
      SCOPED_TRACE(fmt::format("compression {}, {} bytes", writing.compression, left));
      const auto v = readTiffs(lower, upper.bytes().substr(0, left));
      expectRefusal(v, "b.tif: ");
      if (left >= upper.head.size()) expectRefusal(v, "copy the file again: it is cut short");
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(LabelVolume, DeflatedTiffStripsWithFewerValuesThanTheirPictureAreRefused) {
  TiffSlice few = tiff(countingLabels().substr(0, 5) + std::string(7, '\0'), {.compression = kTiffDeflate});
  const std::string five = compressed(countingLabels().substr(0, 5), Stream::kZlib);
  few.strips = five + std::string(few.strips.size() - std::min(few.strips.size(), five.size()), '\0');
  expectRefusal(readTiffs(few.bytes(), few.bytes()), "strip 1 of 1: 5 bytes of values, unpacked; expected 12");
}

// Without a checksum, only contradictions are found. Kerf reports libtiff's message.
TEST(LabelVolume, PackBitsThatEndTooSoonAreRefusedWithoutAWordFromTheLibrary) {
  const TiffWriting runs{.compression = kTiffPackBits};
  const std::string lower = tiff(countingLabels().substr(0, 12), runs).bytes();
  TiffSlice upper = tiff(countingLabels().substr(12), runs);
  upper.strips[10] = 2;  // the last row has three values; the fourth would be the length of a missing run
  testing::internal::CaptureStderr();
  const auto v = readTiffs(lower, upper.bytes());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  expectRefusal(v, "b.tif");
}

// libpng checks the checksum of every part.
TEST(LabelVolume, PngSlicesWithOneBitChangedAreNeverReadWithOtherLabels) {
  const std::string lower = greyPng(4, 3, countingLabels().substr(0, 12)),
                    upper = greyPng(4, 3, countingLabels().substr(12));
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * upper.size(); bit += 7) {
    SCOPED_TRACE(fmt::format("bit {}", bit));
    std::string damaged = upper;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const TemporaryFolder folder;
    folder.write("a.png", lower);
    folder.write("b.png", damaged);
    const auto v = readLabelVolume(folder.path(), spacing(0.5, 0.5, 1));
    if (v) expectCounting(v);
    refused += !v;
  }
  EXPECT_GT(2 * refused, upper.size());  // of 8/7 as many; bytes after the values are not read
}

TEST(LabelVolume, CompressedFilesSayWhatIsWrongWithThem) {
  const std::string volume = compressed(nifti(countingLabels()), Stream::kGzip);
  expectRefusal(readBytes("a.nii.gz", volume.substr(0, volume.size() - 8)), "values that break off after 376 bytes");
  std::string wrong_sum = volume;
  wrong_sum[wrong_sum.size() - 8] = static_cast<char>(wrong_sum[wrong_sum.size() - 8] + 1);
  expectRefusal(readBytes("a.nii.gz", wrong_sum), "compressed bytes that are damaged");
  expectRefusal(readBytes("a.nii.gz", compressed(nifti(countingLabels().substr(0, 14)), Stream::kGzip)),
                "14 bytes of values, unpacked; expected 24, as its header claims");

  // Longer than the part read for the header.
  std::string large = nifti(std::string(90 * 90 * 90, '\1'));
  for (std::size_t axis = 0; axis < 3; ++axis) put<std::int16_t>(large, 42 + 2 * axis, 90);
  std::mt19937 random(20261122);
  for (std::size_t i = 352; i < large.size(); ++i) large[i] = static_cast<char>(random() % 4);
  std::string packed = compressed(large, Stream::kGzip);
  EXPECT_TRUE(readBytes("a.nii.gz", packed));
  expectRefusal(readBytes("a.nii.gz", packed.substr(0, packed.size() / 2)), "values that break off after");
  packed[packed.size() - 8] = static_cast<char>(packed[packed.size() - 8] + 1);
  expectRefusal(readBytes("a.nii.gz", packed), "damaged after 729352 bytes (incorrect data check)");

  const std::string values = compressed(countingLabels(), Stream::kZlib);
  expectRefusal(readBytes("a.mha", metaImageHead(values.size()) + values.substr(0, values.size() - 1)),
                fmt::format("{} bytes of compressed values; expected {}", values.size() - 1, values.size()));
  expectRefusal(readBytes("a.mha", metaImage("ElementSpacing = 1 1 1\nCompressedData = True\n", values)),
                "key CompressedDataSize: it is not there");
  const std::string few = compressed(countingLabels().substr(0, 5), Stream::kZlib);
  expectRefusal(readBytes("a.mha", metaImageHead(few.size()) + few), "5 bytes of values, unpacked; expected 24");
}

TEST(LabelVolume, MetaImageWithItsValuesCompressedBesideItIsRefusedByTheNameOfThatFile) {
  const std::string values = compressed(countingLabels(), Stream::kZlib);
  std::string head = metaImageHead(values.size());
  head.replace(head.find("LOCAL"), 5, "a.zraw");
  const TemporaryFolder folder;
  folder.write("a.mhd", head);
  folder.write("a.zraw", values);
  expectCounting(readLabelVolume(folder.path() / "a.mhd"));
  std::string damaged = values;
  damaged.back() = static_cast<char>(damaged.back() + 1);
  folder.write("a.zraw", damaged);
  expectRefusal(readLabelVolume(folder.path() / "a.mhd"), "a.zraw: compressed values that are damaged");
}

TEST(LabelVolume, MetaImageInTextIsReadWholeOrRefused) {
  const std::string fields = "ElementSpacing = 1 1 1\nBinaryData = False\n";
  std::string numbers;
  for (int i = 0; i < 24; ++i) numbers += std::to_string(i) + (i % 5 ? " " : "\n");
  expectCounting(readBytes("a.mha", metaImage(fields, numbers)));
  expectRefusal(readBytes("a.mha", metaImage(fields, numbers.substr(0, numbers.size() - 3))),
                "23 values; expected 24, as its header claims");
}

// ITK ignores keys in other letter case: it would use a spacing of 1 mm and read compressed bytes as labels. Found by
// fuzzing: MetaIO copied a type name of 300 bytes into 255, and ended the program.
TEST(LabelVolume, WordsOfMetaImageThatItsReaderHasNoRoomForAreRefused) {
  const std::string spacing = "ElementSpacing = 1 1 1\n", many(255, 'x');
  for (const char* key : {"ObjectSubType", "Comment", "Name", "AcquisitionDate", "Sender"})
    expectRefusal(readBytes("a.mha", metaImage(spacing + key + " = " + many + "\n", countingLabels())),
                  "a word of 255 bytes; expected at most 254");
  expectRefusal(readBytes("a.mha", metaImage(spacing + many + " = 1\n", countingLabels())), "a word of 255 bytes");
  expectCounting(readBytes("a.mha", metaImage(spacing + "Comment = " + many.substr(1) + "\n", countingLabels())));
}

TEST(LabelVolume, KeysOfMetaImageInOtherLettersAreRefusedByName) {
  expectRefusal(readBytes("a.mha", metaImage("elementspacing = 0.5 0.5 0.5\n", countingLabels())),
                "line 4: key 'elementspacing'; expected 'ElementSpacing'");
  const std::string fields = "ElementSpacing = 1 1 1\nCOMPRESSEDDATA = True\n";
  expectRefusal(readBytes("a.mha", metaImage(fields, compressed(countingLabels(), Stream::kZlib))),
                "key 'COMPRESSEDDATA'; expected 'CompressedData'");
}

TEST(LabelVolume, BytesThatMetaImageSkipsAreNotCountedAsValues) {
  const std::string head = metaImage("ElementSpacing = 1 1 1\nHeaderSize = 999\n", "");
  expectRefusal(readBytes("a.mha", head + countingLabels()), "0 bytes of values; expected enough for the 24");
}

TEST(LabelVolume, LongFieldsAreRefusedButNotLongNotes) {
  const std::string grid = std::string(kNrrdGrid) + kNrrdSpace;
  EXPECT_TRUE(readBytes(
      "a.nrrd",
      nrrd("# " + std::string(3000, 'x') + "\nnote:=" + std::string(3000, 'x') + "\n" + grid, countingLabels())));
  expectRefusal(readBytes("a.nrrd", nrrd(grid + "content: " + std::string(3000, 'x') + "\n", countingLabels())),
                "a field of at most 500 bytes");
}

TEST(LabelVolume, SingularDirectionsAreRefused) {
  expectRefusal(readBytes("a.nrrd", nrrd(std::string(kNrrdGrid) +
                                             "space: left-posterior-superior\nspace directions: (1,0,0) (1,0,0) "
                                             "(0,0,2)\nspace origin: (1,2,3)\n",
                                         countingLabels())),
                "a.nrrd");
}

TEST(LabelVolume, WhatIsNoVolumeIsRefusedByName) {
  expectRefusal(readLabelVolume("/nonexistent/a.nrrd"), "no such file");
  expectRefusal(readBytes("a.stl", "solid"), "'.stl'");
  const TemporaryFolder empty;
  expectRefusal(readLabelVolume(empty.path()), "no slices");
  EXPECT_FALSE(isLabelVolume(empty.path()));
  EXPECT_FALSE(isLabelVolume("a.stl"));
}

TEST(LabelVolume, CancellingStopsReading) {
  const TemporaryFile file("a.nrrd", nrrd(std::string(kNrrdGrid) + kNrrdSpace, countingLabels()));
  const auto v = readLabelVolume(file.path(), {}, [](double, std::string_view) { return false; });
  ASSERT_FALSE(v);
  EXPECT_EQ(v.error().code, Error::Code::kCancelled);
}

// Each format 600 times (slices, each tried in a separate process, 100), with bytes changed, cut off or doubled, most
// of them in the header: read or refused.
TEST(LabelVolume, MutatedFilesAreReadOrRefused) {
  const std::vector<std::pair<std::string, std::string>> seeds{
      {"a.nrrd", nrrd(std::string(kNrrdGrid) + kNrrdSpace, countingLabels())},
      {"a.mha", metaImage("Offset = 1 2 3\nElementSpacing = 1 1 1\n", countingLabels())},
      {"a.nii", nifti(countingLabels())},
      {"a.dcm", dicomSlice(countingLabels().substr(0, 12), 0)},
      {"a.png", greyPng(4, 3, countingLabels().substr(0, 12))},
      {"a.tif", tiff(countingLabels().substr(0, 12), {.compression = kTiffDeflate}).bytes()}};

  const TemporaryFolder folder;
  LabelReadOptions given = spacing(1, 1, 1);
  given.max_bytes = 64 << 20;
  for (std::size_t f = 0; f < seeds.size(); ++f) {
    const auto& [name, seed] = seeds[f];
    std::mt19937 random(static_cast<unsigned>(20261121 + f));
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
    int read = 0, refused = 0;
    for (int round = 0; round < (f < 3 ? 600 : 100); ++round) {
      std::string bytes = seed;
      const std::size_t changes = 1 + below(4);
      for (std::size_t c = 0; c < changes && !bytes.empty(); ++c) {
        const std::size_t at = below(bytes.size());
        switch (below(6)) {
          case 0:
            bytes.resize(at);
            break;
          case 1:
            bytes.insert(at, bytes.substr(at, 1 + below(20)));
            break;
          case 2:
            bytes.erase(at, 1 + below(8));
            break;
          case 3:
            bytes[at] = static_cast<char>(below(2) ? 255 : '9');
            break;
          default:
            bytes[at] = static_cast<char>(random());
            break;
        }
      }

      const bool slices = f >= 3;
      const TemporaryFolder own;
      own.write(name, bytes);
      if (slices) own.write("b" + name, f == 3 ? dicomSlice(countingLabels().substr(12), 2) : seed);
      const auto v = readLabelVolume(slices ? own.path() : own.path() / name, round % 2 ? given : LabelReadOptions{});

      if (v) {
        ++read;
        std::size_t voxels = 1;
        for (const int s : v->size) voxels *= static_cast<std::size_t>(s);
        std::uint64_t counted = 0;
        for (const LabelCount& c : countLabels(*v)) counted += c.voxels;
        EXPECT_EQ(counted, voxels);
        EXPECT_TRUE((v->spacing.array() > 0).all() && v->spacing.allFinite() && v->origin.allFinite());
        EXPECT_GT(v->voxelVolume(), 0);
      } else {
        ++refused;
        EXPECT_FALSE(v.error().message().empty());
      }
    }

    // PNG checksums find every change; TIFF deflate checksums all but a few.
    EXPECT_GT(read, f > 3 ? -1 : 0) << name;
    EXPECT_GT(refused, f < 3 ? 50 : 10) << name;
  }
}

}  // namespace
}  // namespace kerf::label_volume_test
