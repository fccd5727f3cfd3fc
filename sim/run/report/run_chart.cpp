#include "sim/run/report/run_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "geometry/base/xml_text.h"

namespace kerf {
namespace {

// Sheet, px.
constexpr double kWidth = 1000, kLeft = 78, kRight = 26, kTop = 90, kBottom = 64, kPanel = 128, kBetween = 34;
constexpr double kPlotWidth = kWidth - kLeft - kRight;
constexpr const char* kInk = "#1d2733";
constexpr const char* kFaint = "#5b6673";
constexpr const char* kGrid = "#cdd4dc";
constexpr const char* kStroke = "#eef1f4";

// From Okabe and Ito, "Color Universal Design" (2008), without the pale ones, which do not show on white.
constexpr const char *kBlue = "#0072b2", *kVermilion = "#d55e00", *kGreen = "#009e73", *kPurple = "#a8518a",
                     *kBlack = "#30343a";

// ---- Contents of the panels

enum class Marked { kNothing, kLargest, kLeast };

struct Line {
  std::string name;  // empty: as the panel's title
  std::vector<float> values;
  const char* color;
  const char* dashes;  // "": solid
  Marked marked = Marked::kNothing;
};

struct Panel {
  std::string title, unit;
  std::vector<Line> lines;
  bool has_zero = true;         // the axis reaches 0
  std::optional<double> limit;  // a significant level
  std::string limit_text;
};

std::string unitFor(const RunSeries& s, const char* spinning, const char* reciprocating) {
  if (!s.has_reciprocating_tool) return spinning;
  if (!s.has_spinning_tool) return reciprocating;
  return fmt::format("{}; saw: {}", spinning, reciprocating);
}

bool hasValue(const std::vector<float>& values) {
  return std::any_of(values.begin(), values.end(), [](float v) { return !std::isnan(v); });
}

Panel forcePanel(const RunSeries& s) {
  Panel out{"force", "N", {}, true, {}, {}};
  out.lines.push_back({"on the tool", s.contact_N, kBlue, "", Marked::kLargest});
  if (*std::max_element(s.hand_N.begin(), s.hand_N.end()) > 0)
    out.lines.push_back({"on the hand", s.hand_N, kVermilion, "", Marked::kNothing});
  return out;
}

Panel speedPanel(const RunSeries& s) {
  // Users know drive speed in turns per minute.
  std::vector<float> values = s.speed;
  constexpr auto kRpm = static_cast<float>(60 / (2 * std::numbers::pi));
  if (!s.has_reciprocating_tool)
    for (float& v : values) v *= kRpm;
  Panel out{"speed of the drive", unitFor(s, "rpm", "mm/s"), {}, true, {}, {}};
  if (s.has_reciprocating_tool && s.has_spinning_tool) out.unit = "rad/s; saw: mm/s";
  out.lines.push_back({"", std::move(values), kBlack, "", Marked::kNothing});
  return out;
}

Panel temperaturePanel(const RunSeries& s) {
  Panel out{"temperature under the tool", "\u00b0C", {}, false, {}, {}};
  out.lines.push_back({"", s.temperature_C, kVermilion, "", Marked::kLargest});
  constexpr float kBoneLimit = 47, kNearLimit = 42;
  // The pulp of a tooth has a temperature and a limit of its own.
  const auto has = [&](const char* id) {
    return std::any_of(s.distances.begin(), s.distances.end(), [&](const auto& d) { return d.id == id; });
  };
  const bool is_tooth = has("pulp") && !has("nerve_canal");
  if (!is_tooth && *std::max_element(s.temperature_C.begin(), s.temperature_C.end()) > kNearLimit) {
    out.limit = kBoneLimit;
    out.limit_text = "47 \u00b0C, the limit of bone";
  }
  return out;
}

std::string structureName(const std::string& id) {
  if (id == "nerve_canal") return "nerve canal";
  if (id.starts_with("beside_")) return "neighbour " + id.substr(7);
  return id;
}

Panel distancePanel(const RunSeries& s) {
  Panel out{"distance of the cutting part", "mm", {}, true, {}, {}};
  constexpr std::array<const char*, 4> kColors{kPurple, kGreen, kBlue, kVermilion};
  constexpr std::array<const char*, 4> kDashes{"", "7 3", "2 3", "10 3 2 3"};
  for (std::size_t n = 0; n < s.distances.size(); ++n)
    if (hasValue(s.distances[n].mm))
      out.lines.push_back({"to " + structureName(s.distances[n].id), s.distances[n].mm, kColors[n % kColors.size()],
                           kDashes[n % kDashes.size()], Marked::kLeast});
  return out;
}

Panel panelOf(ChartPanel panel, const RunSeries& s) {
  switch (panel) {
    case ChartPanel::kForce:
      return forcePanel(s);
    case ChartPanel::kLoad: {
      Panel out{"load of the drive", unitFor(s, "N mm", "N"), {}, true, {}, {}};
      out.lines.push_back({"", s.drive_load, kGreen, "", Marked::kLargest});
      return out;
    }
    case ChartPanel::kSpeed:
      return speedPanel(s);
    case ChartPanel::kTemperature:
      return temperaturePanel(s);
    case ChartPanel::kDistance:
      return distancePanel(s);
    case ChartPanel::kRemoved: {
      Panel out{"removed", "mm\u00b3", {}, true, {}, {}};
      out.lines.push_back({"", s.removed_mm3, kBlue, "", Marked::kLargest});
      return out;
    }
  }
  return {};
}

// ---- Axes

struct Axis {
  double low = 0, high = 1, step = 1;
};

// Ticks at 1, 2 or 5 times a power of ten, about `count` of them.
Axis roundAxis(double low, double high, int count) {
  if (!(high > low)) {
    const double half = std::max(0.5, 0.1 * std::abs(high));
    low -= half;
    high += half;
  }
  const double raw = (high - low) / count, power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double times : {1.0, 2.0, 5.0})
    if (times * power >= raw * (1 - 1e-9)) {
      step = times * power;
      break;
    }
  return {step * std::floor(low / step + 1e-9), step * std::ceil(high / step - 1e-9), step};
}

std::string numberText(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  if (std::abs(value) < 1e-9 * step) value = 0;
  std::string text = fmt::format("{:.{}f}", value, decimals);
  // Writes 400000 as 400 000.
  const std::size_t point = std::min(text.find('.'), text.size()), first = text[0] == '-' ? 1 : 0;
  if (point - first > 4)
    for (std::size_t at = point; at > first + 3; at -= 3) text.insert(at - 3, "\u2009");
  return text;
}

// ---- Drawing

class Chart {
 public:
  Chart(const RunSeries& series, std::size_t begin, std::size_t end, std::size_t panels)
      : s_(series), begin_(begin), end_(end), panels_(panels) {
    time_.low = begin == 0 ? 0 : static_cast<double>(s_.t_s[begin - 1]);
    time_.high = s_.t_s[end - 1];
  }

