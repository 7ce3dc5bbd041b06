"""What the ROS 1 and the ROS 2 node share, without any import of ROS.

A node hands over stamps, odometry and scans; `Bridge` sends them to the server in a thread of its
own and calls back with each answer.
"""
from __future__ import annotations

import bisect
import collections
import concurrent.futures
import dataclasses
import enum
import math
import threading
from dataclasses import dataclass
from typing import Any, Callable, Deque, Dict, List, Optional, Sequence, Tuple, TypeVar

from cornerfix import (
    CLOCK_SET_BACK_S,
    Answer,
    Client,
    CornerfixError,
    Lidar,
    LocalizedPose,
    Near,
    Pose,
    Robot,
    Scan,
    wrap_angle,
)

MAX_TILT_RAD = math.radians(25.0)  # As for bags (docs/logs.md).
MAX_NORM_ERROR = 0.1  # Of a unit quaternion, as over HTTP.
ODOMETRY_KEPT_S = 10.0
MAX_ODOMETRY_WAIT_S = 0.5
MAX_WAITING_SCANS = 500

Quaternion = Tuple[float, float, float, float]
Result = TypeVar("Result")


# --- geometry -------------------------------------------------------------------------------------


def yaw_of(q: Quaternion) -> float:
    """Heading of the x axis of a frame turned by the quaternion x, y, z, w. One that is not of unit
    length, such as that of a message which was not filled in, is a ValueError."""
    x, y, z, w = q
    if not abs(math.sqrt(x * x + y * y + z * z + w * w) - 1.0) <= MAX_NORM_ERROR:
        raise ValueError(f"orientation {q}: expected a unit quaternion x, y, z, w")
    return math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))


def quaternion_of(yaw: float) -> Quaternion:
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


@dataclass(frozen=True)
class Mount:
    """`laser` in `base_link`, seen from above."""

    pose: Pose
    is_upside_down: bool

    @staticmethod
    def of(x: float, y: float, q: Quaternion) -> Mount:
        """From a transform; a laser that is tilted by more than 25 deg is a ValueError."""
        qx, qy = q[0], q[1]
        up = 1.0 - 2.0 * (qx * qx + qy * qy)  # z component of the laser's z axis.
        tilt = math.acos(max(-1.0, min(1.0, abs(up))))
        if tilt > MAX_TILT_RAD:
            raise ValueError(
                f"the laser is tilted by {math.degrees(tilt):.0f} deg, expected at most "
                f"{math.degrees(MAX_TILT_RAD):.0f} deg from level or from upside down"
            )
        return Mount(Pose(x, y, yaw_of(q)), up < 0.0)

    def lidar(
        self, angle_min: float, angle_increment: float, range_min: float, range_max: float
    ) -> Lidar:
        """Geometry of the scans. A laser upside down turns the other way."""
        turn = -1.0 if self.is_upside_down else 1.0
        return Lidar(
            turn * angle_min,
            turn * angle_increment,
            range_min,
            range_max if math.isfinite(range_max) else None,
            self.pose,
        )


def covariance_6x6(pose: LocalizedPose) -> List[float]:
    """Of geometry_msgs/PoseWithCovariance: x, y, z, roll, pitch, yaw, row by row."""
    places = (0, 1, 5)
    out = [0.0] * 36
    for i, row in enumerate(places):
        for j, column in enumerate(places):
            out[6 * row + column] = float(pose.covariance[3 * i + j])
    return out


# --- odometry -------------------------------------------------------------------------------------


class OdometryTrack:
    """The odometry of the last seconds, interpolated to the stamps of scans."""

    def __init__(self, kept_s: float = ODOMETRY_KEPT_S):
        self._kept_s = kept_s
        self._stamps: List[float] = []
        self._poses: List[Pose] = []

    def add(self, stamp: float, pose: Pose) -> None:
        """A stamp that goes back begins a new track: the clock was set, or a bag began again. A
        pose with NaN, as of a filter that diverged, is none."""
        if not all(map(math.isfinite, (pose.x, pose.y, pose.yaw))):
            return
        if self._stamps and stamp <= self._stamps[-1]:
            if stamp == self._stamps[-1]:
                return
            self._stamps.clear()
            self._poses.clear()
        self._stamps.append(stamp)
        self._poses.append(pose)
        old = bisect.bisect_left(self._stamps, stamp - self._kept_s)
        del self._stamps[:old], self._poses[:old]

    @property
    def newest(self) -> Optional[float]:
        return self._stamps[-1] if self._stamps else None

    def at(self, stamp: float) -> Optional[Pose]:
        """None outside of the track."""
        after = bisect.bisect_left(self._stamps, stamp)
        if after == len(self._stamps):
            return None
        if self._stamps[after] == stamp:
            return self._poses[after]
        if after == 0:
            return None
        a, b = self._poses[after - 1], self._poses[after]
        t = (stamp - self._stamps[after - 1]) / (self._stamps[after] - self._stamps[after - 1])
        return Pose(
            a.x + t * (b.x - a.x),
            a.y + t * (b.y - a.y),
            wrap_angle(a.yaw + t * wrap_angle(b.yaw - a.yaw)),
        )


