"""Client of a Cornerfix server: maps, robots and recorded runs. Standard library only.

A robot:

    from cornerfix import Robot, read_log

    with Robot("http://127.0.0.1:8080", "robot-7", map="willow") as robot:
        for scan in read_log("robot.jsonl.gz"):
            answer = robot.add(scan)
            if answer and answer.pose:
                print(answer.pose)

Units are metres, radians and seconds; frames are those of ROS REP-105. A `Client` or a `Robot` is
for one thread at a time. docs/http-api.md describes each call.
"""
from __future__ import annotations

import collections
import datetime
import email.utils
import gzip
import http.client
import itertools
import json
import math
import numbers
import pathlib
import random
import re
import ssl
import time
import uuid
import zlib
from dataclasses import asdict, astuple, dataclass, field, fields
from typing import (
    Any,
    Callable,
    Deque,
    Dict,
    Iterable,
    Iterator,
    List,
    Literal,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    Type,
    TypeVar,
    Union,
)
from urllib.parse import quote, urlsplit

__version__ = "0.1.0"

Json = Dict[str, Any]
PathLike = Union[str, "pathlib.PurePath"]
Item = TypeVar("Item")

Status = Literal["collecting", "ambiguous", "localized", "lost"]
Reason = Literal[
    "no_returns",
    "few_features",
    "no_motion",
    "no_match",
    "few_evidence",
    "contradicted",
    "odometry_contradicts_scans",
    "prior_contradicted",
    "mirrored_scans",
    "searching",
]
"""docs/statuses.md describes each, and what to do."""

MAX_SCANS_PER_BATCH = 100  # `max_scans` of the server's default configuration.
CLOCK_SET_BACK_S = 2.0  # Stamps that go back further begin a new run (docs/logs.md).
LIDAR_SILENT_S = 0.5  # A lidar that is this far behind the others is not waited for.
_RETRIED = (408, 429, 502, 503, 504)  # 502 and 504: a proxy lost the server.
_MAX_BACKOFF_S = 5.0


# --- errors ---------------------------------------------------------------------------------------


class CornerfixError(Exception):
    """Any failure of this module."""


class Unreachable(CornerfixError):
    """No answer from the server, after all retries."""


class LogError(CornerfixError):
    """A recorded run that cannot be read: file, line and reason."""


class Problem(CornerfixError):
    """An error answer of the server (RFC 9457). docs/http-api.md lists the codes."""

    def __init__(self, status: int, members: Json):
        self.status = status
        self.members = members
        self.code: str = members.get("code", "unknown")
        self.detail: str = members.get("detail", "")
        self.errors: List[Tuple[str, str]] = [
            (error.get("pointer", ""), error.get("detail", ""))
            for error in members.get("errors", [])
        ]
        super().__init__(f"{status} {self.code}: {self.detail or 'no detail'}{self._pointed()}")

    @property
    def pointer(self) -> Optional[str]:
        """JSON pointer to the first wrong member of the request; None if none is named."""
        return self.errors[0][0] if self.errors else None

    def _pointed(self) -> str:
        parts = [
            f"{pointer}: {detail}" for pointer, detail in self.errors if pointer not in self.detail
        ]
        return "".join(f"; {part}" for part in parts)


# --- values ---------------------------------------------------------------------------------------


def wrap_angle(angle: float) -> float:
    """The same angle in (-pi, pi]."""
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


