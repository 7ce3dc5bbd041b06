#include "storage/digest.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

KeyFrameChain chain_of(const std::vector<PosedScan>& key_frames) {
  KeyFrameChain chain{};
  for (const PosedScan& key_frame : key_frames) chain = extend(chain, encode_key_frame(key_frame));
  return chain;
}

// sha256sum of 32 zero bytes, and of those followed by "{}".
TEST(Digest, IsTheSha256ThatTheSchemaDescribes) {
  EXPECT_EQ(map_digest("", {}), "66687aadf862bd776c8fc18b8e9f8e20089714856ee233b3902a591d0d5f2925");
  EXPECT_EQ(map_digest("{}", {}),
            "fb1634c4e6cd4b1f1afe3ce2d6ef080f7ac5d1f357d723ad4dfca782733b62db");
}

TEST(Digest, ChangesWithTheParameters) {
  EXPECT_NE(map_digest("{\"a\":1}", {}), map_digest("{\"a\":2}", {}));
}

TEST(Digest, ChangesWithOneRangeOfOneKeyFrame) {
  std::vector<PosedScan> key_frames = sample_key_frames(3);
  const KeyFrameChain before = chain_of(key_frames);
  key_frames[1].scan.ranges[0] += 0.01F;
  EXPECT_NE(map_digest("", chain_of(key_frames)), map_digest("", before));
}

TEST(Digest, ChangesWithTheOrderOfKeyFrames) {
  std::vector<PosedScan> key_frames = sample_key_frames(3);
  const KeyFrameChain before = chain_of(key_frames);
  std::swap(key_frames[0], key_frames[2]);
  EXPECT_NE(map_digest("", chain_of(key_frames)), map_digest("", before));
}

}  // namespace
}  // namespace cornerfix::storage
