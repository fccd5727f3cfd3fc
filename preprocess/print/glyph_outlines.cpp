#include "preprocess/print/glyph_outlines.h"

#include <fmt/format.h>
#include <ft2build.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "geometry/base/text.h"
#include FT_FREETYPE_H
#include FT_OUTLINE_H
#include FT_TRUETYPE_TABLES_H

namespace kerf::internal {
namespace {

constexpr double kLineSpacing = 1.6;  // cap heights; Inter's own is 1.66
constexpr const char* kInterBold = "/usr/share/fonts/opentype/inter/Inter-Bold.otf";

struct Line {
  std::vector<char32_t> characters;
};

char32_t decoded(std::string_view bytes) {
  const auto first = static_cast<unsigned char>(bytes[0]);
  char32_t c = bytes.size() == 1 ? first : first & (0x7fu >> bytes.size());
  for (std::size_t k = 1; k < bytes.size(); ++k) c = (c << 6) | (static_cast<unsigned char>(bytes[k]) & 0x3fu);
  return c;
}

Expected<std::vector<Line>> linesOf(std::string_view text) {
  std::vector<Line> lines(1);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8Length(text, at);
    if (length == 0)
      return fail({.code = Error::Code::kBadFormat,
                   .place = fmt::format("label text, byte {}", at),
                   .found = printable(text.substr(at, 1)),
                   .expected = "UTF-8"});
    const char32_t c = decoded(text.substr(at, length));
    at += length;
    if (c == '\n')
      lines.emplace_back();
    else if (!(c == '\r' && at < text.size() && text[at] == '\n'))
      lines.back().characters.push_back(c);
  }
  return lines;
}

struct Font {
  std::unique_ptr<FT_LibraryRec_, decltype(&FT_Done_FreeType)> library{nullptr, FT_Done_FreeType};
  std::unique_ptr<FT_FaceRec_, decltype(&FT_Done_Face)> face{nullptr, FT_Done_Face};
};

Expected<Font> opened(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    return fail({.code = Error::Code::kNotFound,
                 .file = file.string(),
                 .found = "no such font file",
                 .expected = "the font of labels",
                 .hint = file == kInterBold ? "sudo apt install fonts-inter" : "another font file"});
  Font font;
  FT_Library library = nullptr;
  if (FT_Init_FreeType(&library) == 0) font.library.reset(library);
  FT_Face face = nullptr;
  if (library && FT_New_Face(library, file.c_str(), 0, &face) == 0) font.face.reset(face);
  if (!font.face || !FT_IS_SCALABLE(face) || FT_Select_Charmap(face, FT_ENCODING_UNICODE) != 0)
    return fail({.code = Error::Code::kUnreadable,
                 .file = file.string(),
                 .found = "no font with outlines for Unicode",
                 .expected = "an OpenType or TrueType font"});
  return font;
}

// Collects a glyph's curves as polygons; font units times `scale`.
class Flattener {
 public:
  Flattener(double scale, std::vector<Contour>& out) : scale_(scale), out_(out) {}

  bool add(FT_Outline& outline, const Point2d& origin) {
    origin_ = origin;
    FT_Outline_Funcs calls{};
    calls.move_to = [](const FT_Vector* to, void* self) { return static_cast<Flattener*>(self)->moveTo(*to); };
    calls.line_to = [](const FT_Vector* to, void* self) { return static_cast<Flattener*>(self)->lineTo(*to); };
    calls.conic_to = [](const FT_Vector* a, const FT_Vector* to, void* self) {
      return static_cast<Flattener*>(self)->curveTo(*a, *a, *to, true);
    };
    calls.cubic_to = [](const FT_Vector* a, const FT_Vector* b, const FT_Vector* to, void* self) {
      return static_cast<Flattener*>(self)->curveTo(*a, *b, *to, false);
    };
    return FT_Outline_Decompose(&outline, &calls, this) == 0;
  }

 private:
  // On a grid of 2^-10 mm: contours that nearly touch do touch, and no edge is shorter.
  Point2d placed(const FT_Vector& v) const {
    return origin_ + scale_ * Point2d(static_cast<double>(v.x), static_cast<double>(v.y));
  }
  void push(const Point2d& p) {
    const Point2d on_grid = (p * 1024).array().round() / 1024;
    if (out_.back().empty() || out_.back().back() != on_grid) out_.back().push_back(on_grid);
    last_ = p;
  }
  int moveTo(const FT_Vector& to) {
    out_.emplace_back();
    push(placed(to));
    return 0;
  }
  int lineTo(const FT_Vector& to) {
    push(placed(to));
    return 0;
  }
  // A chord of 1/n of a curve lies at most |second derivative| / (8 n^2) from it.
  int curveTo(const FT_Vector& first, const FT_Vector& second, const FT_Vector& to, bool is_conic) {
    const Point2d p = last_, a = placed(first), b = placed(second), q = placed(to);
    const double bend =
        is_conic ? 2 * (p - 2 * a + q).norm() : 6 * std::max((p - 2 * a + b).norm(), (a - 2 * b + q).norm());
    const int n = std::max(1, static_cast<int>(std::ceil(std::sqrt(bend / (8 * kOutlineTolerance)))));
    for (int k = 1; k <= n; ++k) {
      const double t = k / double(n), s = 1 - t;
      push(k == n     ? q
           : is_conic ? Point2d(s * s * p + 2 * s * t * a + t * t * q)
                      : Point2d(s * s * s * p + 3 * s * s * t * a + 3 * s * t * t * b + t * t * t * q));
    }
    return 0;
  }

