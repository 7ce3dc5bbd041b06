/// \file  Empty databases of each engine, for tests of what both engines promise.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {

enum class Engine { kSqlite, kPostgresql };

/// Those that this program was built with.
[[nodiscard]] std::vector<Engine> engines();
[[nodiscard]] std::string name_of(Engine engine);

/// Databases of one engine, which a test knows by short names of its own.
class TestDatabases {
 public:
  explicit TestDatabases(Engine engine);

  /// Empty where the engine can be used here, else why not.
  [[nodiscard]] const std::string& obstacle() const { return obstacle_; }

  /// Where a database is; it exists only once it was opened.
  [[nodiscard]] std::string location(const std::string& name);
  /// Opens or creates; nothing where the engine cannot be used here.
  [[nodiscard]] std::shared_ptr<Database> open(const std::string& name,
                                               Synchronous synchronous = Synchronous::kNormal);
  [[nodiscard]] Result<std::shared_ptr<Database>> try_open(
      const std::string& name, int busy_timeout_ms = kDefaultBusyTimeoutMs);

  /// Runs SQL on a connection of its own, to look at what is stored or to damage it. The first
  /// number of the result, or 0.
  std::int64_t run(const std::string& name, const std::string& sql);
  /// A BLOB as SQL spells it.
  [[nodiscard]] std::string literal(BlobView blob) const;

 private:
  Engine engine_;
  std::string obstacle_;
  TempDirectory directory_;
  std::string prefix_;  ///< Of names in the server that all tests of this program share.
  std::set<std::string> created_;
};

/// A test that runs on every engine.
class EngineTest : public ::testing::TestWithParam<Engine> {
 protected:
  void SetUp() override;

  TestDatabases databases_{GetParam()};
};

/// A constant, since the macro that uses it is expanded in many files.
struct EngineName {
  std::string operator()(const ::testing::TestParamInfo<Engine>& info) const {
    return name_of(info.param);
  }
};

}  // namespace cornerfix::storage
