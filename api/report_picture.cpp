#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <cornerfix/map_image.hpp>

#include "api/format.hpp"
#include "api/report_advice.hpp"
#include "api/report_codec.hpp"

namespace cornerfix::api {
namespace {

constexpr double kTextHeight = 0.022;  // of the picture's width
constexpr double kMaxDotRadius = 0.8;  // [m]
constexpr std::size_t kMaxPairsDrawn = 8;

struct Shade {
  double up_to_m;  ///< Of the way that robots drive from a place.
  const char* color;
  const char* meaning;
};
constexpr std::array kShades{
    Shade{0.5, "#1a9850", "found at once"}, Shade{3.0, "#a6d96a", "within 3 m"},
    Shade{8.0, "#fdae61", "within 8 m"}, Shade{1e9, "#d73027", "8 m and more"}};

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group =
          group << 8U | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[group >> (18U - 6U * k) & 63U] : '=';
  }
  return text;
}

const char* color_of(double way_m) {
  return std::ranges::find_if(kShades, [&](const Shade& shade) { return way_m < shade.up_to_m; })
      ->color;
}

/// Map coordinates with y up, about the box of the grid: everything is drawn in metres.
class Canvas {
 public:
  explicit Canvas(const OccupancyGrid& grid) {
    low_ = high_ = grid.T_map_grid.translation();
    for (const int column : {0, grid.width}) {
      for (const int row : {0, grid.height}) {
        const Point2 corner = grid.T_map_grid * (grid.resolution * Point2(column, row));
        low_ = low_.cwiseMin(corner);
        high_ = high_.cwiseMax(corner);
      }
    }
  }
  [[nodiscard]] double x(const Point2& point) const { return point.x() - low_.x(); }
  [[nodiscard]] double y(const Point2& point) const { return high_.y() - point.y(); }
  [[nodiscard]] double width() const { return high_.x() - low_.x(); }
  [[nodiscard]] double height() const { return high_.y() - low_.y(); }

 private:
  Point2 low_;
  Point2 high_;
};

std::string grid_image(const Canvas& canvas, const OccupancyGrid& grid) {
  const Point2 origin = grid.T_map_grid.translation();
  const double height = grid.height * grid.resolution;
  return format(
             "<image transform=\"translate(%.3f %.3f) rotate(%.4f)\" y=\"%.3f\" width=\"%.3f\" "
             "height=\"%.3f\" image-rendering=\"pixelated\" href=\"data:image/png;base64,",
             canvas.x(origin), canvas.y(origin), -grid.T_map_grid.yaw * 180.0 / std::numbers::pi,
             -height, grid.width * grid.resolution, height) +
         base64(encode_grid_png(grid)) + "\"/>\n";
}

std::string look_alike_line(const Canvas& canvas, const AliasedPoses& pair) {
  const Point2 a = pair.T_map_a.translation();
  const Point2 b = pair.T_map_b.translation();
  return format(
      "<line x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" y2=\"%.3f\"><title>look alike for %.1f "
      "m</title></line>\n",
      canvas.x(a), canvas.y(a), canvas.x(b), canvas.y(b), pair.way_m);
}

std::string place_dot(const Canvas& canvas, const AssessedPlace& place,
                      const LocalizabilityReport& report) {
  const double way_m = expected_way_m(place, report.way_limit_m);
  return format(
      "<circle cx=\"%.3f\" cy=\"%.3f\" r=\"%.3f\" fill=\"%s\"><title>(%.1f, %.1f): %.1f "
      "m</title></circle>\n",
      canvas.x(place.position_map), canvas.y(place.position_map),
      std::min(kMaxDotRadius, 0.35 * report.lattice_m), color_of(way_m), place.position_map.x(),
      place.position_map.y(), way_m);
}

std::string legend(const Canvas& canvas, double size) {
  std::string svg;
  double x = size;
  const double y = canvas.height() + 3.2 * size;
  for (const Shade& shade : kShades) {
    svg += format(
        "<circle cx=\"%.3f\" cy=\"%.3f\" r=\"%.3f\" fill=\"%s\"/><text x=\"%.3f\" "
        "y=\"%.3f\">%s</text>\n",
        x, y - 0.35 * size, 0.45 * size, shade.color, x + 0.8 * size, y, shade.meaning);
    x += 0.23 * canvas.width();
  }
  return svg;
}

}  // namespace

std::string draw_report(const LocalizabilityReport& report, const OccupancyGrid& grid) {
  const Canvas canvas(grid);
  const double size = kTextHeight * canvas.width();
  const double height = canvas.height() + 4.0 * size;
  std::string svg = format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.3f %.3f\" width=\"1200\" "
      "height=\"%.0f\" font-family=\"sans-serif\" font-size=\"%.3f\">\n<rect width=\"100%%\" "
      "height=\"100%%\" fill=\"white\"/>\n",
      canvas.width(), height, 1200.0 * height / canvas.width(), size);
  svg += grid_image(canvas, grid);
  svg += "<g fill-opacity=\"0.75\">\n";
  for (const AssessedPlace& place : report.places) svg += place_dot(canvas, place, report);
  svg += format("</g>\n<g stroke=\"#5e3c99\" stroke-width=\"%.3f\" stroke-dasharray=\"%.3f\">\n",
                0.12 * size, 0.5 * size);
  for (std::size_t i = 0; i < std::min(report.look_alikes.size(), kMaxPairsDrawn); ++i)
    svg += look_alike_line(canvas, report.look_alikes[i]);
  svg += format("</g>\n<text x=\"%.3f\" y=\"%.3f\">", size, canvas.height() + 1.4 * size) +
         summarize(report) + "</text>\n" + legend(canvas, size);
  return svg + "</svg>\n";
}

}  // namespace cornerfix::api