@dataclass(frozen=True)
class Pose:
    """Position [m] and heading [rad]. `a * b` composes transforms, as T_ab * T_bc."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def __mul__(self, other: Pose) -> Pose:
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            wrap_angle(self.yaw + other.yaw),
        )

    def inverse(self) -> Pose:
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose(
            -cos * self.x - sin * self.y, sin * self.x - cos * self.y, wrap_angle(-self.yaw)
        )


@dataclass(frozen=True)
class Lidar:
    """Geometry of scans, named as in sensor_msgs/LaserScan. `range_max` None is no limit."""

    angle_min: float
    angle_increment: float
    range_min: float
    range_max: Optional[float]
    mount: Pose = Pose()
    """`laser` in `base_link`."""
    roll: float = 0.0
    """Of the mount [rad]: pi for a lidar upside down; else within 0.175 of level."""
    pitch: float = 0.0
    """Of the mount [rad], within 0.175."""

    def to_json(self) -> Json:
        tilt = {"roll": self.roll, "pitch": self.pitch}
        mount = {**asdict(self.mount), **{name: angle for name, angle in tilt.items() if angle}}
        return {**self.geometry(), "mount": mount}

    def is_finite(self) -> bool:
        """All but `range_max`, which may be no limit."""
        angles = (self.angle_min, self.angle_increment, self.roll, self.pitch)
        return all(map(_is_finite, (*angles, self.range_min, *astuple(self.mount))))

    def geometry(self) -> Json:
        return {
            "angle_min": self.angle_min,
            "angle_increment": self.angle_increment,
            "range_min": self.range_min,
            "range_max": _number_or_none(self.range_max),
        }


@dataclass(frozen=True)
class Near:
    """Where a robot may be at its first scan, in the frame of the map: poses elsewhere are not
    searched."""

    x: float
    y: float
    radius_m: float
    yaw: Optional[float] = None
    """None: any heading."""
    yaw_tolerance_rad: Optional[float] = None
    map: Optional[str] = None

    def to_json(self) -> Json:
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass
class Scan:
    """One scan. A range that is None, not finite or outside the limits is a beam without return."""

    stamp: float
    ranges: Sequence[Optional[float]]
    lidar: Optional[Lidar] = None
    """None: that of the session or map."""
    odom: Optional[Pose] = None
    """`base_link` in `odom` at the stamp."""
    pose: Optional[Pose] = None
    """`base_link` in `map` at the stamp: for mapping and scores, never sent by a robot."""
    time_increment: Optional[float] = None
    """From beam to beam [s], for scans of a moving lidar."""
    lidar_name: Optional[str] = None
    """Which of the robot's `lidars`."""

    def check(self) -> None:
        """A ValueError for a scan that cannot be sent."""
        if not _is_finite(self.stamp):
            raise ValueError(f"stamp: {self.stamp!r}, expected seconds")
        if len(self.ranges) == 0:
            raise ValueError("ranges: none, expected metres, or None for no return")
        for name, value, kind in (("lidar", self.lidar, Lidar), ("odom", self.odom, Pose)):
            if value is not None and not isinstance(value, kind):
                raise ValueError(f"{name}: {value!r}, expected a {kind.__name__} or None")
        if self.odom and not all(map(_is_finite, astuple(self.odom))):
            raise ValueError(f"odom: {self.odom!r}, expected finite numbers, or None for none")
        if self.lidar and not self.lidar.is_finite():
            raise ValueError(f"lidar: {self.lidar!r}, expected finite numbers but of range_max")
        if self.time_increment is not None and not _is_finite(self.time_increment):
            raise ValueError(f"time_increment: {self.time_increment!r}, expected seconds or None")

    def to_json(self, lidar: Optional[Lidar]) -> Json:
        """Without the pose, and without geometry and mount if they are those of `lidar`, which the
        request or the session has."""
        body: Json = {"stamp": self.stamp, "ranges": [_range_or_none(r) for r in self.ranges]}
        if self.lidar_name is not None:
            body["lidar"] = self.lidar_name
        if self.lidar and self.lidar != lidar:
            body.update(self.lidar.to_json())
        if self.odom:
            body["odom"] = asdict(self.odom)
        if self.time_increment:
            body["time_increment"] = self.time_increment
        return body


@dataclass(frozen=True)
class LocalizedPose:
    """`base_link` in `map` at the stamp of the batch's last scan."""

    map: str
    revision: int
    stamp: float
    x: float
    y: float
    yaw: float
    covariance: Sequence[float]
    """3 x 3, row by row, in the order x, y, yaw [m^2, m rad, rad^2]."""
    epoch: int
    """Rises when the pose does not continue those before."""
    confirmed: bool

    def as_pose(self) -> Pose:
        return Pose(self.x, self.y, self.yaw)


@dataclass(frozen=True)
class Hypothesis:
    """A pose that fits the scans."""

    map: str
    revision: int
    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Answer:
    """What the server answers to a batch. `pose` is None unless `status` is "localized"."""

    status: Status
    session: Optional[str] = None
    sequence: Optional[int] = None
    pose: Optional[LocalizedPose] = None
    confidence: Optional[float] = None
    hypotheses: Sequence[Hypothesis] = ()
    reason: Optional[Reason] = None
    odometry: Optional[Literal["used", "weighted_down", "ignored"]] = None
    given: Optional[Literal["near"]] = None
    """"near" while the search is restricted by `near`: `confidence` is conditional on it."""
    raw: Json = field(default_factory=dict, repr=False, compare=False)

    @property
    def is_localized(self) -> bool:
        return self.pose is not None


@dataclass(frozen=True)
class MapEntry:
    """A map on the server; `raw` has all members."""

    name: str
    description: str = ""
    revision: int = 0
    digest: str = ""
    keyframes: int = 0
    features: int = 0
    bounds: Optional[Json] = None
    raw: Json = field(default_factory=dict, repr=False, compare=False)


@dataclass(frozen=True)
class Job:
    """Long work on the server; `raw` has all members."""

    id: str
    kind: str
    map: str
    status: Literal["queued", "running", "succeeded", "failed", "cancelled"]
    stage: Optional[str] = None
    progress: float = 0.0
    problem: Optional[Json] = None
    """Why it failed: members as those of `Problem`."""
    raw: Json = field(default_factory=dict, repr=False, compare=False)

    @property
    def is_finished(self) -> bool:
        return self.status not in ("queued", "running")


@dataclass(frozen=True)
class Session:
    """A robot's session on the server; `raw` has all members."""

    id: str
    robot: str
    status: Status
    expected: int
    """Sequence of the next batch."""
    maps: Optional[Sequence[str]] = None
    """None: every map."""
    last_seen: str = ""
    stale: bool = False
    """Not seen for long: status and last answer are old."""
    superseded_by: Optional[str] = None
    """Id of a newer session of the robot."""
    last_answer: Optional[Answer] = None
    raw: Json = field(default_factory=dict, repr=False, compare=False)


