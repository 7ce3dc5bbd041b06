"""Checks that what deploy/ asks Prometheus for is what the server counts, and its rules.

deploy_test.py SOURCE_DIRECTORY: exit code 1 for a fault, 77 when promtool is not installed.
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys


def names_of(text):
    return set(re.findall(r"(?:cornerfix|process)_[a-z_]+", text))


def known_names(source):
    names = names_of((source / "server/metrics.cpp").read_text())
    return names | {f"{name}_{part}" for name in names for part in ("bucket", "sum", "count")}


def expressions(source):
    """Of the alert rules and the dashboard, by file."""
    alerts = (source / "deploy/prometheus/alerts.yml").read_text()
    dashboard = json.loads((source / "deploy/grafana/cornerfix.json").read_text())
    targets = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
    assert targets, "the dashboard asks for nothing"
    return {"alerts.yml": re.sub(r"summary:.*", "", alerts), "cornerfix.json": " ".join(targets)}


def main():
    source = pathlib.Path(sys.argv[1])
    known = known_names(source)
    faults = [f"{file}: {name} is not counted by the server"
              for file, text in expressions(source).items()
              for name in sorted(names_of(text) - known)]
    documented = (source / "docs/operations.md").read_text()
    for alert in re.findall(r"alert: (\w+)", (source / "deploy/prometheus/alerts.yml").read_text()):
        if alert not in documented:
            faults.append(f"docs/operations.md: {alert} is missing")
    if faults:
        print("\n".join(faults))
        return 1
    promtool = shutil.which("promtool")
    if not promtool:
        return 77
    directory = source / "deploy/prometheus"
    for command in (["check", "rules", "alerts.yml"], ["check", "config", "prometheus.yml"],
                    ["test", "rules", "alerts_test.yml"]):
        subprocess.run([promtool, *command], cwd=directory, check=True)
    return 0


sys.exit(main())
