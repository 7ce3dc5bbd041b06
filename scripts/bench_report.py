#!/usr/bin/python3
"""Makes docs/results.md, its figures and their tables from what cornerfix-bench measured.

Usage: bench_report.py RESULTS OUT: RESULTS is the folder of scripts/bench.sh with its CSV files, OUT the folder for results.md
and results/. Every number of the report comes from these files or, where it says so, from bench/paper and bench/originals.
"""
import csv
import math
import pathlib
import statistics
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

BENCH = pathlib.Path(__file__).resolve().parent.parent / "bench"
PAPER = BENCH / "paper"
ORIGINALS = BENCH / "originals" / "originals.csv"
DEGREES = 180.0 / math.pi

METHODS = {  # name in tables -> name for readers, colour
    "cornerfix": ("Cornerfix", "#d62728"),
    "cornerfix_rma": ("Cornerfix, method rma", "#ff9896"),
    "rma_published": ("RMA as published", "#9467bd"),
    "amcl": ("AMCL, 20,000", "#1f77b4"),
    "mrpt": ("MRPT Monte Carlo", "#17becf"),
    "cartographer_full": ("branch and bound, whole map", "#2ca02c"),
    "cartographer_window": ("branch and bound, 7 m / 30 deg given", "#98df8a"),
    "correlative_icp": ("correlative + ICP", "#8c564b"),
}
CHECKS = {
    "standing": "the first scan, half of the run mapped",
    "even_odd": "every other scan, the others mapped",
}
CORNERS = {
    "vfp": ("VFP", "#9467bd", "x"),
    "two_arm": ("line intersection", "#d62728", "+"),
    "loam": ("LOAM", "#1f77b4", "1"),
    "harris": ("HARRIS", "#2ca02c", "2"),
    "orb": ("ORB", "#8c564b", "3"),
}
SIMULATED = {"museum", "stata", "changed_office", "willow"}
BUILDINGS = ["intel", "freiburg_079", "aces", "fhw", "csail", "museum", "stata", "changed_office", "willow"]


def number(text):
    try:
        return float(text)
    except ValueError:
        return None


def read(path):
    """Rows of a CSV file as dictionaries, numbers as such; none when there is no such file."""
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return [{k: v if number(v) is None else number(v) for k, v in row.items()} for row in csv.DictReader(file)]


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None


def shown(value, digits=2):
    return "–" if value is None else f"{value:,.{digits}f}"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def wrapped(part):
    """Running text in lines of at most 100 columns; tables, headings and pictures stay."""
    lines = []
    for line in part.split("\n"):
        indent = "  " if line.startswith("- ") else ""
        if line.startswith(("|", "#", "!")):
            lines.append(line)
        else:
            lines += textwrap.wrap(line, 100, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines)


class Report:
    def __init__(self, results, out):
        self.results = results
        self.out = out
        self.folder = out / "results"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.run = {row["key"]: row["value"] for row in read(results / "run.csv")}
        self.text = []

    def read(self, name):
        return read(self.results / name)

    def say(self, *paragraphs):
        self.text.extend(paragraphs)

    def keep(self, name):
        """Puts the table behind a figure beside it."""
        source = self.results / name
        if source.exists():
            (self.folder / name).write_text(source.read_text())

    def figure(self, name, caption, tables):
        plt.savefig(self.folder / name, dpi=110, bbox_inches="tight")
        plt.close()
        for source in tables:
            self.keep(source)
        kept = ", ".join(f"[{t}](results/{t})" for t in tables if (self.folder / t).exists())
        behind = f" Behind it: {kept}." if kept else ""
        self.say(f"![{caption}](results/{name})", f"*{caption}.*{behind}")

    def write(self):
        (self.out / "results.md").write_text("\n\n".join(wrapped(part.rstrip("\n")) for part in self.text) + "\n")


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


