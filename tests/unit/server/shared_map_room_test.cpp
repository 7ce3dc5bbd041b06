// Maps in the hands of robots share the room of all loaded maps.
#include "server/localization_service.hpp"

#include <gmock/gmock.h>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

class SharedMapRoom : public LocalizationServiceTest {
 protected:
  void SetUp() override {
    for (const char* name : {"second", "third", "fourth"}) make_map(process_, name);
    for (const char* name : {"office", "second", "third", "fourth"})
      bytes_ = std::max(bytes_, (*process_.maps->load(name))->bytes());
  }

  std::size_t bytes_ = 0;  ///< Of one map.
};

TEST_F(SharedMapRoom, BoundsTheMapsOfAllRobotsTogether) {
  Process process(file(), {.max_map_bytes = 2 * bytes_});
  std::vector<std::string> ids;
  for (const char* name : {"office", "second", "third", "fourth"}) {
    ids.push_back(create(process, {name}));
    answer(process, ids.back(), batch(0));
    EXPECT_LE(process.maps->cache_use().bytes, 2 * bytes_) << name;
  }
  EXPECT_GE(process.maps->cache_use().loads, 4U);
}

TEST_F(SharedMapRoom, LoadsAReleasedMapForTheRobotThatNeedsIt) {
  constexpr std::size_t kBatches = 8;
  Process process(file(), {.max_map_bytes = 1});
  const std::string first = create(process, {"office"});
  const std::string second = create(process, {"second"});
  std::string last;
  for (std::size_t i = 0; i < kBatches; ++i) {
    last = answer(process, first, batch(i));
    EXPECT_EQ(process.maps->cache_use().maps, 1U);
    answer(process, second, batch(i));
    EXPECT_EQ(process.maps->cache_use().maps, 1U);
  }
  EXPECT_THAT(last, HasSubstr("localized in office"));
  EXPECT_EQ(process.maps->cache_use().loads, 2 * kBatches);
}

TEST_F(SharedMapRoom, DoesNotBeginASearchAnewForAnotherRobot) {
  constexpr std::size_t kBatches = 20;
  Process process(file(), {.max_map_bytes = 1});
  std::vector<std::string> ids;
  for (const char* map : {"office", "second"}) {
    api::CreateSessionRequest request = session_of(map, {map});
    request.params.search_budget_ms = 0.05;  // A search takes several batches.
    request.options_json = R"({"search_budget_ms": 0.05})";
    ids.push_back(process.localization.create(request).value().value().id);
  }
  std::string first;
  std::string last;
  for (std::size_t i = 0; i < kBatches; ++i) {
    for (const std::string& id : ids) last = answer(process, id, batch(i, 1));
    if (i == 0) first = last;
  }
  EXPECT_THAT(first, HasSubstr("collecting"));
  EXPECT_THAT(last, HasSubstr("localized in second"));
}

}  // namespace
}  // namespace cornerfix::server
