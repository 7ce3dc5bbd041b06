"""What the browser tests share: the real server, simulated robots, and headless Chromium.

A test program exits with 77 where the browser or its driver is missing, unless CORNERFIX_REQUIRE_TOOLS is set.
"""
import argparse
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.request

CHROMIUM = "/usr/bin/chromium"
CHROMEDRIVER = "/usr/bin/chromedriver"
SKIPPED = 77
WAIT_S = int(os.environ.get("WAIT_S", 60))


def skip(reason):
    if os.environ.get("CORNERFIX_REQUIRE_TOOLS"):
        sys.exit(f"FAILED: {reason}")
    print(f"SKIPPED: the page was not tested: {reason}", file=sys.stderr)
    sys.exit(SKIPPED)


try:
    from selenium import webdriver
    from selenium.common.exceptions import TimeoutException
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    skip("python3-selenium is not installed")
for program in (CHROMIUM, CHROMEDRIVER):
    if not shutil.which(program):
        skip(f"{program} is not installed")

# A room with one door-less wall in the middle of each long side: turned by half a turn it is the same.
SYMMETRIC_ROOM_M = (14.0, 8.0)


def read_log(path):
    with gzip.open(path, "rt") as lines:
        header = json.loads(next(lines))
        return header, [json.loads(line) for line in lines]


def as_pose(values):
    return dict(zip(("x", "y", "yaw"), values))


class Server:
    """The real server on a free port."""

    def __init__(self, cornerfix, *options):
        self.command = [cornerfix, "serve", "--port", "0", *map(str, options)]
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        self.url = re.search(r"http://\S+", self.process.stdout.readline()).group()

    def call(self, method, path, body=None, content_type="application/json"):
        data = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.url + path, data, {"Content-Type": content_type}, method=method)
        with urllib.request.urlopen(request) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def post(self, path, body):
        return self.call("POST", path, body)

    def archive(self, name):
        with urllib.request.urlopen(f"{self.url}/v1/maps/{name}/archive") as answer:
            return answer.read()

    def restore(self, name, archive):
        return self.call("POST", f"/v1/maps/{name}/archive", archive, "application/vnd.sqlite3")

    def stop(self):
        with self.process:
            self.process.terminate()
        return self.process.returncode


class Robot:
    """Posts a log's scans with odometry and without any pose."""

    def __init__(self, server, log, name="robot-7", map_name="willow"):
        self.header, self.scans = read_log(log)
        self.server = server
        self.sequence = 0
        self.posted = 0
        lidar = {key: self.header[key] for key in ("angle_min", "angle_increment", "range_min", "range_max", "beams")}
        self.id = server.post("/v1/sessions", {"robot": name, "map": map_name, "lidar": lidar})["id"]

    def drive(self, batch=5):
        """The answer to the next batch, and where the robot truly is."""
        scans = self.scans[self.posted:self.posted + batch]
        self.posted += batch
        return self.post(scans), as_pose(scans[-1]["pose"])

    def post(self, scans):
        answer = self.server.post(f"/v1/sessions/{self.id}/scans", {
            "sequence": self.sequence,
            "scans": [{"stamp": s["t"], "ranges": s["ranges"], "odom": as_pose(s["odom"])} for s in scans]})
        self.sequence += 1
        return answer

    def drive_until(self, status, batches=80):
        for _ in range(batches):
            answer, truth = self.drive()
            if answer["status"] == status:
                return answer, truth
        raise AssertionError(f"not {status} after {self.sequence} batches: {answer}")

    def carry(self, scans):
        """The robot was carried to where another log goes on; its odometry did not notice."""
        last = self.scans[self.posted - 1]
        for i, scan in enumerate(scans):
            answer = self.post([{**scan, "t": last["t"] + 0.1 * (i + 1), "odom": last["odom"]}])
            if answer["status"] == "lost":
                return answer
        raise AssertionError(f"not lost: {answer}")