def corners(report):
    rows = report.read("corners.csv")
    if not rows:
        return
    paper = {(row["noise_m"], row["method"]): row for row in read(PAPER / "corners.csv")}
    seeds = int(rows[0]["rooms"])
    report.say(
        "## Corners: the paper's section 4.2, tables 1-3",
        "A room of 10 by 10 m after the paper's figure 7, 1440 beams in a full turn. Suppression is "
        f"within 1 m for all; a corner is right within 0.1 m. Means over {seeds} scans at the paper's "
        f"place in different headings, and over {seeds} random rooms. Recall counts corners with 0.6 m of "
        "both walls in sight. LOAM is the coarse score alone. HARRIS and ORB are OpenCV's on the returns "
        "drawn at 0.02 m per pixel; the paper does not give its settings for them. P is precision, R "
        "recall, ms extraction + suppression.",
    )
    lines = []
    for row in rows:
        if row["room"] != "paper":
            continue
        theirs = paper.get((row["noise_m"], row["method"]))
        other = next(r for r in rows if r["room"] == "random" and (r["noise_m"], r["method"]) == (row["noise_m"], row["method"]))
        lines.append(
            [
                f"{row['noise_m']:.2f}",
                CORNERS[row["method"]][0],
                f"{row['precision']:.2f} / {row['recall']:.2f}",
                f"{row['extract_ms']:.3f} + {row['suppress_ms']:.3f}",
                f"{other['precision']:.2f} / {other['recall']:.2f}",
                f"{theirs['precision']:.2f} / {theirs['recall']:.2f}" if theirs else "–",
                f"{theirs['ms']:.3f}" if theirs else "–",
            ]
        )
    report.say(table(["noise m", "method", "P / R", "ms", "P / R, random rooms", "paper: P / R", "paper: ms"], lines))
    report.keep("corners.csv")
    picture = report.read("corners_picture.csv")
    noises = sorted({row["noise_m"] for row in picture})
    methods = [m for m in CORNERS if any(row["kind"] == m for row in picture)]
    _, axes = plt.subplots(len(noises), len(methods), figsize=(3.2 * len(methods), 3.2 * len(noises)), squeeze=False)
    for i, noise in enumerate(noises):
        of = {}
        for row in picture:
            if row["noise_m"] == noise:
                of.setdefault(row["kind"], []).append((row["x_m"], row["y_m"]))
        for j, method in enumerate(methods):
            axis = axes[i][j]
            axis.plot(*zip(*of["scan"]), ",", color="0.6")
            axis.plot(*zip(*of["corner"]), "o", mfc="none", color="k", ms=11)
            axis.plot(*zip(*of["lidar"]), "k^", ms=5)
            if method in of:
                axis.plot(*zip(*of[method]), CORNERS[method][2], color=CORNERS[method][1], ms=9, mew=2)
            axis.set(aspect="equal", xticks=[], yticks=[])
            if i == 0:
                axis.set_title(CORNERS[method][0])
            if j == 0:
                axis.set_ylabel(f"noise {noise:g} m")
    report.figure(
        "corners.png",
        "Detected corners (marks) in one scan, and the room's corners in sight (circles)",
        ["corners_picture.csv"],
    )