def _from_json(kind: Type[Item], body: Mapping[str, Any]) -> Item:
    """Members that `kind` does not have are left to `raw`, so that newer servers can be read."""
    names = {each.name for each in fields(kind)}
    members = {name: value for name, value in body.items() if name in names}
    if "raw" in names:
        members["raw"] = dict(body)
    return kind(**members)


def _answer(body: Json) -> Answer:
    pose = body.get("pose")
    hypotheses = tuple(_from_json(Hypothesis, each) for each in body.get("hypotheses") or ())
    members = {**body, "pose": pose and _from_json(LocalizedPose, pose), "hypotheses": hypotheses}
    answer = _from_json(Answer, members)
    answer.raw.update(body)
    return answer


def _session(body: Json) -> Session:
    last = body.get("last_answer")
    session = _from_json(Session, {**body, "last_answer": last and _answer(last)})
    session.raw.update(body)
    return session


def _is_finite(number: object) -> bool:
    return isinstance(number, numbers.Real) and math.isfinite(number)


def _plain_number(number: object) -> float:
    """Of a number that the module json does not know, as numpy.float32."""
    if isinstance(number, numbers.Real):
        return float(number)
    raise TypeError(f"{number!r} is no number that JSON has")


def _number_or_none(number: Optional[float]) -> Optional[float]:
    return number if number is not None and math.isfinite(number) else None


def _range_or_none(number: Optional[float]) -> Optional[float]:
    """To tenths of a millimetre: below the noise of any lidar, and half the text."""
    return round(float(number), 4) if number is not None and math.isfinite(number) else None


# --- client ---------------------------------------------------------------------------------------


@dataclass
class _Reply:
    status: int
    headers: http.client.HTTPMessage
    body: bytes

    def json(self) -> Json:
        try:
            members = json.loads(self.body or b"{}")
        except ValueError:
            members = None
        if not isinstance(members, dict):
            raise CornerfixError("the answer is no JSON object; is this a Cornerfix server?")
        return members

    def problem(self) -> Problem:
        try:
            members = json.loads(self.body)
        except ValueError:
            members = {"detail": self.body[:200].decode(errors="replace")}
        return Problem(self.status, members if isinstance(members, dict) else {})

    def retry_after_s(self) -> Optional[float]:
        """Of the header Retry-After: seconds or a date."""
        text = self.headers.get("Retry-After", "").strip()
        if text.isdigit():
            return float(text)
        try:
            date = email.utils.parsedate_to_datetime(text)
        except (TypeError, ValueError):
            return None
        return max(0.0, (date - datetime.datetime.now(datetime.timezone.utc)).total_seconds())


