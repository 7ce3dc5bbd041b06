#!/usr/bin/python3
"""Makes the pictures of the documents from the real page: inspector.png and the animation inspector.gif.

A robot with a short lidar is switched on in the Willow Garage map, drives, and becomes localized.
"""
import argparse
import io
import pathlib
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/system/browser"))
from PIL import Image  # noqa: E402
from support import By, Robot, Server, WebDriverWait, start_browser, write_symmetric_room  # noqa: E402

FLOOR = ROOT / "tests/data/willow_full_0.05.yaml"
PAGE_PX = (1280, 800)
ANIMATION_PX = (900, 562)
FRAME_MS = 600
COLORS = 128
MARK_COLORS = 48
VIVID = 70  # Difference of the largest and the smallest channel.
LOCALIZED_FRAMES = 6
MAX_FRAMES = 40


def simulate(cornerfix, directory, name, *options, floor=FLOOR):
    log = directory / f"{name}.jsonl.gz"
    subprocess.run([cornerfix, "simulate", floor, log, *map(str, options)], check=True, stdout=subprocess.DEVNULL)
    return log


def import_map(cornerfix, server, name, yaml):
    subprocess.run([cornerfix, "map", "import", name, yaml, "--server", server.url], check=True,
                   stdout=subprocess.DEVNULL)


def other_robots(cornerfix, server, directory):
    """A fleet beside the robot that is watched: one is localized, one is ambiguous in a symmetric room."""
    room = write_symmetric_room(directory)
    import_map(cornerfix, server, "storage", room)
    fine = Robot(server, simulate(cornerfix, directory, "fine", "--seed", 1, "--length", 10), "fork-lift-1")
    fine.drive_until("localized")
    cart = Robot(server, simulate(cornerfix, directory, "cart", "--seed", 3, "--length", 6, floor=room), "cart-2", "storage")
    for _ in range(10):
        cart.drive()


class Page:
    def __init__(self, server):
        self.browser = start_browser(*PAGE_PX)
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": PAGE_PX[0], "height": PAGE_PX[1], "deviceScaleFactor": 1, "mobile": False})
        self.url = server.url

    def open(self, session):
        self.browser.get(f"{self.url}/#map=willow&session={session}")
        self.wait(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#map .grid canvas"))

    def wait(self, condition):
        WebDriverWait(self.browser, 60, poll_frequency=0.1).until(lambda _: condition())

    def wait_for_answer(self, sequence):
        script = "return document.getElementById('robot-facts').textContent"
        self.wait(lambda: f"Answer{sequence}Time" in self.browser.execute_script(script))
        time.sleep(0.5)  # The browser draws.

    def picture(self):
        return Image.open(io.BytesIO(self.browser.get_screenshot_as_png())).convert("RGB")


def watch(page, robot):
    """Pictures of the page, one per answer, until the robot has been localized for a while."""
    frames, localized = [], 0
    while localized < LOCALIZED_FRAMES and len(frames) < MAX_FRAMES:
        answer, _ = robot.drive(4)
        localized += answer["status"] == "localized"
        page.wait_for_answer(answer["sequence"])
        frames.append(page.picture())
    if not localized:
        raise RuntimeError("the robot was not localized")
    return frames


def colours_of(image, count):
    return image.quantize(count).getpalette()[:3 * count]


def palette_of(frames):
    """The greys of text and map, and the colours of the marks, which are few pixels."""
    vivid = [pixel for frame in frames for pixel in frame.getdata() if max(pixel) - min(pixel) > VIVID]
    marks = Image.new("RGB", (len(vivid), 1))
    marks.putdata(vivid)
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours_of(frames[-1], COLORS - MARK_COLORS) + colours_of(marks, MARK_COLORS))
    return palette


def save_animation(frames, file):
    small = [frame.resize(ANIMATION_PX, Image.LANCZOS) for frame in frames]
    palette = palette_of(small)
    images = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in small]
    durations = [FRAME_MS] * (len(images) - 1) + [4 * FRAME_MS]
    images[0].save(file, save_all=True, append_images=images[1:], duration=durations, loop=0, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cornerfix", required=True, help="the program")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="directory for the pictures")
    arguments = parser.parse_args()
    cornerfix = arguments.cornerfix
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        server = Server(cornerfix, "--db", directory / "maps.db")
        try:
            import_map(cornerfix, server, "willow", FLOOR)
            other_robots(cornerfix, server, directory)
            log = simulate(cornerfix, directory, "robot", "--seed", 14, "--length", 12, "--range-max", 6,
                           "--fov", 180, "--beams", 361)
            robot = Robot(server, log, "robot-7")
            page = Page(server)
            page.open(robot.id)
            frames = watch(page, robot)
            page.browser.quit()
        finally:
            server.stop()
    frames[-1].save(arguments.out / "inspector.png", optimize=True)
    save_animation(frames, arguments.out / "inspector.gif")
    for file in ("inspector.png", "inspector.gif"):
        print(f"{arguments.out / file}: {(arguments.out / file).stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