def matching(report):
    rows = report.read("matching.csv")
    if not rows:
        return
    report.say(
        "## Matching: the paper's section 4.3, figure 8",
        "Random features in 50 by 50 m. Half of the features of the local map are the map's, without "
        "noise; p = .95, N/N_local = .5, as in the paper. Times are those of matching alone, with the "
        "map's index made before.",
    )
    lines = []
    for count in sorted({row["features"] for row in rows}):
        of = [row for row in rows if row["features"] == count]
        last = of[-1]
        lines.append(
            [
                f"{count:.0f}",
                f"{last['local']:.0f}",
                shown(last["nma_ms"], 3),
                shown(last["rma_ms"], 3),
                shown(last["nma_ms"] / last["rma_ms"], 1),
                shown(last["triangles_ms"], 3),
                shown(100 * statistics.mean(row["rma_as_nma"] for row in of), 1) + " %",
                shown(100 * statistics.mean(row["rma_as_nma"] for row in of if row["local"] >= 20), 1) + " %",
            ]
        )
    report.say(
        table(
            ["features", "local", "NMA ms", "RMA ms", "NMA/RMA", "triangles ms", "RMA as NMA, all local counts", "from 20 local on"], lines
        )
    )
    counts = sorted({row["features"] for row in rows})
    _, axes = plt.subplots(1, len(counts), figsize=(4 * len(counts), 3.4))
    for axis, count in zip(axes, counts):
        of = [row for row in rows if row["features"] == count]
        for key, name, colour in (("nma_ms", "NMA", "#1f77b4"), ("rma_ms", "RMA", "#9467bd"), ("triangles_ms", "triangles", "#d62728")):
            axis.semilogy([row["local"] for row in of], [row[key] for row in of], label=name, color=colour)
        axis.set(title=f"{count:.0f} features in the map", xlabel="features in the local map", ylabel="ms")
        axis.grid(alpha=0.3)
    axes[0].legend()
    report.figure("matching.svg", "Time of a match by the size of the local map (figure 8 of the paper)", ["matching.csv"])

    sweeps = report.read("matching_sweeps.csv")
    _, axes = plt.subplots(1, 2, figsize=(9, 3.4))
    for axis, sweep, key, label in zip(
        axes, ("overlap", "noise"), ("overlap", "noise_m"), ("share of the local map that the map holds (noise 0.05 m)", "noise m (overlap .5)")
    ):
        of = [row for row in sweeps if row["sweep"] == sweep]
        for method, name, colour in (("nma", "NMA", "#1f77b4"), ("rma", "RMA", "#9467bd"), ("triangles", "triangles", "#d62728")):
            axis.plot([row[key] for row in of], [row[method] for row in of], "o-", label=name, color=colour)
        axis.set(xlabel=label, ylabel="right poses", ylim=(-0.03, 1.03))
        axis.grid(alpha=0.3)
    axes[0].legend()
    report.figure(
        "matching_sweeps.svg",
        f"Right poses (0.5 m, 5 deg) of {sweeps[0]['trials']:.0f} local maps of 50 features in a map of 300, .0177 per square metre",
        ["matching_sweeps.csv"],
    )

    large = report.read("matching_large.csv")
    report.say(
        table(
            ["features", "overlap", "RMA ms", "RMA right", "RMA index MB", "triangles ms", "triangles right", "triangles index MB"],
            [
                [
                    f"{row['features']:,.0f}",
                    f"{row['overlap']:.1f}",
                    shown(row["rma_ms"], 2),
                    shown(row["rma_right"]),
                    shown(row["rma_index_bytes"] / 1e6, 1),
                    shown(row["triangles_ms"], 3),
                    shown(row["triangles_right"]),
                    shown(row["triangles_index_bytes"] / 1e6, 1),
                ]
                for row in large
            ],
        )
    )
    report.keep("matching_large.csv")


def worlds(report):
    rows = report.read("worlds.csv")
    if not rows:
        return
    methods = [m for m in METHODS if any(row["method"] == m for row in rows)]
    kinds = ["static", "changed", "similar"]
    report.say(
        "## Worlds: the paper's section 4.4, figures 9-11",
        "25 by 25 m, a lidar of 180 deg at .25 deg and .01 m. The robot turns once on the spot, then "
        "moves for up to 20 m. *static*: as mapped. *changed*: twelve more boxes within 5 m of the start."
        " *similar*: four rooms with the same boxes, and three more boxes in the other rooms.",
    )
    lines = []
    for kind in kinds:
        for method in methods:
            of = [row for row in rows if row["world"] == kind and row["method"] == method]
            fixed = [row for row in of if row["verdict"] == "fixed"]
            lines.append(
                [
                    kind,
                    METHODS[method][0],
                    f"{len(fixed)} of {len(of)}",
                    str(sum(row["verdict"] == "wrong" for row in of)),
                    str(sum(row["way_m"] == 0 for row in fixed)),
                    shown(percentile([row["way_m"] for row in fixed], 0.5), 1),
                    shown(percentile([row["error_m"] for row in fixed], 0.5), 3),
                    shown(statistics.mean(row["corners_seen"] for row in of), 1),
                ]
            )
    report.say(table(["world", "method", "localized", "wrong", "on the spot", "path m, median", "error m, median", "corners in the first scan"], lines))
    walls = report.read("worlds_walls.csv")
    _, axes = plt.subplots(1, 3, figsize=(13, 4.4))
    for axis, kind in zip(axes, kinds):
        for wall in walls:
            if wall["world"] == kind and wall["kind"] == "start":
                axis.plot(wall["x0_m"], wall["y0_m"], "k*", ms=9)
            elif wall["world"] == kind:
                axis.plot([wall["x0_m"], wall["x1_m"]], [wall["y0_m"], wall["y1_m"]], color="k" if wall["kind"] == "mapped" else "#ff7f0e", lw=1)
        for method in methods:
            of = [row for row in rows if row["world"] == kind and row["method"] == method and row["verdict"] == "fixed"]
            axis.plot([row["x_m"] for row in of], [row["y_m"] for row in of], ".", color=METHODS[method][1], label=METHODS[method][0], alpha=0.7)
        axis.set(title=kind, aspect="equal")
    axes[0].legend(fontsize=8)
    report.figure(
        "worlds.png",
        "The first world of each kind (added boxes in orange), the start (star), and the places of robots when localized in all worlds of the kind",
        ["worlds.csv"],
    )


