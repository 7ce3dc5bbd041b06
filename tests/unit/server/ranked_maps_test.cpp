#include "server/localization_service.hpp"

#include <gmock/gmock.h>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Sessions in any of six maps, when two are searched without a ranking.
class RankedMaps : public LocalizationServiceTest {
 protected:
  static constexpr std::size_t kBatches = 8;
  static inline const SessionLimits kRanked{.max_maps_without_ranking = 2};

  void SetUp() override {
    for (const float scale : {1.3F, 1.5F, 1.7F, 1.9F, 2.1F}) {
      const std::string name = "lab-" + std::to_string(scale).substr(0, 3);
      ASSERT_TRUE(process_.maps->put(name, {}));
      ASSERT_TRUE(process_.maps->grow(name, drive_in_lab(scale)));
      ASSERT_TRUE(process_.maps->load(name));
    }
    ASSERT_TRUE(process_.maps->load("office"));
  }

  /// In a room of the same form, but larger.
  static std::vector<PosedScan> drive_in_lab(float scale) {
    auto drive = testing::mapping_drive();
    for (PosedScan& scan : drive) {
      for (float& range : scan.scan.ranges) range *= scale;
      scan.T_map_base_link.x *= static_cast<double>(scale);
      scan.T_map_base_link.y *= static_cast<double>(scale);
    }
    return drive;
  }

  std::string run(Process& process, const std::string& id) {
    std::string last;
    for (std::size_t i = 0; i < kBatches; ++i) last = answer(process, id, batch(i));
    return last;
  }
};

TEST_F(RankedMaps, AreLoadedOnlyWhereTheRobotMayBe) {
  Process process(file(), {}, kRanked);
  const std::string last = run(process, create(process, {}));
  EXPECT_THAT(last, HasSubstr("localized of 6 in office"));
  EXPECT_LT(process.maps->cache_use().loads, 6U);
}

TEST_F(RankedMaps, AreAllSearchedWhenNamed) {
  Process process(file(), {}, kRanked);
  const std::string id = create(process, {"office", "lab-1.3", "lab-1.5"});
  answer(process, id, batch(0));
  EXPECT_EQ(process.maps->cache_use().loads, 3U);
}

TEST_F(RankedMaps, OfTheTrackedOneAloneIsLoadedAfterARestart) {
  Process process(file(), {}, kRanked);
  const std::string id = create(process, {});
  ASSERT_THAT(run(process, id), HasSubstr("in office"));
  Process restarted(file(), {}, kRanked);
  EXPECT_THAT(answer(restarted, id, batch(kBatches)), HasSubstr("localized of 6 in office"));
  EXPECT_EQ(restarted.maps->cache_use().loads, 1U);
}

TEST_F(RankedMaps, LeaveTheRobotLostWhenItsMapIsDeleted) {
  Process process(file(), {}, kRanked);
  const std::string id = create(process, {});
  ASSERT_THAT(run(process, id), HasSubstr("in office"));
  ASSERT_TRUE(process_.maps->remove("office"));
  EXPECT_THAT(answer(process, id, batch(kBatches)), HasSubstr("lost of 5"));
}

TEST_F(RankedMaps, AreUsedInTheirNewestRevision) {
  Process process(file(), {}, kRanked);
  const std::string id = create(process, {});
  ASSERT_THAT(run(process, id), HasSubstr("in office"));
  const std::uint64_t loads = process.maps->cache_use().loads;
  ASSERT_TRUE(process_.maps->grow("office", testing::mapping_drive(900.0)));
  EXPECT_THAT(answer(process, id, batch(kBatches)), HasSubstr("localized of 6 in office"));
  EXPECT_EQ(process.maps->cache_use().loads, loads + 1);
}

TEST_F(RankedMaps, AreFoundWithoutASketch) {
  ASSERT_TRUE(process_.maps->remove("office"));
  make_map(process_, "new office");
  Process process(file(), {}, kRanked);
  EXPECT_THAT(run(process, create(process, {})), HasSubstr("in new office"));
  ASSERT_TRUE(process.ranking->refresh());
  EXPECT_EQ(process.ranking->use().sketches, 6U);  // Made when it was loaded.
}

TEST_F(RankedMaps, ThatAreTwinsStayAmbiguous) {
  make_map(process_, "twin");
  ASSERT_TRUE(process_.maps->load("twin"));
  Process process(file(), {}, kRanked);
  const std::string last = run(process, create(process, {}));
  EXPECT_THAT(last, HasSubstr("ambiguous of 7"));
  EXPECT_THAT(last, Not(HasSubstr(" at ")));
}

TEST_F(RankedMaps, BecomeTheSessionsWhenThereAreMoreThanAreSearchedWithoutThem) {
  Process process(file(), {}, {.max_maps_without_ranking = 6});
  const std::string id = create(process, {});
  ASSERT_THAT(run(process, id), HasSubstr("localized of 6 in office"));
  ASSERT_TRUE(process_.maps->put("hall", {}));
  ASSERT_TRUE(process_.maps->grow("hall", drive_in_lab(2.5F)));
  EXPECT_THAT(answer(process, id, batch(kBatches)), HasSubstr("localized of 7 in office"));
  ASSERT_TRUE(process_.maps->remove("hall"));
  EXPECT_THAT(answer(process, id, batch(kBatches + 1)), HasSubstr("localized of 6 in office"));
}

TEST_F(RankedMaps, WithoutRoomInMemoryLeaveNoPoseAccepted) {
  SessionLimits limits = kRanked;
  limits.max_searched_map_bytes = 1;
  make_map(process_, "twin");
  Process process(file(), {}, limits);
  const std::string last = run(process, create(process, {}));
  EXPECT_THAT(last, HasSubstr("collecting of 7"));
}

}  // namespace
}  // namespace cornerfix::server
