#include "server/entity_tag.hpp"

#include <algorithm>

namespace cornerfix::server {
namespace {

/// A tag without the mark of a weak one: `"…"`.
std::string_view opaque_part(std::string_view tag) {
  if (tag.starts_with("W/")) tag.remove_prefix(2);
  return tag;
}

/// Takes the next tag from the front of a list; empty when there is none.
std::string_view take_tag(std::string_view& list) {
  list.remove_prefix(std::min(list.find_first_not_of(" \t,"), list.size()));
  const std::string_view opaque = opaque_part(list);
  if (!opaque.starts_with('"')) return {};
  const auto end = opaque.find('"', 1);
  if (end == std::string_view::npos) return {};
  const std::string_view tag = list.substr(0, list.size() - opaque.size() + end + 1);
  list.remove_prefix(tag.size());
  return tag;
}

bool is_any(std::string_view list) {
  const auto first = list.find_first_not_of(" \t");
  return first != std::string_view::npos && list[first] == '*' &&
         list.find_first_not_of(" \t", first + 1) == std::string_view::npos;
}

}  // namespace

bool names_entity_tag(std::string_view if_none_match, std::string_view tag) {
  if (is_any(if_none_match)) return true;
  for (;;) {
    const std::string_view named = take_tag(if_none_match);
    if (named.empty()) return false;
    if (opaque_part(named) == opaque_part(tag)) return true;
  }
}

bool requires_entity_tag(std::string_view if_match, std::string_view tag) {
  if (is_any(if_match)) return true;
  for (;;) {
    const std::string_view named = take_tag(if_match);
    if (named.empty()) return false;
    if (named == tag) return true;
  }
}

}  // namespace cornerfix::server