def summary(starts, times, building, method):
    """What one method did in one building."""
    of = [row for row in starts if row["building"] == building and row["method"] == method]
    fixed = [row for row in of if row["verdict"] == "fixed"]
    phase = {row["phase"]: row for row in times if row["building"] == building and row["method"] == method}
    return {
        "starts": len(of),
        "fixed": len(fixed),
        "wrong": sum(row["verdict"] == "wrong" for row in of),
        "seconds": percentile([row["seconds"] for row in fixed], 0.5),
        "way": percentile([row["way_m"] for row in fixed], 0.5),
        "error_m": percentile([row["error_m"] for row in fixed], 0.5),
        "error_deg": percentile([DEGREES * row["error_rad"] for row in fixed], 0.5),
        "work_s": percentile([row["searching_ms"] / 1e3 for row in of], 0.5),
        "searching": phase.get("searching"),
        "tracking": phase.get("tracking"),
    }


def robots(report, starts, times, buildings):
    report.say(
        "## Robots: the paper's section 4.5, tables 4-5",
        "Robots are started all along a run, without an initial pose. All methods have the same starts, "
        "scans, odometry and mapping run, and one thread. Cartographer's grid takes more scans of the "
        "mapping run by its own rule. A start counts if it is within 1 m of a mapped pose. It is *right* "
        "if the first pose is within .5 m and 5 deg, *wrong* if not, and *none* after 20 m or 180 s, of "
        "driving or of computing. Times are of scans that a method worked on. Monte Carlo waits for .2 m "
        "or 30 deg between updates. Branch and bound and correlation wait for .2 m or 10 deg between "
        "searches. Cornerfix and RMA work on every scan. *Work* is the total time of a start until it is "
        "localized or ends. The reference poses of recorded runs are themselves good to .1-.2 m.",
        "- *Branch and bound* is Cartographer's (7 levels, minimum score .6, a grid of probabilities of "
        "its own). It searches the whole map, and the paper's window of 7 m and 30 deg, which requires "
        "that the pose is known so well.\n"
        "- *AMCL* is the algorithm of ROS with its parameters, 20,000 particles in the whole map, "
        "recovery on. *MRPT* is `CMonteCarloLocalization2D` of Debian's package. Their pose counts once "
        "the particles lie within .5 m (standard deviation).\n"
        "- *RMA as published* accepts the first match with more than six votes; *Cornerfix, method rma* "
        "verifies it.\n"
        "- The memory of a map is what the method itself searches, without the grid file.",
    )
    for building in buildings:
        methods = [m for m in METHODS if any(row["building"] == building and row["method"] == m for row in starts)]
        kind = "simulated runs" if building in SIMULATED else "recorded run"
        lines = []
        for method in methods:
            s = summary(starts, times, building, method)
            searching, tracking = s["searching"], s["tracking"]
            lines.append(
                [
                    METHODS[method][0],
                    f"{s['fixed']}/{s['wrong']}/{s['starts'] - s['fixed'] - s['wrong']}",
                    f"{shown(s['seconds'], 1)} / {shown(s['way'], 1)}",
                    " / ".join(shown(searching[k]) for k in ("mean_ms", "p50_ms", "p95_ms")) if searching else "–",
                    " / ".join(shown(tracking[k]) for k in ("mean_ms", "p50_ms", "p95_ms")) if tracking else "–",
                    shown(s["work_s"]),
                    f"{shown(s['error_m'], 3)} / {shown(s['error_deg'])}",
                    f"{shown(searching['map_bytes'] / 1e6, 1)} + {shown(searching['robot_bytes'] / 1e6, 1)}" if searching else "–",
                ]
            )
        report.say(
            f"### {building} ({kind})",
            table(
                [
                    "method",
                    "right/wrong/none",
                    "s / m until localized, median",
                    "searching ms per scan: mean / p50 / p95",
                    "tracking ms: mean / p50 / p95",
                    "work s",
                    "error m / deg, median",
                    "MB map + robot",
                ],
                lines,
            ),
        )
        report.keep(f"starts_{building}.csv")
        report.keep(f"times_{building}.csv")
    paper_table(report, starts, times, buildings)
    curves(report, starts, buildings)
    for building in buildings:
        map_figure(report, starts, building)


