#!/usr/bin/env python3
"""Learns what evidence weighs and how sure it makes, from the samples of `cornerfix evaluate --samples`.

Prints the table of weights that these samples give, the coefficients of the logistic for the table that core's
evidence_model holds, and for each building how the numbers learnt from all others do on it. See docs/algorithm.md.
Needs numpy.
"""
import collections
import csv
import pathlib
import re
import sys

import numpy as np

END_CLASSES, PASS_CLASSES = 14, 4
MATCHED = slice(0, 3)  # ends within 0.15 m of a wall
CONTRADICTED = slice(5, 8)  # ends in known-free space, more than 0.3 m from a wall
UNKNOWN = slice(8, 12)  # unmapped
HIDDEN = slice(12, 14)
UNKNOWN_PASSED = 3
UNSEEN = -0.1  # What the map does not know says nothing; a trace keeps the search out of it.
RARE = 0.002
LEAST_RIVAL, RIVAL_MARGIN = -0.5, 0.75  # nats an end, as in core's localizer
MIN_GAP, MIN_MEAN_GAP = 10, 0.08  # as in AcceptanceParams
PLAUSIBLE = 0.5  # share of matched ends from which a wrong pose is a rival
PROBABILITIES = (0.95, 0.97, 0.98, 0.985, 0.99, 0.995)
HEADER = pathlib.Path(__file__).parent.parent / "core/include/cornerfix/evidence_model.hpp"


class Samples:
    def __init__(self, path):
        rows = list(csv.DictReader(open(path)))

        def counts(place, kind, classes):
            return np.array([[float(row[f"{place}_{kind}{i}"]) for i in range(classes)] for row in rows])

        self.ends = {place: counts(place, "end", END_CLASSES) for place in ("best", "second")}
        self.passes = {place: counts(place, "pass", PASS_CLASSES) for place in ("best", "second")}
        self.right = np.array([int(row["right"]) for row in rows])
        self.building = np.array([row["log"].split(":")[-1] for row in rows])
        self.mirrored = np.array([row["log"].startswith("mirrored:") for row in rows])


def shares(counts):
    total = counts.sum(axis=1, keepdims=True)
    return np.where(total > 0, counts / np.maximum(total, 1), 0)


def learn_weights(samples, chosen):
    """ln(P(class | true pose) / P(class | plausible wrong pose)), each sample weighing the same."""
    right = samples.right[chosen] == 1
    plausible = {place: shares(samples.ends[place][chosen])[:, MATCHED].sum(axis=1) >= PLAUSIBLE
                 for place in ("best", "second")}

    def weights(counts):
        best, second = shares(counts["best"][chosen]), shares(counts["second"][chosen])
        true = best[right].sum(axis=0)
        wrong = second[right & plausible["second"]].sum(axis=0) + best[~right & plausible["best"]].sum(axis=0)
        return np.log((true / true.sum() + RARE) / (wrong / wrong.sum() + RARE))

    ends, passes = weights(samples.ends), weights(samples.passes)
    for cells in (UNKNOWN, HIDDEN):
        ends[cells] = np.minimum(ends[cells], UNSEEN)
    passes[UNKNOWN_PASSED] = min(passes[UNKNOWN_PASSED], UNSEEN)
    return ends, passes


def weights_in_core():
    table = re.search(r"kRivalWeights\{(.*?)\}\};", HEADER.read_text(), re.DOTALL).group(1)
    values = [float(value) for value in re.findall(r"(-?[\d.]+)F", table)]
    return np.array(values[:END_CLASSES]), np.array(values[END_CLASSES:])


