#!/usr/bin/python3
"""A browser watches a robot become localized: the real server, a simulated drive, headless Chromium.

Exits with 77 where the browser or its driver is missing, unless CORNERFIX_REQUIRE_TOOLS is set.
"""
import argparse
import gzip
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.parse
import urllib.request

CHROMIUM = "/usr/bin/chromium"
CHROMEDRIVER = "/usr/bin/chromedriver"
SKIPPED = 77
WAIT_S = 60


def skip(reason):
    if os.environ.get("CORNERFIX_REQUIRE_TOOLS"):
        sys.exit(f"FAILED: {reason}")
    print(f"SKIPPED: the inspector was not tested: {reason}", file=sys.stderr)
    sys.exit(SKIPPED)


try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    skip("python3-selenium is not installed")
for program in (CHROMIUM, CHROMEDRIVER):
    if not shutil.which(program):
        skip(f"{program} is not installed")

# The share of the scan's pixels with a wall of the grid within 3 cells, and the same for the scan moved by 1 m:
# only a scan laid at the right pose lies on the walls.
SHARE_ON_WALLS = """
const grid = document.querySelector('#map img.grid');
const canvas = document.querySelector('#map .leaflet-live-pane canvas');
const wanted = getComputedStyle(document.documentElement).getPropertyValue('--scan').trim();
const [red, green, blue] = [1, 3, 5].map((i) => parseInt(wanted.slice(i, i + 2), 16));

const copy = document.createElement('canvas');
[copy.width, copy.height] = [grid.naturalWidth, grid.naturalHeight];
copy.getContext('2d').drawImage(grid, 0, 0);
const cells = copy.getContext('2d').getImageData(0, 0, copy.width, copy.height).data;
const isWall = (column, row) => cells[4 * (row * copy.width + column)] < 64;
const isNearWall = (column, row) => {
  for (let dr = -3; dr <= 3; ++dr) for (let dc = -3; dc <= 3; ++dc) if (isWall(column + dc, row + dr)) return true;
  return false;
};

const drawn = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
const [from, to] = [canvas.getBoundingClientRect(), grid.getBoundingClientRect()];
const metre = 20;  // Cells.
let [pixels, near, nearMoved] = [0, 0, 0];
for (let y = 0; y < canvas.height; ++y) for (let x = 0; x < canvas.width; ++x) {
  const i = 4 * (y * canvas.width + x);
  if (drawn[i] !== red || drawn[i + 1] !== green || drawn[i + 2] !== blue || drawn[i + 3] !== 255) continue;
  const column = Math.floor((from.left + x * from.width / canvas.width - to.left) * copy.width / to.width);
  const row = Math.floor((from.top + y * from.height / canvas.height - to.top) * copy.height / to.height);
  ++pixels;
  near += isNearWall(column, row);
  nearMoved += isNearWall(column + metre, row + metre);
}
return {pixels, near: near / pixels, nearMoved: nearMoved / pixels};
"""


def read_log(path):
    with gzip.open(path, "rt") as lines:
        header = json.loads(next(lines))
        return header, [json.loads(line) for line in lines]


def as_pose(values):
    return dict(zip(("x", "y", "yaw"), values))


class Server:
    """The real server on a free port and a fresh database."""

    def __init__(self, cornerfix, *options):
        self.process = subprocess.Popen(
            [cornerfix, "serve", "--port", "0", *options],
            stdout=subprocess.PIPE, text=True)
        self.url = re.search(r"http://\S+", self.process.stdout.readline()).group()

    def post(self, path, body):
        request = urllib.request.Request(self.url + path, json.dumps(body).encode(),
                                         {"Content-Type": "application/json"})
        with urllib.request.urlopen(request) as answer:
            return json.load(answer)

    def stop(self):
        with self.process:
            self.process.terminate()
        return self.process.returncode


class Robot:
    """Posts a log's scans with odometry and without any pose."""

    def __init__(self, server, log):
        header, self.scans = read_log(log)
        self.server = server
        self.sequence = 0
        lidar = {key: header[key] for key in ("angle_min", "angle_increment", "range_min", "range_max", "beams")}
        self.id = server.post("/v1/sessions", {"robot": "robot-7", "map": "willow", "lidar": lidar})["id"]

    def drive(self, batch=5):
        """The answer to the next batch, and where the robot truly is."""
        begin = self.sequence * batch
        scans = self.scans[begin:begin + batch]
        answer = self.server.post(f"/v1/sessions/{self.id}/scans", {
            "sequence": self.sequence,
            "scans": [{"stamp": s["t"], "ranges": s["ranges"], "odom": as_pose(s["odom"])} for s in scans]})
        self.sequence += 1
        return answer, as_pose(scans[-1]["pose"])

    def drive_until_localized(self):
        for _ in range(80):
            answer, truth = self.drive()
            if answer["status"] == "localized":
                return answer, truth
        raise AssertionError(f"not localized after {self.sequence} batches: {answer}")


def start_browser():
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update", "--disable-sync",
                     "--window-size=1366,860"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(CHROMEDRIVER))


