#!/usr/bin/python3
"""Makes docs/results.md, its figures and their tables from what cornerfix-bench measured.

Usage: bench_report.py RESULTS OUT: RESULTS is the folder of scripts/bench.sh with its CSV files, OUT the folder for results.md
and results/. Every number of the report comes from these files or, where it says so, from bench/paper and bench/originals.
"""
import pathlib
import sys

from bench_buildings import robots, speed, summary
from bench_experiments import corners, matching, worlds
from bench_page import BENCH, BUILDINGS, METHODS, Report, read, shown, table

ORIGINALS = BENCH / "originals" / "originals.csv"
CHECKS = {
    "standing": "the first scan, half of the run mapped",
    "even_odd": "every other scan, the others mapped",
}


def introduce(report):
    run = report.run
    quick = run["mode"] == "quick"
    robots = int(run["settings"].rsplit(" ", 1)[1])
    again = "scripts/bench.sh" + (" --quick" if quick else "") + ("" if robots == (4 if quick else 50) else f" --robots {robots}")
    report.say(
        "# Results",
        f"Made by `{again}`. All numbers below come from that run, except those of the paper and of the "
        "baselines' original implementations. These are in [bench/paper](../bench/paper) and "
        "[bench/originals](../bench/originals). All times are processor time of one thread.",
        table(
            ["", ""],
            [
                ["machine", f"{run['machine']}, {run['cores']:.0f} cores, {run['memory_gib']:.0f} GiB, {run['system']}"],
                ["compiler", str(run["compiler"])],
                ["commit, date", f"{run['commit']}, {run['date']}"],
                ["settings", f"{run['mode']}: {run['settings']}"],
                ["load when it began", f"{run['load']} (on a machine that does nothing else: under 0.5; else take times as indicative)"],
                ["took", f"{run['run_seconds']:.0f} s"],
            ],
        ),
    )


def baselines_and_originals(report):
    """Whether the baselines reach what their original implementations did, on the same runs."""
    lines = []
    for original in read(ORIGINALS):
        asked = f"{original['building']}_{original['check']}"
        of = [row for row in report.read(f"starts_{asked}.csv") if row["method"] == original["method"]]
        if not of:
            continue
        report.keep(f"starts_{asked}.csv")
        here = [sum(row["verdict"] == verdict for row in of) for verdict in ("fixed", "wrong", "none")]
        there = [original[verdict] for verdict in ("right", "wrong", "none")]
        lines.append(
            [str(original["building"]), CHECKS[original["check"]], METHODS[original["method"]][0]]
            + [f"{'/'.join(f'{n:.0f}' for n in verdicts)}: {verdicts[0] / sum(verdicts):.2f}" for verdicts in (here, there)]
        )
    if lines:
        report.say(
            "## Do the baselines work as their originals?",
            "Right/wrong/none, and the share that was right, beside what their original implementations "
            "reached on the same runs. The originals had other starts and their defaults "
            "([bench/originals](../bench/originals)). AMCL and MRPT here have better parameters.",
            table(["building", "asked", "baseline", "here", "original"], lines),
        )


def many_maps(report):
    rows = [row for b in BUILDINGS for row in report.read(f"many_maps_{b}.csv")]
    if not rows:
        return
    report.say(
        "## Which map",
        "Robots with a given map, and the same ones without. Without, they search among the maps of all "
        "other buildings, their mirror images, their halves and quarters, these mirrored, and the mirror "
        "image of the right map. A pose in another map is wrong.",
        table(
            ["building", "maps", "robots", "right", "wrong", "m until localized: p50 / p90", "searching ms per scan: mean / p50 / p95"],
            [
                [str(row["building"])]
                + [f"{row[key]:.0f}" for key in ("maps", "starts", "right", "wrong")]
                + [" / ".join(shown(row[key], 1) for key in ("way_p50_m", "way_p90_m"))]
                + [" / ".join(shown(row[key]) for key in ("mean_ms", "p50_ms", "p95_ms"))]
                for row in rows
            ],
        ),
    )
    for row in rows:
        report.keep(f"many_maps_{row['building']}.csv")


def where_baselines_are_better(report, starts, times, buildings):
    better = []
    for building in buildings:
        ours = summary(starts, times, building, "cornerfix")
        if not ours["starts"]:
            continue
        for method, (name, _) in METHODS.items():
            if method.startswith("cornerfix"):
                continue
            theirs = summary(starts, times, building, method)
            if not theirs["starts"]:
                continue
            where = []
            if theirs["fixed"] > ours["fixed"]:
                where.append(f"localizes more ({theirs['fixed']} against {ours['fixed']} of {ours['starts']}, with {theirs['wrong']} against {ours['wrong']} wrong)")
            if theirs["wrong"] < ours["wrong"]:
                where.append(f"fewer wrong ({theirs['wrong']} against {ours['wrong']})")
            if theirs["way"] is not None and ours["way"] is not None and theirs["way"] < ours["way"] and theirs["fixed"] >= 0.5 * theirs["starts"]:
                where.append(f"a shorter path until localized (median {theirs['way']:.1f} against {ours['way']:.1f} m)")
            if theirs["error_m"] is not None and ours["error_m"] is not None and theirs["error_m"] < 0.8 * ours["error_m"]:
                where.append(f"a smaller error (median {theirs['error_m']:.3f} against {ours['error_m']:.3f} m)")
            if theirs["searching"] and ours["searching"] and theirs["searching"]["mean_ms"] < ours["searching"]["mean_ms"]:
                where.append(f"less time per scan while searching ({theirs['searching']['mean_ms']:.2f} against {ours['searching']['mean_ms']:.2f} ms)")
            if where:
                better.append(f"- {building}, {name}: {'; '.join(where)}.")
    report.say("## Where a baseline is better", "\n".join(better) if better else "Nowhere in this run, by success, wrong answers, path length until localized, error and time per scan.")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    report = Report(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
    starts = [row for b in BUILDINGS for row in report.read(f"starts_{b}.csv")]
    times = [row for b in BUILDINGS for row in report.read(f"times_{b}.csv")]
    buildings = [b for b in BUILDINGS if any(row["building"] == b for row in starts)]
    introduce(report)
    if buildings:
        robots(report, starts, times, buildings)
        speed(report, times, buildings)
        where_baselines_are_better(report, starts, times, buildings)
    baselines_and_originals(report)
    many_maps(report)
    corners(report)
    matching(report)
    worlds(report)
    report.write()


main()
