#!/usr/bin/env python3
"""Folds the results of the honesty run into a table per domain, reliability tables and a list of
wrong starts.

  honesty.py DIR_OF_RESULTS >honesty.md
  honesty.py --first-wrong DIR_OF_RESULTS    only lists the starts whose first answer was wrong

Each result is a file DOMAIN.NAME.json of `cornerfix evaluate --out`. The upper bound is the
one-sided 95 % bound of Clopper and Pearson for the share of counted starts with a wrong answer.
"""
import json
import math
import pathlib
import sys


def binomial_cdf(k, n, p):
    """P(X <= k) for X of n trials."""
    if p <= 0.0:
        return 1.0
    if p >= 1.0:
        return 1.0 if k >= n else 0.0

    def probability(i):
        log_choose = math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1)
        return math.exp(log_choose + i * math.log(p) + (n - i) * math.log1p(-p))

    return math.fsum(probability(i) for i in range(k + 1))


def upper_bound(k, n, confidence=0.95):
    """One-sided upper bound of a share by Clopper and Pearson."""
    if n == 0 or k >= n:
        return 1.0
    low, high = k / n, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if binomial_cdf(k, n, middle) > 1.0 - confidence:
            low = middle
        else:
            high = middle
    return high


def add_bins(total, bins):
    """Adds reliability bins [from, to, forecasts, correct, mean confidence] of the same edges."""
    if not total:
        return [list(b[:4]) + [b[2] * b[4]] for b in bins]
    return [[t[0], t[1], t[2] + b[2], t[3] + b[3], t[4] + b[2] * b[4]] for t, b in zip(total, bins)]


def calibration_error(bins):
    forecasts = sum(b[2] for b in bins)
    return sum(abs(b[4] - b[3]) for b in bins) / forecasts if forecasts else math.nan


class Domain:
    """Sums over the results of one domain."""

    COUNTS = ("starts", "outside", "fixed", "answers_judged", "wrong_answers",
              "starts_with_wrong_answer")

    def __init__(self):
        self.counts = dict.fromkeys(self.COUNTS, 0)
        self.withdrawn = dict.fromkeys(("within_3m", "later_or_never", "undecided"), 0)
        self.bins = {"searches": [], "localized": []}
        self.wrong = []

    def add(self, name, result):
        summary = result["summary"]
        for key in self.COUNTS:
            self.counts[key] += summary[key]
        for key in self.withdrawn:
            self.withdrawn[key] += summary["wrong_withdrawn"][key]
        for key in self.bins:
            self.bins[key] = add_bins(self.bins[key], summary["reliability"][key]["bins"])
        self.wrong += [(name, start) for start in result["starts"]
                       if start["counts"] and "first_wrong" in start]

    def merge(self, other):
        for key in self.COUNTS:
            self.counts[key] += other.counts[key]
        for key in self.withdrawn:
            self.withdrawn[key] += other.withdrawn[key]
        for key in self.bins:
            bins = [b[:4] + [b[4] / max(1, b[2])] for b in other.bins[key]]
            self.bins[key] = add_bins(self.bins[key], bins)

    def asked(self):
        return self.counts["starts"] + self.counts["outside"]


def read(directory):
    domains = {}
    for path in sorted(pathlib.Path(directory).glob("*.json")):
        domain, name = path.stem.split(".", 1)
        domains.setdefault(domain, Domain()).add(name, json.loads(path.read_text()))
    return domains


def percent(value, digits=1):
    return "-" if math.isnan(value) else f"{100 * value:.{digits}f} %"


def table_row(name, domain):
    c, w = domain.counts, domain.withdrawn
    success = c["fixed"] / c["starts"] if c["starts"] else math.nan
    wrong = c["starts_with_wrong_answer"]
    decided = w["within_3m"] + w["later_or_never"]
    withdrawn = f"{w['within_3m']} of {decided}" if decided else "-"
    cells = [name, domain.asked(), c["starts"], c["fixed"], percent(success), wrong,
             percent(upper_bound(wrong, domain.asked()), 2),
             f"{c['wrong_answers']} of {c['answers_judged']}", withdrawn]
    for kind in ("searches", "localized"):
        error = calibration_error(domain.bins[kind])
        cells.append("-" if math.isnan(error) else f"{error:.3f}")
    return "| " + " | ".join(map(str, cells)) + " |"


def print_table(domains, total):
    print("| domain | starts | in the mapped part | localized correctly | success "
          "| starts with a wrong answer | upper 95 % bound | wrong answers "
          "| withdrawn within 3 m | ECE of searches | ECE while localized |")
    print("|---|" + "---|" * 10)
    for name, domain in domains.items():
        print(table_row(name, domain))
    print(table_row("**all**", total))


def print_reliability(title, bins):
    print(f"\n{title}\n")
    print("| confidence | answers | mean confidence | correct |\n|---|---|---|---|")
    for low, high, forecasts, correct, confidence in bins:
        if forecasts:
            print(f"| {low:g} to {high:g} | {forecasts} | {confidence / forecasts:.4f} "
                  f"| {correct / forecasts:.4f} |")


def print_wrong(domains):
    rows = [(domain, name, start)
            for domain, sums in domains.items() for name, start in sums.wrong]
    if not rows:
        return
    print("\n## Starts with a wrong answer\n")
    print("| domain | part | start | driven m | error m | error deg | confidence | NEES "
          "| longest m wrong |")
    print("|---|---|---|---|---|---|---|---|---|")
    for domain, name, start in rows:
        wrong = start["first_wrong"]
        error_m, error_deg = wrong["err"]
        print(f"| {domain} | {name} | {start['start']} | {wrong['driven']:.1f} | {error_m:.2f} "
              f"| {error_deg:.1f} | {wrong['confidence']:.4f} | {wrong['nees']:.0f} "
              f"| {wrong['longest_wrong_m']:.1f} |")


def list_first_wrong(domains):
    for domain, sums in domains.items():
        for name, start in sums.wrong:
            if start["result"] == "false":
                print(domain, name, start["start"])


def main():
    *options, directory = sys.argv[1:] or [None]
    if directory is None or options not in ([], ["--first-wrong"]):
        sys.exit(__doc__)
    domains = read(directory)
    if not domains:
        sys.exit(f"{directory}: holds no result")
    if options:
        list_first_wrong(domains)
        return
    total = Domain()
    for domain in domains.values():
        total.merge(domain)
    print("# Honesty run\n")
    print_table(domains, total)
    print("\n## Reliability")
    print_reliability("Best pose of each search of the whole map:", total.bins["searches"])
    print_reliability("`localized` answers:", total.bins["localized"])
    print_wrong(domains)


if __name__ == "__main__":
    main()
