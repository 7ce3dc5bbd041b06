// Maps from occupancy maps, and maps as archives, against the real server.
#include <gmock/gmock.h>

#include <cornerfix/map_image.hpp>

#include "integration/form_data.hpp"
#include "integration/test_server.hpp"
#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Json;
using testing::kForm;
using testing::part;
using testing::Reply;

constexpr const char* kArchive = "application/vnd.sqlite3";

std::string form(const std::string& yaml, const std::string& image) {
  return part("yaml", yaml) + part("image", image) + "--xyz--\r\n";
}

/// The files of the room that the robots of room_drive.hpp are in.
struct RoomFiles {
  OccupancyGrid grid = testing::drawn_grid(testing::figure7_room(), {5.0, 5.0}, {-1.0, -1.0, 0.0},
                                           {12.0, 12.0}, 0.05);
  std::string yaml = encode_grid_yaml(grid, "room.png");
  std::string image;
  RoomFiles() {
    const auto png = encode_grid_png(grid);
    image.assign(reinterpret_cast<const char*>(png.data()), png.size());
  }
};

class GridApiTest : public ::testing::Test {
 protected:
  Reply put_grid(const std::string& map, const std::string& body, const char* type = kForm) {
    return client_.send("PUT", "/v1/maps/" + map + "/grid", body, type);
  }
  Json entry(const std::string& name) { return client_.get("/v1/maps/" + name).json(); }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  RoomFiles room_;
};

TEST_F(GridApiTest, MakesAMapAndReplacesIt) {
  const Reply created = put_grid("plan", form(room_.yaml, room_.image));
  ASSERT_EQ(created.status, 201) << created.body;
  EXPECT_EQ(created.header("location"), "/v1/maps/plan");
  EXPECT_EQ(created.json()["revision"], 1);
  EXPECT_GE(created.json()["features"], 4);
  EXPECT_EQ(created.json()["warnings"], Json::array());
  EXPECT_EQ(entry("plan")["digest"], created.json()["digest"]);
  EXPECT_EQ(entry("plan")["floor_map"], true);

  const Reply same = put_grid("plan", form(room_.yaml, room_.image));
  EXPECT_EQ(same.status, 200);
  EXPECT_EQ(same.json()["revision"], 1);
}

TEST_F(GridApiTest, TakesImagesThatAreLargerThanOtherBodiesMayBe) {
  const std::size_t more = server::ServerConfig{}.max_body_bytes;
  const std::string behind_its_end(more, '\0');
  const Reply created = put_grid("plan", form(room_.yaml, room_.image + behind_its_end));
  EXPECT_EQ(created.status, 201) << created.body;
}

TEST_F(GridApiTest, ARobotFindsItselfInIt) {
  ASSERT_EQ(put_grid("plan", form(room_.yaml, room_.image)).status, 201);
  const auto drive = testing::robot_drive();
  const std::string id = testing::open_session(client_, "r2", "plan");
  Json answer;
  for (std::uint64_t i = 0; i < 10; ++i) {
    answer = client_.post("/v1/sessions/" + id + "/scans", testing::session_batch(drive, i)).json();
  }
  ASSERT_EQ(answer["status"], "localized") << answer;
  EXPECT_NEAR(answer["pose"]["x"].get<double>(), drive.T_map_base_link.back().x, 0.1);
  EXPECT_NEAR(answer["pose"]["y"].get<double>(), drive.T_map_base_link.back().y, 0.1);
}

TEST_F(GridApiTest, GivesTheFloorMapBackCellByCell) {
  room_.grid.T_map_grid.yaw = 0.6;
  ASSERT_EQ(put_grid("plan", form(encode_grid_yaml(room_.grid, "a.png"), room_.image)).status, 201);
  const std::string yaml = client_.get("/v1/maps/plan/grid.yaml").body;
  const std::string image = client_.get("/v1/maps/plan/grid.png").body;
  EXPECT_EQ(parse_map(yaml, std::as_bytes(std::span(image))).value(), room_.grid);
  ASSERT_EQ(put_grid("again", form(yaml, image)).status, 201);
  EXPECT_EQ(entry("again")["digest"], entry("plan")["digest"]);
}

TEST_F(GridApiTest, IsMadeAnewAfterARestartAndWithOtherParameters) {
  ASSERT_EQ(put_grid("plan", form(room_.yaml, room_.image)).status, 201);
  const Json before = client_.get("/v1/maps/plan/features").json();
  client_.put("/v1/maps/plan", {{"parameters", {{"min_feature_count", 1000}}}});
  EXPECT_THAT(client_.get("/v1/maps/plan/features").json()["features"], IsEmpty());
  client_.put("/v1/maps/plan", {{"parameters", {{"min_feature_count", 2}}}});
  EXPECT_EQ(client_.get("/v1/maps/plan/features").json()["features"], before["features"]);
}

TEST_F(GridApiTest, ScansAndFloorMapsAreNotMixed) {
  testing::make_room_map(client_, "room");
  const Json before = entry("room");
  EXPECT_EQ(put_grid("room", form(room_.yaml, room_.image)).status, 409);
  EXPECT_EQ(entry("room"), before);
  ASSERT_EQ(put_grid("plan", form(room_.yaml, room_.image)).status, 201);
  client_.put("/v1/maps/plan", {{"lidar", testing::lidar_json()}});
  EXPECT_EQ(client_.post("/v1/maps/plan/scans", testing::map_batch(testing::mapping_drive(), 0, 2))
                .status,
            409);
  EXPECT_EQ(client_
                .put("/v1/maps/plan/trajectory",
                     {{"poses", {{{"stamp", 1}, {"x", 0}, {"y", 0}, {"yaw", 0}}}}})
                .status,
            409);
}

