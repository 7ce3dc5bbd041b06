#!/usr/bin/python3
"""Files of deploy/ and the Dockerfile: settings exist, the health check follows the port, and
nothing runs with more rights than it needs."""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from real_server import SOURCE, RealServer, run, skip

try:
    import yaml
except ImportError:
    yaml = None

MAX_EXPOSURE = "20"  # Of systemd-analyze security, in tenths; an unhardened unit has 96.


def has_docker_compose():
    return shutil.which("docker") is not None and subprocess.run(
        ["docker", "compose", "version"], capture_output=True).returncode == 0


def dockerfile():
    """Instructions, each on one line."""
    return (SOURCE / "Dockerfile").read_text().replace("\\\n", " ")


def dockerfile_variables():
    words = re.search(r"^ENV (.*)$", dockerfile(), re.MULTILINE).group(1).split()
    return dict(word.split("=", 1) for word in words)


def compose(name="compose.yaml"):
    return yaml.safe_load((SOURCE / "deploy" / name).read_text())


class DockerfileTest(unittest.TestCase):
    def test_variables_are_settings(self):
        known = run(self.cornerfix, "serve", "--help")
        for name in dockerfile_variables():
            self.assertRegex(known, rf"\b{name}\b")

    def test_health_check_follows_the_port(self):
        health = re.search(r"^HEALTHCHECK .*CMD (\[.*\])$", dockerfile(), re.MULTILINE).group(1)

        def is_healthy(port):
            variables = {**os.environ, **dockerfile_variables(), "CORNERFIX_PORT": port}
            return subprocess.run(json.loads(health), env=variables).returncode == 0

        with tempfile.TemporaryDirectory() as directory:
            server = RealServer(self.cornerfix, pathlib.Path(directory) / "maps.db")
            port = server.url.rsplit(":", 1)[1]
            self.assertTrue(is_healthy(port))
            server.stop()
            self.assertFalse(is_healthy(port))

    def test_copies_into_the_build_what_the_build_reads(self):
        ignored = (SOURCE / ".dockerignore").read_text().split()
        cmake = (SOURCE / "CMakeLists.txt").read_text()
        always = set(re.findall(r"add_subdirectory\((\w+)\)", cmake)) - {"bench", "tests"}
        self.assertIn("server", always)
        for directory in always:
            self.assertIn(f"!{directory}", ignored)


class ComposeTest(unittest.TestCase):
    def services(self):
        services = compose()["services"]
        self.assertEqual(set(services), {"cornerfix", "nginx"})
        return services

    def test_has_only_keys_of_compose(self):
        known = set(
            "build cap_add cap_drop depends_on environment healthcheck image networks ports"
            " read_only restart security_opt stop_grace_period tmpfs ulimits volumes".split()
        )
        for name, service in self.services().items():
            self.assertLessEqual(set(service), known, name)

    def test_gives_no_service_more_rights_than_it_needs(self):
        for name, service in self.services().items():
            self.assertTrue(service["read_only"], name)
            self.assertEqual(service["cap_drop"], ["ALL"], name)
            self.assertIn("no-new-privileges:true", service["security_opt"], name)
        self.assertNotIn("cap_add", self.services()["cornerfix"])

    def test_only_nginx_can_be_reached(self):
        services = self.services()
        self.assertNotIn("ports", services["cornerfix"])
        self.assertEqual(services["cornerfix"]["networks"], ["inside"])
        self.assertTrue(compose()["networks"]["inside"]["internal"])
        self.assertEqual(services["nginx"]["ports"], ["443:443"])

    def test_does_not_start_without_tokens(self):
        given = self.services()["cornerfix"]["environment"]
        self.assertEqual(given["CORNERFIX_ALLOW_INSECURE_LISTEN"], "false")
        with tempfile.TemporaryDirectory() as directory:
            variables = {
                **os.environ,
                **dockerfile_variables(),
                **given,
                "CORNERFIX_DATABASE": f"{directory}/maps.db",
                "CORNERFIX_PORT": "0",
            }
            done = subprocess.run(
                [self.cornerfix, "serve"], env=variables, capture_output=True, text=True
            )
        self.assertEqual(done.returncode, 2)
        self.assertIn("CORNERFIX_LISTEN: without tokens", done.stderr)

    def test_settings_networks_volumes_and_files_exist(self):
        known = run(self.cornerfix, "serve", "--help")
        for name in self.services()["cornerfix"]["environment"]:
            self.assertRegex(known, rf"\b{name}\b")
        for service in self.services().values():
            self.assertLessEqual(set(service["networks"]), set(compose()["networks"]))
            for volume in service["volumes"]:
                source = volume.split(":")[0]
                if not source.startswith("./tls/"):  # That is made by the operator.
                    is_file = (SOURCE / "deploy" / source).is_file()
                    self.assertTrue(is_file or source in compose()["volumes"], source)

    def test_nginx_asks_the_service_at_the_port_of_the_image(self):
        upstream = (SOURCE / "deploy/nginx/compose_upstream.conf").read_text()
        port = dockerfile_variables()["CORNERFIX_PORT"]
        self.assertIn(f"server cornerfix:{port};", upstream)

    def test_docker_compose_takes_it(self):
        if not has_docker_compose():
            self.skipTest("docker compose is not installed")
        run("docker", "compose", "--file", SOURCE / "deploy/compose.yaml", "config", "--quiet")


