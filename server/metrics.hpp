/// \file  What the service counts, as Prometheus reads it.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/localization_service.hpp"
#include "server/map_library.hpp"

namespace cornerfix::server {

/// Any threads may call.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  /// `route` is a pattern ("/v1/maps/{map}"), never a path, so that the number of series is small.
  void count_request(std::string_view method, std::string_view route, int status, double seconds);
  void count_batch(const BatchEvents& events);

  /// Prometheus text format 0.0.4.
  [[nodiscard]] std::string render(const SessionCounts& sessions, const MapCacheUse& maps);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix::server
