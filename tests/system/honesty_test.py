#!/usr/bin/python3
"""scripts/honesty.py folds results of `cornerfix evaluate`: honesty_test.py DIR_OF_SCRIPTS."""

import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, sys.argv.pop())
import honesty


def result(starts, wrong, bins):
    first_wrong = {"driven": 3.0, "err": [20.0, 1.0], "confidence": 0.997, "nees": 90.0,
                   "longest_wrong_m": 7.25}
    records = [{"start": i, "counts": True} for i in range(starts)]
    for record in records[:wrong]:
        record["first_wrong"] = first_wrong
        record["result"] = "false" if record["start"] == 0 else "fixed"
    table = {"bins": bins}
    summary = {"starts": starts, "outside": 0, "fixed": starts - wrong,
               "answers_judged": 10 * starts, "wrong_answers": 3 * wrong,
               "starts_with_wrong_answer": wrong,
               "wrong_withdrawn": {"within_3m": 0, "later_or_never": wrong, "undecided": 0},
               "reliability": {"searches": table, "localized": table}}
    return {"summary": summary, "starts": records}


class UpperBound(unittest.TestCase):
    def test_without_hits_has_its_closed_form(self):
        for trials in (1, 40, 10000):
            self.assertAlmostEqual(honesty.upper_bound(0, trials), 1.0 - 0.05 ** (1.0 / trials),
                                   places=9)

    def test_agrees_with_published_bounds(self):
        # scipy.stats.beta.ppf(0.95, k + 1, n - k)
        for hits, trials, bound in ((1, 10, 0.394163), (24, 200, 0.164595)):
            self.assertAlmostEqual(honesty.upper_bound(hits, trials), bound, places=5)

    def test_without_trials_is_one(self):
        self.assertEqual(honesty.upper_bound(0, 0), 1.0)


class Folding(unittest.TestCase):
    def fold(self, results, *options):
        with tempfile.TemporaryDirectory() as directory:
            for name, content in results.items():
                pathlib.Path(directory, name + ".json").write_text(json.dumps(content))
            sys.argv = ["honesty.py", *options, directory]
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                honesty.main()
        return out.getvalue()

    def test_adds_the_parts_of_a_domain_and_all_domains(self):
        bins = [[0.0, 0.5, 0, 0, 0.0], [0.5, 1.0, 10, 8, 0.9]]
        text = self.fold({"a.one-0.5": result(40, 1, bins), "a.two": result(60, 1, bins),
                          "b.one": result(100, 0, bins)})
        self.assertIn("| a | 100 | 100 | 98 | 98.0 % | 2 |", text)
        self.assertIn("| b | 100 | 100 | 100 | 100.0 % | 0 | 2.95 % |", text)
        self.assertIn("| **all** | 200 | 200 | 198 | 99.0 % | 2 |", text)
        self.assertIn("| 0.5 to 1 | 30 | 0.9000 | 0.8000 |", text)
        self.assertIn("| a | one-0.5 | 0 | 3.0 | 20.00 | 1.0 | 0.9970 | 90 | 7.2 |", text)

    def test_lists_the_starts_whose_first_answer_was_wrong(self):
        text = self.fold({"a.one": result(40, 2, []), "b.one": result(9, 0, [])}, "--first-wrong")
        self.assertEqual(text, "a one 0\n")

    def test_computes_the_calibration_error_over_all_forecasts(self):
        bins = [[0.0, 0.5, 10, 10, 0.4], [0.5, 1.0, 30, 27, 0.9]]
        text = self.fold({"a.one": result(10, 0, bins)})
        self.assertIn("| 0.150 | 0.150 |", text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
