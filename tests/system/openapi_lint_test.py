#!/usr/bin/python3
"""openapi_lint.py finds what is wrong: openapi_lint_test.py FILE.yaml, a description without fault, which is broken."""

import copy
import sys
import unittest

import openapi_lint
import yaml

with open(sys.argv.pop(), encoding="utf-8") as file:
    DOCUMENT = yaml.safe_load(file)


def maps(document):
    return document["paths"]["/v1/maps"]["get"]


def schemas(document):
    return document["components"]["schemas"]


def body(operation):
    return operation["responses"]["200"]["content"]["application/json"]


BREAKAGES = {
    "an unknown field": lambda d: maps(d).update(sumary="List"),
    "a missing operationId": lambda d: maps(d).pop("operationId"),
    "an operationId twice": lambda d: maps(d).update(operationId="getMap"),
    "a response without description": lambda d: maps(d)["responses"]["200"].pop("description"),
    "a status that is none": lambda d: maps(d)["responses"].update({"20": {"description": "?"}}),
    "no answer to success": lambda d: maps(d)["responses"].pop("200"),
    "a reference to nothing": lambda d: body(maps(d)).update(schema={"$ref": "#/components/schemas/None"}),
    "a component nobody uses": lambda d: schemas(d).update(Lonely={"type": "object"}),
    "an undeclared tag": lambda d: maps(d)["tags"].append("robots"),
    "an undeclared security scheme": lambda d: maps(d).update(security=[{"oauth": []}]),
    "an undeclared path parameter": lambda d: d["paths"]["/v1/maps/{map}"].pop("parameters"),
    "a parameter without schema": lambda d: maps(d)["parameters"][0].pop("schema"),
    "a parameter twice": lambda d: maps(d)["parameters"].append(maps(d)["parameters"][0]),
    "a type that is none": lambda d: schemas(d)["Status"].update(type="text"),
    "a keyword that is none": lambda d: schemas(d)["Status"].update(nullable=True),
    "a required member that is not described": lambda d: schemas(d)["Health"]["required"].append("pulse"),
    "a default that does not fit": lambda d: maps(d)["parameters"][0]["schema"].update(default=0),
    "an example that does not fit": lambda d: body(maps(d))["examples"]["oneMap"]["value"].pop("maps"),
}


class OpenapiLint(unittest.TestCase):
    def test_finds_no_fault_where_there_is_none(self):
        self.assertEqual(openapi_lint.lint(DOCUMENT), [])

    def test_finds_what_is_broken(self):
        for name, break_it in BREAKAGES.items():
            with self.subTest(name):
                document = copy.deepcopy(DOCUMENT)
                break_it(document)
                self.assertNotEqual(openapi_lint.lint(document), [])


if __name__ == "__main__":
    unittest.main()
