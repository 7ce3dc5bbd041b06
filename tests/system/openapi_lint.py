#!/usr/bin/python3
"""Lints an OpenAPI 3.1 description: openapi_lint.py FILE.yaml

Its objects have the fields that the specification gives them and no others; names, references, path parameters
and security requirements resolve; schemas are JSON Schema 2020-12, and every example and default fits its own.
Exits with 77 where Debian's python3-jsonschema or python3-yaml is missing, unless CORNERFIX_REQUIRE_TOOLS is set.
"""

import json
import os
import re
import sys

try:
    import yaml
    from jsonschema import Draft202012Validator, RefResolver
except ImportError as missing:
    print(f"openapi_lint: SKIPPED, {missing}")
    sys.exit(1 if os.environ.get("CORNERFIX_REQUIRE_TOOLS") else 77)

METHODS = ["get", "put", "post", "delete", "options", "head", "patch", "trace"]
TEXT = {"type": "string", "minLength": 1}
FLAG = {"type": "boolean"}
ANY = True


def shape(required, optional):
    """An object of these fields; extensions begin with x-."""
    return {
        "type": "object",
        "required": list(required),
        "properties": {**required, **optional},
        "patternProperties": {"^x-": ANY},
        "additionalProperties": False,
    }


def is_a(name):
    return {"$ref": f"#/$defs/{name}"}


def or_reference(name):
    return {"if": {"required": ["$ref"]}, "then": is_a("reference"), "else": is_a(name)}


def table_of(value, keys=".+"):
    return {"type": "object", "patternProperties": {keys: value}, "additionalProperties": False}


def list_of(value):
    return {"type": "array", "items": value}


COMPONENTS = {
    "schemas": "schema",
    "responses": "response",
    "parameters": "parameter",
    "examples": "example",
    "requestBodies": "request_body",
    "headers": "header",
    "securitySchemes": "security_scheme",
}
SECURITY = list_of(table_of(list_of(TEXT)))
EXAMPLES = {"example": ANY, "examples": table_of(or_reference("example"))}
VALUE = {"description": TEXT, "required": FLAG, "deprecated": FLAG, "style": TEXT, "explode": FLAG,
         "schema": is_a("schema"), "content": table_of(is_a("media_type")), **EXAMPLES}

