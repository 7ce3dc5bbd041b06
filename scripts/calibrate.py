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

END_CLASSES, PASS_CLASSES = 14, 4
MATCHED = slice(0, 3)  # hits within 0.15 m of a wall
UNKNOWN = slice(8, 12)  # hits in unknown space
HIDDEN = slice(12, 14)
UNKNOWN_PASSED = 3
UNSEEN = -0.1  # Unknown space must not raise the score; a trace keeps the search out of it.
RARE = 0.002
PLAUSIBLE = 0.5  # share of matched hits from which a wrong pose is a rival
MIN_MARGIN, MIN_MARGIN_PER_HIT = 3, 0.02  # as in AcceptanceParams
# The a-contrario test is calibrated by theory, where the slope is 1; samples of few buildings leave it
# open. Slopes near 0.8 fit all domains that have wrong poses with a low significance.
SIGNIFICANCE_SLOPE = 0.8
NO_RIVAL = 7.99  # evidence against rivals when there is none
LEAST_GROUP = 250  # samples; smaller domains weigh in proportion
PROBABILITIES = (0.9, 0.95, 0.98, 0.99, 0.995)


class Samples:
    def __init__(self, paths):
        rows = []
        for path in paths:
            for row in csv.DictReader(open(path)):
                rows.append({**row, "domain": pathlib.Path(path).stem})
        column = lambda name: np.array([float(row[name]) for row in rows])
        counts = lambda pose, kind, n: np.array([[float(row[f"{pose}_{kind}{i}"]) for i in range(n)] for row in rows])
        self.ends = {pose: counts(pose, "end", END_CLASSES) for pose in ("best", "second")}
        self.passes = {pose: counts(pose, "pass", PASS_CLASSES) for pose in ("best", "second")}
        self.right = column("right").astype(int)
        self.hits = self.ends["best"].sum(axis=1)
        self.terms = {name: column(name) for name in ("significance", "margin_per_hit", "rival_evidence",
                                                      "unknown_share")}
        self.building = np.array([row["log"].split(":")[-1] for row in rows])
        self.domain = np.array([row["domain"] for row in rows])
        self.mirrored = np.array([row["log"].startswith("mirrored:") for row in rows])
        margin = self.terms["margin_per_hit"]
        self.acceptable = (margin >= MIN_MARGIN_PER_HIT) & (margin * self.hits >= MIN_MARGIN)


def shares(counts):
    total = counts.sum(axis=1, keepdims=True)
    return np.where(total > 0, counts / np.maximum(total, 1), 0)


def learn_weights(samples, chosen):
    """ln(P(class | correct pose) / P(class | plausible wrong pose)), each sample weighing the same."""
    right = samples.right[chosen] == 1
    plausible = {pose: shares(samples.ends[pose][chosen])[:, MATCHED].sum(axis=1) >= PLAUSIBLE
                 for pose in ("best", "second")}

    def weights(counts):
        best, second = shares(counts["best"][chosen]), shares(counts["second"][chosen])
        correct = best[right].sum(axis=0)
        wrong = second[right & plausible["second"]].sum(axis=0) + best[~right & plausible["best"]].sum(axis=0)
        return np.log((correct / correct.sum() + RARE) / (wrong / wrong.sum() + RARE))

    ends, passes = weights(samples.ends), weights(samples.passes)
    for cells in (UNKNOWN, HIDDEN):
        ends[cells] = np.minimum(ends[cells], UNSEEN)
    passes[UNKNOWN_PASSED] = min(passes[UNKNOWN_PASSED], UNSEEN)
    return ends, passes


def sigmoid(x):
    return 1 / (1 + np.exp(-np.clip(x, -40, 40)))


def margin_terms(samples, chosen):
    terms = {name: values[chosen] for name, values in samples.terms.items()}
    return np.column_stack([np.ones(len(chosen)), terms["margin_per_hit"], np.log(1.02 - terms["unknown_share"])])


def explained(samples, chosen, offset):
    return sigmoid(offset + SIGNIFICANCE_SLOPE * samples.terms["significance"][chosen])


def no_rival(samples, chosen, offset):
    evidence = samples.terms["rival_evidence"][chosen]
    return np.where(evidence < NO_RIVAL, sigmoid(offset + evidence), 1)


def importance_of(samples, chosen):
    """Each domain weighs the same, but for small ones."""
    size = collections.Counter(samples.domain[chosen])
    weight = np.array([1 / max(LEAST_GROUP, size[name]) for name in samples.domain[chosen]])
    return weight / weight.sum()


def learn(samples, chosen):
    """Maximum likelihood of the product of the three factors, with a weak prior on the slopes."""
    chosen = chosen[samples.acceptable[chosen]]
    x, y, weight = margin_terms(samples, chosen), samples.right[chosen], importance_of(samples, chosen)
    scale = np.r_[1, x[:, 1:].std(axis=0) + 1e-9]
    prior = 0.1 / len(chosen) * np.r_[0, 0, 0, np.ones(x.shape[1] - 1)]

    def loss(parameters):
        by_itself, rival = explained(samples, chosen, parameters[0]), no_rival(samples, chosen, parameters[1])
        margin = sigmoid((x / scale) @ parameters[2:])
        p = np.clip(by_itself * rival * margin, 1e-9, 1 - 1e-9)
        value = -(weight * (y * np.log(p) + (1 - y) * np.log(1 - p))).sum() + (prior * parameters**2).sum()
        slope = weight * (p - y) / (1 - p)
        gradient = np.r_[(slope * (1 - by_itself)).sum(), (slope * (1 - rival)).sum(),
                         (x / scale).T @ (slope * (1 - margin))]
        return value, gradient + 2 * prior * parameters

    start = np.r_[8, 1, 1, np.full(x.shape[1] - 1, 0.3)]
    found = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 3000}).x
    return found[0], found[1], found[2:] / scale


def decide(samples, chosen, model):
    offset, rival_offset, coefficients = model
    p = (explained(samples, chosen, offset) * no_rival(samples, chosen, rival_offset)
         * sigmoid(margin_terms(samples, chosen) @ coefficients))
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
    names = ("kExplainedOffset", "kRivalOffset", "kMarginOffset", "kMarginSlope", "kKnownSlope")
    for name, value in zip(names, [*model[:2], *model[2]]):
        print(f"constexpr double {name} = {value:.3f};")


if __name__ == "__main__":
    main()
