#include "server/media_types.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using api::BodyFormat;

TEST(ContentType, NamesTheFormat) {
  EXPECT_EQ(format_of_content_type("application/json"), BodyFormat::kJson);
  EXPECT_EQ(format_of_content_type("Application/JSON; charset=utf-8"), BodyFormat::kJson);
  EXPECT_EQ(format_of_content_type("application/cbor"), BodyFormat::kCbor);
  EXPECT_EQ(format_of_content_type("application/msgpack"), BodyFormat::kMessagePack);
  EXPECT_EQ(format_of_content_type("application/x-msgpack"), BodyFormat::kMessagePack);
  EXPECT_EQ(format_of_content_type("application/vnd.msgpack"), BodyFormat::kMessagePack);
}

TEST(ContentType, NamesABinaryBatchThatIsNoAnswer) {
  EXPECT_EQ(format_of_content_type("application/octet-stream"), BodyFormat::kBinaryBatch);
  EXPECT_EQ(best_format("application/octet-stream").body, BodyFormat::kJson);
}

TEST(ContentType, IsComparedWithoutCaseAndParameters) {
  EXPECT_EQ(media_type_of("Application/Vnd.SQLite3 ; charset=binary"), "application/vnd.sqlite3");
  EXPECT_EQ(media_type_of(""), "");
}

TEST(ContentType, MayBeMissing) { EXPECT_EQ(format_of_content_type(""), BodyFormat::kJson); }

TEST(ContentType, RefusesOthers) {
  for (const char* type : {"text/plain", "application/x-www-form-urlencoded",
                           "multipart/form-data; boundary=x", "application/jsonx"}) {
    EXPECT_EQ(format_of_content_type(type), std::nullopt) << type;
  }
}

TEST(Accept, IsJsonUnlessAnotherIsAskedFor) {
  for (const char* accept : {"", "*/*", "application/*", "text/html", "application/json",
                             "text/html, */*;q=0.1", "application/cbor;q=0"}) {
    EXPECT_EQ(best_format(accept).body, BodyFormat::kJson) << accept;
  }
}

TEST(Accept, TakesTheOneLikedBest) {
  EXPECT_EQ(best_format("application/cbor").body, BodyFormat::kCbor);
  EXPECT_EQ(best_format("application/json;q=0.5, application/msgpack").body,
            BodyFormat::kMessagePack);
  EXPECT_EQ(best_format("application/json;q=0.9,application/cbor;q=0.8").body, BodyFormat::kJson);
}

TEST(Accept, MayNameAProfile) {
  using api::AnswerProfile;
  const auto profile = [](const char* accept) { return best_format(accept).profile; };
  EXPECT_EQ(profile("application/json"), AnswerProfile::kPlain);
  EXPECT_EQ(profile("application/json; profile=ros"), AnswerProfile::kRos);
  EXPECT_EQ(profile("application/json;Profile=\"VDA5050\";q=0.5"), AnswerProfile::kVda5050);
  EXPECT_EQ(profile("application/json;profile=ros;q=0.5, application/json"), AnswerProfile::kPlain);
  EXPECT_EQ(profile("application/json;profile=other"), AnswerProfile::kPlain);
  EXPECT_EQ(best_format("application/cbor;profile=ros"),
            (AnswerFormat{BodyFormat::kCbor, AnswerProfile::kRos}));
}

}  // namespace
}  // namespace cornerfix::server
