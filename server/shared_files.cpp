#include "server/shared_files.hpp"

#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>

namespace cornerfix::server {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path find_shared(const fs::path& installed, const fs::path& in_source) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  const fs::path bin = program.parent_path();
  const fs::path beside = bin.parent_path() / "share" / "cornerfix" / installed;
  if (fs::exists(beside, error)) return beside;
  // build/PRESET/bin/PROGRAM, three levels below the source tree.
  const fs::path source = bin.parent_path().parent_path().parent_path() / in_source;
  return fs::exists(source, error) ? source : fs::path{};
}

/// A plain scalar means what it looks like (YAML's core schema); a quoted one is a string.
Json scalar_to_json(const YAML::Node& node) {
  const std::string& text = node.Scalar();
  const bool is_plain = node.Tag() == "?" || node.Tag().empty();
  if (!is_plain) return text;
  if (text == "true" || text == "false") return text == "true";
  const Json number = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  return number.is_number() ? number : Json(text);
}

Json to_json(const YAML::Node& node) {
  if (node.IsScalar()) return scalar_to_json(node);
  Json json;
  if (node.IsSequence()) {
    json = Json::array();
    for (const YAML::Node& item : node) json.push_back(to_json(item));
  } else if (node.IsMap()) {
    json = Json::object();
    for (const auto& member : node) json[member.first.Scalar()] = to_json(member.second);
  }
  return json;
}

}  // namespace

fs::path find_web_root() { return find_shared("web", "web"); }

fs::path find_openapi_file() {
  return find_shared("openapi.yaml", fs::path("api") / "openapi.yaml");
}

Result<std::string> yaml_file_as_json(const fs::path& path) {
  try {
    return to_json(YAML::LoadFile(path.string())).dump();
  } catch (const YAML::Exception& exception) {
    return Error{ErrorCode::kMalformed, exception.what(), path.string()};
  }
}

}  // namespace cornerfix::server
