"""A server and a clock under the control of a test of the Python client, and a small scan."""
import http.server
import json
import sys
import threading
from unittest import mock

from real_server import CLIENT

sys.path.insert(0, str(CLIENT))
import cornerfix  # noqa: E402
from cornerfix import Lidar, Scan  # noqa: E402

LIDAR = Lidar(-1.0, 0.5, 0.1, 20.0)

class Clock:
    """Time that passes only while the client waits."""

    def __init__(self, on_wait=lambda: None):
        self.waits = []
        self._on_wait = on_wait

    def monotonic(self):
        return sum(self.waits)

    def sleep(self, seconds):
        self.waits.append(seconds)
        self._on_wait()

    def __enter__(self):
        self._patch = mock.patch.object(cornerfix, "time", self)
        self._patch.start()
        return self

    def __exit__(self, *_):
        self._patch.stop()


class Stub:
    """A server that gives the listed replies, one per request: (status, headers, body), or None to
    close the connection without an answer."""

    def __init__(self, *replies):
        self.replies = list(replies)
        self.requests = []
        stub = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def answer(self):
                length = int(self.headers.get("Content-Length", 0))
                stub.requests.append((self.command, self.path, self.rfile.read(length)))
                reply = stub.replies.pop(0)
                if reply is None:
                    self.close_connection = True
                    return
                status, headers, body = reply
                data = body if isinstance(body, bytes) else json.dumps(body).encode()
                self.send_response(status)
                for name, value in {**headers, "Content-Length": str(len(data))}.items():
                    self.send_header(name, value)
                self.end_headers()
                self.wfile.write(data)

            do_GET = do_POST = do_PUT = do_DELETE = answer

            def log_message(self, *_):
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.01}
        )
        self.url = "http://127.0.0.1:%d" % self._server.server_address[1]

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def bodies(self):
        return [json.loads(body) for _, _, body in self.requests if body]


def problem(status, code, **members):
    return (
        status,
        {"Content-Type": "application/problem+json"},
        {"code": code, "detail": "why", **members},
    )


def scan(stamp):
    return Scan(stamp, [1.0, None, float("nan"), float("inf"), 2.00004], LIDAR)
