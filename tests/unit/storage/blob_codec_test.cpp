#include "storage/blob_codec.hpp"

#include <gmock/gmock.h>
#include <zlib.h>

#include <functional>
#include <limits>
#include <string>

#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::HasSubstr;

/// One kind of BLOB: bytes of a sample, and whether bytes decode.
struct Codec {
  std::string name;
  Blob sample;
  std::function<std::optional<Error>(BlobView)> decode;
};

template <typename Decode>
auto error_of(Decode decode) {
  return [decode](BlobView blob) -> std::optional<Error> {
    const auto result = decode(blob);
    return result ? std::nullopt : std::optional(result.error());
  };
}

const std::vector<Codec>& codecs() {
  static const std::vector<Codec> kCodecs = [] {
    const MapContent content = sample_content(4);
    const std::vector<SubmapScanKey> keys = {{7, 0xDEADBEEF}, {9, 1}};
    return std::vector<Codec>{
        {"KeyFrame", encode_key_frame(sample_key_frame(1)), error_of(decode_key_frame)},
        {"Features", encode_features(content.features), error_of(decode_features)},
        {"Descriptors", encode_descriptors(content.descriptors), error_of(decode_descriptors)},
        {"Grid", encode_grid(content.grid), error_of(decode_grid)},
        {"SubmapScan", encode_submap_scan(sample_submap_scan(3, 2)), error_of(decode_submap_scan)},
        {"LocalizerState", encode_localizer_state(sample_state(0, 0, 1), keys),
         error_of(decode_localizer_state)},
        {"MapSketch", encode_map_sketch(sample_sketch(1)), error_of(decode_map_sketch)},
    };
  }();
  return kCodecs;
}

/// The BLOB with a checksum that is right for its bytes: what a careful forger would store.
Blob resealed(Blob blob) {
  const std::size_t size = blob.size() - 4;
  const auto checksum = static_cast<std::uint32_t>(::crc32_z(0, blob.data(), size));
  for (std::size_t i = 0; i < 4; ++i) {
    blob[size + i] = static_cast<std::uint8_t>(checksum >> (8 * i));
  }
  return blob;
}