# The fixed fields of section 4.8 of the OpenAPI Specification 3.1.0, as far as an API without links, callbacks and
# webhooks needs them. Descriptions of tags and summaries of operations are asked for here only.
DOCUMENT = {
    **shape(
        {"openapi": {"const": "3.1.0"}, "info": is_a("info"),
         "paths": table_of(is_a("path_item"), "^/"), "tags": list_of(shape({"name": TEXT, "description": TEXT}, {}))},
        {"servers": list_of(shape({"url": TEXT}, {"description": TEXT, "variables": ANY})), "security": SECURITY,
         "components": shape({}, {kind: table_of(or_reference(name), r"^[\w.-]+$") for kind, name in COMPONENTS.items()}),
         "externalDocs": ANY, "jsonSchemaDialect": TEXT}),
    "$defs": {
        "reference": {"type": "object", "required": ["$ref"], "additionalProperties": False,
                      "properties": {"$ref": {"type": "string", "pattern": "^#/components/"}, "summary": TEXT,
                                     "description": TEXT}},
        "info": shape({"title": TEXT, "version": TEXT},
                      {"summary": TEXT, "description": TEXT, "termsOfService": TEXT, "contact": ANY,
                       "license": shape({"name": TEXT}, {"identifier": TEXT, "url": TEXT})}),
        "path_item": shape({}, {"summary": TEXT, "description": TEXT, "servers": ANY,
                                "parameters": list_of(or_reference("parameter")),
                                **{method: is_a("operation") for method in METHODS}}),
        "operation": shape({"operationId": TEXT, "summary": TEXT, "tags": {**list_of(TEXT), "minItems": 1},
                            "responses": {**table_of(or_reference("response"), "^([1-5]([0-9]{2}|XX)|default)$"),
                                          "minProperties": 1}},
                           {"description": TEXT, "externalDocs": ANY, "deprecated": FLAG, "security": SECURITY,
                            "parameters": list_of(or_reference("parameter")),
                            "requestBody": or_reference("request_body")}),
        "parameter": {**shape({"name": TEXT, "in": {"enum": ["path", "query", "header", "cookie"]}},
                              {**VALUE, "allowEmptyValue": FLAG, "allowReserved": FLAG}),
                      "oneOf": [{"required": ["schema"]}, {"required": ["content"]}],
                      "not": {"required": ["example", "examples"]},
                      "if": {"properties": {"in": {"const": "path"}}},
                      "then": {"required": ["required"], "properties": {"required": {"const": True}}}},
        "header": {**shape({}, VALUE), "oneOf": [{"required": ["schema"]}, {"required": ["content"]}]},
        "request_body": shape({"content": {**table_of(is_a("media_type")), "minProperties": 1}},
                              {"description": TEXT, "required": FLAG}),
        "response": shape({"description": TEXT},
                          {"headers": table_of(or_reference("header")), "content": table_of(is_a("media_type")),
                           "links": ANY}),
        "media_type": {**shape({}, {"schema": is_a("schema"), "encoding": ANY, **EXAMPLES}),
                       "not": {"required": ["example", "examples"]}},
        "example": {**shape({}, {"summary": TEXT, "description": TEXT, "value": ANY, "externalValue": TEXT}),
                    "not": {"required": ["value", "externalValue"]}},
        "security_scheme": shape({"type": {"enum": ["apiKey", "http", "mutualTLS", "oauth2", "openIdConnect"]}},
                                 {"description": TEXT, "name": TEXT, "in": TEXT, "scheme": TEXT, "bearerFormat": TEXT,
                                  "flows": ANY, "openIdConnectUrl": TEXT}),
        "schema": {"type": ["object", "boolean"]},
    },
}


