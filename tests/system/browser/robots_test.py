#!/usr/bin/python3
"""A browser watches robots: one that becomes localized, one that stays ambiguous, one that is lost."""
import math
import sys

sys.dont_write_bytecode = True
from support import ActionChains, Keys, PageTest, Robot, main, read_log, write_symmetric_room  # noqa: E402

# The share of the painted hits with a wall of the server's grid within 3 cells, and the same for hits moved by
# 1 m: only a scan that is laid on the right pose lies on the walls. The view comes from the address.
SHARE_ON_WALLS = """
const [name, done] = arguments;
(async () => {
  const bitmap = await createImageBitmap(await (await fetch(`v1/maps/${name}/grid.png`)).blob());
  const copy = new OffscreenCanvas(bitmap.width, bitmap.height);
  copy.getContext('2d').drawImage(bitmap, 0, 0);
  const cells = copy.getContext('2d').getImageData(0, 0, copy.width, copy.height).data;
  const isWall = (column, row) => cells[4 * (row * copy.width + column)] < 64;
  const isNearWall = (column, row) => {
    for (let dr = -3; dr <= 3; ++dr) for (let dc = -3; dc <= 3; ++dc) if (isWall(column + dc, row + dr)) return true;
    return false;
  };
  const view = Object.fromEntries(['x', 'y', 'z'].map((key) => [key, Number(new URLSearchParams(location.hash.slice(1)).get(key))]));
  const map = document.getElementById('map').getBoundingClientRect();
  const canvas = document.querySelector('#map .leaflet-live-pane canvas');
  const box = canvas.getBoundingClientRect();
  const wanted = getComputedStyle(document.documentElement).getPropertyValue('--hit-explained').trim();
  const [red, green, blue] = [1, 3, 5].map((i) => parseInt(wanted.slice(i, i + 2), 16));
  const drawn = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  const cellsPerPixel = 20 / 2 ** view.z;
  let [pixels, near, nearMoved] = [0, 0, 0];
  for (let y = 0; y < canvas.height; ++y) for (let x = 0; x < canvas.width; ++x) {
    const i = 4 * (y * canvas.width + x);
    if (drawn[i] !== red || drawn[i + 1] !== green || drawn[i + 2] !== blue || drawn[i + 3] !== 255) continue;
    const right = box.left + x - (map.left + map.width / 2);
    const down = box.top + y - (map.top + map.height / 2);
    const column = Math.floor(view.x * 20 + right * cellsPerPixel);
    const row = Math.floor(bitmap.height - view.y * 20 + down * cellsPerPixel);
    ++pixels;
    near += isNearWall(column, row);
    nearMoved += isNearWall(column + 20, row + 20);
  }
  return {pixels, near: near / pixels, nearMoved: nearMoved / pixels};
})().then(done, (error) => done(String(error)));
"""


# Pixels of the marks for the robot's corners.
LOCAL_CORNER_PIXELS = """
const canvas = document.querySelector('#map .leaflet-live-pane canvas');
const wanted = getComputedStyle(document.documentElement).getPropertyValue('--local-corner').trim();
const [red, green, blue] = [1, 3, 5].map((i) => parseInt(wanted.slice(i, i + 2), 16));
const drawn = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
let pixels = 0;
for (let i = 0; i < drawn.length; i += 4) pixels += drawn[i] === red && drawn[i + 1] === green && drawn[i + 2] === blue;
return pixels;
"""