  double height() const { return kTop + static_cast<double>(panels_) * (kPanel + kBetween) - kBetween + kBottom; }
  double bottom() const { return height() - kBottom; }

  void heading(const ChartOptions& options) {
    text(kLeft, 30, options.title, kInk, "start", 20);
    text(kLeft, 50, options.subtitle, kFaint, "start", 13);
  }

  void panel(std::size_t row, const Panel& panel) {
    const double top = kTop + static_cast<double>(row) * (kPanel + kBetween);
    const Axis axis = axisOf(panel);
    const auto y = [&](double v) { return top + kPanel * (axis.high - v) / (axis.high - axis.low); };

    strokeBands(top);
    gridLines(top, axis, y);
    title(top, panel);
    body_ += fmt::format("<g fill=\"none\" stroke-width=\"1.4\" stroke-linejoin=\"round\">\n");
    for (const Line& line : panel.lines) curve(line, y);
    body_ += "</g>\n";
    if (panel.limit && *panel.limit > axis.low && *panel.limit < axis.high) limit(panel, y(*panel.limit), top);
    for (const Line& line : panel.lines) mark(line, panel.unit, y, top);
  }

  void timeAxis() {
    const Axis ticks = roundAxis(time_.low, time_.high, 10);
    for (double t = ticks.low; t <= time_.high + 1e-9; t += ticks.step) {
      if (t < time_.low - 1e-9) continue;
      line(x(t), bottom(), x(t), bottom() + 5, kFaint, 1);
      text(x(t), bottom() + 20, numberText(t, ticks.step), kInk, "middle", 13);
    }
    text(kLeft + 0.5 * kPlotWidth, bottom() + 40, "time [s]", kInk, "middle", 14);
    if (s_.strokes.empty()) return;
    body_ += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"22\" height=\"12\" fill=\"{}\" stroke=\"{}\"/>\n",
                         kLeft, bottom() + 30, kStroke, "#b9c1ca");
    text(kLeft + 28, bottom() + 40, fmt::format("stroke ({})", s_.strokes.size()), kFaint, "start", 13);
  }