class Client:
    """Calls of one server over a connection that stays open.

    A call is repeated with backoff while the server is away or the answer is 408, 429, 502, 503 or 504, as long as
    `Retry-After` asks for, and for `give_up_after_s` at most. All calls may be repeated: the server
    recognizes scans and batches that it has. A session whose answer was lost is left behind and
    expires.
    """

    def __init__(
        self,
        url: str,
        *,
        token: Optional[str] = None,
        timeout_s: float = 120.0,
        give_up_after_s: float = 60.0,
        ssl_context: Optional[ssl.SSLContext] = None,
    ):
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"url: expected http://HOST:PORT, not {url!r}")
        self.url = url.rstrip("/")
        self.give_up_after_s = give_up_after_s
        self._base_path = parts.path.rstrip("/")
        self._headers = {"Accept": "application/json"}
        if token:
            self._headers["Authorization"] = f"Bearer {token}"
        if parts.scheme == "https":
            self._connection: http.client.HTTPConnection = http.client.HTTPSConnection(
                parts.hostname, parts.port, timeout=timeout_s, context=ssl_context
            )
        else:
            self._connection = http.client.HTTPConnection(
                parts.hostname, parts.port, timeout=timeout_s
            )

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._connection.close()

    # Maps.

    def maps(self) -> List[MapEntry]:
        return [_from_json(MapEntry, {**each}) for each in self._pages("maps")]

    def map(self, name: str) -> MapEntry:
        return _from_json(MapEntry, self.call("GET", _map_path(name)))

    def put_map(
        self,
        name: str,
        *,
        description: Optional[str] = None,
        lidar: Optional[Lidar] = None,
        parameters: Optional[Json] = None,
    ) -> MapEntry:
        """Creates or describes a map; what is None stays as it is."""
        body = {
            "description": description,
            "lidar": lidar and lidar.to_json(),
            "parameters": parameters,
        }
        return _from_json(MapEntry, self.call("PUT", _map_path(name), body))

    def delete_map(self, name: str) -> None:
        self.request("DELETE", _map_path(name))

    def import_map_server(
        self, name: str, yaml: PathLike, image: Optional[PathLike] = None
    ) -> Json:
        """Makes a map from the two files of ROS map_server.

        Without `image` it is the file that the yaml names, or one of that name beside the yaml.
        Returns revision, digest, number of features, and `warnings` about the files.
        """
        body, content_type = _map_server_form(yaml, image)
        return self.request("PUT", _map_path(name, "/grid"), body, content_type).json()

    def start_import(self, name: str, yaml: PathLike, image: Optional[PathLike] = None) -> Job:
        """As import_map_server(), as a job: for maps that take longer than a request may."""
        body, content_type = _map_server_form(yaml, image)
        later = {"Prefer": "respond-async"}
        reply = self.request("PUT", _map_path(name, "/grid"), body, content_type, later)
        return _from_json(Job, reply.json())

    def add_scans(self, name: str, scans: Iterable[Scan], *, batch: int = 50) -> Json:
        """Adds scans to a map that is there: all with `pose`, or all without (SLAM).

        Scans whose stamps the map has are skipped, so an interrupted call may be repeated. Returns
        the counts after the last batch, with `accepted` and `duplicates` of all batches.
        """
        total = {"accepted": 0, "duplicates": 0}
        counts: Json = {}
        for some in _batches(scans, batch):
            lidar = some[0].lidar
            body: Json = {"scans": [_posed(scan, lidar) for scan in some]}
            if lidar:
                body["lidar"] = lidar.to_json()
            counts = self.call("POST", _map_path(name, "/scans"), body)
            total = {key: total[key] + counts[key] for key in total}
        return {**counts, **total}

    def download_archive(self, name: str, file: PathLike) -> None:
        """Writes the whole map as one file."""
        pathlib.Path(file).write_bytes(self.request("GET", _map_path(name, "/archive")).body)

    def upload_archive(self, name: str, file: PathLike) -> MapEntry:
        """Makes a map of an archive. A name in use is a Problem with the code "conflict"."""
        body = pathlib.Path(file).read_bytes()
        reply = self.request("POST", _map_path(name, "/archive"), body, "application/vnd.sqlite3")
        return _from_json(MapEntry, reply.json())

    def map_revisions(self, name: str) -> List[Json]:
        """The present revision, then the former ones that the server keeps, newest first."""
        return self.call("GET", _map_path(name, "/revisions"))["revisions"]

    def roll_back(self, name: str, revision: int) -> MapEntry:
        """Makes the content of a kept revision that of a new one, which is returned."""
        body = {"revision": revision}
        return _from_json(MapEntry, self.call("POST", _map_path(name, "/rollback"), body))

    def localize(
        self, name: str, scans: Sequence[Scan], *, options: Optional[Json] = None
    ) -> Answer:
        """One question without a session."""
        lidar = scans[0].lidar if scans else None
        body = {
            "lidar": lidar and lidar.to_json(),
            "options": options,
            "scans": [scan.to_json(lidar) for scan in scans],
        }
        return _answer(self.call("POST", _map_path(name, "/localize"), body))

    # Jobs.

    def jobs(self) -> List[Job]:
        return [_from_json(Job, each) for each in self._pages("jobs")]

    def job(self, job: str) -> Job:
        return _from_json(Job, self.call("GET", f"/v1/jobs/{quote(job, safe='')}"))

    def job_result(self, job: str) -> Json:
        """Of a job that succeeded: what import_map_server() returns, or the report."""
        return self.call("GET", f"/v1/jobs/{quote(job, safe='')}/result")

    def cancel_job(self, job: str) -> Job:
        return _from_json(Job, self.call("DELETE", f"/v1/jobs/{quote(job, safe='')}"))

    def wait_for_job(self, job: str, *, every_s: float = 0.5) -> Job:
        """The job when it is finished."""
        while not (found := self.job(job)).is_finished:
            time.sleep(every_s)
        return found

    # Sessions.

    def sessions(self) -> List[Session]:
        return [_session(each) for each in self._pages("sessions")]

    def session(self, session: str) -> Session:
        return _session(self.call("GET", _session_path(session)))

    def create_session(self, members: Json) -> Session:
        """`members` as in docs/http-api.md: robot, map or maps, lidar, options."""
        return _session(self.call("POST", "/v1/sessions", members))

    def post_scans(self, session: str, sequence: int, scans: Sequence[Json]) -> Answer:
        """`scans` as in docs/http-api.md. The same batch again gets the same answer."""
        body = {"sequence": sequence, "scans": scans}
        return _answer(self.call("POST", _session_path(session, "/scans"), body))

    def reset_session(self, session: str, *, near: Optional[Near] = None) -> Session:
        """The robot was carried, to `near` if given: forgets its pose and its local map."""
        body = {"near": near.to_json()} if near else None
        return _session(self.call("POST", _session_path(session, "/reset"), body))

    def delete_session(self, session: str) -> None:
        self.request("DELETE", _session_path(session))

    # Any call.

    def call(self, method: str, path: str, body: Optional[Mapping[str, Any]] = None) -> Json:
        """A call with a JSON body or none; the JSON answer. Members that are None are left out."""
        if body is None:
            return self.request(method, path).json()
        members = {name: value for name, value in body.items() if value is not None}
        text = json.dumps(members, separators=(",", ":"), allow_nan=False, default=_plain_number)
        return self.request(method, path, text.encode(), "application/json").json()

    def request(
        self,
        method: str,
        path: str,
        body: Optional[bytes] = None,
        content_type: Optional[str] = None,
        more_headers: Optional[Mapping[str, str]] = None,
    ) -> _Reply:
        """One call, repeated as the class describes. Raises Problem or Unreachable."""
        deadline = time.monotonic() + self.give_up_after_s
        headers = {**self._headers, **(more_headers or {})}
        if content_type:
            headers["Content-Type"] = content_type
        failure: CornerfixError
        for attempt in itertools.count():
            wait_s: Optional[float] = None
            try:
                reply = self._exchange(method, self._base_path + path, body, headers)
            except ssl.SSLCertVerificationError as error:
                raise Unreachable(f"{self.url}: {error}") from error
            except (OSError, http.client.HTTPException) as error:
                failure = Unreachable(f"no answer from {self.url}: {error or type(error).__name__}")
            else:
                if reply.status < 300:
                    return reply
                if reply.status < 400:
                    raise CornerfixError(_redirection(self.url, reply))
                failure = reply.problem()
                if reply.status not in _RETRIED:
                    raise failure
                wait_s = reply.retry_after_s()
            if wait_s is None:
                wait_s = _backoff_s(attempt)
            if time.monotonic() + wait_s > deadline:
                raise failure
            time.sleep(wait_s)
        raise AssertionError("not reached")

    def _exchange(
        self, method: str, path: str, body: Optional[bytes], headers: Mapping[str, str]
    ) -> _Reply:
        try:
            self._connection.request(method, path, body, headers)
            response = self._connection.getresponse()
            return _Reply(response.status, response.headers, response.read())
        except BaseException:
            self._connection.close()  # What was sent or read in part cannot be continued.
            raise

    def _pages(self, what: str) -> Iterator[Json]:
        token: Optional[str] = None
        while True:
            page = self.call(
                "GET", f"/v1/{what}" + (f"?page_token={quote(token)}" if token else "")
            )
            yield from page[what]
            token = page.get("next_page_token")
            if not token:
                return


