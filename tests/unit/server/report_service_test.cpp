#include "server/report_service.hpp"

#include <gmock/gmock.h>

#include <future>
#include <stdexcept>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

using std::chrono::seconds;

constexpr seconds kNoWait{0};
constexpr seconds kLongWait{60};

class ReportServiceTest : public ServiceTest {
 protected:
  storage::MapInfo make_small_map(const std::string& name) {
    EXPECT_TRUE(process_.maps->put(name, {}));
    EXPECT_TRUE(process_.maps->grow(name, std::span(drive_).first(3)));
    return process_.maps->find(name).value();
  }

  std::vector<PosedScan> drive_ = testing::mapping_drive();
  Process process_{file()};
};

TEST_F(ReportServiceTest, AnswersWithAnErrorWhenMakingAReportThrowsAndGoesOn) {
  bool is_first = true;
  ReportService reports(process_.maps, [&](const auto&, const auto&, const auto&) {
    if (std::exchange(is_first, false)) throw std::runtime_error("no memory");
    return std::optional(LocalizabilityReport{});
  });
  const storage::MapInfo map = make_small_map("office");
  const auto failed = reports.get(map, kLongWait);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kInternal);
  EXPECT_EQ(failed.error().message, "no memory");
  const auto made = reports.get(map, kLongWait);
  ASSERT_TRUE(made);
  EXPECT_NE(made->report, nullptr);
}

TEST_F(ReportServiceTest, LeavesAReportAloneWhenSomebodyAsksForAnOlderRevision) {
  ReportService reports(process_.maps, [&](const auto&, const auto&, const auto&) {
    return std::optional(LocalizabilityReport{});
  });
  const storage::MapInfo older = make_small_map("office");
  ASSERT_TRUE(process_.maps->grow("office", std::span(drive_).subspan(3, 3)));
  const storage::MapInfo newer = process_.maps->find("office").value();
  ASSERT_GT(newer.revision, older.revision);
  const auto made = reports.get(newer, kLongWait);
  ASSERT_TRUE(made);
  const auto asked_late = reports.get(older, kLongWait);
  ASSERT_TRUE(asked_late);
  EXPECT_EQ(asked_late->revision, newer.revision);
  EXPECT_EQ(asked_late->report, made->report);
}

TEST_F(ReportServiceTest, GivesUpTheReportsOfDeletedMapsSoThatOthersHaveTheirPlace) {
  std::promise<void> began;
  // Like the real one, it ends when nobody wants its report any longer.
  ReportService reports(process_.maps, [&](const auto& map, const auto&, const auto& progress) {
    if (map->name() != "first") return std::optional(LocalizabilityReport{});
    began.set_value();
    while (progress(0.5)) std::this_thread::yield();
    return std::optional<LocalizabilityReport>();
  });
  std::vector<storage::MapInfo> deleted = {make_small_map("first")};
  ASSERT_TRUE(reports.get(deleted[0], kNoWait));
  began.get_future().wait();
  const storage::MapInfo last = make_small_map("last");
  while (reports.get(deleted.back(), kNoWait)) {
    deleted.push_back(make_small_map("map" + std::to_string(deleted.size())));
  }
  EXPECT_EQ(reports.get(last, kNoWait).error().code, ErrorCode::kUnavailable);

  for (const storage::MapInfo& map : deleted) reports.forget(map.id);
  const auto made = reports.get(last, kLongWait);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_NE(made->report, nullptr);
}

TEST_F(ReportServiceTest, TellsThoseWhoWaitThatTheMapIsGone) {
  std::promise<void> began;
  ReportService reports(process_.maps, [&](const auto&, const auto&, const auto& progress) {
    began.set_value();
    while (progress(0.5)) std::this_thread::yield();
    return std::optional<LocalizabilityReport>();
  });
  const storage::MapInfo map = make_small_map("office");
  auto waiting = std::async(std::launch::async, [&] { return reports.get(map, kLongWait); });
  began.get_future().wait();
  reports.forget(map.id);
  const auto answer = waiting.get();
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace cornerfix::server