  std::string finished(const std::string& title) const {
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
               "{1:.0f}\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\">\n<title>{2}</title>\n"
               "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
               kWidth, height(), xmlText(title)) +
           body_ + "</svg>\n";
  }

 private:
  double x(double t) const { return kLeft + kPlotWidth * (t - time_.low) / (time_.high - time_.low); }

  std::span<const float> shown(const Line& line) const { return std::span(line.values).subspan(begin_, end_ - begin_); }

  Axis axisOf(const Panel& panel) const {
    double low = panel.has_zero ? 0 : 1e30, high = panel.has_zero ? 0 : -1e30;
    for (const Line& line : panel.lines)
      for (const float v : shown(line)) {
        if (std::isnan(v)) continue;
        low = std::min(low, static_cast<double>(v));
        high = std::max(high, static_cast<double>(v));
      }
    if (!(low <= high)) return {};
    if (panel.has_zero && high == low) return {0, 1, 0.5};
    return roundAxis(low, high, 4);
  }

  void strokeBands(double top) {
    for (const StrokeSpan& stroke : s_.strokes) {
      const double from = std::max(stroke.from_s, time_.low), to = std::min(stroke.to_s, time_.high);
      if (to > from)
        body_ += fmt::format("<rect x=\"{:.2f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                             x(from), top, std::max(0.6, x(to) - x(from)), kPanel, kStroke);
    }
  }

  template <class Y>
  void gridLines(double top, const Axis& axis, const Y& y) {
    for (double v = axis.low; v <= axis.high + 1e-9 * axis.step; v += axis.step) {
      line(kLeft, y(v), kLeft + kPlotWidth, y(v), std::abs(v) < 1e-9 * axis.step ? "#9aa4af" : kGrid, 1);
      text(kLeft - 8, y(v) + 4.5, numberText(v, axis.step), kInk, "end", 13);
    }
    line(kLeft, top, kLeft, top + kPanel, "#9aa4af", 1);
  }

  // Name and unit above the panel to the left, its lines to the right.
  void title(double top, const Panel& panel) {
    text(kLeft, top - 8, fmt::format("{} [{}]", panel.title, panel.unit), kInk, "start", 14);
    double right = kLeft + kPlotWidth;
    for (auto it = panel.lines.rbegin(); it != panel.lines.rend(); ++it) {
      if (it->name.empty()) continue;
      text(right, top - 8, it->name, kInk, "end", 13);
      right -= 7 * static_cast<double>(it->name.size()) + 8;
      line(right - 30, top - 12.5, right, top - 12.5, it->color, 2.4, it->dashes);
      right -= 46;
    }
  }

  // Draws the least and the largest value of each pixel column, in their order in time.
  template <class Y>
  void curve(const Line& curve, const Y& y) {
    const std::span<const float> values = shown(curve);
    std::string path;
    bool is_down = false;  // the pen
    const auto to = [&](std::size_t n) {
      path +=
          fmt::format("{}{:.1f} {:.1f}", is_down ? "L" : "M", x(s_.t_s[begin_ + n]), y(static_cast<double>(values[n])));
      is_down = true;
    };
    constexpr double kColumn = 1.2;  // px
    for (std::size_t n = 0; n < values.size();) {
      if (std::isnan(values[n])) {
        is_down = false;
        ++n;
        continue;
      }
      const double until = x(s_.t_s[begin_ + n]) + kColumn;
      std::size_t least = n, most = n, last = n;
      for (; last < values.size() && !std::isnan(values[last]) && x(s_.t_s[begin_ + last]) < until; ++last) {
        if (values[last] < values[least]) least = last;
        if (values[last] > values[most]) most = last;
      }
      to(std::min(least, most));
      if (least != most) to(std::max(least, most));
      n = last;
    }
    body_ += fmt::format("<path d=\"{}\" stroke=\"{}\"{}/>\n", path, curve.color,
                         *curve.dashes ? fmt::format(" stroke-dasharray=\"{}\"", curve.dashes) : "");
  }

  // Named above the panel, to the right, clear of curves.
  void limit(const Panel& panel, double level, double top) {
    const double right = kLeft + kPlotWidth;
    line(kLeft, level, right, level, kInk, 1, "5 4");
    text(right, top - 8, panel.limit_text, kInk, "end", 13);
    const double before = right - 7 * static_cast<double>(panel.limit_text.size()) - 4;
    line(before - 30, top - 12.5, before, top - 12.5, kInk, 1, "5 4");
  }

  template <class Y>
  void mark(const Line& line, const std::string& unit, const Y& y, double top) {
    if (line.marked == Marked::kNothing) return;
    const std::span<const float> values = shown(line);
    std::optional<std::size_t> at;
    for (std::size_t n = 0; n < values.size(); ++n) {
      if (std::isnan(values[n])) continue;
      if (!at || (line.marked == Marked::kLargest ? values[n] > values[*at] : values[n] < values[*at])) at = n;
    }
    if (!at) return;

    const double px = x(s_.t_s[begin_ + *at]), py = y(static_cast<double>(values[*at]));
    body_ += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.4\" fill=\"white\" stroke=\"{}\" stroke-width=\"1.8\"/>\n", px, py,
        line.color);
    const std::string label = fmt::format("{:.3g} {} at {:.2f} s", values[*at], unit, s_.t_s[begin_ + *at]);
    const bool is_right = px > kLeft + 0.75 * kPlotWidth;
    const double below = std::min(py + 16, top + kPanel - 4), above = std::max(py - 7, top + 12);
    const double level = line.marked == Marked::kLeast ? below : above;
    // A white rim keeps the number legible over the curve.
    body_ += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" text-anchor=\"{}\" font-size=\"13\" stroke=\"white\" "
        "stroke-width=\"3.5\" paint-order=\"stroke\">{}</text>\n",
        px + (is_right ? -8 : 8), level, kInk, is_right ? "end" : "start", xmlText(label));
  }

  void line(double x0, double y0, double x1, double y1, const char* color, double width, const char* dashes = "") {
    body_ += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{:.1f}\"{}/>\n", x0,
        y0, x1, y1, color, width, *dashes ? fmt::format(" stroke-dasharray=\"{}\"", dashes) : "");
  }
  void text(double px, double py, const std::string& what, const char* color, const char* anchor, double size) {
    body_ +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" text-anchor=\"{}\" font-size=\"{:.0f}\">{}</text>\n",
                    px, py, color, anchor, size, xmlText(what));
  }

  const RunSeries& s_;
  std::size_t begin_, end_, panels_;  // ticks that are shown
  Axis time_;
  std::string body_;
};

}  // namespace