class ReplicasTest(unittest.TestCase):
    """compose_replicas.yaml and what it mounts."""

    def setUp(self):
        self.compose = compose("compose_replicas.yaml")
        self.services = self.compose["services"]
        self.replicas = sorted(name for name in self.services if name.startswith("replica"))

    def test_has_only_keys_of_compose(self):
        known = set(
            "build cap_add cap_drop depends_on environment healthcheck image networks ports"
            " read_only restart security_opt shm_size stop_grace_period tmpfs ulimits volumes".split()
        )
        for name, service in self.services.items():
            self.assertLessEqual(set(service), known, name)

    def test_gives_no_service_more_rights_than_it_needs(self):
        for name, service in self.services.items():
            self.assertIn("no-new-privileges:true", service["security_opt"], name)
            if name != "postgresql":  # Its image changes the owner of its files first.
                self.assertTrue(service["read_only"], name)
                self.assertEqual(service["cap_drop"], ["ALL"], name)
            if name != "nginx":
                self.assertNotIn("cap_add", service, name)

    def test_only_nginx_can_be_reached(self):
        self.assertTrue(self.compose["networks"]["inside"]["internal"])
        for name, service in self.services.items():
            self.assertEqual("ports" in service, name == "nginx")
            self.assertEqual("outside" in service["networks"], name == "nginx")

    def test_settings_networks_volumes_and_files_exist(self):
        known = run(self.cornerfix, "serve", "--help")
        for replica in self.replicas:
            for name in self.services[replica]["environment"]:
                if name.startswith("CORNERFIX_"):
                    self.assertRegex(known, rf"\b{name}\b")
        for service in self.services.values():
            self.assertLessEqual(set(service["networks"]), set(self.compose["networks"]))
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if not source.startswith("./tls/"):  # That is made by the operator.
                    is_file = (SOURCE / "deploy" / source).is_file()
                    self.assertTrue(is_file or source in self.compose["volumes"], source)

    def test_haproxy_asks_every_replica_at_the_port_of_the_image(self):
        text = (SOURCE / "deploy/haproxy/haproxy.cfg").read_text()
        port = dockerfile_variables()["CORNERFIX_PORT"]
        servers = re.findall(r"^    server (\w+) (\w+):(\d+)$", text, re.MULTILINE)
        expected = [(name, name, port) for name in self.replicas]
        self.assertEqual(len(self.replicas), 3)
        self.assertEqual(servers, 2 * expected)
        upstream = (SOURCE / "deploy/nginx/replicas_upstream.conf").read_text()
        bound = re.search(r"^    bind :(\d+)$", text, re.MULTILINE).group(1)
        self.assertIn(f"server haproxy:{bound};", upstream)

    def test_haproxy_takes_its_configuration(self):
        if not shutil.which("haproxy"):
            self.skipTest("haproxy is not installed")
        text = (SOURCE / "deploy/haproxy/haproxy.cfg").read_text()
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / "haproxy.cfg"
            # Names of compose services are known to compose only.
            file.write_text(re.sub(r" replica\d:", " 127.0.0.1:", text))
            run("haproxy", "-c", "-f", file)

    def test_docker_compose_takes_it(self):
        if not has_docker_compose():
            self.skipTest("docker compose is not installed")
        file = SOURCE / "deploy/compose_replicas.yaml"
        os.environ["CORNERFIX_DB_PASSWORD"] = "example"
        run("docker", "compose", "--file", file, "config", "--quiet")


class UnitTest(unittest.TestCase):
    def setUp(self):
        self._temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self._temporary.cleanup)
        text = (SOURCE / "deploy/systemd/cornerfix.service").read_text()
        self.assertIn("ExecStart=/usr/bin/cornerfix serve", text)
        self.unit = pathlib.Path(self._temporary.name) / "cornerfix.service"
        program = pathlib.Path(self.cornerfix).resolve()
        self.unit.write_text(text.replace("/usr/bin/cornerfix", str(program)))

    def test_is_valid(self):
        done = subprocess.run(
            ["systemd-analyze", "verify", "--man=no", self.unit], capture_output=True, text=True
        )
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_is_hardened(self):
        run(
            "systemd-analyze",
            "security",
            "--offline=true",
            f"--threshold={MAX_EXPOSURE}",
            "--no-pager",
            self.unit,
        )

    def test_runs_with_the_configuration_of_the_package(self):
        config = json.loads((SOURCE / "deploy/debian/config.json").read_text())
        text = self.unit.read_text()
        conffile = (SOURCE / "deploy/debian/conffiles").read_text().strip()
        self.assertIn(f"--config {conffile}\n", text)
        directory = re.search("^StateDirectory=(.*)$", text, re.MULTILINE).group(1)
        self.assertEqual(config["database"], f"/var/lib/{directory}/cornerfix.db")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cornerfix", required=True)
    arguments, rest = parser.parse_known_args()
    if yaml is None or not shutil.which("systemd-analyze"):
        skip("python3-yaml or systemd is not installed")
    for tests in (DockerfileTest, ComposeTest, ReplicasTest, UnitTest):
        tests.cornerfix = arguments.cornerfix
    unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
