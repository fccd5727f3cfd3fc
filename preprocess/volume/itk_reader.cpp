// The only source that includes ITK, in the separate library kerf_volumes.so.
#include "preprocess/volume/itk_reader.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>
#include <itkBMPImageIO.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkPNGImageIO.h>
#include <itkTIFFImageIO.h>
#include <unistd.h>

#include <cmath>
#include <cstdarg>
#include <cstdlib>
#include <mutex>
#include <utility>

#include "geometry/base/version.h"

namespace kerf::internal {
namespace {

using Io = itk::ImageIOBase;

// ITK's copy of libtiff writes its complaints to standard error. It has no header, and uses its own names,
// others in ITK 5.4 than in 5.2.
void quietTiff() {
  using Handler = void (*)(const char* module, const char* format, va_list arguments);
  for (const char* name : {"itk_TIFFSetErrorHandler", "itk_TIFFSetWarningHandler", "itk_tiff_TIFFSetErrorHandler",
                           "itk_tiff_TIFFSetWarningHandler"}) {
    const auto set = reinterpret_cast<Handler (*)(Handler)>(dlsym(RTLD_DEFAULT, name));
    if (set) set(nullptr);
  }
}

void quiet() {
  static std::once_flag once;
  std::call_once(once, [] {
    itk::Object::GlobalWarningDisplayOff();
    gdcm::Trace::SetDebug(false);
    gdcm::Trace::SetWarning(false);
    gdcm::Trace::SetError(false);
    quietTiff();
  });
}

Io::Pointer makeIo(VolumeFormat format) {
  quiet();
  switch (format) {
    case VolumeFormat::kNrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case VolumeFormat::kNifti:
      return itk::NiftiImageIO::New().GetPointer();
    case VolumeFormat::kMetaImage:
      return itk::MetaImageIO::New().GetPointer();
    case VolumeFormat::kDicom:
      return itk::GDCMImageIO::New().GetPointer();
    case VolumeFormat::kTiff:
      return itk::TIFFImageIO::New().GetPointer();
    case VolumeFormat::kBmp:
      return itk::BMPImageIO::New().GetPointer();
    case VolumeFormat::kPng:
      break;
  }
  auto png = itk::PNGImageIO::New();
  png->SetExpandRGBPalette(false);  // an indexed picture: the indices are the labels
  return png.GetPointer();
}

// An ITK error is a paragraph with addresses; the last line has the reason.
std::string reason(const std::exception& e) {
  std::string text = e.what();
  if (const auto* itk_error = dynamic_cast<const itk::ExceptionObject*>(&e)) text = itk_error->GetDescription();
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  if (const auto at = text.find("): "); at != std::string::npos && at < 120) text.erase(0, at + 3);
  while (!text.empty() && text.back() == ' ') text.pop_back();
  constexpr std::size_t kMost = 200;
  return text.size() <= kMost ? text : "... " + text.substr(text.size() - kMost);
}

template <class F>
auto guarded(const std::filesystem::path& path, F&& f) -> decltype(f()) {
  const auto bad = [&](std::string found) {
    return fail({.code = Error::Code::kBadFormat,
                 .file = path.string(),
                 .found = std::move(found),
                 .expected = "a file the ITK reader accepts",
                 .hint = "save it again from the program it came from"});
  };
  try {
    return f();
  } catch (const std::bad_alloc&) {
    return bad("more values than memory can hold");
  } catch (const std::exception& e) {
    return bad("it cannot be read: " + reason(e));
  } catch (...) {
    return bad("it cannot be read");
  }
}

Expected<ValueType> valueType(const std::filesystem::path& path, const Io& io) {
  using C = itk::IOComponentEnum;
  switch (io.GetComponentType()) {
    case C::UCHAR:
      return ValueType::kU8;
    case C::CHAR:
      return ValueType::kI8;
    case C::USHORT:
      return ValueType::kU16;
    case C::SHORT:
      return ValueType::kI16;
    case C::UINT:
      return ValueType::kU32;
    case C::INT:
      return ValueType::kI32;
    case C::ULONG:
      return ValueType::kU64;
    case C::LONG:
      return ValueType::kI64;
    case C::ULONGLONG:
      return ValueType::kU64;
    case C::LONGLONG:
      return ValueType::kI64;
    case C::FLOAT:
      return ValueType::kF32;
    case C::DOUBLE:
      return ValueType::kF64;
    default:
      break;
  }
  return fail({.code = Error::Code::kUnsupported,
               .file = path.string(),
               .found = "values of an unknown type",
               .expected = "integers of 8 to 64 bits, or floating-point numbers",
               .hint = "convert it to 16-bit integers"});
}

Expected<VolumeHeader> headerOf(const std::filesystem::path& path, const Io& io) {
  KERF_TRY(type, valueType(path, io));
  VolumeHeader h;
  h.type = type;
  h.components = io.GetNumberOfComponents();
  const unsigned axes = io.GetNumberOfDimensions();
  for (unsigned a = 0; a < axes; ++a) {
    h.size.push_back(io.GetDimensions(a));
    h.spacing.push_back(io.GetSpacing(a));
    h.origin.push_back(io.GetOrigin(a));
  }
  for (unsigned row = 0; row < axes; ++row)
    for (unsigned a = 0; a < axes; ++a) {
      const std::vector<double> column = io.GetDirection(a);
      h.direction.push_back(row < column.size() ? column[row] : 0);
    }
  return h;
}

// libpng writes its warnings to standard error, and ITK offers no way to change it: this redirects standard error to
// /dev/null while a picture is read. Messages of other threads are lost meanwhile.
class QuietStandardError {
 public:
  explicit QuietStandardError(bool is_wanted) {
    if (!is_wanted) return;
    lock_ = std::unique_lock(mutex());
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere < 0) return;
    before_ = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (before_ >= 0) ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
  }
  ~QuietStandardError() {
    if (before_ < 0) return;
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  QuietStandardError(const QuietStandardError&) = delete;
  QuietStandardError& operator=(const QuietStandardError&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::unique_lock<std::mutex> lock_;
  int before_ = -1;
};

// The decimal strings of an element; empty if it is missing or has no value.
std::vector<double> decimals(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  if (!set.FindDataElement(tag)) return {};
  const gdcm::ByteValue* value = set.GetDataElement(tag).GetByteValue();
  if (!value) return {};
  const std::string text(value->GetPointer(), value->GetLength());
  std::vector<double> out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\\', at), text.size());
    const std::string word = text.substr(at, end - at);
    char* rest = nullptr;
    const double v = std::strtod(word.c_str(), &rest);
    out.push_back(rest == word.c_str() ? std::nan("") : v);
    at = end + 1;
  }
  return out;
}

// The items of a sequence; none if it is missing.
std::vector<const gdcm::DataSet*> items(const gdcm::DataSet& set, const gdcm::Tag& tag,
                                        std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>>& alive) {
  if (!set.FindDataElement(tag)) return {};
  const auto sequence = set.GetDataElement(tag).GetValueAsSQ();
  if (!sequence) return {};
  alive.push_back(sequence);
  std::vector<const gdcm::DataSet*> out;
  for (std::size_t i = 1; i <= sequence->GetNumberOfItems(); ++i)
    out.push_back(&sequence->GetItem(i).GetNestedDataSet());
  return out;
}

// The spacing in the file: if it is missing, or not where GDCM looks for it, GDCM silently reports 1 mm.
// Places after DICOM PS3.3: C.7.6.3 (image pixel), C.7.6.16 (functional groups of frames), C.8.6 (scanned pictures).
void findStatedSpacing(const std::filesystem::path& path, VolumeHeader& h) {
  h.states_pixel_spacing = h.states_frame_spacing = false;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (h.spacing.size() < 2 || !reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010))) return;
  const gdcm::DataSet& top = reader.GetFile().GetDataSet();