Expected<std::string> drawChart(const RunSeries& series, const ChartOptions& options) {
  const auto& t = series.t_s;
  const auto begin =
      static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), static_cast<float>(options.from_s)) - t.begin());
  const auto end =
      static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), static_cast<float>(options.until_s)) - t.begin());
  if (begin >= end)
    return fail({.code = Error::Code::kEmpty,
                 .place = "--from, --until",
                 .found = fmt::format("nothing from {:g} to {:g} s", options.from_s, options.until_s),
                 .expected = fmt::format("a range within 0 to {:.3f} s", t.empty() ? 0 : t.back()),
                 .hint = "omit one of them"});

  std::vector<Panel> panels;
  for (const ChartPanelRow& row : kChartPanels) {
    const bool is_asked = std::find(options.panels.begin(), options.panels.end(), row.panel) != options.panels.end();
    if (!options.panels.empty() && !is_asked) continue;
    Panel panel = panelOf(row.panel, series);
    if (!panel.lines.empty()) panels.push_back(std::move(panel));
  }
  if (panels.empty())
    return fail(
        {.code = Error::Code::kEmpty,
         .place = "--show",
         .found = "nothing to show",
         .expected =
             "a quantity of this run: far from pulp, nerve and neighbours, or without them, there is no distance",
         .hint = "omit --show"});

  Chart chart(series, begin, end, panels.size());
  chart.heading(options);
  for (std::size_t row = 0; row < panels.size(); ++row) chart.panel(row, panels[row]);
  chart.timeAxis();
  return chart.finished(options.title);
}

}  // namespace kerf
