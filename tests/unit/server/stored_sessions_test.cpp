#include "server/localization_service.hpp"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

class StoredSessionsTest : public LocalizationServiceTest {
 protected:
  /// Overwrites what is stored of a session's state.
  void damage_state(const std::string& id) const {
    SQLite::Database database(file().string(), SQLite::OPEN_READWRITE);
    SQLite::Statement update(database, "UPDATE sessions SET state = x'00' WHERE id = ?");
    update.bind(1, id);
    update.exec();
  }
};

TEST_F(StoredSessionsTest, GoesOnAfterARestartAsIfThereHadBeenNone) {
  const std::string with = create(process_);
  const std::string without = create(process_);
  std::string expected;
  for (std::uint64_t i = 0; i < 8; ++i) expected = answer(process_, without, batch(i));
  for (std::uint64_t i = 0; i < 6; ++i) answer(process_, with, batch(i));
  Process restarted(file());
  EXPECT_EQ(restarted.localization.find(with)->expected_sequence, 6U);
  answer(restarted, with, batch(6));
  const std::string last = answer(restarted, with, batch(7));
  EXPECT_EQ(last.substr(with.size()), expected.substr(without.size()));
}

std::vector<Point2> points_base_link(const RobotScan& scan) {
  std::vector<Point2> points;
  for (const Point2& point : returns_as_points(scan.scan))
    points.push_back(scan.T_base_link_laser * point);
  return points;
}

TEST_F(StoredSessionsTest, ShowsTheNewestScanOfTheLocalMapAfterARestart) {
  const std::string id = create(process_);
  for (std::uint64_t i = 0; i < 6; ++i) answer(process_, id, batch(i));
  const std::vector<Point2> last = points_base_link(*service_.find(id)->last_scan);
  Process restarted(file());
  const auto view = restarted.localization.find(id);
  ASSERT_TRUE(view->last_scan);
  const std::vector<Point2> shown = points_base_link(*view->last_scan);
  ASSERT_FALSE(shown.empty());
  const auto is_near_the_last = [&](const Point2& point) {
    return std::ranges::any_of(last, [&](const Point2& o) { return (o - point).norm() < 0.2; });
  };
  EXPECT_GT(10 * std::ranges::count_if(shown, is_near_the_last), 9 * std::ssize(shown));
}

TEST_F(StoredSessionsTest, SharesASessionWithAnotherProcess) {
  const std::string shared = create(process_);
  const std::string alone = create(process_);
  Process other(file());
  std::string expected;
  std::string last;
  for (std::uint64_t i = 0; i < 8; ++i) {
    expected = answer(process_, alone, batch(i));
    last = answer(i % 2 == 0 ? process_ : other, shared, batch(i));
  }
  EXPECT_EQ(last.substr(shared.size()), expected.substr(alone.size()));
  EXPECT_EQ(answer(process_, shared, batch(7)), last);
  EXPECT_EQ(answer(other, shared, batch(7)), last);
}

TEST_F(StoredSessionsTest, SeesAResetByAnotherProcess) {
  const std::string id = create(process_);
  for (std::uint64_t i = 0; i < 5; ++i) answer(process_, id, batch(i));
  Process other(file());
  ASSERT_TRUE(other.localization.reset(id));
  auto early = batch(0);
  early.sequence = 5;
  answer(process_, id, early);
}

TEST_F(StoredSessionsTest, ListsAndForgetsSessions) {
  const std::string id = create(process_);
  create(process_);
  const std::string last = answer(process_, id, batch(0));
  const auto list = service_.list({}).value().sessions;
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].id, id);
  EXPECT_EQ(list[0].last_answer, last);
  ASSERT_TRUE(service_.remove(id));
  EXPECT_EQ(service_.list({}).value().sessions.size(), 1U);
  EXPECT_EQ(service_.post_scans(id, batch(1)).error().code, ErrorCode::kNotFound);
}

TEST_F(StoredSessionsTest, CountsSessionsInMemory) {
  create(process_);
  EXPECT_EQ(service_.count_by_status(), (SessionCounts{1, 0, 0, 0}));
}

TEST_F(StoredSessionsTest, KeepsTheLeastUsedSessionsInTheStoreOnly) {
  Process small(file(), {}, {.max_bytes = 1});
  std::vector<std::string> parked;
  std::vector<std::string> kept;
  for (int i = 0; i < 3; ++i) {
    parked.push_back(create(small));
    kept.push_back(create(process_));
  }
  const auto without_id = [](const std::string& answer) { return answer.substr(answer.find(' ')); };
  for (std::uint64_t i = 0; i < 5; ++i) {
    for (std::size_t robot = 0; robot < parked.size(); ++robot) {
      EXPECT_EQ(without_id(answer(small, parked[robot], batch(i))),
                without_id(answer(process_, kept[robot], batch(i))));
    }
  }
  const SessionCounts counts = small.localization.count_by_status();
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::size_t{0}), 1U);
}