TEST_F(GridApiTest, BadFilesGetAClearErrorAndStoreNothing) {
  const std::string huge = "P5 100000 100000 255\n";
  const std::string nan = "image: a\nresolution: 0.05\norigin: [.nan, 0, 0]\n";
  const std::string zero = "image: a\nresolution: 0\norigin: [0, 0, 0]\n";
  const std::string one_by_one = "P5 1 1 255\n\xff";
  struct Case {
    std::string body;
    int status;
    std::string says;
  };
  for (const Case& bad : {
           Case{form(room_.yaml, huge), 413, R"("pointer":"/image","detail":"100000 x 100000)"},
           Case{form(nan, room_.image), 422, R"("pointer":"/yaml/origin")"},
           Case{form(zero, room_.image), 422, R"("pointer":"/yaml/resolution")"},
           Case{form("resolution: 1", room_.image), 422, R"("pointer":"/yaml/image")"},
           Case{form(room_.yaml, one_by_one), 422, "no occupied cell"},
           Case{form(room_.yaml, "GIF89a"), 400, "is a gif, expected"},
           Case{form(room_.yaml, room_.image.substr(0, 200)), 400, "png"},
           Case{form("[", room_.image), 400, R"("pointer":"/yaml")"},
           Case{part("yaml", room_.yaml) + "--xyz--\r\n", 422, "/image"},
           Case{part("lidar", "{}") + form(room_.yaml, room_.image), 422, "/lidar"},
           Case{part("yaml", "a") + form("a", "b"), 400, "twice"},
           Case{"no form at all", 400, "form"},
       }) {
    const Reply reply = put_grid("plan", bad.body);
    EXPECT_EQ(reply.status, bad.status) << reply.body;
    EXPECT_EQ(reply.header("content-type"), "application/problem+json");
    EXPECT_THAT(reply.body, HasSubstr(bad.says));
  }
  EXPECT_EQ(put_grid("plan", "{}", "application/json").status, 415);
  EXPECT_EQ(put_grid("-plan", form(room_.yaml, room_.image)).status, 422);
  EXPECT_THAT(client_.get("/v1/maps").json()["maps"], IsEmpty());
}

TEST_F(GridApiTest, AnArchiveMakesTheSameMap) {
  testing::make_room_map(client_, "room");
  const Reply archive = client_.get("/v1/maps/room/archive");
  ASSERT_EQ(archive.status, 200);
  EXPECT_EQ(archive.header("content-type"), kArchive);
  const Reply restored = client_.send("POST", "/v1/maps/copy/archive", archive.body, kArchive);
  ASSERT_EQ(restored.status, 201) << restored.body;
  for (const char* key : {"digest", "revision", "keyframes", "features", "bounds", "lidar"}) {
    EXPECT_EQ(restored.json()[key], entry("room")[key]) << key;
  }
  EXPECT_EQ(client_.get("/v1/maps/copy/features").json(),
            client_.get("/v1/maps/room/features").json());
  EXPECT_EQ(client_.get("/v1/maps/copy/archive").body, archive.body);
}

TEST_F(GridApiTest, AnArchiveOfAFloorMapMakesTheSameMap) {
  ASSERT_EQ(put_grid("plan", form(room_.yaml, room_.image)).status, 201);
  const Reply archive = client_.get("/v1/maps/plan/archive");
  const Reply restored = client_.send("POST", "/v1/maps/copy/archive", archive.body, kArchive);
  ASSERT_EQ(restored.status, 201) << restored.body;
  for (const char* key : {"digest", "floor_map", "features", "bounds"}) {
    EXPECT_EQ(restored.json()[key], entry("plan")[key]) << key;
  }
}

TEST_F(GridApiTest, AnArchiveIsNotRestoredOverAMapNorFromOtherBytes) {
  testing::make_room_map(client_, "room");
  const std::string archive = client_.get("/v1/maps/room/archive").body;
  EXPECT_EQ(client_.send("POST", "/v1/maps/room/archive", archive, kArchive).status, 409);
  EXPECT_EQ(client_.send("POST", "/v1/maps/copy/archive", archive, "application/json").status, 415);
  EXPECT_EQ(client_.send("POST", "/v1/maps/copy/archive", "{}", kArchive).status, 400);
  EXPECT_EQ(
      client_.send("POST", "/v1/maps/copy/archive", archive.substr(0, archive.size() / 2), kArchive)
          .status,
      400);
  EXPECT_EQ(client_.get("/v1/maps/copy").status, 404);
  EXPECT_EQ(client_.get("/v1/maps/copy/archive").status, 404);
}

TEST_F(GridApiTest, RefusesNoise) {
  constexpr std::size_t kSide = 600;
  std::string image = "P5 600 600 255\n";
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t column = 0; column < kSide; ++column)
      image += row % 8 == 0 && column % 8 == 0 ? '\0' : '\xfe';
  }
  const std::string yaml = "image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n";
  const Reply reply = client_.send("PUT", "/v1/maps/noise/grid", form(yaml, image), kForm);
  EXPECT_EQ(reply.status, 422) << reply.body;
  EXPECT_THAT(reply.json()["detail"].get<std::string>(), HasSubstr("is this noise?"));
  EXPECT_EQ(client_.get("/v1/maps/noise").status, 404);
}

}  // namespace
}  // namespace cornerfix
