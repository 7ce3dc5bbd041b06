#!/usr/bin/env python3
"""Learns the acceptance model from the samples of `cornerfix evaluate --samples`.

Usage: calibrate.py DOMAIN.csv... One file per domain (offices, outdoor, warehouses, ...); the column
`log` names the building. Prints the table of evidence weights that these samples give, the coefficients
of core's acceptance model, and how well models without a building and without a domain do on it.
See docs/method/05-acceptance.md. Needs numpy and scipy.
"""
import collections
import csv
import pathlib
import sys

import numpy as np
from scipy.optimize import minimize

UNSEEN = -0.1  # Unknown space must not raise the score; a trace keeps the search out of it.
RARE = 0.002
PLAUSIBLE = 0.5  # share of hits within 0.15 m of a wall from which a wrong pose is a rival
# The a-contrario test is calibrated by theory, where the slope is 1; samples of few buildings leave it
# open. Slopes near 0.8 fit all domains that have wrong poses with a low significance.
SIGNIFICANCE_SLOPE = 0.8
LEAST_GROUP = 250  # samples; smaller domains weigh in proportion
PROBABILITIES = (0.9, 0.95, 0.98, 0.99, 0.995)


class Samples:
    def __init__(self, paths):
        rows = []
        for path in paths:
            for row in csv.DictReader(open(path)):
                rows.append({**row, "domain": pathlib.Path(path).stem})
        column = lambda name: np.array([float(row[name]) for row in rows])
        classes = lambda kind: [name[len(kind):] for name in rows[0] if name.startswith(kind)]
        counts = lambda kind, names: np.array([[float(row[kind + name]) for name in names] for row in rows])
        # The columns name the classes, in the order of core's tables of weights.
        self.hit_classes, self.miss_classes = classes("best_hits_"), classes("best_misses_")
        self.ends = {pose: counts(f"{pose}_hits_", self.hit_classes) for pose in ("best", "second")}
        self.passes = {pose: counts(f"{pose}_misses_", self.miss_classes) for pose in ("best", "second")}
        self.matched = {pose: column(f"{pose}_matched") for pose in ("best", "second")}
        self.right = column("right").astype(int)
        self.significance, self.rival_evidence = column("significance"), column("rival_evidence")
        self.building = np.array([row["log"].split(":")[-1] for row in rows])
        self.domain = np.array([row["domain"] for row in rows])
        self.mirrored = np.array([row["log"].startswith("mirrored:") for row in rows])
        self.acceptable = column("has_margin") == 1


def shares(counts):
    total = counts.sum(axis=1, keepdims=True)
    return np.where(total > 0, counts / np.maximum(total, 1), 0)


def learn_weights(samples, chosen):
    """ln(P(class | correct pose) / P(class | plausible wrong pose)), each sample weighing the same."""
    right = samples.right[chosen] == 1
    plausible = {pose: samples.matched[pose][chosen] >= PLAUSIBLE for pose in ("best", "second")}

    def weights(counts):
        best, second = shares(counts["best"][chosen]), shares(counts["second"][chosen])
        correct = best[right].sum(axis=0)
        wrong = second[right & plausible["second"]].sum(axis=0) + best[~right & plausible["best"]].sum(axis=0)
        return np.log((correct / correct.sum() + RARE) / (wrong / wrong.sum() + RARE))

    ends, passes = weights(samples.ends), weights(samples.passes)
    for weight, names in ((ends, samples.hit_classes), (passes, samples.miss_classes)):
        unseen = [name.startswith(("unknown", "hidden")) for name in names]
        weight[unseen] = np.minimum(weight[unseen], UNSEEN)
    return ends, passes


def sigmoid(x):
    return 1 / (1 + np.exp(-np.clip(x, -40, 40)))


def no_rival(samples, chosen, offset=0.0):
    """Probability that no rival is the correct pose. By theory the offset is 0."""
    return sigmoid(offset + samples.rival_evidence[chosen])


def importance_of(samples, chosen):
    """Each domain weighs the same, but for small ones."""
    size = collections.Counter(samples.domain[chosen])
    weight = np.array([1 / max(LEAST_GROUP, size[name]) for name in samples.domain[chosen]])
    return weight / weight.sum()


def learn(samples, chosen, rival_offset=0.0):
    """The offset of the significance by maximum likelihood. `rival_offset=None` learns that one, too."""
    chosen = chosen[samples.acceptable[chosen]]
    y, weight = samples.right[chosen], importance_of(samples, chosen)
    significance = SIGNIFICANCE_SLOPE * samples.significance[chosen]

    def loss(offsets):
        rival = no_rival(samples, chosen, offsets[1] if rival_offset is None else rival_offset)
        p = np.clip(sigmoid(offsets[0] + significance) * rival, 1e-9, 1 - 1e-9)
        return -(weight * (y * np.log(p) + (1 - y) * np.log(1 - p))).sum()

    return minimize(loss, np.array([6.0, 0.0]), method="Nelder-Mead").x


def decide(samples, chosen, model):
    p = (sigmoid(model[0] + SIGNIFICANCE_SLOPE * samples.significance[chosen])
         * no_rival(samples, chosen))
    return np.where(samples.acceptable[chosen], p, 0)


def calibration_error(p, right, bins=10):
    groups = np.array_split(np.argsort(p), bins)
    return sum(len(g) * abs(p[g].mean() - right[g].mean()) for g in groups if len(g)) / max(1, len(p))


def report(name, p, right):
    judged = p > 0
    cells = [f"{least}: {right[p >= least].sum()}/{right.sum()} right, {(1 - right)[p >= least].sum()} wrong"
             for least in PROBABILITIES]
    error = calibration_error(p[judged], right[judged])
    print(f"{name}: {len(p)} samples, ECE {error:.3f}; at p >= " + "; ".join(cells))


def curve(p, right):
    print("mean probability, share correct, samples:")
    edges = (0.0001, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 1.0001)
    for low, high in zip(edges, edges[1:]):
        here = (p >= low) & (p < high)
        if here.any():
            print(f"  {p[here].mean():.3f}, {right[here].mean():.3f}, {here.sum()}")


def leave_out(samples, everything, groups, title):
    print(f"without the {title}:")
    held_out = np.zeros(len(samples.right))
    for group in sorted(set(groups[everything])):
        here = groups[everything] == group
        rest, test = everything[~here], everything[here]
        held_out[test] = decide(samples, test, learn(samples, rest))
        report(f"  {group}", held_out[test], samples.right[test])
    report("  pooled", held_out[everything], samples.right[everything])
    curve(held_out[everything], samples.right[everything])


def main():
    samples = Samples(sys.argv[1:])
    mirrored, everything = np.flatnonzero(samples.mirrored), np.flatnonzero(~samples.mirrored)
    leave_out(samples, everything, samples.building, "building")
    leave_out(samples, everything, samples.domain, "domain")
    model = learn(samples, everything)
    report("all", decide(samples, everything, model), samples.right[everything])
    if len(mirrored):  # The localizer looks for the mirror image before it accepts: not learnt from.
        report("mirrored, before that check", decide(samples, mirrored, model), samples.right[mirrored])
    weights = learn_weights(samples, everything)
    print("kRivalWeights, from these samples", weights[0].round(2).tolist(), weights[1].round(2).tolist())
    print(f"constexpr double kExplainedOffset = {model[0]:.2f};")
    print(f"constexpr double kExplainedSlope = {SIGNIFICANCE_SLOPE};")
    print(f"offset of the rival evidence, 0 by theory: {learn(samples, everything, None)[1]:.2f}")


if __name__ == "__main__":
    main()