def _redirection(url: str, reply: _Reply) -> str:
    target = reply.headers.get("Location", "another place")
    return f"{url} answers {reply.status}, a redirection to {target}: use the URL of that server"


def _backoff_s(attempt: int) -> float:
    """Doubles; spread, so that a fleet does not come back in step. An idle connection that the
    server has closed costs no wait."""
    if attempt == 0:
        return 0.0
    return min(_MAX_BACKOFF_S, 0.1 * 2.0 ** min(attempt, 10)) * random.uniform(0.5, 1.0)


def _map_path(name: str, rest: str = "") -> str:
    return f"/v1/maps/{quote(name, safe='')}{rest}"


def _session_path(session: str, rest: str = "") -> str:
    return f"/v1/sessions/{quote(session, safe='')}{rest}"


def _map_server_form(yaml: PathLike, image: Optional[PathLike]) -> Tuple[bytes, str]:
    yaml_path = pathlib.Path(yaml)
    image_path = pathlib.Path(image) if image else _image_of(yaml_path)
    return _multipart({"yaml": yaml_path, "image": image_path})


def _image_of(yaml: pathlib.Path) -> pathlib.Path:
    """The path in a yaml may be one of another computer."""
    text = yaml.read_text(encoding="utf-8-sig", errors="replace")
    named = re.search(
        r"""^\s*["']?image["']?\s*:\s*("[^"\n]*"|'[^'\n]*'|[^"'#\n][^\n]*?)\s*(?:\s#.*)?$""",
        text,
        re.MULTILINE,
    )
    if not named:
        raise ValueError(f"{yaml}: names no image; expected a line like image: map.pgm")
    name = named.group(1).strip("\"'")
    there = yaml.parent / name
    beside = yaml.parent / re.split(r"[/\\]", name)[-1]
    return beside if not there.is_file() and beside.is_file() else there


def _multipart(files: Mapping[str, pathlib.Path]) -> Tuple[bytes, str]:
    boundary = uuid.uuid4().hex
    parts = []
    for name, path in files.items():
        head = (
            f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"; '
            f'filename="{quote(path.name)}"\r\n\r\n'
        )
        parts.append(head.encode() + path.read_bytes() + b"\r\n")
    return (
        b"".join(parts) + f"--{boundary}--\r\n".encode(),
        f"multipart/form-data; boundary={boundary}",
    )


def _batches(items: Iterable[Item], size: int) -> Iterator[List[Item]]:
    iterator = iter(items)
    return iter(lambda: list(itertools.islice(iterator, size)), [])


def _posed(scan: Scan, lidar: Optional[Lidar]) -> Json:
    return {**scan.to_json(lidar), **({"pose": asdict(scan.pose)} if scan.pose else {})}


# --- robot ----------------------------------------------------------------------------------------


