/// \file  As much of JSON Schema as openapi.yaml uses: does a document fit?
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cornerfix::api {

/// What does not fit, a line each. With `only_known`, members that the schema does not name do not
/// fit either: what the service writes is documented.
class SchemaCheck {
 public:
  using Json = nlohmann::json;

  SchemaCheck(const Json& openapi, bool only_known) : openapi_(openapi), only_known_(only_known) {}

  [[nodiscard]] std::vector<std::string> check(const Json& schema, const Json& value) const {
    std::vector<std::string> wrong;
    check(schema, value, "", wrong);
    return wrong;
  }

 private:
  using Wrong = std::vector<std::string>;

  void check(const Json& schema, const Json& value, const std::string& at, Wrong& wrong) const {
    check_rules(schema, value, at, wrong);
    const Json known = only_known_ ? known_members(schema) : Json();
    if (!value.is_object() || known.empty()) return;
    for (const auto& [name, member] : value.items()) {
      if (!known.contains(name)) wrong.push_back(at + "/" + name + " is not documented");
    }
  }

  /// Of an object that must fit all of its parts.
  Json known_members(const Json& schema) const {
    Json known = schema.value("properties", Json::object());
    if (schema.contains("$ref")) known.update(known_members(target(schema)));
    for (const Json& part : schema.value("allOf", Json::array())) {
      known.update(known_members(part));
    }
    return known;
  }

  void check_rules(const Json& schema, const Json& value, const std::string& at,
                   Wrong& wrong) const {
    if (schema.contains("$ref")) check_rules(target(schema), value, at, wrong);
    check_type(schema, value, at, wrong);
    check_limits(schema, value, at, wrong);
    check_object(schema, value, at, wrong);
    if (schema.contains("items") && value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        check(schema["items"], value[i], at + "/" + std::to_string(i), wrong);
      }
    }
    for (const Json& part : schema.value("allOf", Json::array())) {
      check_rules(part, value, at, wrong);
    }
    check_alternatives(schema, "oneOf", value, at, wrong);
    check_alternatives(schema, "anyOf", value, at, wrong);
  }

  const Json& target(const Json& schema) const {
    return openapi_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1)));
  }

  static bool has_type(const Json& value, const std::string& type) {
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    return value.type_name() == type;
  }

  static void check_type(const Json& schema, const Json& value, const std::string& at,
                         Wrong& wrong) {
    if (!schema.contains("type")) return;
    const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
    for (const Json& type : types) {
      if (has_type(value, type)) return;
    }
    wrong.push_back(at + " is " + value.type_name() + ", not " + types.dump());
  }

  static void check_limits(const Json& schema, const Json& value, const std::string& at,
                           Wrong& wrong) {
    const auto broken = [&](const char* rule) { wrong.push_back(at + " breaks " + rule); };
    if (schema.contains("enum")) {
      const Json& allowed = schema["enum"];
      if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) broken("enum");
    }
    if (value.is_number()) {
      const double number = value;
      if (schema.contains("minimum") && number < schema["minimum"]) broken("minimum");
      if (schema.contains("maximum") && number > schema["maximum"]) broken("maximum");
    }
    if (value.is_array()) {
      if (schema.contains("minItems") && value.size() < schema["minItems"]) broken("minItems");
      if (schema.contains("maxItems") && value.size() > schema["maxItems"]) broken("maxItems");
    }
  }

  void check_object(const Json& schema, const Json& value, const std::string& at,
                    Wrong& wrong) const {
    if (!value.is_object()) return;
    for (const std::string name : schema.value("required", Json::array())) {
      if (!value.contains(name)) wrong.push_back(at + "/" + name + " is missing");
    }
    if (!schema.contains("properties")) return;
    const Json& properties = schema["properties"];
    const bool closed = schema.value("additionalProperties", true) == false;
    for (const auto& [name, member] : value.items()) {
      if (properties.contains(name)) {
        check(properties[name], member, at + "/" + name, wrong);
      } else if (closed) {
        wrong.push_back(at + "/" + name + " is not in the schema");
      }
    }
  }

  void check_alternatives(const Json& schema, const char* rule, const Json& value,
                          const std::string& at, Wrong& wrong) const {
    if (!schema.contains(rule)) return;
    Wrong of_first;
    for (const Json& part : schema[rule]) {
      Wrong of_part;
      check(part, value, at, of_part);
      if (of_part.empty()) return;
      if (of_first.empty()) of_first = of_part;
    }
    wrong.insert(wrong.end(), of_first.begin(), of_first.end());
  }

  const Json& openapi_;
  bool only_known_;
};

}  // namespace cornerfix::api
