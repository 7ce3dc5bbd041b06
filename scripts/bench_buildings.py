"""The part of the benchmarks' report on robots in buildings: success, tracking and speed of all methods."""
import math

from bench_page import METHODS, PAPER, percentile, plt, read, shown, table

DEGREES = 180.0 / math.pi
SIMULATED = {"museum", "stata", "changed_office", "willow"}


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
        building_table(report, starts, times, building)
    paper_table(report, starts, times, buildings)
    curves(report, starts, buildings)
    for building in buildings:
        map_figure(report, starts, building)


def building_table(report, starts, times, building):
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


def speed(report, times, buildings):
    tracking = [row for building in buildings for row in report.read(f"tracking_{building}.csv")]
    tracking_table(report, tracking, buildings)

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
    speed_figure(report, columns, buildings)


def tracking_table(report, tracking, buildings):
    names = {"cornerfix": "Cornerfix", "amcl": "AMCL, KLD", "amcl_20000": "AMCL, all 20,000", "amcl_20000_binary_search": "AMCL, all 20,000, binary search", "mrpt": "MRPT, KLD"}
    if not tracking:
        return
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


def speed_figure(report, columns, buildings):
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