  // Its possible places: the file as a whole, or the frames.
  std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> alive;
  std::vector<const gdcm::DataSet*> places{&top};
  std::vector<std::vector<double>> positions;  // of frames
  for (const gdcm::Tag& groups : {gdcm::Tag(0x5200, 0x9229), gdcm::Tag(0x5200, 0x9230)})
    for (const gdcm::DataSet* group : items(top, groups, alive)) {
      for (const gdcm::DataSet* measures : items(*group, gdcm::Tag(0x0028, 0x9110), alive)) places.push_back(measures);
      for (const gdcm::DataSet* plane : items(*group, gdcm::Tag(0x0020, 0x9113), alive))
        if (auto p = decimals(*plane, gdcm::Tag(0x0020, 0x0032)); p.size() == 3) positions.push_back(std::move(p));
    }

  const auto same = [](double stated, double found) { return std::abs(stated - found) <= 1e-4 * found; };
  const auto is_length = [](double v) { return std::isfinite(v) && v > 0; };
  for (const gdcm::DataSet* place : places) {
    for (const gdcm::Tag& tag : {gdcm::Tag(0x0028, 0x0030), gdcm::Tag(0x0018, 0x1164), gdcm::Tag(0x0018, 0x2010)}) {
      const std::vector<double> v = decimals(*place, tag);  // between rows, then between columns
      if (h.states_pixel_spacing || v.size() != 2 || !is_length(v[0]) || !is_length(v[1])) continue;
      // The others hold on the detector or on the film; only GDCM knows for which kinds of pictures they count.
      const bool is_pixel_spacing = tag == gdcm::Tag(0x0028, 0x0030);
      if (!is_pixel_spacing && !(same(v[0], h.spacing[1]) && same(v[1], h.spacing[0]))) continue;
      h.spacing[0] = v[1];
      h.spacing[1] = v[0];
      h.states_pixel_spacing = true;
    }
    const std::vector<double> between = decimals(*place, gdcm::Tag(0x0018, 0x0088));
    if (h.spacing.size() > 2 && !h.states_frame_spacing && between.size() == 1 && is_length(std::abs(between[0]))) {
      h.spacing[2] = std::abs(between[0]);
      h.states_frame_spacing = true;
    }
  }