class Robot:
    """A robot that sends its scans and learns its pose.

    Scans are sent in batches of `batch`; what could not be sent is kept, up to `max_waiting` scans,
    and goes with the next call. The session is made with the first scan, whose lidar it gets. It is
    continued after a restart of the server, and made anew if the server no longer has it. With
    `session`, the id of an earlier `Robot`, that one is continued.

    A robot with several lidars has them in `lidars` by name, and each scan has its `lidar_name`.
    With names alone, each scan has its `lidar` as well. Lidars may deliver in any order, each with
    stamps of its own that increase. A scan is sent once the others have come as far, but for those
    that are silent.
    """

    _MAX_CONFLICTS = 3
    _KEPT_BATCHES = 20

    def __init__(
        self,
        server: Union[str, Client],
        name: str,
        *,
        map: Optional[str] = None,
        maps: Optional[Sequence[str]] = None,
        token: Optional[str] = None,
        batch: int = 5,
        max_waiting: int = 1000,
        session: Optional[str] = None,
        near: Optional[Near] = None,
        lidars: Union[Mapping[str, Lidar], Sequence[str], None] = None,
        **members: Any,
    ):
        """Without `map` and `maps` the robot may be in any map. `near` is where it may be at its
        first scan. `members` go into the request for a session, as `options`."""
        if not 1 <= batch <= MAX_SCANS_PER_BATCH:
            raise ValueError(f"batch: {batch}, expected 1 to {MAX_SCANS_PER_BATCH}")
        self.client = Client(server, token=token) if isinstance(server, str) else server
        self.session = session
        self.answer: Optional[Answer] = None
        self.dropped = 0
        """Scans that were not sent: stamp not after the one before, or too many waiting."""
        self._members: Json = {"robot": name, "map": map, "maps": maps and list(maps), **members}
        self._batch = batch
        self._lidars: Dict[str, Optional[Lidar]] = (
            dict(lidars) if isinstance(lidars, Mapping) else dict.fromkeys(lidars or ())
        )
        self._waiting: Deque[Scan] = collections.deque()  # By stamp.
        self._max_waiting = max_waiting
        self._in_flight: List[Scan] = []
        self._sent: Deque[List[Scan]] = collections.deque(maxlen=self._KEPT_BATCHES)
        self._sequence = self.client.session(session).expected if session else 0
        self._lidar: Optional[Lidar] = None
        self._near = None if session else near
        self._last_stamps: Dict[Optional[str], float] = {}  # By the lidar's name.
        self._last_taken: Optional[float] = None  # Stamp of the last scan that went into a batch.

    def __enter__(self) -> Robot:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None:
            self.close()

    def add(self, scan: Scan) -> Optional[Answer]:
        """Takes a scan. The answer, when this scan made a batch full; None otherwise. A scan that
        cannot be sent is a ValueError, and is not taken."""
        scan.check()
        self._check_lidar_name(scan)
        if not self._accept_stamp(scan):
            self.dropped += 1
            return None
        self._last_stamps[scan.lidar_name] = scan.stamp
        self._wait(scan)
        if len(self._waiting) > self._max_waiting:
            self._waiting.popleft()
            self.dropped += 1
        return self._send(self._batch, self._complete)

    def flush(self) -> Optional[Answer]:
        """Sends all that waits; the answer to the last batch, None when nothing waited."""
        return self._send(1, lambda: len(self._waiting))

    def state(self) -> Optional[Session]:
        """The session as the server has it, with `stale` and `superseded_by`; None before the first
        batch."""
        return self.client.session(self.session) if self.session else None

    def _check_lidar_name(self, scan: Scan) -> None:
        name = scan.lidar_name
        if name is not None and not self._lidars:
            raise ValueError(f"lidar_name: {name!r}, but the robot has no `lidars`")
        if self._lidars and name not in self._lidars:
            raise ValueError(f"lidar_name: {name!r}, expected one of {', '.join(self._lidars)}")
        if name is not None and scan.lidar is None and self._lidars[name] is None:
            raise ValueError(f"lidar: is needed, since the robot has no geometry of {name!r}")

    def _accept_stamp(self, scan: Scan) -> bool:
        """Resets the session when the clock was set back."""
        last = self._last_stamps.get(scan.lidar_name)
        if last is not None and scan.stamp <= last - CLOCK_SET_BACK_S:
            self.reset()
            return True
        if last is not None and scan.stamp <= last:
            return False
        return self._last_taken is None or scan.stamp >= self._last_taken

    def _wait(self, scan: Scan) -> None:
        place = len(self._waiting)
        while place > 0 and self._waiting[place - 1].stamp > scan.stamp:
            place -= 1
        self._waiting.insert(place, scan)

    def _complete(self) -> int:
        """How many waiting scans no other lidar can come before."""
        newest = max(self._last_stamps.values(), default=0.0)
        until = min(
            (stamp for stamp in self._last_stamps.values() if stamp >= newest - LIDAR_SILENT_S),
            default=0.0,
        )
        return sum(scan.stamp <= until for scan in self._waiting)

    def _send(self, least: int, complete: Callable[[], int]) -> Optional[Answer]:
        """Sends batches until fewer than `least` of the `complete` scans wait."""
        answer: Optional[Answer] = None
        conflicts = 0
        while self._in_flight or complete() >= least:
            if not self._in_flight:
                count = min(complete(), max(self._batch, MAX_SCANS_PER_BATCH // 2))
                self._in_flight = [self._waiting.popleft() for _ in range(count)]
                self._last_taken = self._in_flight[-1].stamp
            try:
                answer = self._post()
            except Problem as problem:
                if problem.status in _RETRIED:
                    raise
                conflicts += 1
                if conflicts > self._MAX_CONFLICTS or not self._recover(problem):
                    self._in_flight = []  # The server will never take it.
                    raise
                continue
            self._sent.append(self._in_flight)
            self._in_flight = []
            self._sequence += 1
            self.answer = answer
        return answer

    def reset(self, *, near: Optional[Near] = None) -> None:
        """The robot was carried, to `near` if given: forgets its pose, its local map and the scans
        that wait."""
        self._near = near
        if self.session:
            try:
                self._sequence = self.client.reset_session(self.session, near=near).expected
                self._near = None
            except Problem as problem:
                if problem.code != "not_found":
                    raise
                self.session = None
        self._waiting.clear()
        self._in_flight = []
        self._sent.clear()
        self._last_stamps.clear()
        self._last_taken = None
        self.answer = None

    def close(self) -> None:
        """Sends what waits and ends the session."""
        self.flush()
        if self.session:
            self.client.delete_session(self.session)
            self.session = None
        self.client.close()

    def _post(self) -> Answer:
        if self.session is None:
            self._create_session(self._in_flight[0].lidar)
        try:
            scans = [scan.to_json(self._known_lidar(scan)) for scan in self._in_flight]
            assert self.session is not None
            return self.client.post_scans(self.session, self._sequence, scans)
        except (TypeError, ValueError):  # A range that is no number.
            self._in_flight = []
            raise

    def _known_lidar(self, scan: Scan) -> Optional[Lidar]:
        """The session's own, which a scan need not repeat."""
        return self._lidar if scan.lidar_name is None else self._lidars[scan.lidar_name]

    def _create_session(self, lidar: Optional[Lidar]) -> None:
        # A lidar that is known by name gets some geometry: its scans bring their own.
        named = {name: (each or lidar) for name, each in self._lidars.items()}
        lidar = None if named else lidar
        members = {
            **self._members,
            "lidar": lidar and lidar.to_json(),
            "lidars": {name: each.to_json() for name, each in named.items() if each} or None,
            "near": self._near and self._near.to_json(),
        }
        self.session = self.client.create_session(members).id
        self._near = None  # A session made anew later begins elsewhere.
        self._lidar = lidar
        self._sequence = 0
        self._sent.clear()

    def _recover(self, problem: Problem) -> bool:
        """After an error that only says that client and server disagree on what was sent."""
        if problem.code == "not_found" and self.session is not None:
            self.session = None  # It expired, or the server has another database.
            return True
        if problem.code != "sequence_conflict" or "expected" not in problem.members:
            return False
        self._go_on_at(problem.members["expected"], problem.members.get("last_stamp"))
        return True

    def _go_on_at(self, expected: int, last_stamp: Optional[float]) -> None:
        """Sends again the kept batches from `expected` on, without scans that the server has."""
        lost = max(0, self._sequence - expected)
        batches = list(self._sent)[-lost:] if lost else []
        again = [scan for batch in [*batches, self._in_flight] for scan in batch]
        if last_stamp is not None:
            again = [scan for scan in again if scan.stamp > last_stamp]
        self._waiting.extendleft(reversed(again))
        self._in_flight = []
        self._sent.clear()
        self._sequence = expected


# --- recorded runs --------------------------------------------------------------------------------


def read_log(path: PathLike) -> Iterator[Scan]:
    """The scans of a recorded run: JSON lines (docs/logs.md), or FLASER messages of a CARMEN log.

    Both may be packed with gzip. Odometry and poses of a log are those of the laser, so the mount
    is zero. Of several lidars (`lidar`), the scans of the first one are taken. Lines that cannot be
    read raise LogError; a file that is cut off ends there. The command `cornerfix replay` reads
    more kinds of logs, and bags.
    """
    opener = gzip.open if _is_gzip(path) else open
    with opener(path, "rt", encoding="utf-8-sig") as lines:  # type: ignore[operator]
        numbered = enumerate(_whole_lines(lines, path), start=1)
        first = next(((number, line) for number, line in numbered if line.strip()), None)
        if first is None:
            raise LogError(f"{path}: holds no whole line")
        every = itertools.chain([first], numbered)
        yield from (_json_lines if first[1].lstrip().startswith("{") else _carmen)(every, path)


def _is_gzip(path: PathLike) -> bool:
    with open(path, "rb") as file:
        return file.read(2) == b"\x1f\x8b"


def _whole_lines(lines: Iterable[str], path: PathLike) -> Iterator[str]:
    try:
        for line in lines:
            if line.endswith("\n") or line.rstrip().endswith("}"):
                yield line
    except EOFError:
        return  # A gzip file that is cut off.
    except UnicodeDecodeError as error:
        raise LogError(f"{path}: expected text in UTF-8: {error}") from error
    except (gzip.BadGzipFile, zlib.error) as error:
        raise LogError(f"{path}: the gzip file is damaged: {error}") from error


def _json_lines(lines: Iterable[Tuple[int, str]], path: PathLike) -> Iterator[Scan]:
    header: Optional[Json] = None
    lidars: List[Optional[str]] = []  # Of the first scan.
    for number, line in lines:
        if not line.strip():
            continue
        try:
            members = json.loads(line)
            # A log that was appended has a header of its own.
            if header is None or not {"t", "ranges"} & members.keys():
                header = members
                lidar = _lidar_of(header)
                if "ranges" not in members:  # Else each scan has its geometry.
                    continue
            scan = _json_scan(members, header, lidar)
            lidars = lidars or [members.get("lidar")]
            if members.get("lidar") == lidars[0]:
                yield scan
        except KeyError as error:
            raise LogError(f"{path}, line {number}: {error.args[0]}: missing") from error
        except (AttributeError, TypeError, ValueError) as error:
            raise LogError(f"{path}, line {number}: {error}") from error


def _lidar_of(members: Json) -> Lidar:
    return Lidar(
        members["angle_min"],
        members["angle_increment"],
        members.get("range_min", 0.0),
        members["range_max"],
    )


def _json_scan(members: Json, header: Json, lidar: Lidar) -> Scan:
    own = {"angle_min", "angle_increment", "range_min", "range_max"} & members.keys()
    ranges = members["ranges"]
    if not own and header.get("beams", len(ranges)) != len(ranges):
        raise ValueError(
            f"ranges: {len(ranges)} values, expected {header['beams']} (from the header)"
        )
    return Scan(
        stamp=float(members["t"]),
        ranges=ranges,
        lidar=_lidar_of({**header, **members}) if own else lidar,
        odom=_pose_or_none(members.get("odom")),
        pose=_pose_or_none(members.get("pose")),
        time_increment=members.get("time_increment", header.get("time_increment")),
    )


def _pose_or_none(values: Optional[Sequence[float]]) -> Optional[Pose]:
    if values is None:
        return None
    if not isinstance(values, list) or len(values) != 3:
        raise ValueError(f"{values!r}, expected [x, y, yaw] or null")
    if any(value is None or value != value for value in values):
        return None  # As odometry that is lost.
    if not all(map(_is_finite, values)):
        raise ValueError(f"{values!r}, expected [x, y, yaw] or null")
    x, y, yaw = values
    return Pose(float(x), float(y), wrap_angle(yaw))


_CARMEN_RANGE_MAX_M = 80.0


def _carmen(lines: Iterable[Tuple[int, str]], path: PathLike) -> Iterator[Scan]:
    params: Dict[str, str] = {}
    found = False
    for number, line in lines:
        words = line.split()
        try:
            if words[:1] == ["PARAM"] and len(words) >= 3:
                params[words[1]] = words[2]
            elif words[:1] == ["FLASER"]:
                yield _carmen_scan(words[1:], params)
                found = True
        except (IndexError, ValueError) as error:
            raise LogError(f"{path}, line {number}: FLASER: {error}") from error
    if not found:
        raise LogError(f"{path}: neither JSON lines nor a CARMEN log with FLASER messages")


def _carmen_scan(words: Sequence[str], params: Mapping[str, str]) -> Scan:
    """num_readings [ranges] x y theta odom_x odom_y odom_theta stamp …: laser, then robot."""
    beams = int(words[0])
    if beams < 2 or not 8 <= len(words) - beams <= 10:  # Host and logger_timestamp may follow.
        raise ValueError(f"expected {beams} ranges, two poses and a stamp")
    ranges = [float(word) for word in words[1 : 1 + beams]]
    rest = [float(word) for word in words[1 + beams : 8 + beams]]
    if not all(map(_is_finite, rest)):
        raise ValueError("expected finite numbers in poses and stamp")
    view = math.radians(float(params.get("laser_front_laser_fov", 180.0)))
    range_max = min(
        _CARMEN_RANGE_MAX_M, float(params.get("robot_front_laser_max", _CARMEN_RANGE_MAX_M))
    )
    lidar = Lidar(-view / 2.0, view / (beams if beams % 2 == 0 else beams - 1), 0.0, range_max)
    mount = Pose(
        *(
            float(params.get(f"robot_frontlaser_{name}", 0.0))
            for name in ("offset", "side_offset", "angular_offset")
        )
    )
    laser, robot = Pose(*rest[0:3]), Pose(*rest[3:6])
    odom = robot * mount
    corrected = not (_is_same(laser, odom) or _is_same(laser, robot))
    return Scan(
        stamp=rest[6],
        ranges=[r if r < range_max else None for r in ranges],
        lidar=lidar,
        odom=odom,
        pose=laser if corrected else None,
    )


def _is_same(a: Pose, b: Pose) -> bool:
    return math.hypot(a.x - b.x, a.y - b.y) <= 1e-4 and abs(wrap_angle(a.yaw - b.yaw)) <= 1e-4
