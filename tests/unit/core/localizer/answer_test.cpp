#include <cornerfix/answer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cornerfix {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Answer, NamesItsStatusAsOnTheWire) {
  EXPECT_EQ(to_string(Status::kCollecting), "collecting");
  EXPECT_EQ(to_string(Status::kAmbiguous), "ambiguous");
  EXPECT_EQ(to_string(Status::kLocalized), "localized");
  EXPECT_EQ(to_string(Status::kLost), "lost");
}

TEST(Answer, NamesWhatIsMissingAsOnTheWire) {
  EXPECT_EQ(to_string(Reason::kNone), "");
  EXPECT_EQ(to_string(Reason::kNoReturns), "no_returns");
  EXPECT_EQ(to_string(Reason::kFewFeatures), "few_features");
  EXPECT_EQ(to_string(Reason::kNoMotion), "no_motion");
  EXPECT_EQ(to_string(Reason::kNoMatch), "no_match");
  EXPECT_EQ(to_string(Reason::kFewEvidence), "few_evidence");
  EXPECT_EQ(to_string(Reason::kContradicted), "contradicted");
  EXPECT_EQ(to_string(Reason::kOdometryContradictsScans), "odometry_contradicts_scans");
  EXPECT_EQ(to_string(Reason::kSearching), "searching");
  EXPECT_EQ(to_string(Reason::kPriorContradicted), "prior_contradicted");
  EXPECT_EQ(to_string(Reason::kMirroredScans), "mirrored_scans");
}

MATCHER_P2(IsClass, name, count, "is class " + std::string(name)) {
  return arg.name == name && arg.count == count;
}

TEST(Answer, ListsTheClassesThatHaveHitsOrMisses) {
  EvidenceScore score;
  score.end_counts.front() = 3;
  score.end_counts.back() = 2;
  score.pass_counts[2] = 40;
  const auto hits = hits_by_class(score);
  EXPECT_THAT(hits, ElementsAre(IsClass("wall_0.05", 3), IsClass("hidden", 2)));
  EXPECT_GT(hits.front().decision_llr, 0.0);
  EXPECT_LT(hits.back().decision_llr, 0.0);
  EXPECT_THAT(misses_by_class(score), ElementsAre(IsClass("free", 40)));
  EXPECT_THAT(hits_by_class({}), IsEmpty());
}

}  // namespace
}  // namespace cornerfix