def paper_table(report, starts, times, buildings):
    rows = [row for row in read(PAPER / "robots.csv") if row["building"] in buildings]
    if not rows:
        return
    lines = []
    for row in rows:
        s = summary(starts, times, row["building"], row["method"])
        searching = s["searching"]
        lines.append(
            [
                str(row["building"]),
                METHODS[row["method"]][0],
                f"{row['found']:.0f} of {row['starts']:.0f}",
                shown(row["mean_ms"]),
                f"{shown(row['error_m'])} / {shown(row['error_deg'])}",
                f"{s['fixed']} of {s['starts']}",
                shown(searching["mean_ms"]) if searching else "–",
                f"{shown(s['error_m'], 3)} / {shown(s['error_deg'])}",
            ]
        )
    report.say(
        "### Beside the paper's tables 4-5",
        "The paper used recorded bags of the two buildings on its own machine. Here runs are simulated in"
        " their occupancy maps. Times are means per scan while searching.",
        table(["building", "method", "paper: localized", "paper: ms", "paper: error m / deg", "here: localized", "here: ms", "here: error m / deg"], lines),
    )


def curves(report, starts, buildings):
    columns = min(3, len(buildings))
    lines = math.ceil(len(buildings) / columns)
    _, axes = plt.subplots(lines, columns, figsize=(4.6 * columns, 3.3 * lines), squeeze=False)
    for axis, building in zip(axes.flat, buildings):
        for method, (name, colour) in METHODS.items():
            of = [row for row in starts if row["building"] == building and row["method"] == method]
            if not of or method == "cartographer_window":
                continue
            ways = sorted(row["way_m"] for row in of if row["verdict"] == "fixed")
            axis.step([0.0] + ways + [20.0], [i / len(of) for i in range(len(ways) + 1)] + [len(ways) / len(of)], where="post", color=colour, label=name)
        axis.set(title=building, xlabel="m driven", ylabel="localized correctly", ylim=(-0.03, 1.03), xlim=(-0.3, 20))
        axis.grid(alpha=0.3)
    for axis in list(axes.flat)[len(buildings):]:
        axis.axis("off")
    axes.flat[0].legend(fontsize=7)
    report.figure("time_to_fix.svg", "Share of the robots that were localized correctly, by path length", [f"starts_{b}.csv" for b in buildings])


def map_figure(report, starts, building):
    walls = report.read(f"walls_{building}.csv")
    way = report.read(f"way_{building}.csv")
    methods = [m for m in ("cornerfix", "amcl", "cartographer_full", "rma_published") if any(row["building"] == building and row["method"] == m for row in starts)]
    if not walls or not methods:
        return
    _, axes = plt.subplots(1, len(methods), figsize=(4.2 * len(methods), 4.4), squeeze=False)
    for axis, method in zip(axes[0], methods):
        axis.plot([row["x_m"] for row in walls], [row["y_m"] for row in walls], ",", color="0.5")
        axis.plot([row["x_m"] for row in way], [row["y_m"] for row in way], ",", color="#aec7e8")
        of = [row for row in starts if row["building"] == building and row["method"] == method]
        for verdict, colour in (("fixed", "#2ca02c"), ("wrong", "#d62728")):
            said = [row for row in of if row["verdict"] == verdict]
            for row in said:
                axis.plot([row["true_x_m"], row["x_m"]], [row["true_y_m"], row["y_m"]], "-", color=colour, lw=0.8)
            axis.plot([row["x_m"] for row in said], [row["y_m"] for row in said], ".", color=colour, ms=6)
        axis.set(title=METHODS[method][0], aspect="equal", xticks=[], yticks=[])
    report.figure(
        f"fixes_{building}.png",
        f"{building}: the path of the robots (blue) and their poses when localized: right (green), wrong (red, joined to the true place)",
        [],
    )


