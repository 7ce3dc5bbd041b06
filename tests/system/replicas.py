"""PostgreSQL and HAProxy for tests of several servers on one database. Both end with the test."""
import os
import shutil
import socket
import subprocess

from real_server import SOURCE, run

NOT_INSTALLED = 77
CONFIGURATION = SOURCE / "deploy" / "haproxy" / "haproxy.cfg"


class Postgresql:
    """On a Unix socket in a directory. It ends with this process at the latest."""

    def __init__(self, directory):
        self._directory = str(directory)
        self._databases = 0

    def control(self, action, *arguments):
        script = SOURCE / "tests" / "support" / "postgresql.sh"
        return subprocess.run(["bash", script, action, self._directory, *arguments]).returncode

    def start(self):
        return self.control("start", str(os.getpid()))

    def new_database(self):
        """The URL of an empty one: a schema of its own."""
        self._databases += 1
        url = f"postgresql:///postgres?host={self._directory}&user=cornerfix"
        schema = f"test{self._databases}"
        run("psql", "--quiet", url, "--command", f"CREATE SCHEMA {schema}")
        return f"{url}&options=-csearch_path%3D{schema}"


class HaProxy:
    """The deployed configuration before up to three servers, on a free port."""

    @staticmethod
    def program():
        """Its path; None where it is not installed."""
        return shutil.which("haproxy", path=os.environ.get("PATH", "") + ":/usr/sbin")

    def __init__(self, directory, servers, most_connections=100):
        """`most_connections` at the same time; each needs two descriptors."""
        self._control = str(directory / "haproxy.sock")
        text = CONFIGURATION.read_text()
        text = text.replace("maxconn 20000", f"maxconn {most_connections}")
        text = text.replace("global\n", f"global\n    stats socket {self._control}\n", 1)
        for number in (1, 2, 3):
            name = f"replica{number}"
            if number <= len(servers):
                address = servers[number - 1].url.removeprefix("http://")
                text = text.replace(f"server {name} {name}:8080", f"server {name} {address}")
            else:
                text = text.replace(f"    server {name} {name}:8080\n", "")
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.url = "http://127.0.0.1:%d" % listener.getsockname()[1]
            file = directory / "haproxy.cfg"
            file.write_text(text.replace("bind :8080", f"bind fd@{listener.fileno()}"))
            self._process = subprocess.Popen(
                [self.program(), "-db", "-q", "-f", file],
                pass_fds=[listener.fileno()],
                stdout=subprocess.DEVNULL,
            )

    def servers_up(self):
        """How many servers it sends sessions to."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(self._control)
            connection.sendall(b"show stat\n")
            with connection.makefile() as answer:
                rows = [line.split(",") for line in answer]
        return sum(
            row[0] == "sessions" and row[1].startswith("replica") and row[17].startswith("UP")
            for row in rows
            if len(row) > 17
        )

    def stop(self):
        self._process.terminate()
        self._process.wait()
