#include <fstream>
#include <iterator>
#include <string>

#include "support/fake_server.hpp"
#include "unit/cli/command_run.hpp"

namespace cornerfix::cli {
namespace {

using ::testing::HasSubstr;

class MapCommand : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

TEST_F(MapCommand, ListsMapsOverAllPages) {
  testing::FakeServer server([](const testing::FakeRequest& request) {
    if (request.path == "/v1/maps") {
      return testing::FakeAnswer{200, R"({"maps": [{"name": "attic", "revision": 3, "keyframes": 10,
          "features": 20, "bounds": {"min_x": -1, "min_y": 0, "max_x": 4, "max_y": 2.5},
          "updated": "2024-01-02T03:04:05Z"}], "next_page_token": "attic"})"};
    }
    EXPECT_EQ(request.path, "/v1/maps?page_token=attic");
    return testing::FakeAnswer{200, R"({"maps": [{"name": "cellar", "revision": 1, "bounds": null}],
        "next_page_token": null})"};
  });
  const Outcome outcome = run({"map", "list", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out,
            "NAME    REVISION  KEYFRAMES  FEATURES  SIZE         UPDATED\n"
            "attic   3         10         20        5.0 x 2.5 m  2024-01-02T03:04:05Z\n"
            "cellar  1         -          -         -            -\n");
}

TEST_F(MapCommand, WaitsForAReportAndSavesItsPicture) {
  int asked = 0;
  testing::FakeServer server([&asked](const testing::FakeRequest& request) {
    if (request.path == "/v1/maps/attic/report.svg") return testing::FakeAnswer{200, "<svg/>"};
    EXPECT_EQ(request.path, "/v1/maps/attic/report?wait=2");
    if (++asked < 3) return testing::FakeAnswer{202, R"({"state": "computing", "progress": 0.5})"};
    return testing::FakeAnswer{200, R"({"state": "done", "summary": "All well but one place.",
        "free_area_m2": 80, "features_per_100_m2": 12.5, "advice": ["Start elsewhere."],
        "areas": [{"x": 4, "y": 1.25, "radius_m": 2, "way_m": 9.5, "found": 0.75,
                   "looks_like": {"x": 30, "y": 1}, "better_start": null}]})"};
  });
  const std::string picture = (directory_.path() / "attic.svg").string();
  const Outcome outcome = run(
      {"map", "report", "attic", "--picture", picture.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "All well but one place.\n"
            "80 m2 free, 12.5 features in 100 m2\n\n"
            "REGION    RADIUS  DISTANCE  LOCALIZED  ALIASED WITH  BETTER START\n"
            "4.0, 1.2  2.0 m   9.5 m     75 %       30.0, 1.0     -\n"
            "- Start elsewhere.\n");
  std::ifstream file(picture);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "<svg/>");
}

TEST_F(MapCommand, PrintsTheProblemOfTheServer) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{404, R"({"title": "Not found", "detail": "there is no map attic"})"};
  });
  const Outcome outcome = run({"map", "delete", "attic", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "cornerfix: DELETE /v1/maps/attic: 404 there is no map attic\n");
}

TEST_F(MapCommand, ImportsALargePgmInASmallBody) {
  const std::string yaml =
      directory_.write("map.yaml", "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n")
          .string();
  directory_.write("map.pgm", "P5 4096 4096 255\n" + std::string(4096 * 4096, '\xfe'));
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{200, R"({"features": 5})"};
  });
  const Outcome outcome =
      run({"map", "import", "attic", yaml.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 1U);
  EXPECT_LT(requests[0].length, 1'000'000U);
  EXPECT_GT(requests[0].length, 100U);
}

TEST_F(MapCommand, RefusesAnEmptyFileToRestore) {
  const std::string file = directory_.write("a.cornerfix", "").string();
  const Outcome outcome = run({"map", "restore", "a", file.c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("is empty"));
}

}  // namespace
}  // namespace cornerfix::cli
