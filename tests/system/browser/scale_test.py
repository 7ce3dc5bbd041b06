#!/usr/bin/python3
"""1,000 maps, 500 robots and a map with many thousands of corners: the page stays usable. Times are printed."""
import sys

sys.dont_write_bytecode = True
from support import PageTest, main, write_symmetric_room  # noqa: E402

MAPS = 1000
ROBOTS = 500
CORNERS = 25000

# The time of the frames while `act` is done 20 times: {median, worst} [ms].
FRAMES = """
const [act, done] = [new Function('i', arguments[0]), arguments[1]];
const times = [];
let i = 0;
let last = null;
const frame = (now) => {
  if (last !== null) times.push(now - last);
  last = now;
  if (i === 20) {
    times.sort((a, b) => a - b);
    done({median: times[Math.floor(times.length / 2)], worst: times.at(-1)});
    return;
  }
  act(i++);
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""


# The page is given more corners than the map has: to import a map with so many takes a minute.
MANY_CORNERS = """
const answer = window.fetch;
window.fetch = async (path, options) => {
  const response = await answer(path, options);
  if (!response.ok || !/^v1[/]maps([?]|.*[/]features$)/.test(path)) return response;
  const body = await response.json();
  for (const map of body.maps ?? []) map.features = CORNERS;
  if (body.features) body.features = Array.from({length: CORNERS}, (_, id) => ({
    ...body.features[id % body.features.length], id, x: 0.5 + (id % 250) * 0.056, y: 0.5 + Math.floor(id / 250) * 0.08,
  }));
  return new Response(JSON.stringify(body), {status: 200, headers: response.headers});
};
""".replace("CORNERS", str(CORNERS))


# A warehouse of 300 x 200 m with shelves, at 0.05 m per cell.
LARGE_GRID = """
const ask = window.fetch;
window.fetch = async (path, options) => {
  if (/map-0000[/]grid.png$/.test(path)) {
    const canvas = new OffscreenCanvas(6000, 4000);
    const context = canvas.getContext('2d');
    context.fillStyle = '#fff';
    context.fillRect(0, 0, 6000, 4000);
    context.fillStyle = '#000';
    for (let x = 60; x < 5900; x += 100) for (let y = 60; y < 3900; y += 400) context.fillRect(x, y, 24, 300);
    return new Response(await canvas.convertToBlob());
  }
  if (/map-0000[/]grid.yaml$/.test(path)) {
    return new Response('resolution: 0.05\\norigin: [0.0, 0.0, 0.0]\\nnegate: 0\\noccupied_thresh: 0.65\\nfree_thresh: 0.196\\n');
  }
  const response = await ask(path, options);
  if (!response.ok || !/^v1[/]maps[?]/.test(path)) return response;
  const body = await response.json();
  for (const map of body.maps) map.bounds = {min_x: 0, min_y: 0, max_x: 300, max_y: 200};
  return new Response(JSON.stringify(body), {status: 200, headers: response.headers});
};
"""

DRAG = """
  const map = document.getElementById('map');
  const at = {clientX: 700 + 10 * i, clientY: 400 + 5 * i, button: 0, buttons: 1, bubbles: true};
  map.dispatchEvent(new MouseEvent(i === 0 ? 'mousedown' : 'mousemove', at));
  if (i === 19) document.dispatchEvent(new MouseEvent('mouseup', at));"""


class ScaleTest(PageTest):
    @classmethod
    def set_up_server(cls):
        cls.import_map("map-0000", write_symmetric_room(cls.directory))
        archive = cls.server.archive("map-0000")
        for i in range(1, MAPS):
            cls.server.restore(f"map-{i:04}", archive)
        lidar = {"angle_min": -1.57, "angle_increment": 0.0175, "range_min": 0.1, "range_max": 30}
        for i in range(ROBOTS):
            cls.server.post("/v1/sessions", {"robot": f"robot-{i:03}", "map": f"map-{i:04}", "lidar": lidar})

    def setUp(self):
        super().setUp()
        self.browser.execute_cdp_cmd("Performance.enable", {"timeDomain": "threadTicks"})

    def frames(self, what, act):
        before = self.processor_s()
        times = self.browser.execute_async_script(FRAMES, act)
        busy_ms = 1000 * (self.processor_s() - before) / 20
        print(f"\n{what}: processor {busy_ms:.1f} ms per frame; frames of {times['median']:.0f} ms in the median, "
              f"{times['worst']:.0f} ms at most", file=sys.stderr)

    def processor_s(self):
        """Processor time of the page's main thread, which other programs do not lengthen."""
        metrics = self.browser.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
        return next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration")

    def test_a_thousand_maps_and_five_hundred_robots_are_listed(self):
        self.open()
        self.wait_for(lambda: len(self.all("#robots li")) == ROBOTS, "all robots")
        self.frames("scrolling 500 robots", "document.getElementById('robots').scrollTop = 300 * i;")
        self.find("#robot-filter input").send_keys("robot-42")
        self.wait_for(lambda: len(self.all("#robots li")) == 10, "robots 420 to 429")
        self.find("#tab-maps").click()
        self.wait_for(lambda: len(self.all("#maps li")) == MAPS, "all maps")
        self.frames("scrolling 1,000 maps", "document.getElementById('maps').scrollTop = 600 * i;")
        self.find("#map-filter input").send_keys("0777")
        self.wait_for(lambda: self.texts("#maps strong") == ["map-0777"], "the one map")
        self.find("#maps a").click()
        self.wait_for_text("#map-facts", "map-0777")
        self.find("#map-filter input").clear()
        self.wait_for(lambda: len(self.all("#maps li")) == MAPS, "all maps again")
        self.screenshot("maps-1000")

    def test_a_map_with_many_corners_is_dragged(self):
        script = self.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": MANY_CORNERS})
        self.addCleanup(self.browser.execute_cdp_cmd, "Page.removeScriptToEvaluateOnNewDocument", script)
        self.open("#map=map-0000&tab=maps")
        self.wait_for_grid()
        corner_box = self.find("#view-options [name=corners]")
        self.assertFalse(corner_box.is_selected(), "corners are off in a dense map")
        corner_box.click()
        self.wait_for(lambda: self.browser.execute_script(
            "const c = document.querySelector('.leaflet-corners-pane canvas');"
            "return c.getContext('2d').getImageData(c.width / 3, c.height / 3, 200, 200).data.some((value) => value)"),
            "the corners")
        self.frames(f"dragging {CORNERS:,} corners", DRAG)
        self.frames(f"zooming with {CORNERS:,} corners",
                    "document.querySelector('.leaflet-control-zoom-' + (i % 2 ? 'in' : 'out')).click();")
        self.screenshot("map-dense")

    def test_a_map_of_6000_by_4000_cells_is_dragged(self):
        script = self.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": LARGE_GRID})
        self.addCleanup(self.browser.execute_cdp_cmd, "Page.removeScriptToEvaluateOnNewDocument", script)
        self.open("#map=map-0000&tab=maps&x=150&y=100&z=4")
        self.wait_for_grid()
        self.assertIn("300 × 200 m", self.text("#map-facts"))
        self.frames("dragging 6,000 x 4,000 cells", DRAG)
        self.frames("zooming 6,000 x 4,000 cells",
                    "document.querySelector('.leaflet-control-zoom-' + (i % 2 ? 'in' : 'out')).click();")
        tiles = len(self.all("#map .grid canvas"))
        self.assertLess(tiles, 100, "only the tiles in view are made")
        self.find("#whole-map").click()
        self.screenshot("map-6000x4000")


if __name__ == "__main__":
    main(__doc__)
