#!/usr/bin/python3
"""deploy/nginx in front of the real server: a robot over TLS, tokens, events and metrics."""
import argparse
import http.client
import json
import pathlib
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import unittest

from real_server import CLIENT, SOURCE, WILLOW, RealServer, record_run, run, skip

sys.path.insert(0, str(CLIENT))
from cornerfix import Client, Problem, Robot, read_log  # noqa: E402

WAIT_S = 60  # For what is sure to come.
ATTEMPTS = 5  # To find a port that nobody else takes.
CERTIFICATE, KEY = "/etc/ssl/certs/cornerfix.pem", "/etc/ssl/private/cornerfix.key"


def make_certificate(directory):
    run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
        "-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost",
        "-keyout", directory / "cornerfix.key", "-out", directory / "cornerfix.pem")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def replaced(text, old, new):
    assert text.count(old) == 1, f"expected {old!r} once"
    return text.replace(old, new)


class Nginx:
    """nginx with the files of deploy/nginx, of which only addresses and paths are replaced."""

    def __init__(self, program, directory, server_url):
        self._program = program
        self._directory = directory
        make_certificate(directory)
        address = server_url.removeprefix("http://")
        upstream = (SOURCE / "deploy/nginx/cornerfix_upstream.conf").read_text()
        (directory / "upstream.conf").write_text(replaced(upstream, "127.0.0.1:8080", address))
        for _ in range(ATTEMPTS):
            self.port = free_port()
            if self._start():
                return
        raise AssertionError((directory / "error.log").read_text())

    def _start(self):
        site = (SOURCE / "deploy/nginx/cornerfix.conf").read_text()
        site = replaced(site, "listen 443 ssl", f"listen 127.0.0.1:{self.port} ssl")
        site = replaced(site, CERTIFICATE, str(self._directory / "cornerfix.pem"))
        site = replaced(site, KEY, str(self._directory / "cornerfix.key"))
        (self._directory / "site.conf").write_text(site)
        kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
        paths = "".join(f"{kind}_temp_path {self._directory}/{kind};" for kind in kinds)
        (self._directory / "nginx.conf").write_text(
            f"user root; pid {self._directory}/nginx.pid; events {{}} http {{"
            f" access_log off; {paths}"
            f" include {self._directory}/upstream.conf; include {self._directory}/site.conf; }}")
        # It returns when it listens.
        return subprocess.run([self._program, *self._options()]).returncode == 0

    def _options(self):
        return ("-p", self._directory, "-e", self._directory / "error.log", "-c",
                self._directory / "nginx.conf")

    def stop(self):
        run(self._program, *self._options(), "-s", "quit")


class NginxTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._temporary = tempfile.TemporaryDirectory()
        directory = pathlib.Path(cls._temporary.name)
        database = directory / "maps.db"
        cls.token = run(cls.cornerfix, "token", "create", "--db", database, "--role", "admin",
                        "--name", "operator").strip()
        cls.server = RealServer(cls.cornerfix, database)
        cls.nginx = Nginx(cls.program, directory, cls.server.url)
        cls.trust = ssl.create_default_context(cafile=directory / "cornerfix.pem")
        cls.url = f"https://localhost:{cls.nginx.port}"
        cls.log = directory / "run.jsonl"
        record_run(cls.cornerfix, cls.log, "--seed", "2")

    @classmethod
    def tearDownClass(cls):
        cls.nginx.stop()
        cls.server.stop()
        cls._temporary.cleanup()

    def client(self, token=None):
        return Client(self.url, token=token, ssl_context=self.trust, timeout_s=WAIT_S)

    def get(self, path, source="127.0.0.1", **headers):
        connection = http.client.HTTPSConnection("localhost", self.nginx.port, timeout=WAIT_S,
                                                 context=self.trust, source_address=(source, 0))
        self.addCleanup(connection.close)
        names = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request("GET", path, headers=names)
        return connection.getresponse()

    def with_token(self):
        return {"Authorization": f"Bearer {self.token}"}

    def test_is_ready_over_tls(self):
        self.assertEqual(self.get("/readyz").status, 200)
        self.assertIn(b"<title>", self.get("/").read())

    def test_passes_tokens_on(self):
        self.assertEqual(self.get("/v1/maps").status, 401)
        self.assertEqual(self.get("/v1/maps", **self.with_token()).status, 200)

    def test_keeps_the_request_id_of_a_client(self):
        reply = self.get("/v1/maps", X_Request_Id="robot-7.42", **self.with_token())
        self.assertEqual(reply.headers["X-Request-Id"], "robot-7.42")
        self.assertRegex(self.get("/healthz").headers["X-Request-Id"], "^[0-9a-f]{32}$")

    def test_shows_metrics_to_its_own_machine_only(self):
        self.assertEqual(self.get("/metrics", **self.with_token()).status, 200)
        self.assertEqual(self.get("/metrics", source="127.0.0.2", **self.with_token()).status, 403)

    def test_localizes_a_robot_and_passes_each_answer_on_at_once(self):
        client = self.client(self.token)
        client.import_map_server("willow", WILLOW)
        scans = iter(read_log(self.log))
        robot = Robot(client, "robot-7", map="willow", batch=1)
        robot.add(next(scans))
        events = self.get(f"/v1/sessions/{robot.session}/events", **self.with_token())
        self.assertEqual(events.status, 200)
        robot.add(next(scans))
        # The stream does not end: a proxy that buffers would show nothing within the timeout.
        answers = (json.loads(line[5:]) for line in events if line.startswith(b"data:"))
        self.assertTrue(any(answer["sequence"] == 1 for answer in answers))
        self.assertTrue(any(answer and answer.pose for answer in map(robot.add, scans)))

    def test_refuses_a_wrong_token(self):
        with self.assertRaises(Problem) as caught:
            self.client("cfx_" + "0" * 64).maps()
        self.assertEqual(caught.exception.status, 401)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    NginxTest.program = shutil.which("nginx", path="/usr/sbin:/usr/bin")
    if not NginxTest.program:
        skip("nginx is not installed")
    NginxTest.cornerfix = arguments.cornerfix
    unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
