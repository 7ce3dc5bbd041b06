// Former revisions of maps, in the library.
#include <gmock/gmock.h>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

class MapVersionsTest : public ServiceTest {
 protected:
  void SetUp() override {
    make_map(process_, "office");
    before_ = maps_.find("office").value();
    api::PutMapRequest other;
    other.parameters_json = R"({"grid":{"resolution_m":0.1}})";
    ASSERT_TRUE(maps_.put("office", other));
    changed_ = maps_.find("office").value();
  }

  Process process_{file()};
  MapLibrary& maps_ = *process_.maps;
  storage::MapInfo before_;
  storage::MapInfo changed_;
};

TEST_F(MapVersionsTest, LocalizesInWhatItRolledBackTo) {
  EXPECT_DOUBLE_EQ((*maps_.load("office"))->grid().resolution, 0.1);
  const storage::MapInfo rolled = maps_.roll_back("office", before_.revision).value();
  EXPECT_EQ(rolled.revision, changed_.revision + 1);
  EXPECT_EQ(rolled.digest, before_.digest);
  EXPECT_EQ(rolled.feature_count, before_.feature_count);
  const LocalizationMapPtr map = maps_.load("office").value();
  EXPECT_EQ(map->revision(), rolled.revision);
  EXPECT_NE(map->grid().resolution, 0.1);
}

TEST_F(MapVersionsTest, TakesScansAfterARollBack) {
  ASSERT_TRUE(maps_.roll_back("office", before_.revision));
  const auto drive = testing::mapping_drive();
  EXPECT_EQ(maps_.grow("office", drive)->duplicates, drive.size());
  const auto later = testing::mapping_drive(1e6, testing::refurnished_room());
  EXPECT_EQ(maps_.grow("office", later)->revision, changed_.revision + 2);
}

TEST_F(MapVersionsTest, StaysWhenItRollsBackToThePresent) {
  EXPECT_EQ(maps_.roll_back("office", changed_.revision)->revision, changed_.revision);
  EXPECT_EQ(maps_.revisions("office")->size(), 2U);
}

TEST_F(MapVersionsTest, KnowsTheDigestOfKeptRevisionsOnly) {
  const MapVersion present = maps_.version("office", changed_.revision).value();
  EXPECT_EQ(present.digest, changed_.digest);
  EXPECT_TRUE(present.is_current);
  const MapVersion former = maps_.version("office", before_.revision).value();
  EXPECT_EQ(former.digest, before_.digest);
  EXPECT_FALSE(former.is_current);
  EXPECT_EQ(maps_.version("office", 99)->digest, "");
  EXPECT_EQ(maps_.version("lab", 1).error().code, ErrorCode::kNotFound);
}

TEST_F(MapVersionsTest, RefusesARevisionThatIsNotKept) {
  EXPECT_EQ(maps_.roll_back("office", 99).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(maps_.roll_back("lab", 1).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace cornerfix::server
