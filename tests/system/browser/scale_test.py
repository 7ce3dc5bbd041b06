#!/usr/bin/python3
"""1,000 maps, 500 robots and a map with many thousands of corners: the page stays usable. Times are printed."""
import sys

sys.dont_write_bytecode = True
from support import PageTest, main, write_symmetric_room  # noqa: E402

MAPS = 1000
ROBOTS = 500
PILLARS = 80  # In each direction: four corners each.

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


def write_pillars(directory):
    """A hall full of pillars at 0.05 m."""
    pitch, size = 20, 8
    side = PILLARS * pitch + 60
    rows = [bytearray([254] * side) for _ in range(side)]

    def fill(x0, y0, x1, y1):
        for row in rows[y0:y1]:
            row[x0:x1] = bytes(x1 - x0)

    for x0, y0, x1, y1 in ((0, 0, side, 4), (0, side - 4, side, side), (0, 0, 4, side), (side - 4, 0, side, side)):
        fill(x0, y0, x1, y1)
    for i in range(PILLARS):
        for j in range(PILLARS):
            x, y = 40 + i * pitch + (i * 7 + j * 3) % 5, 40 + j * pitch + (i * 5 + j * 11) % 5
            fill(x, y, x + size, y + size)
    (directory / "hall.pgm").write_bytes(b"P5 %d %d 255\n" % (side, side) + b"".join(rows))
    (directory / "hall.yaml").write_text("image: hall.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n"
                                         "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return directory / "hall.yaml"


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

    def frames(self, what, act):
        times = self.browser.execute_async_script(FRAMES, act)
        print(f"\n{what}: median {times['median']:.0f} ms, worst {times['worst']:.0f} ms per frame", file=sys.stderr)

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
        self.import_map("hall", write_pillars(self.directory))
        corners = self.server.call("GET", "/v1/maps/hall")["features"]
        self.open("#map=hall&tab=maps")
        self.wait_for_grid()
        corner_box = self.find("#view-options [name=corners]")
        self.assertFalse(corner_box.is_selected(), "corners are off in a dense map")
        corner_box.click()
        self.wait_for(lambda: self.browser.execute_script(
            "const c = document.querySelector('.leaflet-corners-pane canvas');"
            "return c.getContext('2d').getImageData(c.width / 3, c.height / 3, 200, 200).data.some((value) => value)"),
            "the corners")
        self.frames(f"dragging {corners} corners", """
          const map = document.getElementById('map');
          const at = {clientX: 700 + 10 * i, clientY: 400 + 5 * i, button: 0, buttons: 1, bubbles: true};
          map.dispatchEvent(new MouseEvent(i === 0 ? 'mousedown' : 'mousemove', at));
          if (i === 19) document.dispatchEvent(new MouseEvent('mouseup', at));""")
        self.frames(f"redrawing {corners} corners", "window.dispatchEvent(new Event('resize'));"
                    "document.querySelector('.leaflet-control-zoom-' + (i % 2 ? 'in' : 'out')).click();")
        self.screenshot("map-dense")


if __name__ == "__main__":
    main(__doc__)
