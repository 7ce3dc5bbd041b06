// Build step: openapi.yaml to a source file that holds it as JSON.
//
// embed_openapi openapi.yaml openapi.cpp

#include <yaml-cpp/yaml.h>

#include <exception>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

using Json = nlohmann::ordered_json;

/// YAML's core schema for a plain scalar; a quoted one is always a string.
Json scalar_to_json(const YAML::Node& node) {
  const std::string& text = node.Scalar();
  const bool is_plain = node.Tag() == "?";
  if (!is_plain) return text;
  if (text == "null" || text == "~" || text.empty()) return nullptr;
  if (text == "true") return true;
  if (text == "false") return false;
  const Json number = Json::parse(text, nullptr, false);
  return number.is_number() ? number : Json(text);
}

Json to_json(const YAML::Node& node) {
  if (node.IsMap()) {
    Json object = Json::object();
    for (const auto& member : node) object[member.first.Scalar()] = to_json(member.second);
    return object;
  }
  if (node.IsSequence()) {
    Json array = Json::array();
    for (const auto& item : node) array.push_back(to_json(item));
    return array;
  }
  return node.IsScalar() ? scalar_to_json(node) : Json(nullptr);
}

void write_source(const Json& document, std::ostream& out) {
  out << "#include \"api/openapi.hpp\"\n\n"
      << "namespace cornerfix::api {\n\n"
      << "std::string_view openapi_json() {\n"
      << "  return R\"openapi(" << document.dump() << ")openapi\";\n"
      << "}\n\n"
      << "}  // namespace cornerfix::api\n";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: embed_openapi openapi.yaml openapi.cpp\n";
    return 2;
  }
  try {
    std::ofstream out(argv[2]);
    write_source(to_json(YAML::LoadFile(argv[1])), out);
    out.close();
    if (out) return 0;
    std::cerr << argv[2] << ": cannot be written\n";
  } catch (const std::exception& error) {
    std::cerr << argv[1] << ": " << error.what() << '\n';
  }
  return 1;
}