void set_u32(Blob& blob, std::size_t offset, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) {
    blob[offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

class EveryBlob : public ::testing::TestWithParam<std::size_t> {
 protected:
  [[nodiscard]] static const Codec& codec() { return codecs()[GetParam()]; }
  static void expect_corrupt(BlobView blob, const std::string& what) {
    const std::optional<Error> error = codec().decode(blob);
    ASSERT_TRUE(error) << codec().name << ": " << what;
    EXPECT_EQ(error->code, ErrorCode::kCorruptData) << codec().name << ": " << what;
  }
};

INSTANTIATE_TEST_SUITE_P(Kinds, EveryBlob, ::testing::Range<std::size_t>(0, 7),
                         [](const auto& kind) { return codecs()[kind.param].name; });

TEST_P(EveryBlob, DecodesAsEncoded) { EXPECT_FALSE(codec().decode(codec().sample)); }

TEST_P(EveryBlob, IsRefusedWhenCutShortAtAnyLength) {
  const BlobView sample = codec().sample;
  for (std::size_t size = 0; size < sample.size(); ++size) {
    expect_corrupt(sample.first(size), std::to_string(size) + " bytes");
  }
}

TEST_P(EveryBlob, IsRefusedWhenCutShortAndResealedAtAnyLength) {
  const BlobView sample = codec().sample;
  for (std::size_t size = 6; size < sample.size(); ++size) {
    const BlobView part = sample.first(size);
    expect_corrupt(resealed(Blob(part.begin(), part.end())), std::to_string(size) + " bytes");
  }
}

TEST_P(EveryBlob, IsRefusedWithAnyBitFlipped) {
  Blob blob = codec().sample;
  for (std::size_t bit = 0; bit < blob.size() * 8; ++bit) {
    const auto mask = static_cast<std::uint8_t>(1U << (bit % 8));
    blob[bit / 8] ^= mask;
    expect_corrupt(blob, "bit " + std::to_string(bit));
    blob[bit / 8] ^= mask;
  }
}

TEST_P(EveryBlob, IsRefusedWithBytesBehindIt) {
  Blob blob = codec().sample;
  blob.insert(blob.end() - 4, 3, 0);
  expect_corrupt(resealed(blob), "three more bytes");
}

TEST_P(EveryBlob, IsRefusedInAnotherVersion) {
  Blob blob = codec().sample;
  blob[0] += 1;
  const std::optional<Error> error = codec().decode(resealed(blob));
  ASSERT_TRUE(error);
  EXPECT_THAT(error->message, HasSubstr("version"));
  blob[0] = 0;
  EXPECT_TRUE(codec().decode(resealed(blob)));
}

TEST_P(EveryBlob, IsRefusedAsAnotherKind) {
  for (const Codec& other : codecs()) {
    if (other.name != codec().name) expect_corrupt(other.sample, "bytes of " + other.name);
  }
}

// For any bytes, decoding ends with a value or an error; the sanitizers watch.
TEST_P(EveryBlob, SurvivesAnyResealedByte) {
  const Blob sample = codec().sample;
  for (std::size_t i = 2; i < sample.size() - 4; ++i) {
    for (const std::uint8_t value : Blob{0x00, 0x7F, 0x80, 0xFF}) {
      Blob blob = sample;
      blob[i] = value;
      const std::optional<Error> error = codec().decode(resealed(blob));
      EXPECT_TRUE(!error || error->code == ErrorCode::kCorruptData);
    }
  }
}

TEST(BlobCodec, BeginsWithVersionAndKind) {
  for (std::size_t i = 0; i < codecs().size(); ++i) {
    const std::string& name = codecs()[i].name;
    EXPECT_EQ(codecs()[i].sample[0], name == "LocalizerState" ? 5 : name == "Features" ? 2 : 1);
    EXPECT_EQ(codecs()[i].sample[1], i + 1) << codecs()[i].name;
  }
}

TEST(BlobCodec, GivesBackAKeyFrameBitForBit) {
  const PosedScan key_frame = sample_key_frame(5);
  EXPECT_TRUE(is_same(decode_key_frame(encode_key_frame(key_frame)).value(), key_frame));
}

TEST(BlobCodec, GivesBackAKeyFrameWithoutBeams) {
  PosedScan key_frame = sample_key_frame(5);
  key_frame.scan.ranges.clear();
  EXPECT_TRUE(is_same(decode_key_frame(encode_key_frame(key_frame)).value(), key_frame));
}

TEST(BlobCodec, ReadsFeaturesOfTheFirstVersion) {
  std::vector<Feature> features = sample_content(9).features;
  const Blob newest = encode_features(features);
  Blob first(newest.begin(), newest.begin() + 6);
  first[0] = 1;
  for (std::size_t i = 0; i < features.size(); ++i) {
    const auto begin = newest.begin() + static_cast<std::ptrdiff_t>(6 + 53 * i);
    first.insert(first.end(), begin, begin + 44);
    features[i].convex = false;
    features[i].sigma_m = 0.0;
  }
  first.resize(first.size() + 4);
  EXPECT_TRUE(is_same(decode_features(resealed(first)).value(), features));
}

TEST(BlobCodec, GivesBackFeaturesBitForBit) {
  const std::vector<Feature> features = sample_content(9).features;
  EXPECT_TRUE(is_same(decode_features(encode_features(features)).value(), features));
}

TEST(BlobCodec, GivesBackDescriptorsBitForBit) {
  const DescriptorSet set = sample_content(9).descriptors;
  EXPECT_TRUE(is_same(decode_descriptors(encode_descriptors(set)).value(), set));
}

TEST(BlobCodec, GivesBackDescriptorsOfNoFeatures) {
  const DescriptorSet set;
  EXPECT_TRUE(is_same(decode_descriptors(encode_descriptors(set)).value(), set));
}

TEST(BlobCodec, GivesBackAGridBitForBit) {
  const OccupancyGrid grid = sample_content(1).grid;
  EXPECT_TRUE(is_same(decode_grid(encode_grid(grid)).value(), grid));
}

TEST(BlobCodec, GivesBackAnEmptyGrid) {
  const OccupancyGrid grid;
  EXPECT_TRUE(is_same(decode_grid(encode_grid(grid)).value(), grid));
}

TEST(BlobCodec, GivesBackAMapSketchBitForBit) {
  for (const MapSketch& sketch : {sample_sketch(4), MapSketch{}})
    EXPECT_EQ(decode_map_sketch(encode_map_sketch(sketch)).value(), sketch);
}

TEST(BlobCodec, RefusesAMapSketchThatCannotBeUsed) {
  MapSketch without_cells = sample_sketch(1);
  without_cells.cell_m = 0.0;
  MapSketch endless_corner = sample_sketch(1);
  endless_corner.corners[1].y = std::numeric_limits<float>::infinity();
  MapSketch lost = sample_sketch(1);
  lost.T_map_grid.yaw = std::numeric_limits<double>::quiet_NaN();
  for (const MapSketch& sketch : {without_cells, endless_corner, lost})
    EXPECT_EQ(decode_map_sketch(encode_map_sketch(sketch)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, GivesBackASubmapScanBitForBit) {
  const SubmapScan scan = sample_submap_scan(std::numeric_limits<std::uint64_t>::max(), 4);
  EXPECT_TRUE(is_same(decode_submap_scan(encode_submap_scan(scan)).value(), scan));
}

TEST(BlobCodec, GivesBackALocalizerStateBitForBit) {
  const LocalizerState state = sample_state(0, 0, 3);
  const std::vector<SubmapScanKey> keys = {{3, 4}, {1, 2}};
  const LocalizerStateOutline outline =
      decode_localizer_state(encode_localizer_state(state, keys)).value();
  EXPECT_TRUE(is_same(outline.state, state));
  EXPECT_EQ(outline.submap, keys);
}

// Where the fields that a version added begin in the newest one, and how long they are.
constexpr std::ptrdiff_t kSecondVersion = 150;
constexpr std::ptrdiff_t kSecondSize = 98;
constexpr std::ptrdiff_t kThirdVersion = kSecondVersion + kSecondSize;
constexpr std::ptrdiff_t kThirdSize = 81;
constexpr std::ptrdiff_t kFifthVersion = kThirdVersion + kThirdSize;
constexpr std::ptrdiff_t kFifthSize = 46;  // Of a region without a map's name.

/// A state as versions before the fifth could hold it, and its BLOB in the fifth.
struct OldState {
  LocalizerState state = sample_state(0, 0, 3);
  Blob blob;

  OldState() {
    state.region.reset();
    blob = encode_localizer_state(state, {});
    blob.erase(blob.begin() + kFifthVersion, blob.begin() + kFifthVersion + kFifthSize);
  }
};

TEST(BlobCodec, ReadsALocalizerStateOfTheFourthVersion) {
  OldState old;
  old.blob[0] = 4;
  EXPECT_TRUE(is_same(decode_localizer_state(resealed(old.blob)).value().state, old.state));
}

TEST(BlobCodec, RefusesALocalizerStateWithAnImpossibleRegion) {
  LocalizerState state = sample_state(0, 0, 3);
  state.region->radius_m = -1.0;
  EXPECT_EQ(decode_localizer_state(encode_localizer_state(state, {})).error().code,
            ErrorCode::kCorruptData);
}

void forget_fourth_version(LocalizerState& state) { state.last_interval_s = 0.0; }

void forget_third_version(LocalizerState& state) {
  forget_fourth_version(state);
  state.odometry_sums = {};
  state.epoch = 0;
  state.confirmed = false;
  state.distance_since_acceptance_m = 0.0;
  state.searched_at_m = 0.0;
  state.accepted_index = 0;
}

TEST(BlobCodec, ReadsALocalizerStateOfTheThirdVersion) {
  auto [state, third] = OldState();
  third[0] = 3;
  forget_fourth_version(state);
  EXPECT_TRUE(is_same(decode_localizer_state(resealed(third)).value().state, state));
}

TEST(BlobCodec, ReadsALocalizerStateOfTheSecondVersion) {
  auto [state, second] = OldState();
  second.erase(second.begin() + kThirdVersion, second.begin() + kThirdVersion + kThirdSize);
  second[0] = 2;
  forget_third_version(state);
  EXPECT_TRUE(is_same(decode_localizer_state(resealed(second)).value().state, state));
}

TEST(BlobCodec, ReadsALocalizerStateOfTheFirstVersion) {
  auto [state, first] = OldState();
  first.erase(first.begin() + kSecondVersion, first.begin() + kThirdVersion + kThirdSize);
  first[0] = 1;
  state.misfit_way_m = 0.0;
  state.tracking_covariance = {};
  state.usual_fit.reset();
  state.usual_share.reset();
  forget_third_version(state);
  EXPECT_TRUE(is_same(decode_localizer_state(resealed(first)).value().state, state));
}

TEST(BlobCodec, GivesBackAFreshLocalizerState) {
  const LocalizerState state;
  EXPECT_TRUE(
      is_same(decode_localizer_state(encode_localizer_state(state, {})).value().state, state));
}

TEST(BlobCodec, RefusesAHugeNumberOfFeaturesWithoutAllocatingThem) {
  Blob blob = encode_features(sample_content(2).features);
  set_u32(blob, 2, 0xFFFFFFFF);
  EXPECT_EQ(decode_features(resealed(blob)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesAHugeGridWithoutAllocatingIt) {
  Blob blob = encode_grid(sample_content(1).grid);
  set_u32(blob, 34, 0x7FFFFFFF);
  set_u32(blob, 38, 0x7FFFFFFF);
  EXPECT_EQ(decode_grid(resealed(blob)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesAGridOfNegativeSize) {
  Blob blob = encode_grid(OccupancyGrid{});
  set_u32(blob, 34, 0xFFFFFFFF);
  EXPECT_EQ(decode_grid(resealed(blob)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesAnUnknownKindOfCell) {
  OccupancyGrid grid = sample_content(1).grid;
  grid.cells[5] = static_cast<Cell>(3);
  EXPECT_EQ(decode_grid(encode_grid(grid)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesADescriptorOfAFeatureThatIsNotThere) {
  DescriptorSet set = sample_content(3).descriptors;
  set.entries.back().feature = 3;
  EXPECT_EQ(decode_descriptors(encode_descriptors(set)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesDescriptorOffsetsThatDoNotAscend) {
  DescriptorSet set = sample_content(3).descriptors;
  std::swap(set.offsets[1], set.offsets[2]);
  EXPECT_EQ(decode_descriptors(encode_descriptors(set)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesDescriptorEntriesThatBelongToNoFeature) {
  DescriptorSet set = sample_content(3).descriptors;
  set.entries.push_back(set.entries.back());
  EXPECT_EQ(decode_descriptors(encode_descriptors(set)).error().code, ErrorCode::kCorruptData);
}

TEST(BlobCodec, RefusesAnUnknownStatus) {
  LocalizerState state;
  state.status = static_cast<Status>(4);
  EXPECT_EQ(decode_localizer_state(encode_localizer_state(state, {})).error().code,
            ErrorCode::kCorruptData);
}

TEST(BlobCodec, TellsScansApartByTheirChecksum) {
  SubmapScan scan = sample_submap_scan(0, 1);
  const std::uint32_t before = checksum_of(encode_submap_scan(scan));
  scan.scan.ranges[7] += 0.001F;
  EXPECT_NE(checksum_of(encode_submap_scan(scan)), before);
}

}  // namespace
}  // namespace cornerfix::storage
