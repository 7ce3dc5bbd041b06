#!/usr/bin/env python3
"""Learns what evidence weighs and how sure it makes, from the samples of `cornerfix evaluate --samples`.

Prints the two weight tables and the coefficients of the logistic for core's evidence_model, and for each building how the
numbers learnt from all others do on it. See docs/algorithm.md. Needs numpy.
"""
import collections
import csv
import sys

import numpy as np

END_CLASSES, PASS_CLASSES = 12, 4
CONTRADICTED = slice(5, 8)  # ends in known-free space, more than 0.3 m from a wall
ON_WALL = 0
LEAST_RIVAL, RIVAL_MARGIN = -0.5, 1.0  # nats an end, as in core's localizer
PROBABILITIES = (0.97, 0.98, 0.985, 0.99, 0.995)


class Samples:
    def __init__(self, path):
        rows = list(csv.DictReader(open(path)))

        def counts(place, kind, classes):
            return np.array([[float(row[f"{place}_{kind}{i}"]) for i in range(classes)] for row in rows])

        self.ends = {place: counts(place, "end", END_CLASSES) for place in ("best", "second")}
        self.passes = {place: counts(place, "pass", PASS_CLASSES) for place in ("best", "second")}
        self.right = np.array([int(row["right"]) for row in rows])
        self.building = np.array([row["log"].split(":")[-1] for row in rows])


def shares(counts):
    total = counts.sum(axis=1, keepdims=True)
    return np.where(total > 0, counts / np.maximum(total, 1), 0)


def learn_weights(samples, chosen):
    """ln(P(class | true pose) / P(class | best wrong pose)), each sample weighing the same."""

    def weights(counts):
        right = samples.right[chosen] == 1
        best, second = shares(counts["best"][chosen]), shares(counts["second"][chosen])
        true = best[right].sum(axis=0)
        wrong = second[right].sum(axis=0) + best[~right].sum(axis=0)
        rare = 0.002
        return np.log((true / true.sum() + rare) / (wrong / wrong.sum() + rare))

    return weights(samples.ends), weights(samples.passes)


def features(samples, chosen, weights):
    ends, passes = weights
    score = {place: samples.ends[place][chosen] @ ends + samples.passes[place][chosen] @ passes
             for place in ("best", "second")}
    count = samples.ends["best"][chosen].sum(axis=1)
    best = score["best"]
    second = np.where(samples.ends["second"][chosen].sum(axis=1) > 0, score["second"], -np.inf)
    floor = np.maximum(LEAST_RIVAL * count, best - RIVAL_MARGIN * count)
    gap = np.maximum(0, best - np.maximum(second, floor))
    contradicted = samples.ends["best"][chosen][:, CONTRADICTED].sum(axis=1) / count
    passed = samples.passes["best"][chosen]
    blocked = passed[:, ON_WALL] / np.maximum(1, passed.sum(axis=1))
    return np.column_stack([np.ones(len(gap)), np.sqrt(gap), np.sqrt(gap / count), np.minimum(best / count, 1),
                            np.log(contradicted + 0.02), np.log(blocked + 0.02)])


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


def learn(samples, chosen):
    weights = learn_weights(samples, chosen)
    buildings = samples.building[chosen]
    size = collections.Counter(buildings)
    importance = np.array([len(chosen) / len(size) / size[name] for name in buildings])
    return weights, fit_logistic(features(samples, chosen, weights), samples.right[chosen], importance)


def calibration_error(p, right, bins=10):
    groups = np.array_split(np.argsort(p), bins)
    return sum(len(g) * abs(p[g].mean() - right[g].mean()) for g in groups if len(g)) / len(p)


def report(name, p, right):
    cells = []
    for least in PROBABILITIES:
        taken = p >= least
        cells.append(f"{least}: {right[taken].sum()}/{right.sum()} right, {(1 - right)[taken].sum()} wrong")
    print(f"{name}: {len(p)} samples, ECE {calibration_error(p, right):.3f}; at p >= " + "; ".join(cells))


def main():
    samples = Samples(sys.argv[1])
    everything = np.arange(len(samples.right))
    print("left out:")
    held_out = np.zeros(len(everything))
    for building in sorted(set(samples.building)):
        test = everything[samples.building == building]
        weights, coefficients = learn(samples, everything[samples.building != building])
        held_out[test] = probability(features(samples, test, weights), coefficients)
        report(building, held_out[test], samples.right[test])
    report("pooled", held_out, samples.right)
    weights, coefficients = learn(samples, everything)
    report("all, learnt on all", probability(features(samples, everything, weights), coefficients), samples.right)
    print("kEndWeights", weights[0].round(2).tolist())
    print("kPassWeights", weights[1].round(2).tolist())
    print("logistic", coefficients.round(3).tolist())


if __name__ == "__main__":
    main()
