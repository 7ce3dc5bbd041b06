#include "server/entity_tag.hpp"

#include <gtest/gtest.h>

namespace cornerfix::server {
namespace {

constexpr const char* kTag = R"(W/"a1-image/png")";

TEST(EntityTag, IsNamedWeakOrStrongAnywhereInAList) {
  for (const char* list : {R"(W/"a1-image/png")", R"("a1-image/png")", R"("x", W/"a1-image/png")",
                           R"("x,y" , "a1-image/png","z")", "*", " * "}) {
    EXPECT_TRUE(names_entity_tag(list, kTag)) << list;
  }
}

TEST(EntityTag, IsNotNamedByOtherTagsOrBrokenLists) {
  for (const char* list : {"", R"("a1")", R"("xa1-image/png")", "a1-image/png", R"("a1-image/png)",
                           R"("*")", R"(x, "a1-image/png")", ", ,", R"("W/"a1-image/png"")"}) {
    EXPECT_FALSE(names_entity_tag(list, kTag)) << list;
  }
}

TEST(EntityTag, IsRequiredByAListThatHasItAndNoWeakOne) {
  for (const char* list :
       {R"("a1-image/png")", R"("x", "a1-image/png")", R"(W/"y","a1-image/png")", "*"}) {
    EXPECT_TRUE(requires_entity_tag(list, R"("a1-image/png")")) << list;
  }
  for (const char* list : {"", R"("a1")", R"(W/"a1-image/png")", "a1-image/png", R"("*")"}) {
    EXPECT_FALSE(requires_entity_tag(list, R"("a1-image/png")")) << list;
  }
}

}  // namespace
}  // namespace cornerfix::server