class InspectorTest(unittest.TestCase):
    arguments = None

    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.directory.cleanup)
        directory = pathlib.Path(cls.directory.name)
        cornerfix, floor = cls.arguments.cornerfix, cls.arguments.map
        cls.map_log, cls.robot_log = directory / "map.jsonl.gz", directory / "robot.jsonl.gz"
        # The same seed drives the same way, so the robot is where the map knows the building.
        subprocess.run([cornerfix, "simulate", floor, cls.map_log, "--seed", "1", "--length", "300", "--step", "0.3"],
                       check=True)
        subprocess.run([cornerfix, "simulate", floor, cls.robot_log, "--seed", "1", "--length", "40",
                        "--noise", "0.03"], check=True)
        cls.server = Server(cornerfix, "--db", directory / "maps.db")
        cls.addClassCleanup(cls.stop_server)
        cls.browser = start_browser()
        cls.addClassCleanup(cls.browser.quit)

    @classmethod
    def stop_server(cls):
        assert cls.server.stop() == 0, "the server did not end well"

    def wait_for(self, condition, what):
        return WebDriverWait(self.browser, WAIT_S, poll_frequency=0.1).until(lambda _: condition(), what)

    def shown(self, selector):
        return [element.text for element in self.browser.find_elements(By.CSS_SELECTOR, selector)]

    def screenshot(self, name):
        self.browser.save_screenshot(str(pathlib.Path(self.arguments.screenshots) / name))

    def complaints(self):
        return [entry["message"] for entry in self.browser.get_log("browser")
                if entry["level"] in ("SEVERE", "WARNING")]

    def test_a_server_that_asks_for_a_token_gets_it(self):
        directory = pathlib.Path(self.directory.name)
        config = directory / "config.json"
        config.write_text(json.dumps({"tokens": [{"token": "correct-horse-battery", "role": "viewer", "name": "me"}]}))
        server = Server(self.arguments.cornerfix, "--db", directory / "guarded.db", "--config", config)
        self.addCleanup(server.stop)
        self.browser.get(server.url)
        entry = self.browser.find_element(By.NAME, "token")
        self.wait_for(entry.is_displayed, "the form that asks for a token")
        entry.send_keys("correct-horse-battery\n")
        self.wait_for(lambda: "cornerfix map build" in " ".join(self.shown("#maps code")), "what the token opens")
        self.assertFalse(entry.is_displayed())
        self.assertTrue(all(" 401 " in complaint for complaint in self.complaints()))

    def show_where_robots_are_found(self):
        self.assertFalse(self.browser.find_element(By.ID, "report-panel").is_displayed())
        choice = self.browser.find_element(By.NAME, "report")
        choice.click()
        self.wait_for(lambda: "robots" in " ".join(self.shown("#report p")).lower(), "the report or its progress")
        choice.click()
        self.wait_for(lambda: not self.browser.find_element(By.ID, "report-panel").is_displayed(), "no report")

    def test_a_robot_becomes_localized_before_the_watchers_eyes(self):
        self.browser.get(self.server.url)
        self.wait_for(lambda: "cornerfix map build" in " ".join(self.shown("#maps code")), "a hint that there is no map")

        subprocess.run([self.arguments.cornerfix, "map", "build", "willow", self.map_log,
                        "--server", self.server.url], check=True)
        self.wait_for(lambda: self.shown("#maps strong") == ["willow"], "the new map in the list")
        self.wait_for(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#map img.grid"), "the map's grid")

        robot = Robot(self.server, self.robot_log)
        self.wait_for(lambda: self.shown("#sessions strong") == ["robot-7"], "the robot in the list")
        self.browser.find_element(By.CSS_SELECTOR, "#sessions a").click()
        self.wait_for(lambda: "Waiting for its first scans." in self.shown("#session p"), "the robot's panel")

        answer, truth = robot.drive_until_localized()
        self.assertLess(math.hypot(answer["pose"]["x"] - truth["x"], answer["pose"]["y"] - truth["y"]), 0.3)
        self.wait_for(lambda: self.shown('#session .badge[data-status="localized"]'), "the status localized")
        for _ in range(12):
            answer, truth = robot.drive()
        pose = answer["pose"]
        expected = f'x {pose["x"]:.2f} m, y {pose["y"]:.2f} m, heading {math.degrees(pose["yaw"]):.1f}°'
        self.wait_for(lambda: expected in self.shown("#session dd"), f"the pose {expected}")

        self.screenshot("inspector.png")
        self.show_where_robots_are_found()
        drawn = self.browser.execute_script(SHARE_ON_WALLS)
        self.assertGreater(drawn["pixels"], 200, drawn)
        self.assertGreater(drawn["near"], 0.8, drawn)
        self.assertLess(drawn["nearMoved"], drawn["near"] - 0.3, drawn)

        # The address alone brings a colleague to the same view.
        address = self.browser.current_url
        fragment = urllib.parse.parse_qs(urllib.parse.urlsplit(address).fragment)
        self.assertEqual(fragment, {"map": ["willow"], "session": [robot.id]})
        self.browser.get("about:blank")
        self.browser.get(address)
        self.wait_for(lambda: expected in self.shown("#session dd"), "the last answer of a robot that is silent")

        self.assertEqual(self.complaints(), [])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True)
    parser.add_argument("--map", required=True, help="ROS map_server yaml of the building")
    parser.add_argument("--screenshots", required=True, help="directory to leave a picture in")
    InspectorTest.arguments, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