class ScanQueue:
    """Scans that wait for the odometry of their stamps.

    A scan waits until odometry with its stamp or a later one is there, but no longer than until a
    scan 0.5 s later has come; then it goes without odometry. Before any odometry none waits.
    """

    def __init__(self) -> None:
        self._odometry = OdometryTrack()
        self._scans: Deque[Scan] = collections.deque()

    def add_odometry(self, stamp: float, pose: Pose) -> List[Scan]:
        self._odometry.add(stamp, pose)
        return self._ready()

    def add_scan(self, scan: Scan) -> List[Scan]:
        if self._scans and scan.stamp < self._scans[-1].stamp - CLOCK_SET_BACK_S:
            self._scans.clear()
        place = len(self._scans)
        while place > 0 and self._scans[place - 1].stamp > scan.stamp:
            place -= 1
        self._scans.insert(place, scan)  # By stamp, since several lidars deliver in any order.
        return self._ready()

    def _ready(self) -> List[Scan]:
        ready = []
        while self._scans and not self._must_wait(self._scans[0].stamp):
            scan = self._scans.popleft()
            ready.append(dataclasses.replace(scan, odom=self._odometry.at(scan.stamp)))
        return ready

    def _must_wait(self, stamp: float) -> bool:
        newest = self._odometry.newest
        if newest is None or newest >= stamp:
            return False
        return self._scans[-1].stamp - stamp <= MAX_ODOMETRY_WAIT_S


# --- what is published ----------------------------------------------------------------------------


class PoseGate:
    """Lets one pose per epoch pass: that of the first answer that is localized, or confirmed.

    While no one listens the gate keeps the pose back, so that who comes later gets a fresh one.
    """

    def __init__(self, require_confirmed: bool = False):
        self._require_confirmed = require_confirmed
        self._passed: Optional[Tuple[Optional[str], int]] = None

    def passes(self, answer: Answer, listeners: int) -> bool:
        pose = answer.pose
        if pose is None or answer.status != "localized" or listeners == 0:
            return False
        if self._require_confirmed and not pose.confirmed:
            return False
        epoch = (answer.session, pose.epoch)
        if epoch == self._passed:
            return False
        self._passed = epoch
        return True


