#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>

#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/storeys.hpp"
#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;
using ::testing::ElementsAre;
using ::testing::IsSupersetOf;
using ::testing::UnorderedElementsAre;

/// Maps in memory; counts those that were asked for.
class FakeSource : public MapSource {
 public:
  void add(MapKey key, LocalizationMapPtr map) {
    catalog_.put(key, sketch_of(*map));
    maps_[key] = std::move(map);
  }
  /// Load() fails for this map from now on.
  void refuse(MapKey key) { refused_.insert(key); }

  std::size_t size() override { return maps_.size(); }
  double free_area_m2() override { return catalog_.free_area_m2(); }
  std::vector<RankedMap> rank(const MapQuery& query) override { return catalog_.rank(query); }
  std::vector<MapKey> keys() override {
    std::vector<MapKey> keys;
    for (const auto& [key, map] : maps_) keys.push_back(key);
    return keys;
  }
  std::optional<MapKey> find(std::string_view name) override {
    for (const auto& [key, map] : maps_) {
      if (map->name() == name) return key;
    }
    return std::nullopt;
  }
  LocalizationMapPtr load(MapKey key, std::size_t held_bytes) override {
    if (refused_.contains(key) || held_bytes + maps_.at(key)->bytes() > max_bytes) return nullptr;
    loaded.insert(key);
    return maps_.at(key);
  }

  std::set<MapKey> loaded;
  std::size_t max_bytes = std::numeric_limits<std::size_t>::max();

 private:
  MapCatalog catalog_;
  std::map<MapKey, LocalizationMapPtr> maps_;
  std::set<MapKey> refused_;
};

constexpr std::uint64_t kOwnStorey = 700;  // of the storey that the robot is in

LocalizationMapPtr map_of_scene(const SceneBuilder& scene, const Point2& inside, std::string name) {
  testing::Storey storey{scene, inside};
  Result<GridMap> made = map_from_grid(storey.grid(0.1), {});
  return std::make_shared<const LocalizationMap>(std::move(name), 1, std::move(made->content));
}

LocalizationMapPtr storey_map(std::uint64_t seed, std::string name) {
  const testing::Storey storey = testing::random_storey(seed);
  return map_of_scene(storey.scene, storey.inside, std::move(name));
}

/// 100 storeys, made once; none is the robot's.
const std::vector<LocalizationMapPtr>& other_maps() {
  static const std::vector<LocalizationMapPtr> kMaps = [] {
    std::vector<LocalizationMapPtr> maps;
    for (std::uint64_t i = 1; i <= 100; ++i)
      maps.push_back(storey_map(kOwnStorey + i, "other-" + std::to_string(i)));
    return maps;
  }();
  return kMaps;
}

std::shared_ptr<FakeSource> source_of_others() {
  auto source = std::make_shared<FakeSource>();
  for (std::size_t i = 0; i < other_maps().size(); ++i)
    source->add(static_cast<MapKey>(1000 + i), other_maps()[i]);
  return source;
}

/// Into the first room and along the corridor.
std::vector<Moment> storey_drive(std::size_t count) {
  const testing::Storey storey = testing::random_storey(kOwnStorey);
  const Pose2 start{storey.inside.x() + 1.0, storey.inside.y(), 0.4};
  return drive(storey.scene, {}, testing::wander(storey.scene, start, count), 7);
}

/// The robot's storey with one more box, where the robot does not come.
LocalizationMapPtr changed_map() {
  testing::Storey storey = testing::random_storey(kOwnStorey);
  storey.scene.box({27.5, storey.corridor_high + 3.5}, {1.0, 1.0}, 0.4);
  return map_of_scene(storey.scene, storey.inside, "changed");
}

std::set<std::string> names_in(const Answer& answer) {
  std::set<std::string> names;
  for (const RankedHypothesis& one : answer.hypotheses) names.insert(one.map->name());
  return names;
}

