"""What the parts of the benchmarks' report share: tables of results, figures, and the page that is written."""
import csv
import pathlib
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

BENCH = pathlib.Path(__file__).resolve().parent.parent / "bench"
PAPER = BENCH / "paper"

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