TEST_F(StoredSessionsTest, LimitsTheSessionsOfARobot) {
  Process strict(file(), {}, {.max_per_robot = 2});
  const std::string first = create(strict);
  create(strict);
  EXPECT_FALSE(strict.localization.create(session_of("cart-7")).value().has_value());
  EXPECT_TRUE(strict.localization.create(session_of("cart-8")).value().has_value());
  ASSERT_TRUE(strict.localization.remove(first));
  create(strict);
}

TEST_F(StoredSessionsTest, LimitsTheSessionsOfAllRobots) {
  Process strict(file(), {}, {.max_all = 1});
  EXPECT_TRUE(strict.localization.create(session_of("cart-7")).value().has_value());
  EXPECT_FALSE(strict.localization.create(session_of("cart-8")).value().has_value());
}

TEST_F(StoredSessionsTest, RemovesASessionWhoseStateIsDamaged) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  damage_state(id);
  Process restarted(file());
  const auto found = restarted.localization.find(id);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kCorruptData);
  EXPECT_EQ(found.error().field, "session");
  EXPECT_EQ(restarted.localization.robot_of(id).value(), "cart-7");
  const auto list = restarted.localization.list({});
  ASSERT_EQ(list->sessions.size(), 1U);
  EXPECT_TRUE(list->sessions[0].is_damaged);
  EXPECT_TRUE(restarted.localization.remove(id));
  EXPECT_EQ(restarted.localization.robot_of(id).error().code, ErrorCode::kNotFound);
}

TEST_F(StoredSessionsTest, RemovesSessionsThatWereNotUsedForLong) {
  const std::string id = create(process_);
  Process later(file(), {}, {.expired_before = [] { return std::string("2024-06-01T12:00:00Z"); }});
  EXPECT_EQ(later.localization.find(id).error().code, ErrorCode::kNotFound);
}

TEST_F(StoredSessionsTest, ASessionThatIsSilentForLongIsStale) {
  const std::string id = create(process_);
  EXPECT_FALSE(service_.find(id)->is_stale);
  const auto at = [this](const std::string& stale_before) {
    return Process(file(), {}, {.stale_before = [=] { return stale_before; }});
  };
  Process soon = at("2024-05-01T12:00:00Z");
  EXPECT_FALSE(soon.localization.find(id)->is_stale);
  EXPECT_FALSE(soon.localization.list({}).value().sessions.front().is_stale);
  Process later = at("2024-05-01T12:00:01Z");
  EXPECT_TRUE(later.localization.find(id)->is_stale);
  EXPECT_TRUE(later.localization.list({}).value().sessions.front().is_stale);
}

TEST_F(StoredSessionsTest, NamesTheNewestSessionOfTheRobotInTheOlderOnes) {
  const std::string first = create(process_);
  EXPECT_EQ(service_.find(first)->superseded_by, "");
  const std::string other = service_.create(session_of("cart-8")).value().value().id;
  const std::string second = create(process_);
  const std::string third = create(process_);
  EXPECT_EQ(service_.find(first)->superseded_by, third);
  EXPECT_EQ(service_.find(second)->superseded_by, third);
  EXPECT_EQ(service_.find(third)->superseded_by, "");
  EXPECT_EQ(service_.find(other)->superseded_by, "");
  const auto sessions = service_.list({}).value().sessions;
  ASSERT_EQ(sessions.size(), 4U);
  EXPECT_EQ(sessions[0].superseded_by, third);
  EXPECT_EQ(sessions[3].superseded_by, "");
  ASSERT_TRUE(service_.remove(third));
  EXPECT_EQ(service_.find(first)->superseded_by, second);
}

TEST_F(StoredSessionsTest, ListsSessionsInPages) {
  std::vector<std::string> ids;
  for (int i = 0; i < 3; ++i) ids.push_back(create(process_));
  const SessionList first = service_.list({.limit = 2}).value();
  ASSERT_EQ(first.sessions.size(), 2U);
  EXPECT_EQ(first.sessions[1].id, ids[1]);
  const SessionList second = service_.list({.after = first.next.value(), .limit = 2}).value();
  ASSERT_EQ(second.sessions.size(), 1U);
  EXPECT_EQ(second.sessions[0].id, ids[2]);
  EXPECT_FALSE(second.next.has_value());
  EXPECT_TRUE(service_.list({.robot = "another"}).value().sessions.empty());
}

}  // namespace
}  // namespace cornerfix::server