  double scale_;
  std::vector<Contour>& out_;
  Point2d origin_ = Point2d::Zero(), last_ = Point2d::Zero();
};

// In font units.
double capHeight(FT_Face face) {
  const auto* const table = static_cast<const TT_OS2*>(FT_Get_Sfnt_Table(face, FT_SFNT_OS2));
  if (table && table->version >= 2 && table->version != 0xFFFF && table->sCapHeight > 0) return table->sCapHeight;
  if (FT_Load_Char(face, 'H', FT_LOAD_NO_SCALE) == 0 && face->glyph->metrics.height > 0)
    return static_cast<double>(face->glyph->metrics.height);
  return 0.7 * face->units_per_EM;
}

std::string named(char32_t c) {
  std::string utf8;
  if (c < 0x80)
    utf8 = static_cast<char>(c);
  else if (c < 0x800)
    utf8 = {static_cast<char>(0xC0 | (c >> 6)), static_cast<char>(0x80 | (c & 0x3F))};
  else if (c < 0x10000)
    utf8 = {static_cast<char>(0xE0 | (c >> 12)), static_cast<char>(0x80 | ((c >> 6) & 0x3F)),
            static_cast<char>(0x80 | (c & 0x3F))};
  else
    utf8 = {static_cast<char>(0xF0 | (c >> 18)), static_cast<char>(0x80 | ((c >> 12) & 0x3F)),
            static_cast<char>(0x80 | ((c >> 6) & 0x3F)), static_cast<char>(0x80 | (c & 0x3F))};
  return fmt::format("{} (U+{:04X})", printable(utf8), static_cast<unsigned>(c));
}

Expected<void> requireGlyphs(FT_Face face, const std::filesystem::path& file, const std::vector<Line>& lines) {
  constexpr std::size_t kMostNamed = 8;
  std::vector<char32_t> missing;
  bool has_mark = false;
  for (const Line& line : lines)
    for (const char32_t c : line.characters) {
      // A combining mark needs shaping: Inter has the letters with marks as characters of their own.
      const bool is_mark = c >= 0x300 && c < 0x370;
      has_mark |= is_mark;
      if ((is_mark || FT_Get_Char_Index(face, c) == 0) && std::find(missing.begin(), missing.end(), c) == missing.end())
        missing.push_back(c);
    }
  if (missing.empty()) return {};
  std::string names;
  for (std::size_t n = 0; n < std::min(missing.size(), kMostNamed); ++n) names += (n ? ", " : "") + named(missing[n]);
  if (missing.size() > kMostNamed) names += fmt::format(" and {} more", missing.size() - kMostNamed);
  return fail(
      {.code = Error::Code::kUnsupported,
       .file = file.string(),
       .place = "label text",
       .found = "characters that the font cannot draw: " + names,
       .expected = "characters of the font",
       .hint = has_mark ? "a letter with its mark as one character (Unicode NFC)" : "other words, or another font"});
}

}  // namespace

Expected<std::vector<Contour>> glyphOutlines(std::string_view text, double height_mm, TextAlign align,
                                             const std::filesystem::path& font_file) {
  KERF_TRY(lines, linesOf(text));
  const std::filesystem::path file = font_file.empty() ? kInterBold : font_file;
  KERF_TRY(font, opened(file));
  const FT_Face face = font.face.get();
  KERF_CHECK(requireGlyphs(face, file, lines));

  const double scale = height_mm / capHeight(face);
  std::vector<Contour> out;
  double baseline = 0;
  for (const Line& line : lines) {
    std::vector<Contour> drawn;
    Flattener flattener(scale, drawn);
    double pen = 0;
    FT_UInt before = 0;
    for (const char32_t c : line.characters) {
      const FT_UInt glyph = FT_Get_Char_Index(face, c);
      FT_Vector kerning{};
      if (before && FT_HAS_KERNING(face)) FT_Get_Kerning(face, before, glyph, FT_KERNING_UNSCALED, &kerning);
      pen += scale * static_cast<double>(kerning.x);
      if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_SCALE) != 0 || face->glyph->format != FT_GLYPH_FORMAT_OUTLINE ||
          !flattener.add(face->glyph->outline, {pen, baseline}))
        return fail({.code = Error::Code::kUnreadable,
                     .file = file.string(),
                     .place = "glyph of " + named(c),
                     .found = "no outline",
                     .expected = "a font with outlines"});
      pen += scale * static_cast<double>(face->glyph->metrics.horiAdvance);
      before = glyph;
    }
    const double shift = align == TextAlign::kLeft ? 0 : align == TextAlign::kRight ? -pen : -pen / 2;
    for (Contour& contour : drawn) {
      while (contour.size() > 1 && contour.back() == contour.front()) contour.pop_back();
      if (contour.size() < 3) continue;
      for (Point2d& p : contour) p.x() += std::round(1024 * shift) / 1024;
      out.push_back(std::move(contour));
    }
    baseline -= kLineSpacing * height_mm;
  }

  if (out.empty())
    return fail({.code = Error::Code::kEmpty,
                 .place = "label text",
                 .found = text.empty() ? "no text" : "only spaces",
                 .expected = "at least one letter"});
  Point2d low = out[0][0], high = low;
  for (const Contour& contour : out)
    for (const Point2d& p : contour) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  const Point2d middle = (512 * (low + high)).array().round() / 1024;
  for (Contour& contour : out)
    for (Point2d& p : contour) p -= middle;
  return out;
}

}  // namespace kerf::internal
