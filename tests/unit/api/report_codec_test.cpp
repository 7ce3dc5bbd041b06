#include "api/report_codec.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <string>

#include "api/openapi.hpp"
#include "unit/api/schema_check.hpp"

namespace cornerfix::api {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

AssessedPlace place_at(const Point2& position, std::optional<double> way_m,
                       std::optional<Pose2> rival = {}) {
  AssessedStart start;
  start.T_map_base_link = {position.x(), position.y(), 0.5};
  start.way_m = way_m;
  start.rival = rival;
  start.rival_way_m = 4.0;
  return {position, 7, {start}};
}

/// An easy place in the west, a hard one in the east that looks like one in the far north.
LocalizabilityReport sample() {
  LocalizabilityReport report;
  report.way_limit_m = 20.0;
  report.lattice_m = 2.0;
  report.free_area_m2 = 50.0;
  report.features = 4;
  report.places = {place_at({0, 0}, 0.0), place_at({10, 1}, {}, Pose2{4, 30, 0})};
  report.look_alikes = {{{10, 1, 0.5}, {4, 30, 0}, 4.0, 1}};
  return report;
}

std::string advice_in(const Json& report) {
  std::string all;
  for (const auto& sentence : report.at("advice")) all += sentence.get<std::string>() + "\n";
  return all;
}

TEST(ReportCodec, FitsItsSchema) {
  const auto openapi = nlohmann::json::parse(openapi_json());
  const SchemaCheck schemas(openapi, true);
  for (const LocalizabilityReport& report : {sample(), LocalizabilityReport{}}) {
    const auto document = nlohmann::json::parse(render_report({"hall", 3}, report).dump());
    EXPECT_THAT(schemas.check({{"$ref", "#/components/schemas/Report"}}, document), IsEmpty());
  }
  const auto progress = nlohmann::json::parse(render_report_progress({"hall", 3}, 0.25).dump());
  EXPECT_THAT(schemas.check({{"$ref", "#/components/schemas/ReportProgress"}}, progress),
              IsEmpty());
}

TEST(ReportCodec, CountsAStartThatIsNeverToldItsPoseWithTheWholeWay) {
  const Json report = render_report({"hall", 3}, sample());
  EXPECT_EQ(report["success"], 0.5);
  EXPECT_EQ(report["success_at_once"], 0.5);
  EXPECT_EQ(report["places"][1]["way_m"], 20.0);
  EXPECT_TRUE(report["places"][1]["starts"][0]["way_m"].is_null());
  EXPECT_EQ(report["features_per_100_m2"], 8.0);
}

TEST(ReportCodec, TellsWhereToStartInsteadAndWhatTheHardPlaceLooksLike) {
  const std::string advice = advice_in(render_report({"hall", 3}, sample()));
  EXPECT_THAT(advice, AllOf(HasSubstr("in the north-east, around (10.0, 1.0)"),
                            HasSubstr("looks like the place around (4.0, 30.0)"),
                            HasSubstr("nearer to (0.0, 0.0), 10.0 m away")));
}

TEST(ReportCodec, SaysThatAMapWithoutHardPlacesIsWell) {
  LocalizabilityReport report = sample();
  report.places.pop_back();
  EXPECT_THAT(advice_in(render_report({"hall", 3}, report)), HasSubstr("switched on anywhere"));
}

TEST(ReportCodec, WarnsOfAWrongFix) {
  LocalizabilityReport report = sample();
  report.places[1].starts[0].is_wrong = true;
  EXPECT_THAT(advice_in(render_report({"hall", 3}, report)), HasSubstr("a wrong pose first"));
}

TEST(ReportPicture, LaysThePlacesOnTheGrid) {
  OccupancyGrid grid;
  grid.resolution = 0.5;
  grid.T_map_grid = {-2.0, -1.0, 0.0};
  grid.width = 40;
  grid.height = 20;
  grid.cells.assign(800, Cell::kFree);
  const std::string svg = draw_report(sample(), grid);
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 20.000 "));
  // (10, 1) is 12 m from the left and 8 m from the top of what the grid covers.
  EXPECT_THAT(svg, HasSubstr("cx=\"12.000\" cy=\"8.000\" r=\"0.700\" fill=\"#d73027\""));
  EXPECT_THAT(svg, HasSubstr("translate(0.000 10.000) rotate(-0.0000)"));
  EXPECT_THAT(svg, HasSubstr("<line x1=\"12.000\" y1=\"8.000\""));
}

}  // namespace
}  // namespace cornerfix::api