class Level(enum.IntEnum):
    """Of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Diagnosis:
    level: Level
    message: str
    values: Dict[str, str]


def diagnose(answer: Answer) -> Diagnosis:
    pose = answer.pose
    values: Dict[str, Any] = {
        "status": answer.status,
        "reason": answer.reason or "",
        "confidence": f"{answer.confidence or 0.0:.4f}",
        "session": answer.session,
        "sequence": answer.sequence,
        "odometry": answer.odometry or "",
        "hypotheses": len(answer.hypotheses),
    }
    if pose:
        values.update(
            map=pose.map,
            epoch=pose.epoch,
            confirmed=str(pose.confirmed).lower(),
            stamp=f"{pose.stamp:.6f}",
        )
    message = answer.status + (f": {answer.reason}" if answer.reason else "")
    return Diagnosis(
        Level.OK if pose else Level.WARN,
        message,
        {key: str(value) for key, value in values.items()},
    )


# --- bridge ---------------------------------------------------------------------------------------


@dataclass
class Settings:
    """Parameters of the nodes, under these names."""

    server: str = "http://127.0.0.1:8080"
    token: str = ""
    robot: str = "robot"
    map: str = ""
    """Empty: every map of the server."""
    batch: int = 5
    require_confirmed: bool = False
    """Publish the pose once 3 m of new ground agree with it."""
    scans: str = "scan"
    """Topics of the lidars, separated by blanks."""
    use_odom: bool = True
    base_frame: str = "base_link"
    map_frame: str = "map"
    near_x: float = 0.0
    near_y: float = 0.0
    near_radius_m: float = 0.0
    """Where the robot is switched on; 0: anywhere."""
    near_yaw: float = 0.0
    near_yaw_tolerance_rad: float = 0.0
    """0: any heading."""
    retry_s: float = 5.0
    """A failure is reported after this time; scans are kept and sent later."""

    @property
    def topics(self) -> List[str]:
        return self.scans.split()

    @property
    def lidar_names(self) -> Dict[str, Optional[str]]:
        """By topic, as the server has them; None for the only one."""
        if len(self.topics) == 1:
            return {self.topics[0]: None}
        return {topic: topic.strip("/_").replace("/", ".") for topic in self.topics}

    @property
    def near(self) -> Optional[Near]:
        if not self.near_radius_m:
            return None
        has_heading = self.near_yaw_tolerance_rad != 0.0
        return Near(
            self.near_x,
            self.near_y,
            self.near_radius_m,
            yaw=self.near_yaw if has_heading else None,
            yaw_tolerance_rad=self.near_yaw_tolerance_rad if has_heading else None,
        )

    @staticmethod
    def read(get: Callable[[str, Any], Any]) -> Settings:
        """From `get(name, default)`; a parameter of another type is a ValueError."""
        values = {}
        for each in dataclasses.fields(Settings):
            value = get(each.name, each.default)
            if isinstance(each.default, float) and type(value) is int:
                value = float(value)
            if type(value) is not type(each.default):
                raise ValueError(
                    f"parameter {each.name}: {value!r}, expected {type(each.default).__name__}"
                )
            values[each.name] = value
        settings = Settings(**values)
        if not settings.topics:
            raise ValueError("parameter scans: empty, expected one topic or more")
        return settings


class Bridge:
    """Sends scans in a thread of its own, so that no callback of ROS waits for the server.

    `on_answer(answer)` and `on_failure(error)` are called from that thread. All methods may be
    called from any other thread.
    """

    def __init__(
        self,
        settings: Settings,
        on_answer: Callable[[Answer], None],
        on_failure: Callable[[Exception], None],
    ):
        self._settings = settings
        self._on_answer = on_answer
        self._on_failure = on_failure
        self._lock = threading.Lock()  # Of the queue.
        self._queue = ScanQueue()
        self._scans: Deque[Scan] = collections.deque(maxlen=MAX_WAITING_SCANS)
        self._robot = self._make_robot(settings.map, settings.near)
        self._worker = concurrent.futures.ThreadPoolExecutor(max_workers=1)

    def add_odometry(self, stamp: float, pose: Pose) -> None:
        if self._settings.use_odom:
            with self._lock:
                self._hand_over(self._queue.add_odometry(stamp, pose))

    def add_scan(self, scan: Scan) -> None:
        with self._lock:
            self._hand_over(self._queue.add_scan(scan))

    def reset(self) -> None:
        """The robot was carried. Returns when the server knows; raises CornerfixError."""
        self._do(lambda: self._robot.reset())

    def change_map(self, name: str) -> None:
        """Goes on in a new session in that map, or in every map when empty. A map that the server
        does not have is a Problem, and the robot goes on in the old one."""
        self._do(lambda: self._change_map(name))

    def close(self) -> None:
        """Ends the session, if the server is there."""
        with self._lock:
            self._scans.clear()
        self._do(lambda: _end(self._robot))
        self._worker.shutdown()

    def _hand_over(self, scans: Sequence[Scan]) -> None:
        """A full queue loses its oldest scan, and the task for it finds nothing to do."""
        for scan in scans:
            self._scans.append(scan)
            self._worker.submit(self._take_scan)

    def _take_scan(self) -> None:
        try:
            scan = self._scans.popleft()
        except IndexError:
            return
        try:
            answer = self._robot.add(scan)
        except Exception as error:  # Else the executor would keep it for itself.
            self._on_failure(error)
            return
        if answer:
            self._on_answer(answer)

    def _do(self, task: Callable[[], Result]) -> Result:
        return self._worker.submit(task).result()

    def _change_map(self, name: str) -> None:
        if name:
            self._robot.client.map(name)
        old, self._robot = self._robot, self._make_robot(name, None)
        _end(old)

    def _make_robot(self, map_name: str, near: Optional[Near]) -> Robot:
        client = Client(
            self._settings.server,
            token=self._settings.token or None,
            give_up_after_s=self._settings.retry_s,
        )
        return Robot(
            client,
            self._settings.robot,
            map=map_name or None,
            batch=self._settings.batch,
            near=near,
            lidars=[name for name in self._settings.lidar_names.values() if name] or None,
        )


def _end(robot: Robot) -> None:
    """Without the server the session expires by itself."""
    try:
        robot.close()
    except CornerfixError:
        pass
