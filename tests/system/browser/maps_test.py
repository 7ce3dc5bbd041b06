#!/usr/bin/python3
"""A browser manages maps: adds them by files, finds, describes, downloads and deletes them, and looks around."""
import sys

sys.dont_write_bytecode = True
from support import ActionChains, Keys, PageTest, main, write_symmetric_room  # noqa: E402


def write_changed_room(directory, room):
    """The room with one wall more and one pillar less, as the two files of map_server."""
    header, size, *_ = room.with_suffix(".pgm").read_bytes().split(b"\n", 1)[0].split(b" ", 1)
    width, height, _ = map(int, size.split())
    cells = bytearray(room.with_suffix(".pgm").read_bytes()[-width * height:])

    def fill(x0, y0, x1, y1, value):
        for row in range(y0, y1):
            cells[row * width + x0:row * width + x1] = bytes([value] * (x1 - x0))

    fill(140, height - 60, 160, height - 56, 0)
    fill(165, 35, 195, 65, 254)
    (directory / "changed.pgm").write_bytes(b"%s %d %d 255\n" % (header, width, height) + bytes(cells))
    (directory / "changed.yaml").write_text(room.read_text().replace("room.pgm", "changed.pgm"))
    return directory / "changed.yaml"


class MapsTest(PageTest):
    @classmethod
    def set_up_server(cls):
        cls.room = write_symmetric_room(cls.directory)

    def setUp(self):
        super().setUp()
        for entry in self.server.call("GET", "/v1/maps")["maps"]:
            self.server.call("DELETE", f"/v1/maps/{entry['name']}")

    def names(self):
        return self.texts("#maps strong")

    def upload(self, *files, name=None):
        self.find("#add-map").click()
        self.find("#upload-files").send_keys("\n".join(map(str, files)))
        if name:
            field = self.find("#upload-name")
            field.clear()
            field.send_keys(name)
        self.find("#upload-start").click()

    def test_an_empty_server_says_how_to_begin_and_has_a_demo(self):
        self.open("#tab=maps")
        self.wait_for_text("#maps-hint", "cornerfix map build")
        self.assertIn("cornerfix map import", self.text("#maps-hint"))
        self.screenshot("maps-empty")
        self.find("#demo").click()
        self.wait_for(lambda: self.names() == ["willow"], "the demo map")
        self.wait_for_grid()

    def test_a_map_server_pair_is_added(self):
        self.open("#tab=maps")
        self.upload(self.room, self.room.with_suffix(".pgm"), name="lab-1")
        self.wait_for(lambda: self.names() == ["lab-1"], "the map")
        self.wait_for_text("#map-facts", "an occupancy map")
        self.wait_for_grid()
        self.assertEqual(self.fragment()["map"], "lab-1")
        self.wait_for(lambda: self.browser.execute_script(
            "return document.querySelector('.thumbnail')?.width > 20"), "the thumbnail")

    def test_files_may_be_dropped_on_the_page(self):
        self.open("#tab=maps")
        # The browser cannot be made to drag; the event is the page's own.
        self.browser.execute_script("""
          const files = new DataTransfer();
          files.items.add(new File(['x'], 'office.yaml'));
          document.body.dispatchEvent(new DragEvent('drop', {dataTransfer: files, bubbles: true, cancelable: true}));
        """)
        self.wait_for_text("#upload-kind", "the image (pgm or png) as well")
        self.assertEqual(self.find("#upload-name").get_attribute("value"), "office")
        self.assertFalse(self.find("#upload-start").is_enabled())

    def test_a_recorded_run_becomes_a_map(self):
        log = self.simulate("run", "--seed", "1", "--length", "20", "--step", "0.3", floor=self.room)
        self.open("#tab=maps")
        self.upload(log, name="from-run")
        self.wait_for(lambda: self.names() == ["from-run"], "the map")
        self.wait_for_text("#map-facts", "keyframes")
        self.assertIn("from run.jsonl.gz", self.text("#map-facts"))
        self.wait_for_grid()

    def test_what_is_wrong_with_files_is_said(self):
        broken = self.directory / "broken.cornerfix"
        broken.write_bytes(b"no database")
        self.expected = ["/v1/maps/broken/archive"]
        self.open("#tab=maps")
        self.upload(broken, name="broken")
        self.wait_for(lambda: self.text("#upload-error"), "an error of the server")
        self.find("#upload-cancel").click()
        self.upload(broken, name="not a name")
        self.wait_for_text("#upload-error", "letters, digits")
        bag = self.directory / "run.bag"
        bag.write_bytes(b"#ROSBAG V2.0\n")
        self.find("#upload-cancel").click()
        self.find("#add-map").click()
        self.find("#upload-files").send_keys(str(bag))
        self.wait_for_text("#upload-kind", "cornerfix map build NAME run.bag")
        self.assertEqual(self.names(), [])

    def test_maps_are_found_sorted_described_downloaded_and_deleted(self):
        self.import_map("room-10", self.room)
        archive = self.server.archive("room-10")
        for name in ("room-2", "attic"):
            self.server.restore(name, archive)
        self.browser.execute_cdp_cmd("Browser.setDownloadBehavior",
                                     {"behavior": "allow", "downloadPath": str(self.directory)})
        self.open("#tab=maps&map=room-2")
        self.wait_for(lambda: self.names() == ["attic", "room-2", "room-10"], "maps by name, numbers as numbers")
        self.find("#map-filter input").send_keys("room")
        self.wait_for_text("#maps-hint", "2 maps of 3")
        self.assertEqual(self.names(), ["room-2", "room-10"])

        self.find("#describe-map").click()
        self.find("#describe-dialog textarea").send_keys("Second floor, west wing")
        self.find("#describe-save").click()
        self.wait_for_text("#map-facts", "Second floor, west wing")
        self.assertEqual(self.server.call("GET", "/v1/maps/room-2")["description"], "Second floor, west wing")

        self.find("#download-map").click()
        saved = self.directory / "room-2.cornerfix"
        self.wait_for(saved.exists, "the downloaded archive")
        self.wait_for(lambda: saved.read_bytes()[:15] == b"SQLite format 3", "a whole archive")
        self.screenshot("maps")

        self.find("#delete-map").click()
        self.wait_for_text("#confirm-title", "Delete the map room-2?")
        self.find("#confirm-dialog button[value='no']").click()
        self.assertIn("room-2", self.names())
        self.find("#delete-map").click()
        self.find("#confirm-yes").click()
        self.wait_for(lambda: self.names() == ["room-10"], "one map less")

    def test_the_map_view_measures_and_shows_a_corner(self):
        self.import_map("room", self.room)
        self.open("#map=room&tab=maps&x=7&y=4&z=5")
        self.wait_for_grid()
        self.assertTrue(self.find("#view-options [name=corners]").is_selected())
        corners = self.server.call("GET", "/v1/maps/room/features")["features"]
        corner = min(corners, key=lambda each: abs(each["x"] - 7) + abs(each["y"] - 4))
        right, down = round(32 * (corner["x"] - 7)), round(32 * (4 - corner["y"]))
        ActionChains(self.browser).move_to_element_with_offset(self.find("#map"), right, down).perform()
        self.wait_for_text("#pointer", f"corner {corner['id']}")
        self.assertIn(f"x {corner['x']:.1f}", self.text("#pointer"))
        self.click_map(right, down)
        self.wait_for_text(".corner-popup h3", f"Corner {corner['id']}")
        self.wait_for_text(".corner-popup figcaption", "other corner")
        self.assertRegex(self.text(".corner-popup .aliases"), r"Surroundings like it: corner \d+ \(\d+ %\)")
        self.wait_for(lambda: self.is_shown(".leaflet-popup-close-button"), "the whole popup")
        self.screenshot("map-corner")
        self.find(".leaflet-popup-close-button").click()

        self.find("#view-options [name=measure]").click()
        self.click_map(-64, 0)
        self.click_map(96, 0)
        self.wait_for_text("#map-caption", "5.00 m, direction 0.0°")
        self.assertEqual(self.text(".leaflet-control-scale-line")[-1], "m")

    def test_the_chosen_map_is_in_sight(self):
        self.import_map("room-00", self.room)
        archive = self.server.archive("room-00")
        for i in range(1, 30):
            self.server.restore(f"room-{i:02}", archive)
        self.open("#map=room-25&tab=maps")
        self.wait_for(lambda: self.browser.execute_script("""
          const [row, list] = ['#maps [aria-current]', '#maps'].map((selector) => document.querySelector(selector)?.getBoundingClientRect());
          return Boolean(row) && row.top >= list.top && row.bottom <= list.bottom;"""), "the chosen map in the list")

    def test_two_maps_are_compared(self):
        self.import_map("before", self.room)
        self.import_map("after", write_changed_room(self.directory, self.room))
        self.open("#map=after&tab=maps")
        self.wait_for_grid()
        self.find('#compare-with option[value="before"]').click()
        self.wait_for_text("#comparison", "differ from before")
        self.assertEqual(self.fragment()["compare"], "before")
        text = self.text("#comparison")
        self.assertRegex(text, r"Around \(7\.\d, 2\.\d\) walls came")
        self.assertRegex(text, r"Around \(8\.\d, 6\.\d\) walls went")
        self.screenshot("map-compare")
        # The link leads a colleague to the same.
        self.open("#map=before&compare=after&tab=maps")
        self.wait_for_text("#comparison", "differ from after")
        self.assertRegex(self.text("#comparison"), r"Around \(7\.\d, 2\.\d\) walls went")
        self.assertEqual(self.find("#compare-with").get_property("value"), "after")
        self.find('#compare-with option[value=""]').click()
        self.wait_for(lambda: not self.text("#comparison"), "no comparison")

    def test_a_map_is_rolled_back_to_a_former_revision(self):
        self.import_map("room", self.room)
        self.open("#map=room&tab=maps")
        self.wait_for_grid()
        self.assertFalse(self.is_shown("#revisions-panel"))
        self.import_map("room", write_changed_room(self.directory, self.room))
        self.wait_for_text("#revisions", "Revision 2")
        self.assertRegex(self.text("#revisions"), r"Revision 2, .*by an occupancy map, \d+ corners\. In use\.")
        self.screenshot("map-revisions")
        self.find('[data-action="compare-revision"]').click()
        self.find("#confirm-yes").click()
        self.wait_for_text("#comparison", "differ from room.r1")
        self.assertIn("room.r1", self.names())
        self.find('[data-action="roll-back"]').click()
        self.wait_for_text("#confirm-text", "those of revision 1")
        self.find("#confirm-yes").click()
        self.wait_for_text("#revisions", "Revision 3")
        self.assertIn("by a roll-back", self.text("#revisions"))
        self.wait_for_text("#comparison", "The walls are those of room.r1.")

    def test_maps_with_the_same_walls_do_not_differ(self):
        self.import_map("room", self.room)
        self.server.restore("copy", self.server.archive("room"))
        self.open("#map=copy&compare=room&tab=maps")
        self.wait_for_text("#comparison", "The walls are those of room.")

    def test_a_map_that_cannot_be_loaded_is_tried_again(self):
        self.import_map("room", self.room)
        self.expected = ["grid.png"]
        self.browser.execute_cdp_cmd("Network.enable", {})
        self.browser.execute_cdp_cmd("Network.setBlockedURLs", {"urls": ["*grid.png"]})
        self.addCleanup(self.browser.execute_cdp_cmd, "Network.setBlockedURLs", {"urls": []})
        self.open("#map=room")
        self.wait_for_text("#notice", "could not be loaded")
        self.assertIn("Next try in", self.text("#notice"))
        self.browser.execute_cdp_cmd("Network.setBlockedURLs", {"urls": []})
        self.wait_for_grid()
        self.wait_for(lambda: not self.text("#notice"), "no notice")

    def test_a_simulated_robot_finds_itself_where_it_is_clicked(self):
        self.import_map("willow", self.arguments.map)
        self.open("#map=willow&tab=maps&x=32&y=17&z=4")
        self.wait_for_grid()
        self.find("#try-here").click()
        self.wait_for_text("#trial-state", "where the robot is switched on")
        self.click_map()
        self.wait_for_text("#trial-state", "where the robot looks")
        self.click_map(60, 0)
        self.wait_for_text("#trial-state", "off the true one")
        self.find("#tab-robots").click()
        self.wait_for_text("#robots", "trial")
        self.screenshot("trial")


if __name__ == "__main__":
    main(__doc__)