def speed(report, starts, times, buildings):
    tracking = [row for building in buildings for row in report.read(f"tracking_{building}.csv")]
    names = {"cornerfix": "Cornerfix", "amcl": "AMCL, KLD", "amcl_20000": "AMCL, all 20,000", "amcl_20000_binary_search": "AMCL, all 20,000, binary search", "mrpt": "MRPT, KLD"}
    if tracking:
        report.say(
            "## Tracking a robot",
            "Over 20 m each, from a known start. Cornerfix starts from its own accepted pose. AMCL is "
            "given the start with .5 m and 15 deg of deviation, MRPT within .25 m and 7.5 deg. In "
            "recorded runs every other scan is used, and the others make the map. Times are of scans that"
            " a method worked on. *Right* is within .5 m and 5 deg of the reference; it also checks that "
            "Monte Carlo works. ROS's AMCL draws each particle by a loop over all of them; *binary "
            "search* uses one instead.",
            table(
                ["building", "method", "scans", "ms: mean / p50 / p95", "right"],
                [
                    [
                        str(row["building"]),
                        names[row["method"]],
                        f"{row['scans']:.0f}",
                        " / ".join(shown(row[k]) for k in ("mean_ms", "p50_ms", "p95_ms")),
                        shown(row["right"] / max(1, row["right"] + row["wrong"])),
                    ]
                    for row in tracking
                ],
            ),
        )
        for building in buildings:
            report.keep(f"tracking_{building}.csv")

    def ms(building, method, phase, key):
        found = [row[key] for row in times if (row["building"], row["method"], row["phase"]) == (building, method, phase)]
        return found[0] if found else None

    def following(building, method):
        found = [row["mean_ms"] for row in tracking if row["building"] == building and row["method"] == method]
        return found[0] if found else None

    def ratio(a, b):
        return a / b if a is not None and b else None

    columns = [  # label, goal, ratio in a building
        ("searching, mean: AMCL", 15, lambda b: ratio(ms(b, "amcl", "searching", "mean_ms"), ms(b, "cornerfix", "searching", "mean_ms"))),
        ("branch and bound", 100, lambda b: ratio(ms(b, "cartographer_full", "searching", "mean_ms"), ms(b, "cornerfix", "searching", "mean_ms"))),
        ("median: AMCL", 50, lambda b: ratio(ms(b, "amcl", "searching", "p50_ms"), ms(b, "cornerfix", "searching", "p50_ms"))),
        ("branch and bound ", 300, lambda b: ratio(ms(b, "cartographer_full", "searching", "p50_ms"), ms(b, "cornerfix", "searching", "p50_ms"))),
        ("tracking, mean: AMCL, all 20,000", 200, lambda b: ratio(following(b, "amcl_20000"), following(b, "cornerfix"))),
    ]
    report.say(
        "## Speed against the baselines",
        "How many times the time of Cornerfix per scan the baselines need. While searching, Cornerfix's "
        "own searches for rivals are included.",
        table(
            ["building"] + [label.strip() for label, _, _ in columns],
            [["*goal*"] + [f"*{goal}*" for _, goal, _ in columns]] + [[b] + [shown(of(b), 0) for _, _, of in columns] for b in buildings],
        ),
    )
    _, axis = plt.subplots(figsize=(10, 3.6))
    width = 0.8 / len(columns)
    for i, (label, goal, of) in enumerate(columns):
        values = [of(b) or 0.0 for b in buildings]
        bars = axis.bar([j + i * width for j in range(len(buildings))], values, width, label=f"{label.strip()} (goal {goal})")
        axis.hlines([goal] * len(buildings), [j + (i - 0.5) * width for j in range(len(buildings))], [j + (i + 0.5) * width for j in range(len(buildings))], color="k", lw=1.2)
        del bars
    axis.set_yscale("log")
    axis.set_xticks([j + 0.4 - width / 2 for j in range(len(buildings))], buildings, rotation=20)
    axis.set_ylabel("times Cornerfix's")
    axis.legend(fontsize=7, ncol=2)
    report.figure("speed.svg", "Time of a scan against Cornerfix's; black lines are the goals", [f"times_{b}.csv" for b in buildings])


def rivals_well(report):
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


def honest(report, starts, times, buildings):
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
        speed(report, starts, times, buildings)
        honest(report, starts, times, buildings)
    rivals_well(report)
    many_maps(report)
    corners(report)
    matching(report)
    worlds(report)
    report.write()


main()