class Lint:
    def __init__(self, document):
        self.document = document
        self.problems = []
        self.references = set()
        self.values = []  # Each with its schema and where it stands.
        self.schemas = RefResolver("", document)
        self.schema_keywords = set(Draft202012Validator.VALIDATORS) | {
            "title", "description", "default", "examples", "deprecated", "readOnly", "writeOnly", "then", "else",
            "$defs", "$comment", "contentEncoding", "contentMediaType", "discriminator", "externalDocs"}

    def complain(self, where, what):
        self.problems.append(f"{where}: {what}")

    def resolved(self, node):
        while isinstance(node, dict) and "$ref" in node:
            node = self.schemas.resolve(node["$ref"])[1]
        return node

    def run(self):
        for error in Draft202012Validator(DOCUMENT).iter_errors(self.document):
            self.complain(error.json_path, error.message[:300])
        if self.problems:
            return  # What follows needs the shape.
        self.walk(self.document, "$")
        self.check_unused()
        self.check_operations()
        if not self.problems:  # Values cannot be held against broken schemas.
            self.check_values()

    def walk(self, node, where):
        """References, schemas and examples, wherever they are."""
        if isinstance(node, list):
            for i, item in enumerate(node):
                self.walk(item, f"{where}[{i}]")
        if not isinstance(node, dict):
            return
        if "$ref" in node:
            self.check_reference(node["$ref"], where)
        elif "schema" in node:
            self.check_schema(node["schema"], f"{where}.schema")
            self.note_examples(node, where)
        for name, item in node.items():
            at = f"{where}.{name}"
            if at == "$.components.schemas":
                for schema, content in item.items():
                    self.check_schema(content, f"{at}.{schema}")
            elif name not in ("schema", "example", "examples"):
                self.walk(item, at)

    def check_reference(self, reference, where):
        self.references.add(reference)
        try:
            self.schemas.resolve(reference)
        except Exception:
            self.complain(where, f"{reference} is not there")

    def check_schema(self, schema, where):
        for error in Draft202012Validator(Draft202012Validator.META_SCHEMA).iter_errors(schema):
            self.complain(where, error.message[:300])
        self.check_subschemas(schema, where)

    def check_subschemas(self, schema, where):
        if not isinstance(schema, dict):
            return
        if "$ref" in schema:
            self.check_reference(schema["$ref"], where)
        for keyword in schema:
            if keyword not in self.schema_keywords and not keyword.startswith("x-"):
                self.complain(where, f"{keyword} is no keyword of JSON Schema")
        for name in schema.get("required", []):
            if "properties" in schema and name not in schema["properties"]:
                self.complain(where, f"{name} is required, but not described")
        if "default" in schema:
            self.values.append((schema, schema["default"], f"{where}.default"))
        for keyword in ("properties", "patternProperties", "$defs"):
            for name, part in schema.get(keyword, {}).items():
                self.check_subschemas(part, f"{where}.{keyword}.{name}")
        for keyword in ("allOf", "anyOf", "oneOf", "prefixItems"):
            for i, part in enumerate(schema.get(keyword, [])):
                self.check_subschemas(part, f"{where}.{keyword}[{i}]")
        for keyword in ("items", "additionalProperties", "not", "if", "then", "else"):
            self.check_subschemas(schema.get(keyword), f"{where}.{keyword}")

    def note_examples(self, node, where):
        if "example" in node:
            self.values.append((node["schema"], node["example"], f"{where}.example"))
        for name, example in node.get("examples", {}).items():
            self.values.append((node["schema"], self.resolved(example).get("value"), f"{where}.examples.{name}"))

    def check_values(self):
        for schema, value, where in self.values:
            for error in Draft202012Validator(schema, resolver=self.schemas).iter_errors(value):
                self.complain(where, f"does not fit its schema, {error.json_path}: {error.message[:300]}")

    def check_unused(self):
        for kind in COMPONENTS:
            for name in self.document.get("components", {}).get(kind, {}):
                if kind != "securitySchemes" and f"#/components/{kind}/{name}" not in self.references:
                    self.complain(f"$.components.{kind}.{name}", "nothing refers to it")

    def check_operations(self):
        tags = [tag["name"] for tag in self.document["tags"]]
        schemes = self.document.get("components", {}).get("securitySchemes", {})
        names = set()
        for path, item in self.document["paths"].items():
            for method in filter(item.__contains__, METHODS):
                operation = item[method]
                where = f"{method} {path}"
                if operation["operationId"] in names:
                    self.complain(where, "another operation has its operationId")
                names.add(operation["operationId"])
                for tag in set(operation["tags"]) - set(tags):
                    self.complain(where, f"the tag {tag} is not declared")
                for requirement in operation.get("security", self.document.get("security", [])):
                    for scheme in requirement.keys() - schemes.keys():
                        self.complain(where, f"the security scheme {scheme} is not declared")
                if not any(status.startswith("2") for status in operation["responses"]):
                    self.complain(where, "no answer says that it worked")
                self.check_parameters(path, item, operation, where)

    def check_parameters(self, path, item, operation, where):
        parameters = [self.resolved(node) for node in item.get("parameters", []) + operation.get("parameters", [])]
        named = [(parameter["in"], parameter["name"]) for parameter in parameters]
        if len(named) != len(set(named)):
            self.complain(where, "a parameter is declared twice")
        declared = {name for place, name in named if place == "path"}
        used = re.findall(r"{([^}]*)}", path)
        if declared != set(used) or len(used) != len(set(used)):
            self.complain(where, f"path parameters {sorted(declared)}, but {used} in the path")


def lint(document):
    """What is wrong, a line each."""
    document = json.loads(json.dumps(document))  # As it is served: keys are strings.
    checked = Lint(document)
    checked.run()
    return checked.problems


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        problems = lint(yaml.safe_load(file))
    for problem in problems:
        print(problem)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
