#include "bench/rivals/particle_bins.hpp"

#include <gtest/gtest.h>

namespace cornerfix::bench {
namespace {

TEST(ParticleBins, CountsABinOnce) {
  ParticleBins bins;
  bins.insert({0.1, 0.1, 0.05});
  bins.insert({0.4, 0.4, 0.10});
  EXPECT_EQ(bins.size(), 1U);
}

TEST(ParticleBins, DistinguishesHeadings) {
  ParticleBins bins;
  bins.insert({0.1, 0.1, 0.05});
  bins.insert({0.1, 0.1, 1.0});
  EXPECT_EQ(bins.size(), 2U);
}

TEST(ParticleBins, JoinsBinsThatTouchInACorner) {
  ParticleBins bins;
  bins.insert({0.4, 0.4, 0.05});
  bins.insert({0.6, 0.6, 0.20});
  EXPECT_EQ(bins.find_clusters(), 1U);
}

TEST(ParticleBins, JoinsAcrossTheSeamOfHeadings) {
  ParticleBins bins;
  bins.insert({0.1, 0.1, 3.14});
  bins.insert({0.1, 0.1, -3.14});
  EXPECT_EQ(bins.find_clusters(), 1U);
}

TEST(ParticleBins, DistinguishesPositions) {
  ParticleBins bins;
  bins.insert({-3.0, 0.1, 0.0});
  bins.insert({3.0, 0.1, 0.0});
  EXPECT_EQ(bins.find_clusters(), 2U);
  EXPECT_NE(bins.cluster_of({-3.0, 0.1, 0.0}), bins.cluster_of({3.0, 0.1, 0.0}));
}

}  // namespace
}  // namespace cornerfix::bench
