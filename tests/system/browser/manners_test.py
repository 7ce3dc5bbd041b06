#!/usr/bin/python3
"""The page's manners: tokens, keyboard, accessibility, narrow and dark screens, and its security policy."""
import json
import os
import pathlib
import sys
import unittest
import urllib.request

sys.dont_write_bytecode = True
from support import ActionChains, Keys, PageTest, Robot, Server, main, write_symmetric_room  # noqa: E402

ACCESSIBILITY = (pathlib.Path(__file__).parent / "accessibility.js").read_text()
AXE = os.environ.get("AXE_CORE")  # axe.min.js of the npm package axe-core, which Debian has not.
NAMED_ROLES = {"button", "link", "textbox", "searchbox", "combobox", "checkbox", "slider", "tab", "img", "progressbar",
               "dialog", "application", "navigation", "complementary", "tabpanel", "tablist"}
TOKEN = "correct-horse-battery"


class MannersTest(PageTest):
    @classmethod
    def set_up_server(cls):
        room = write_symmetric_room(cls.directory)
        cls.import_map("room", room)
        robot = Robot(cls.server, cls.simulate("room", "--seed", "3", "--length", "6", floor=room), "r-1", "room")
        for _ in range(8):
            robot.drive()
        cls.robot = robot

    def resize(self, width, height=900, dark=False):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})

    def overlaps(self, one, other):
        return self.browser.execute_script("""
          const [a, b] = [...arguments].map((selector) => document.querySelector(selector).getBoundingClientRect());
          return a.width > 0 && a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;""", one, other)

    def faults(self):
        faults = self.browser.execute_script(f"return ({ACCESSIBILITY});")
        for node in self.browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]:
            role = node.get("role", {}).get("value")
            if not node.get("ignored") and role in NAMED_ROLES and not node.get("name", {}).get("value", "").strip():
                faults.append(f"4.1.2 a {role} without a name: {node.get('properties')}")
        return faults + self.axe_faults()

    def axe_faults(self):
        if not AXE:
            return []
        self.browser.execute_script(pathlib.Path(AXE).read_text())
        found = self.browser.execute_async_script("""
          const done = arguments[0];
          axe.run().then(({violations}) => done(violations), (error) => done(String(error)));""")
        return [f"axe {each['id']}: {each['nodes'][0]['html'][:200]}" for each in found]

    @unittest.skipUnless(AXE, "AXE_CORE names no axe.min.js")
    def test_axe_finds_a_fault_that_is_there(self):
        self.open()
        self.wait_for_text("#robots", self.robot.header.get("robot", "r-1"))
        self.assertEqual(self.axe_faults(), [])
        self.browser.execute_script("document.querySelector('#robots-pane').append(document.createElement('button'))")
        self.assertRegex(" ".join(self.axe_faults()), "axe button-name")

    def test_it_is_accessible_in_light_and_dark_from_420_px_to_a_wall_screen(self):
        for width in (420, 1024, 1440, 2560):
            for dark in (False, True):
                with self.subTest(width=width, dark=dark):
                    self.resize(width, 900, dark)
                    self.open(f"#session={self.robot.id}")
                    self.wait_for(lambda: self.all("#fit-pictures canvas"), "the robot")
                    self.assertEqual(self.faults(), [])
                    self.screenshot(f"page-{width}-{'dark' if dark else 'light'}")
                    self.find("#tab-maps").click()
                    self.wait_for(lambda: self.texts("#maps strong"), "the maps")
                    self.assertEqual(self.faults(), [])
                    self.find("#add-map").click()
                    self.assertEqual(self.faults(), [])
                    self.find("#upload-cancel").click()
                    self.assertEqual(self.overlaps("#map-caption", "#view-options"), False)

    def test_everything_is_reached_by_the_keyboard(self):
        self.resize(1440)
        self.open("#tab=maps")
        self.wait_for(lambda: self.texts("#maps strong") == ["room"], "the map")
        body = self.find("body")
        first = None  # Where the browser begins depends on what was clicked before: go round once.
        reached = []
        for _ in range(120):
            ActionChains(self.browser).send_keys(Keys.TAB).perform()
            active = self.browser.switch_to.active_element
            if active == body:
                continue
            if active == first:
                break
            first = first or active
            reached.append(active.get_attribute("id") or active.get_attribute("name")
                           or active.get_attribute("data-key") or active.get_attribute("class"))
        for wanted in ("tab-maps", "text", "order", "add-map", "map-room", "follow", "corners", "map", "describe-map",
                       "download-map", "delete-map", "trial-lidar", "try-here"):
            self.assertIn(wanted, reached)
        self.find("#tab-maps").send_keys(Keys.ARROW_LEFT)
        self.wait_for(lambda: self.browser.switch_to.active_element.get_attribute("id") == "tab-robots", "the other tab")
        self.assertTrue(self.is_shown("#robots-pane"))
        # A dialog takes the keyboard, and Escape closes it.
        self.browser.execute_script("arguments[0].focus()", self.find("#tab-robots"))
        self.find("#tab-robots").send_keys(Keys.ARROW_RIGHT)
        self.find("#add-map").send_keys(Keys.ENTER)
        self.wait_for(lambda: self.is_shown("#upload-dialog"), "the dialog")
        ActionChains(self.browser).send_keys(Keys.ESCAPE).perform()
        self.wait_for(lambda: not self.is_shown("#upload-dialog"), "no dialog")

    def test_the_policy_allows_nothing_from_elsewhere(self):
        with urllib.request.urlopen(self.server.url) as answer:
            policy = answer.headers["Content-Security-Policy"]
            page = answer.read().decode()
        self.assertIn("default-src 'self'", policy)
        self.assertNotIn("unsafe", policy)
        self.assertNotRegex(page, r'(src|href)="(https?:)?//|style="|<script>|\son[a-z]+="')

    def test_a_token_is_asked_for_explained_and_kept_for_the_tab(self):
        self.expected = [" 401 ", " 403 "]
        config = self.directory / "config.json"
        config.write_text(json.dumps({"tokens": [
            {"token": TOKEN, "role": "viewer", "name": "me"}]}))
        config.chmod(0o600)
        server = Server(self.arguments.cornerfix, "--db", self.directory / "guarded.db", "--config", config)
        self.addCleanup(server.stop)
        self.browser.get(server.url)
        entry = self.find("[name=token]")
        self.wait_for(entry.is_displayed, "the form that asks for a token")
        self.assertIn("for this tab only", self.text("#token-hint"))
        self.assertEqual(self.faults(), [])
        self.screenshot("token")
        entry.send_keys("wrong-horse-battery\n")
        self.wait_for_text("#notice", "does not accept this token")
        entry.send_keys(f"{TOKEN}\n")
        self.wait_for(lambda: not entry.is_displayed(), "what the token opens")
        self.browser.refresh()
        self.wait_for(lambda: self.is_shown("#sign-out"), "the token kept for the tab")
        # A viewer may not change anything, and is told why.
        self.find("#tab-maps").click()
        self.wait_for(lambda: self.is_shown("#demo"), "the demo button")
        self.find("#demo").click()
        self.wait_for_text("#upload-error", "Your token does not allow this")
        self.find("#upload-cancel").click()
        self.find("#sign-out").click()
        self.wait_for(lambda: self.find("[name=token]").is_displayed(), "the form again")


if __name__ == "__main__":
    main(__doc__)