def write_symmetric_room(directory):
    """An occupancy map that is the same after half a turn, as the two files of map_server."""
    resolution = 0.05
    width, height = (int(side / resolution) + 20 for side in SYMMETRIC_ROOM_M)
    rows = [bytearray([205] * width) for _ in range(height)]

    def fill(x0, y0, x1, y1, value):
        for row in rows[y0:y1]:
            row[x0:x1] = bytes([value] * (x1 - x0))

    fill(8, 8, width - 8, height - 8, 0)
    fill(10, 10, width - 10, height - 10, 254)
    for x0, y0 in ((80, 10), (170, 40)):  # A wall and a pillar, each with its twin.
        x1, y1 = (x0 + 4, y0 + 50) if y0 == 10 else (x0 + 16, y0 + 16)
        fill(x0, y0, x1, y1, 0)
        fill(width - x1, height - y1, width - x0, height - y0, 0)
    (directory / "room.pgm").write_bytes(b"P5 %d %d 255\n" % (width, height) + b"".join(rows))
    (directory / "room.yaml").write_text(
        f"image: room.pgm\nresolution: {resolution}\norigin: [0.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return directory / "room.yaml"


def start_browser(width=1440, height=900):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update", "--disable-sync",
                     f"--window-size={width},{height}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(CHROMEDRIVER))


class PageTest(unittest.TestCase):
    """A fresh directory and browser per class; `cls.server` is made by set_up_server()."""
    arguments = None
    server_options = ()

    @classmethod
    def setUpClass(cls):
        directory = tempfile.TemporaryDirectory()
        cls.addClassCleanup(directory.cleanup)
        cls.directory = pathlib.Path(directory.name)
        cls.server = Server(cls.arguments.cornerfix, "--db", cls.directory / "maps.db", *cls.server_options)
        cls.addClassCleanup(cls.stop_server)
        cls.set_up_server()
        cls.browser = start_browser()
        cls.addClassCleanup(cls.browser.quit)

    @classmethod
    def set_up_server(cls):
        pass

    @classmethod
    def stop_server(cls):
        assert cls.server.stop() == 0, "the server did not end well"

    @classmethod
    def command(cls, *arguments):
        subprocess.run([cls.arguments.cornerfix, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)

    @classmethod
    def simulate(cls, name, *options, floor=None):
        log = cls.directory / f"{name}.jsonl.gz"
        cls.command("simulate", floor or cls.arguments.map, log, *options)
        return log

    @classmethod
    def import_map(cls, name, yaml):
        cls.command("map", "import", name, yaml, "--server", cls.server.url)

    def setUp(self):
        # Parts of what the browser's console may say in this test. It advises on speed by its own measure.
        self.expected = ["willReadFrequently"]

    def tearDown(self):
        self.browser.get("about:blank")  # Or it would go on asking a server that is stopped.
        self.assertEqual([entry for entry in self.complaints() if not any(part in entry for part in self.expected)], [])

    def open(self, fragment=""):
        """A fresh page: an address that differs by its fragment only would not load it again."""
        self.browser.get("about:blank")
        self.browser.get(f"{self.server.url}/{fragment}")

    def wait_for(self, condition, what):
        try:
            return WebDriverWait(self.browser, WAIT_S, poll_frequency=0.1).until(lambda _: condition(), what)
        except TimeoutException:
            self.screenshot(f"failed-{self.id().split('.')[-1]}")
            raise

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def all(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def texts(self, selector):
        return self.browser.execute_script(
            "return [...document.querySelectorAll(arguments[0])].map((node) => node.textContent)", selector)

    def text(self, selector):
        return " ".join(self.texts(selector))

    def wait_for_text(self, selector, wanted):
        self.wait_for(lambda: wanted in self.text(selector), f"{wanted!r} in {selector}")

    def is_shown(self, selector):
        return self.find(selector).is_displayed()

    def wait_for_grid(self):
        self.wait_for(lambda: self.all("#map .grid canvas"), "the map's grid")

    def fragment(self):
        return self.browser.execute_script("return Object.fromEntries(new URLSearchParams(location.hash.slice(1)))")

    def click_map(self, right=0, down=0):
        """Clicks at an offset from the middle of the map [px]."""
        ActionChains(self.browser).move_to_element_with_offset(self.find("#map"), right, down).click().perform()

    def screenshot(self, name):
        self.browser.save_screenshot(str(pathlib.Path(self.arguments.screenshots) / f"{name}.png"))

    def complaints(self):
        return [entry["message"] for entry in self.browser.get_log("browser")
                if entry["level"] in ("SEVERE", "WARNING")]


def main(description):
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--cornerfix", required=True)
    parser.add_argument("--map", required=True, type=pathlib.Path, help="map_server yaml of the building")
    parser.add_argument("--screenshots", required=True, help="directory to leave pictures in")
    PageTest.arguments, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