def features(samples, chosen, weights):
    """The terms of the logistic, and which samples may be accepted at all."""
    ends, passes = weights
    best, second = (samples.ends[place][chosen] @ ends + samples.passes[place][chosen] @ passes
                    for place in ("best", "second"))
    count = samples.ends["best"][chosen].sum(axis=1)
    second = np.where(samples.ends["second"][chosen].sum(axis=1) > 0, second, -np.inf)
    floor = np.maximum(LEAST_RIVAL * count, best - RIVAL_MARGIN * count)
    gap = np.maximum(0, best - np.maximum(second, floor))
    contradicted, unmapped = (samples.ends["best"][chosen][:, cells].sum(axis=1) / count
                              for cells in (CONTRADICTED, UNKNOWN))
    x = np.column_stack([np.ones(len(gap)), gap / count, np.log(contradicted + 0.02), np.log(1.02 - unmapped),
                         np.log(np.maximum(count, 1))])
    return x, (gap >= MIN_GAP) & (gap >= MIN_MEAN_GAP * count)


def fit_logistic(x, y, importance):
    """Newton's method on the weighted likelihood, with a trace of a prior."""
    coefficients = np.zeros(x.shape[1])
    prior = 1e-2 * np.eye(x.shape[1])
    for _ in range(60):
        p = probability(x, coefficients)
        gradient = x.T @ (importance * (p - y)) + prior @ np.r_[0, coefficients[1:]]
        step = np.linalg.solve((x * (importance * p * (1 - p))[:, None]).T @ x + prior, gradient)
        coefficients -= step
        if np.abs(step).max() < 1e-8:
            break
    return coefficients


def probability(x, coefficients):
    return 1 / (1 + np.exp(-np.clip(x @ coefficients, -30, 30)))


def learn_decision(samples, chosen, weights):
    """Over the samples that may be accepted, each building weighing the same."""
    x, distinct = features(samples, chosen, weights)
    buildings = samples.building[chosen][distinct]
    size = collections.Counter(buildings)
    importance = np.array([len(buildings) / len(size) / size[name] for name in buildings])
    return fit_logistic(x[distinct], samples.right[chosen][distinct], importance)


def decide(samples, chosen, weights, coefficients):
    x, distinct = features(samples, chosen, weights)
    return np.where(distinct, probability(x, coefficients), 0)


def calibration_error(p, right, bins=10):
    groups = np.array_split(np.argsort(p), bins)
    return sum(len(g) * abs(p[g].mean() - right[g].mean()) for g in groups if len(g)) / len(p)


def report(name, p, right):
    distinct = p > 0
    cells = []
    for least in PROBABILITIES:
        taken = p >= least
        cells.append(f"{least}: {right[taken].sum()}/{right.sum()} right, {(1 - right)[taken].sum()} wrong")
    error = calibration_error(p[distinct], right[distinct])
    print(f"{name}: {len(p)} samples, {distinct.sum()} distinct, ECE {error:.3f}; at p >= " + "; ".join(cells))


def curve(p, right):
    print("said, happened, samples:")
    edges = (0.0001, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 1.0001)
    for low, high in zip(edges, edges[1:]):
        here = (p >= low) & (p < high)
        if here.any():
            print(f"  {p[here].mean():.3f}, {right[here].mean():.3f}, {here.sum()}")


def main():
    samples = Samples(sys.argv[1])
    mirrored, everything = np.flatnonzero(samples.mirrored), np.flatnonzero(~samples.mirrored)
    print("left out:")
    held_out = np.zeros(len(samples.right))
    for building in sorted(set(samples.building)):
        here = samples.building[everything] == building
        rest, test = everything[~here], everything[here]
        weights = learn_weights(samples, rest)
        held_out[test] = decide(samples, test, weights, learn_decision(samples, rest, weights))
        report(building, held_out[test], samples.right[test])
    report("pooled", held_out[everything], samples.right[everything])
    curve(held_out[everything], samples.right[everything])
    weights = weights_in_core()
    coefficients = learn_decision(samples, everything, weights)
    report("all, with core's weights", decide(samples, everything, weights, coefficients), samples.right[everything])
    # The localizer looks for the mirror image of what it sees before a fix: so these never taught it.
    report("mirrored, before that check", decide(samples, mirrored, weights, coefficients), samples.right[mirrored])
    learnt = learn_weights(samples, everything)
    print("kRivalWeights, from these samples", learnt[0].round(2).tolist(), learnt[1].round(2).tolist())
    print("logistic, with core's weights", coefficients.round(3).tolist())


if __name__ == "__main__":
    main()