TEST(LocalizerWithSource, FindsTheRightOneOfManyMapsAndLoadsFew) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  // More than are all loaded where corners are few.
  for (std::size_t i = 0; i < 40; ++i) source->add(static_cast<MapKey>(2000 + i), other_maps()[i]);
  Localizer localizer(source, {}, {});
  const std::vector<Moment> moments = storey_drive(80);
  const std::vector<Answer> answers = answers_of(localizer, moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  ASSERT_TRUE(answers.back().pose) << to_string(answers.back().reason);
  EXPECT_EQ(answers.back().pose->map->name(), "own");
  EXPECT_EQ(answers.back().searched_maps, 141U);
  EXPECT_LT(source->loaded.size(), 60U);
  const auto at = std::ranges::find(localizer.maps(), answers.back().pose->map);
  EXPECT_EQ(localizer.map_keys().at(static_cast<std::size_t>(at - localizer.maps().begin())), 1);
}

TEST(LocalizerWithSource, AcceptsNoPoseWhenTheRightMapIsNotThere) {
  Localizer localizer(source_of_others(), {}, {});
  EXPECT_EQ(count(answers_of(localizer, storey_drive(80)), Status::kLocalized), 0U);
}

TEST(LocalizerWithSource, NearTwinsAmongAHundredMapsStayAmbiguousAndAreBothNamed) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  source->add(2, changed_map());
  Localizer localizer(source, {}, {});
  const std::vector<Answer> answers = answers_of(localizer, storey_drive(80));
  EXPECT_EQ(count(answers, Status::kLocalized), 0U);
  EXPECT_EQ(answers.back().status, Status::kAmbiguous) << to_string(answers.back().reason);
  EXPECT_THAT(names_in(answers.back()), IsSupersetOf({"own", "changed"}));
}

TEST(LocalizerWithSource, AcceptsNoPoseBesideALikelyMapThatCannotBeLoaded) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  source->add(2, changed_map());
  source->refuse(2);
  Localizer localizer(source, {}, {});
  const std::vector<Answer> answers = answers_of(localizer, storey_drive(80));
  EXPECT_EQ(count(answers, Status::kLocalized), 0U);
  EXPECT_EQ(answers.back().status, Status::kCollecting);
  EXPECT_EQ(answers.back().reason, Reason::kSearching);
  for (const Answer& answer : answers) EXPECT_LE(answer.confidence, 0.5 + 1e-9);
}

TEST(LocalizerWithSource, SearchesTheMapOfAStartRegionOnly) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  source->add(2, changed_map());
  Localizer localizer(source, {}, {});
  const std::vector<Moment> moments = storey_drive(80);
  localizer.reset(StartRegion{
      .map = "own", .center = moments.front().T_map_base_link.translation(), .radius_m = 2.0});
  const std::vector<Answer> answers = answers_of(localizer, {moments.begin(), moments.begin() + 8});
  EXPECT_THAT(source->loaded, UnorderedElementsAre(1));
  EXPECT_EQ(count_wrong(answers, moments), 0U);
}

TEST(LocalizerWithSource, FindsTheRobotNearAPlaceInOneOfManyMaps) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  // More than are all searched.
  for (std::size_t i = 0; i < 40; ++i) source->add(static_cast<MapKey>(2000 + i), other_maps()[i]);
  Localizer localizer(source, {}, {});
  const std::vector<Moment> moments = storey_drive(80);
  localizer.reset(
      StartRegion{.center = moments.front().T_map_base_link.translation(), .radius_m = 2.0});
  const std::vector<Answer> answers = answers_of(localizer, moments);
  EXPECT_EQ(count_wrong(answers, moments), 0U);
  ASSERT_TRUE(answers.back().pose) << to_string(answers.back().reason);
  EXPECT_EQ(answers.back().pose->map->name(), "own");
  EXPECT_TRUE(answers.back().is_given_region);
}

