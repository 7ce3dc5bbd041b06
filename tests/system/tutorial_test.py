#!/usr/bin/python3
"""Runs the blocks of a tutorial in a temporary directory, as its reader would.

Blocks of bash run one after the other in one shell, with the repository at ~/cornerfix and another
port. A block of text states lines that the block before prints, in this order; "…" stands for what
varies. Any other block is the content of the file that the paragraph before it names, as `robot.py`.
"""
import argparse
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from real_server import SOURCE, skip

TIMEOUT_S = 540
BLOCK = re.compile(
    r"(?:`(?P<file>[^`\n]+)`:\n\n)?^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE
)
MARK = "== end of block "


class Tutorial:
    def __init__(self, path):
        self.blocks = [match.groupdict() for match in BLOCK.finditer(path.read_text())]
        assert self.blocks, f"{path}: no blocks"
        for block in self.blocks:
            assert (
                block["kind"] in ("bash", "text") or block["file"]
            ), f"{path}: names no file for\n{block['text']}"

    def script(self):
        """One shell script; a line behind each block marks where its output ends."""
        parts = []
        for number, block in enumerate(self.blocks):
            if block["kind"] == "bash":
                parts.append(block["text"])
            elif block["kind"] != "text":
                parts.append(f"cat >{block['file']} <<'END OF FILE'\n{block['text']}END OF FILE")
            parts.append(f"printf '\\n{MARK}{number}\\n'")
        return "\n".join(parts)

    def check(self, output):
        """Raises if a line that is stated is missing."""
        printed = re.split(rf"^{MARK}\d+\n", output, flags=re.MULTILINE)
        for number, block in enumerate(self.blocks):
            if block["kind"] != "text":
                continue
            rest = printed[number - 1].splitlines()
            for line in block["text"].splitlines():
                pattern = ".*".join(re.escape(part) for part in line.strip().split("…"))
                found = next(
                    (i for i, each in enumerate(rest) if re.fullmatch(pattern, each.strip())), None
                )
                assert found is not None, f"not printed: {line}\nbut:\n{printed[number - 1]}"
                rest = rest[found + 1 :]


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return str(free.getsockname()[1])


def moved(script):
    """At free ports, so that tutorials run beside each other and beside a server at 8080."""
    port, ros_port = free_port(), free_port()
    server = f" --server http://127.0.0.1:{port}"
    script = script.replace("8080", port)
    script = script.replace("cornerfix serve", f"cornerfix serve --port {port}")
    script = re.sub(r"cornerfix (replay|map \w+)", lambda match: match.group() + server, script)
    script = script.replace("roscore >", f"roscore -p {ros_port} >")
    return f"export ROS_MASTER_URI=http://127.0.0.1:{ros_port}\n{script}"


def home(directory):
    """A home with a copy of what tutorials use of the repository."""
    for name in ("clients", "tests/data"):
        shutil.copytree(SOURCE / name, directory / "cornerfix" / name)
    (directory / "work").mkdir()
    return directory


def environment(directory, arguments):
    path = f"{pathlib.Path(arguments.cornerfix).resolve().parent}:/usr/bin:/bin"
    return {
        "HOME": str(directory),
        "PATH": path,
        "LANG": "C.UTF-8",
        "CMAKE_PREFIX_PATH": str(directory / "prefix"),
        "ROS_HOME": str(directory),
        "ROS_IP": "127.0.0.1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }


def stop_group(group):
    """Asks first, since roscore has children outside of the group, which it ends itself."""
    try:
        os.killpg(group, signal.SIGTERM)
        for _ in range(200):
            os.killpg(group, 0)
            time.sleep(0.05)
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        pass


def run(script, directory, arguments):
    """The output of all blocks; the shell and all that it started is gone afterwards."""
    log = directory / "output.txt"
    with open(log, "w") as output:
        shell = subprocess.Popen(
            ["/bin/bash", "-e", "-c", script],
            cwd=directory / "work",
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=environment(directory, arguments),
        )
        try:
            code = shell.wait(timeout=TIMEOUT_S)
        finally:
            stop_group(shell.pid)
    text = log.read_text()
    print(text)
    assert code == 0, f"a block ended with {code}"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True)
    parser.add_argument(
        "--needs", action="append", default=[], help="program without which it is skipped"
    )
    parser.add_argument("--install", help="build directory to install to CMAKE_PREFIX_PATH first")
    parser.add_argument("tutorial", type=pathlib.Path)
    arguments = parser.parse_args()
    for program in arguments.needs:
        if not shutil.which(program):
            skip(f"{arguments.tutorial.name} was not tested: {program} is not installed")
    tutorial = Tutorial(arguments.tutorial)
    with tempfile.TemporaryDirectory() as name:
        directory = home(pathlib.Path(name))
        if arguments.install:
            subprocess.run(
                ["cmake", "--install", arguments.install, "--prefix", directory / "prefix"],
                check=True,
                stdout=subprocess.DEVNULL,
            )
        tutorial.check(run(moved(tutorial.script()), directory, arguments))
    print(f"{arguments.tutorial.name}: {len(tutorial.blocks)} blocks as stated")


if __name__ == "__main__":
    sys.exit(main())