  // Between frames it may follow from their positions.
  if (h.spacing.size() > 2 && positions.size() > 1 && !h.states_frame_spacing) {
    const auto &a = positions.front(), &b = positions.back();
    const double step = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / static_cast<double>(positions.size() - 1);
    if (std::abs(step - h.spacing[2]) <= 0.02 * h.spacing[2]) h.states_frame_spacing = true;  // rounded strings
  }
}

Expected<VolumeHeader> readHeader(const std::filesystem::path& path, VolumeFormat format) {
  return guarded(path, [&]() -> Expected<VolumeHeader> {
    const QuietStandardError quiet_error(format == VolumeFormat::kPng);
    const Io::Pointer io = makeIo(format);
    io->SetFileName(path.string());
    io->ReadImageInformation();
    auto header = headerOf(path, *io);
    if (header && format == VolumeFormat::kDicom) {
      itk::ExposeMetaData<std::string>(io->GetMetaDataDictionary(), "0020|000e", header->series);
      findStatedSpacing(path, *header);
    }
    return header;
  });
}

Expected<void> readValues(const std::filesystem::path& path, VolumeFormat format, std::byte* out, std::uint64_t bytes) {
  return guarded(path, [&]() -> Expected<void> {
    const QuietStandardError quiet_error(format == VolumeFormat::kPng);
    const Io::Pointer io = makeIo(format);
    io->SetFileName(path.string());
    io->ReadImageInformation();
    KERF_TRY(header, headerOf(path, *io));
    std::uint64_t needed = header.components * io->GetComponentSize();
    itk::ImageIORegion whole(static_cast<unsigned>(header.size.size()));
    for (unsigned a = 0; a < header.size.size(); ++a) {
      needed *= header.size[a];
      whole.SetIndex(a, 0);
      whole.SetSize(a, header.size[a]);
    }
    if (needed != bytes)
      return fail({.code = Error::Code::kBadFormat,
                   .file = path.string(),
                   .found = std::to_string(needed) + " bytes of values",
                   .expected = std::to_string(bytes) + ", like its header and the other slices",
                   .hint = "export the volume again"});

    io->SetIORegion(whole);
    io->Read(out);
    return {};
  });
}

bool isDicomFile(const std::filesystem::path& path) {
  quiet();
  try {
    return itk::GDCMImageIO::New()->CanReadFile(path.string().c_str());
  } catch (...) {
    return false;
  }
}

}  // namespace
}  // namespace kerf::internal

extern "C" const kerf::internal::ItkReader* kerfItkReader() {
  using namespace kerf::internal;
  static const ItkReader reader{kerf::kVersion, sizeof(VolumeHeader), readHeader, readValues, isDicomFile};
  return &reader;
}
