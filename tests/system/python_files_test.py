#!/usr/bin/python3
"""The files that the Python client reads, and its package."""
import ast
import gzip
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from real_server import CLIENT, SOURCE

sys.path.insert(0, str(CLIENT))
import cornerfix  # noqa: E402
from cornerfix import Lidar, LogError, Pose, read_log  # noqa: E402


class LogTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = pathlib.Path(directory.name) / "run.log"

    HEADER = {"beams": 2, "angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": None}

    def read(self, *lines):
        self.path.write_text("".join(f"{line}\n" for line in lines))
        return list(read_log(self.path))

    def test_reads_json_lines(self):
        one, two = self.read(
            json.dumps(self.HEADER),
            '{"t": 1, "ranges": [1, null], "odom": [1, 2, 7]}',
            "",
            '{"t": 2, "ranges": [1], "angle_min": 1, "pose": [0, 0, 0]}',
        )
        self.assertEqual(one.lidar, Lidar(0, 0.1, 0, None))
        self.assertAlmostEqual(one.odom.yaw, 7 - 2 * math.pi)
        self.assertEqual((one.pose, two.pose, two.lidar.angle_min), (None, Pose(), 1))

    def test_names_the_line_that_is_wrong(self):
        for line, what in (
            ('{"t": 1, "ranges": [1]}', "1 values, expected 2"),
            ('{"t": 1', "line 2"),
            ("[1, 2]", "line 2: "),
            ('{"t": 1, "ranges": [1, 2], "odom": [1, 2]}', r"\[1, 2\], expected \[x, y, yaw\]"),
            ('{"ranges": [1, 2]}', "line 2: t: missing"),
        ):
            with self.subTest(line), self.assertRaisesRegex(LogError, what):
                self.read(json.dumps(self.HEADER), line)

    def test_reads_what_there_is_of_a_file_that_is_cut_off(self):
        lines = [json.dumps(self.HEADER)] + [
            '{"t": %d, "ranges": [1.5, null]}' % i for i in range(5000)
        ]
        packed = gzip.compress("\n".join(lines).encode())
        self.path.write_bytes(packed[: len(packed) // 2])
        self.assertGreater(len(list(read_log(self.path))), 1000)

    def test_passes_over_a_byte_order_mark(self):
        text = json.dumps(self.HEADER) + '\n{"t": 1, "ranges": [1, 2]}\n'
        self.path.write_bytes(b"\xef\xbb\xbf" + text.encode())
        self.assertEqual([scan.stamp for scan in read_log(self.path)], [1.0])

    def test_reads_a_scan_whose_odometry_is_lost(self):
        scans = self.read(
            json.dumps(self.HEADER),
            '{"t": 1, "ranges": [1, 2], "odom": [NaN, 0, 0]}',
            '{"t": 2, "ranges": [1, 2], "odom": [null, 0, 0]}',
        )
        self.assertEqual([scan.odom for scan in scans], [None, None])

    def test_reads_a_log_without_a_header_and_one_that_was_appended(self):
        own = '{"t": %d, "ranges": [1, 2], "angle_min": 0, "angle_increment": 1, "range_max": 9}'
        self.assertEqual([scan.stamp for scan in self.read(own % 1, own % 2)], [1.0, 2.0])
        line = '{"t": %d, "ranges": [1, 2]}'
        other = json.dumps({**self.HEADER, "angle_min": 0.5})
        scans = self.read(json.dumps(self.HEADER), line % 1, other, line % 2)
        self.assertEqual([scan.lidar.angle_min for scan in scans], [0, 0.5])

    def test_takes_the_scans_of_the_first_lidar(self):
        line = '{"t": %d, "ranges": [1, 2], "lidar": "%s"}'
        scans = self.read(
            json.dumps(self.HEADER), line % (1, "front"), line % (2, "rear"), line % (3, "front")
        )
        self.assertEqual([scan.stamp for scan in scans], [1.0, 3.0])

    def test_takes_nan_of_a_carmen_log_for_no_return(self):
        (scan,) = self.read("FLASER 3 1.5 nan inf 1 2 0 3 4 0 7.5 host 8.5")
        self.assertEqual((scan.stamp, scan.odom, scan.pose), (7.5, Pose(3, 4, 0), Pose(1, 2, 0)))
        self.assertEqual(scan.ranges, [1.5, None, None])

    def test_refuses_a_carmen_scan_of_another_number_of_ranges(self):
        for wrong in ("FLASER 2 1 2 3 0 0 0 0 0 0 7.5 host 8.5", "FLASER 4 1 2 3 0 0 0 0 0 0 7.5"):
            with self.subTest(wrong), self.assertRaisesRegex(LogError, "line 1: FLASER: expected"):
                self.read(wrong)

    def test_names_a_file_that_is_no_text_or_damaged(self):
        packed = gzip.compress((json.dumps(self.HEADER) + "\n").encode() * 50)
        for content, what in (
            (b'{"name": "B\xfcro"}\n', "expected text in UTF-8"),
            (packed[:20] + b"\0\0\0\0" + packed[24:], "the gzip file is damaged"),
        ):
            self.path.write_bytes(content)
            with self.subTest(what), self.assertRaisesRegex(LogError, what):
                list(read_log(self.path))

    def test_refuses_a_file_that_is_no_log(self):
        with self.assertRaisesRegex(LogError, "neither JSON lines nor a CARMEN log"):
            self.read("hello")
        with self.assertRaisesRegex(LogError, "holds no whole line"):
            self.read()


class MapImageTest(unittest.TestCase):
    def image_of(self, line, *files):
        with tempfile.TemporaryDirectory() as directory:
            path = pathlib.Path(directory)
            (path / "map.yaml").write_bytes(line.encode("latin-1") + b"\r\nresolution: 0.05\r\n")
            for file in files:
                (path / file).touch()
            return cornerfix._image_of(path / "map.yaml").relative_to(path)

    def test_is_read_as_yamls_are_written(self):
        for line, image in (
            ("image: map.pgm", "map.pgm"),
            ("# caf\xe9\nimage: 'second floor.pgm'  # new", "second floor.pgm"),
            ("image: second floor.pgm # new", "second floor.pgm"),
            ('"image":   "a#b.png"', "a#b.png"),
        ):
            with self.subTest(line):
                self.assertEqual(str(self.image_of(line, image)), image)

    def test_lies_beside_the_yaml_of_another_computer(self):
        for line in ("image: /home/someone/maps/map.pgm", "image: C:\\maps\\map.pgm"):
            with self.subTest(line):
                self.assertEqual(str(self.image_of(line, "map.pgm")), "map.pgm")

    def test_is_asked_for_where_none_is_named(self):
        with self.assertRaisesRegex(ValueError, "names no image; expected a line like"):
            self.image_of("origin: [0, 0, 0]")


class PackageTest(unittest.TestCase):
    def test_can_be_installed_without_a_network(self):
        with tempfile.TemporaryDirectory() as directory:
            source, target = pathlib.Path(directory, "source"), pathlib.Path(directory, "target")
            shutil.copytree(CLIENT, source, ignore=shutil.ignore_patterns("__pycache__"))
            subprocess.run(
                [
                    sys.executable,
                    "-m",
                    "pip",
                    "install",
                    "--quiet",
                    "--no-index",
                    "--no-build-isolation",
                    "--no-warn-script-location",
                    "--root-user-action=ignore",
                    "--target",
                    target,
                    source,
                ],
                check=True,
            )
            subprocess.run(
                [sys.executable, "-c", "import cornerfix, cornerfix_ros"],
                check=True,
                cwd=directory,
                env={"PYTHONPATH": str(target)},
            )

    def test_keeps_to_the_syntax_of_python_3_8(self):
        files = sorted((SOURCE / "clients").rglob("*.py"))
        self.assertGreaterEqual(len(files), 4)
        for file in files:
            ast.parse(file.read_text(), str(file), feature_version=(3, 8))


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
