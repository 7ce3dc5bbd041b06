/// \file  The maps of one session that may be in any map: ranked, then loaded one by one.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <cornerfix/map_source.hpp>

#include "server/map_library.hpp"
#include "server/map_ranking.hpp"

namespace cornerfix::server {

/// Stateless: threads may share it.
class RankedMapSource : public MapSource {
 public:
  /// \param max_bytes  Of the maps that the session holds together; a single one may have more.
  RankedMapSource(std::shared_ptr<MapRanking> ranking, std::shared_ptr<MapLibrary> library,
                  std::size_t max_bytes);

  [[nodiscard]] std::size_t size() override { return ranking_->size(); }
  [[nodiscard]] double free_area_m2() override { return ranking_->free_area_m2(); }
  [[nodiscard]] std::vector<RankedMap> rank(const MapQuery& query) override {
    return ranking_->rank(query);
  }
  [[nodiscard]] std::vector<MapKey> keys() override { return ranking_->keys(); }
  [[nodiscard]] std::optional<MapKey> find(std::string_view name) override {
    return ranking_->find(name);
  }
  [[nodiscard]] LocalizationMapPtr load(MapKey key, std::size_t held_bytes) override;

 private:
  std::shared_ptr<MapRanking> ranking_;
  std::shared_ptr<MapLibrary> library_;
  std::size_t max_bytes_;
};

}  // namespace cornerfix::server
