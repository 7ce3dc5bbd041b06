/// \file  Namespaces of topics: "/robot1/scan" is in "/robot1", which encloses "/robot1/lidar".
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace cornerfix::evaluation {

/// "/robot1" of "/robot1/scan"; empty for "/scan".
[[nodiscard]] inline std::string_view namespace_of(std::string_view topic) {
  const std::size_t slash = topic.rfind('/');
  return slash == std::string_view::npos ? std::string_view() : topic.substr(0, slash);
}

/// "scan" of "/robot1/scan".
[[nodiscard]] inline std::string_view base_name(std::string_view topic) {
  return topic.substr(topic.rfind('/') + 1);
}

/// How near the namespace of `topic` encloses `other`: the length of the namespace, or nothing when
/// it does not.
[[nodiscard]] inline std::optional<std::size_t> nearness(std::string_view topic,
                                                         std::string_view other) {
  const std::string_view outer = namespace_of(topic);
  const std::string_view inner = namespace_of(other);
  const bool encloses =
      inner.starts_with(outer) && (inner.size() == outer.size() || inner[outer.size()] == '/');
  return encloses ? std::optional(outer.size()) : std::nullopt;
}

}  // namespace cornerfix::evaluation
