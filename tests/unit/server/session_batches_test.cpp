#include "server/localization_service.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <thread>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

using SessionBatchesTest = LocalizationServiceTest;

using ::testing::HasSubstr;

TEST_F(SessionBatchesTest, AnswersTheSameBatchWithTheSameBytes) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  const std::string first = answer(process_, id, batch(1));
  EXPECT_EQ(answer(process_, id, batch(1)), first);
  EXPECT_EQ(process_.events.scans, 6U);
}

TEST_F(SessionBatchesTest, RefusesOtherScansWithTheLastSequence) {
  const std::string id = create(process_);
  const std::string first = answer(process_, id, batch(0));
  auto other = batch(1);
  other.sequence = 0;
  Process restarted(file());
  for (Process* process : {&process_, &restarted}) {
    const auto refused = process->localization.post_scans(id, other);
    ASSERT_TRUE(refused);
    EXPECT_TRUE(refused->is_another_batch);
    EXPECT_EQ(refused->expected_sequence, 1U);
    EXPECT_EQ(answer(*process, id, batch(0)), first);
  }
  ASSERT_TRUE(service_.reset(id));
  EXPECT_TRUE(service_.post_scans(id, other)->is_another_batch);
}

TEST_F(SessionBatchesTest, SaysWhichSequenceItExpects) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  answer(process_, id, batch(1));
  for (const std::uint64_t wrong : {0U, 3U, 100U}) {
    auto request = batch(0);
    request.sequence = wrong;
    EXPECT_EQ(service_.post_scans(id, request)->expected_sequence, 2U) << wrong;
  }
  EXPECT_EQ(service_.find(id)->expected_sequence, 2U);
}

TEST_F(SessionBatchesTest, TakesNoHugeSequenceForTheOneBeforeTheFirst) {
  auto request = batch(0);
  request.sequence = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(service_.post_scans(create(process_), request)->expected_sequence, 0U);
}

TEST_F(SessionBatchesTest, TellsStampsThatAreNearToEachOtherApart) {
  const std::string id = create(process_);
  auto request = batch(0);
  for (std::size_t i = 0; i < 3; ++i) request.scans[i].scan.stamp = 1e9 + static_cast<double>(i);
  answer(process_, id, request);
  request.sequence = 1;
  request.scans[0].scan.stamp = 1e9 + 2.0 - 1.2e-7;
  EXPECT_THAT(service_.post_scans(id, request).error().message,
              HasSubstr("1000000001.9999999 is not after 1000000002"));
}

TEST_F(SessionBatchesTest, RefusesStampsThatDoNotIncreaseAndChangesNothing) {
  const std::string id = create(process_);
  const std::string first = answer(process_, id, batch(0));
  auto stale = batch(1);
  stale.scans[0].scan.stamp = drive_.scans[2].scan.stamp;
  const auto refused = service_.post_scans(id, stale);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().field, "/scans/0/stamp");
  EXPECT_EQ(service_.find(id)->expected_sequence, 1U);
  EXPECT_EQ(service_.find(id)->last_answer, first);
}

TEST_F(SessionBatchesTest, DoesNotBindLaterScansToTheNumberOfBeamsOfTheFirst) {
  const std::string id = create(process_);
  answer(process_, id, batch(0));
  const auto expected_beams = [&](const auto& head) {
    EXPECT_TRUE(head->lidars.only);
    return head->lidars.only ? head->lidars.only->beams : std::nullopt;
  };
  EXPECT_EQ(expected_beams(service_.head(id)), std::nullopt);
  EXPECT_EQ(expected_beams(Process(file()).localization.head(id)), std::nullopt);
}

TEST_F(SessionBatchesTest, AnswersRobotsSideBySide) {
  std::vector<std::string> ids;
  for (int i = 0; i < 8; ++i) ids.push_back(create(process_));
  std::vector<std::string> last(ids.size());
  std::vector<std::thread> threads;
  for (std::size_t robot = 0; robot < ids.size(); ++robot) {
    threads.emplace_back([&, robot] {
      for (std::uint64_t i = 0; i < 8; ++i) last[robot] = answer(process_, ids[robot], batch(i));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t robot = 0; robot < ids.size(); ++robot) {
    EXPECT_EQ(last[robot].substr(ids[robot].size()), last[0].substr(ids[0].size()));
  }
}

TEST_F(SessionBatchesTest, TakesABatchPostedTwiceAtOnceOnlyOnce) {
  const std::string id = create(process_);
  std::vector<std::string> answers(4);
  std::vector<std::thread> threads;
  for (std::string& text : answers) {
    threads.emplace_back([&] { text = answer(process_, id, batch(0)); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(process_.events.scans, 3U);
  EXPECT_EQ(std::ranges::count(answers, answers[0]), 4);
}

TEST_F(SessionBatchesTest, AConflictHasTheStampOfTheLastScan) {
  const std::string id = create(process_);
  EXPECT_FALSE(service_.post_scans(id, batch(1))->last_stamp.has_value());
  answer(process_, id, batch(0));
  const double last = drive_.scans[2].scan.stamp;
  EXPECT_EQ(service_.post_scans(id, batch(5))->last_stamp, last);
  EXPECT_EQ(Process(file()).localization.post_scans(id, batch(5))->last_stamp, last);
  auto other = batch(1);
  other.sequence = 0;
  EXPECT_EQ(service_.post_scans(id, other)->last_stamp, last);
}

}  // namespace
}  // namespace cornerfix::server