# Two poses in a free map of 40 x 40 m; 4 m before the first one is a wall 2 m wide.
SETTLE = """
const done = arguments[0];
(async () => {
  const [{Grid}, {whereTheyDiffer}, {settleText}] = await Promise.all(['grid', 'settle', 'why'].map((name) => import(`/${name}.js`)));
  const canvas = new OffscreenCanvas(400, 400);
  const context = canvas.getContext('2d');
  context.fillStyle = '#fff';
  context.fillRect(0, 0, 400, 400);
  context.fillStyle = '#000';
  context.fillRect(140, 190, 4, 20);
  const grid = await Grid.load(await canvas.convertToBlob(),
    {resolution: 0.1, origin: {x: 0, y: 0, yaw: 0}, negate: false, occupied: 0.65, free: 0.196});
  const [a, b] = [{x: 10, y: 20, yaw: 0}, {x: 30, y: 20, yaw: 0}].map((pose) => ({grid, pose}));
  const place = whereTheyDiffer(a, b, []);
  return {place, text: settleText({place, other: 2}), same: whereTheyDiffer(a, a, [])};
})().then(done, (error) => done(String(error)));
"""


class RobotsTest(PageTest):
    @classmethod
    def set_up_server(cls):
        # The same seed drives the same path, so the robot is where the map knows the building.
        cls.import_map("willow", cls.arguments.map)
        cls.robot_log = cls.simulate("robot", "--seed", "1", "--length", "40", "--noise", "0.03")
        cls.elsewhere_log = cls.simulate("elsewhere", "--seed", "5", "--length", "15")
        room = write_symmetric_room(cls.directory)
        cls.import_map("room", room)
        cls.room_log = cls.simulate("room", "--seed", "3", "--length", "6", floor=room)

    def tearDown(self):
        super().tearDown()
        for session in self.server.call("GET", "/v1/sessions")["sessions"]:
            self.server.call("DELETE", f"/v1/sessions/{session['id']}")

    def test_a_robot_becomes_localized_before_the_watchers_eyes(self):
        self.open("#map=willow")
        self.wait_for_grid()
        robot = Robot(self.server, self.robot_log)
        self.wait_for(lambda: self.texts("#robots strong") == ["robot-7"], "the robot in the list")
        self.wait_for_text("#robot-why", "no scan has come")

        answer, truth = robot.drive_until("localized")
        self.assertLess(math.hypot(answer["pose"]["x"] - truth["x"], answer["pose"]["y"] - truth["y"]), 0.3)
        self.wait_for_text('#robot-head .badge[data-status="localized"]', "Localized")
        for _ in range(12):
            answer, truth = robot.drive()
        pose = answer["pose"]
        expected = f'x {pose["x"]:.2f} m, y {pose["y"]:.2f} m, heading {math.degrees(pose["yaw"]):.1f}°'
        self.wait_for_text("#robot-facts", expected)
        self.wait_for_text("#robot-why", "The pose may be used")
        self.wait_for_text("#summary", "1 localized")
        self.screenshot("robot-localized")

        # By hand the view is kept in the address; then the address alone brings a colleague to the same view.
        self.find("#map .leaflet-control-zoom-in").click()
        self.wait_for(lambda: "z" in self.fragment(), "the view in the address")
        drawn = self.browser.execute_async_script(SHARE_ON_WALLS, "willow")
        self.assertGreater(drawn["pixels"], 200, drawn)
        self.assertGreater(drawn["near"], 0.8, drawn)
        self.assertLess(drawn["nearMoved"], drawn["near"] - 0.3, drawn)
        before = self.fragment()
        self.assertEqual((before["map"], before["session"]), ("willow", robot.id))
        self.open(self.browser.current_url[self.browser.current_url.index("#"):])
        self.wait_for_text("#robot-facts", expected)
        self.wait_for_grid()
        self.assertEqual(self.fragment(), before)

    def test_history_shows_what_happened_and_steps_through_it(self):
        robot = Robot(self.server, self.robot_log)
        robot.drive_until("localized")
        for _ in range(4):
            robot.drive()
        self.open(f"#session={robot.id}")
        self.wait_for(lambda: self.all("#timeline button"), "the timeline of a robot that was not watched before")
        self.assertIn("Localized", self.all("#timeline button")[-1].get_attribute("aria-label"))
        self.assertIn("Median per answer", self.text("#times-text"))
        self.find("#history-step").send_keys(Keys.HOME)
        self.wait_for_text("#history-entry", "Answer 0, ")
        self.assertIn("--recorded-answers", self.text("#history-entry"))
        self.find("#step-live").click()
        self.wait_for(lambda: not self.text("#history-entry"), "the last answer again")

    def test_an_ambiguous_robot_shows_its_candidate_poses_side_by_side(self):
        robot = Robot(self.server, self.room_log, "r-ambiguous", "room")
        for _ in range(10):
            answer, _ = robot.drive()
        self.assertNotEqual(answer["status"], "localized")
        self.assertGreaterEqual(len(answer["hypotheses"]), 2, answer)
        self.open(f"#session={robot.id}")
        self.wait_for(lambda: len(self.all("#fit-pictures canvas")) == 1, "the scan on the best pose")
        self.wait_for_text("#robot-why", "pose")
        self.assertIn("2 poses explain the scans about equally well", self.text("#robot-why .why"))
        self.assertIn("looks the same from poses 1 and 2", self.text("#robot-why .todo"))
        header = self.texts("#robot-candidates th")
        self.assertEqual(header, ["pose", "x", "y", "heading", "local map", "last scan"])
        self.all("#robot-candidates button")[1].click()
        self.wait_for(lambda: len(self.all("#fit-pictures canvas")) == 2, "the chosen pose beside the best")
        self.wait_for_text("#map-caption", "The scan lies on pose 2")
        self.assertIn("on walls", self.text("#fit-pictures .legend"))
        # Two equal poses are not judged, so there is no probability to show.
        self.assertNotIn("Probability", self.text("#robot-facts"))
        ActionChains(self.browser).move_to_element(self.all("#robot-candidates tbody tr")[0]).perform()
        self.screenshot("robot-ambiguous")

    def test_a_lost_robot_says_so_and_comes_first(self):
        lost = Robot(self.server, self.robot_log, "z-carried")
        lost.drive_until("localized")
        fine = Robot(self.server, self.robot_log, "a-fine")
        fine.drive_until("localized")
        lost.carry(read_log(self.elsewhere_log)[1])
        self.open(f"#session={lost.id}")
        self.wait_for_text('#robot-head .badge[data-status="lost"]', "Lost")
        self.wait_for_text("#robot-why .why", "no longer fit")
        self.assertTrue(self.text("#robot-why .todo"))
        # What was explained before the robot was lost is not shown beside what contradicts the map now.
        self.wait_for(lambda: self.all("#fit-pictures canvas"), "the scan on the map")
        self.assertEqual(self.texts("#robot-candidates th"), ["pose", "x", "y", "heading", "last scan"])
        self.assertLess(int(self.texts("#robot-candidates td")[-1].removesuffix(" %")), 50)
        self.assertNotIn("Probability", self.text("#robot-facts"))
        # The view is where the robot may be.
        self.find("#map .leaflet-control-zoom-in").click()
        self.wait_for(lambda: "x" in self.fragment(), "the view in the address")
        self.assertLess(abs(float(self.fragment()["x"]) - float(self.texts("#robot-candidates td")[1])), 1.0)
        self.wait_for(lambda: self.texts("#robots strong")[0] == "z-carried", "the lost robot first")
        self.assertEqual(self.texts("#robots strong")[-1], "a-fine")
        self.screenshot("robot-lost")

    def test_what_would_settle_two_poses_is_the_nearest_wall_that_one_lacks(self):
        self.open()
        found = self.browser.execute_async_script(SETTLE)
        self.assertEqual(found["same"], None, found)
        self.assertAlmostEqual(found["place"]["x"], 4.0, delta=0.5)
        self.assertAlmostEqual(found["place"]["y"], 0.0, delta=0.6)
        self.assertIn("Drive about 4 m ahead: there the map differs between poses 1 and 3", found["text"])

    def test_corners_that_the_robot_sees_are_joined_to_those_of_the_map(self):
        robot = Robot(self.server, self.robot_log)
        robot.drive_until("localized")
        self.open(f"#session={robot.id}")
        self.wait_for_grid()
        corners = self.find("#view-options [name=corners]")
        self.wait_for(corners.is_selected, "the map's corners")
        corners.click()
        self.wait_for(lambda: self.browser.execute_script(LOCAL_CORNER_PIXELS) > 0, "the robot's corners")
        apart = self.browser.execute_script(LOCAL_CORNER_PIXELS)
        corners.click()
        self.wait_for(lambda: self.browser.execute_script(LOCAL_CORNER_PIXELS) > apart, "lines to the map's corners")

    def test_an_older_session_of_a_robot_needs_nobody(self):
        Robot(self.server, self.room_log, "twice", "room").drive()
        newer = Robot(self.server, self.robot_log, "twice")
        newer.drive_until("localized")
        self.open()
        self.wait_for(lambda: len(self.texts("#robots strong")) == 2, "both sessions")
        self.assertIn("1 robot · 1 localized ·", self.text("#summary"))
        self.assertIn("has a newer session", self.texts("#robots li")[1])
        self.find('#robot-filter option[value="help"]').click()
        self.wait_for(lambda: not self.texts("#robots strong"), "nobody who needs help")

    def test_robots_are_filtered_by_name_map_and_state(self):
        robot = Robot(self.server, self.robot_log, "fork-lift-1")
        robot.drive_until("localized")
        Robot(self.server, self.room_log, "cart-2", "room")
        self.open()
        self.wait_for(lambda: len(self.texts("#robots strong")) == 2, "both robots")
        find = self.find("#robot-filter input")
        find.send_keys("room")
        self.wait_for(lambda: self.texts("#robots strong") == ["cart-2"], "by map")
        find.clear()
        self.find('#robot-filter option[value="localized"]').click()
        self.wait_for(lambda: self.texts("#robots strong") == ["fork-lift-1"], "by state")

    def test_a_silent_robot_looks_silent(self):
        robot = Robot(self.server, self.robot_log)
        robot.drive_until("localized")
        self.open(f"#session={robot.id}")
        self.wait_for_text("#robots .age", "")
        # Two hours pass for the page alone.
        self.browser.execute_script("const now = Date.now; Date.now = () => now() + 7200e3;")
        self.wait_for_text("#robots .age", "2 h ago")
        self.assertEqual(len(self.all("#robots a[data-silent]")), 1)
        self.assertIn("No scan has come for 2 h", self.text("#robot-why .why"))
        self.assertIn("1 silent", self.text("#summary"))
        self.screenshot("robot-silent")

    def test_reset_and_delete_ask_first(self):
        robot = Robot(self.server, self.robot_log)
        robot.drive_until("localized")
        self.open(f"#session={robot.id}")
        self.wait_for(lambda: self.is_shown("#reset-robot"), "the buttons")
        self.find("#reset-robot").click()
        self.wait_for_text("#confirm-title", "Reset robot-7?")
        self.find('#confirm-dialog button[value="no"]').click()
        self.assertEqual(self.server.call("GET", f"/v1/sessions/{robot.id}")["status"], "localized")
        self.find("#reset-robot").click()
        self.find("#confirm-yes").click()
        self.wait_for(lambda: self.server.call("GET", f"/v1/sessions/{robot.id}")["status"] == "collecting", "a reset")
        self.wait_for(lambda: not self.is_shown("#confirm-dialog"), "no dialog")
        self.find("#delete-robot").click()
        self.find("#confirm-yes").click()
        self.wait_for(lambda: not self.server.call("GET", "/v1/sessions")["sessions"], "no session")
        self.wait_for_text("#robots-hint", "No robot has a session")


if __name__ == "__main__":
    main(__doc__)