TEST(LocalizerWithSource, ContinuesInTheMapOfARestoredState) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  Localizer before(source, {}, {});
  const std::vector<Moment> moments = storey_drive(82);
  const std::vector<Moment> first(moments.begin(), moments.begin() + 80);
  ASSERT_TRUE(answers_of(before, first).back().pose);
  LocalizerState state = before.state();
  const std::vector<MapKey> held{before.map_keys().at(static_cast<std::size_t>(state.tracked_map))};
  state.tracked_map = 0;
  Localizer after(source, held, {});
  after.restore(std::move(state));
  const Answer answer = after.process(moments[80].scan);
  ASSERT_TRUE(answer.pose) << to_string(answer.reason);
  EXPECT_EQ(answer.pose->map->name(), "own");
}

TEST(LocalizerWithSource, HoldsOneMapOnceThePoseIsConfirmed) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  Localizer localizer(source, {}, {});
  bool is_confirmed = false;
  for (const Moment& moment : storey_drive(160)) {
    const Answer answer = localizer.process(moment.scan);
    is_confirmed = is_confirmed || (answer.pose && answer.pose->confirmed);
    if (is_confirmed) {
      ASSERT_TRUE(answer.pose) << to_string(answer.reason);
      EXPECT_EQ(answer.pose->map->name(), "own");
    }
  }
  ASSERT_TRUE(is_confirmed);
  EXPECT_THAT(localizer.map_keys(), ElementsAre(1));
  EXPECT_EQ(localizer.maps().size(), 1U);
}

TEST(LocalizerWithSource, TracksInANewerRevisionOfItsMap) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  Localizer localizer(source, {}, {});
  const std::vector<Moment> moments = storey_drive(82);
  const std::vector<Moment> first(moments.begin(), moments.begin() + 80);
  ASSERT_TRUE(answers_of(localizer, first).back().pose);
  const LocalizationMapPtr newer = storey_map(kOwnStorey, "newer");
  std::vector<LocalizationMapPtr> maps = localizer.maps();
  const auto at = std::ranges::find(localizer.map_keys(), MapKey{1});
  maps.at(static_cast<std::size_t>(at - localizer.map_keys().begin())) = newer;
  localizer.replace_maps(maps);
  const Answer answer = localizer.process(moments[80].scan);
  ASSERT_TRUE(answer.pose) << to_string(answer.reason);
  EXPECT_EQ(answer.pose->map, newer);
}

TEST(LocalizerWithSource, HoldsNoMoreThanTheSourceHasRoomFor) {
  const auto source = source_of_others();
  source->add(1, storey_map(kOwnStorey, "own"));
  source->max_bytes = 3 * other_maps()[0]->bytes();
  Localizer localizer(source, {}, {});
  for (const Moment& moment : storey_drive(40)) {
    const Answer answer = localizer.process(moment.scan);
    std::size_t bytes = 0;
    for (const LocalizationMapPtr& map : localizer.maps()) bytes += map->bytes();
    EXPECT_LE(bytes, source->max_bytes);
  }
}

/// Two corners of a long wall are all that it sees.
TEST(LocalizerWithSource, StatesThatCornersAreFewAmongMoreMapsThanAreAllSearched) {
  const auto source = source_of_others();
  for (std::size_t i = 0; i < 40; ++i) source->add(static_cast<MapKey>(2000 + i), other_maps()[i]);
  SceneBuilder scene;
  scene.wall({-30.0, 2.0}, {2.0, 2.0}).wall({2.0, 2.0}, {2.0, 30.0});
  std::vector<Pose2> poses;
  for (int i = 0; i < 24; ++i) poses.push_back({-0.3 * i, 0.0, 0.0});
  const std::vector<Moment> moments = drive(scene, {}, poses, 7);
  for (const bool is_near : {false, true}) {
    Localizer localizer(source, {}, {});
    if (is_near) localizer.reset(StartRegion{.center = {5.0, 5.0}, .radius_m = 2.0});
    for (const Answer& answer : answers_of(localizer, moments)) {
      EXPECT_EQ(answer.status, Status::kCollecting);
      EXPECT_EQ(answer.reason, Reason::kFewFeatures);
      EXPECT_LE(answer.confidence, 0.5 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace cornerfix
