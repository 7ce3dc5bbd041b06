"""The part of the benchmarks' report on the paper's experiments: corners, matching and generated worlds."""
import statistics

from bench_page import METHODS, PAPER, percentile, plt, read, shown, table

CORNERS = {
    "vfp": ("VFP", "#9467bd", "x"),
    "two_arm": ("line intersection", "#d62728", "+"),
    "loam": ("LOAM", "#1f77b4", "1"),
    "harris": ("HARRIS", "#2ca02c", "2"),
    "orb": ("ORB", "#8c564b", "3"),
}


def corners(report):
    rows = report.read("corners.csv")
    if not rows:
        return
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
    corner_table(report, rows)
    corner_figure(report)


def corner_table(report, rows):
    paper = {(row["noise_m"], row["method"]): row for row in read(PAPER / "corners.csv")}
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


def corner_figure(report):
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
    matching_table(report, rows)
    matching_figure(report, rows)
    matching_sweeps(report)
    large_maps(report)


def matching_table(report, rows):
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


def matching_figure(report, rows):
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


def matching_sweeps(report):
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


def large_maps(report):
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
