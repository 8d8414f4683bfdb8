"""Open a session in the viewer's window, or in a browser through a server that only this machine can reach.

The viewer sends no usage statistics: in its window an environment variable switches them off, and in the browser the page
is served with a policy that allows connections to this server only.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.error import URLError

from physident.errors import NotSolvedError

HOST = "127.0.0.1"
START_LIMIT = 30.0  # s that the viewer's web server may take to start
POLICY = (
    "default-src 'self' 'unsafe-inline' 'wasm-unsafe-eval' 'unsafe-eval' blob: data:;"
    " connect-src 'self' blob: data:; frame-ancestors 'none'"
)
SESSION = "/session.rrd"


def open_window(path: Path) -> None:
    """Open a session file in the viewer's window and wait until it is closed; raises NotSolvedError where that fails."""
    done = subprocess.run(
        [*_viewer(), str(path), "--bind", HOST, "--port", "auto"],
        env=_quiet(),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        last = [line for line in done.stderr.splitlines() if line.strip()][-1:] or ["no reason given"]
        reason = last[0].strip().split(" at /")[0][:200]
        raise NotSolvedError(
            f"the viewer could not open a window ({reason}); write a file (--out) and open it on a machine with a screen, or use --web"
        )


def serve(path: Path) -> None:
    """Serve a session file to a browser on this machine, at the address it prints, until it is interrupted."""
    with web_server(path) as address:
        print(f"open {address} in a browser; Ctrl-C ends it", flush=True)
        try:
            while True:
                time.sleep(3600)
        except KeyboardInterrupt:
            return


@contextmanager
def web_server(path: Path) -> Iterator[str]:
    """Serve a session file and the web viewer to this machine only; yields the address to open in a browser."""
    upstream = _free_port()
    command = [
        *_viewer(),
        "--serve-web",
        "--bind",
        HOST,
        "--port",
        str(_free_port()),
        "--web-viewer-port",
        str(upstream),
    ]
    process = subprocess.Popen(command, env=_quiet(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        _wait_for(f"http://{HOST}:{upstream}/", process)
        server = ThreadingHTTPServer((HOST, 0), _handler(path, f"http://{HOST}:{upstream}"))
        with _running(server):
            address = f"http://{HOST}:{server.server_address[1]}"
            yield f"{address}/?url={address}{SESSION}"
    finally:
        process.terminate()
        process.wait()


@contextmanager
def _running(server: ThreadingHTTPServer) -> Iterator[None]:
    import threading

    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def _handler(path: Path, upstream: str) -> Callable[..., BaseHTTPRequestHandler]:
    """A handler that serves the session file and, for all other paths, the answer of the viewer's server."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path.split("?")[0] == SESSION:
                self._head("application/octet-stream", path.stat().st_size)
                with path.open("rb") as stream:
                    shutil.copyfileobj(stream, self.wfile)
                return
            try:
                with urllib.request.urlopen(upstream + self.path.split("?")[0]) as answer:
                    body = answer.read()
                    self._head(answer.headers.get_content_type(), len(body))
                    self.wfile.write(body)
            except URLError:
                self.send_error(404)

        def _head(self, kind: str, length: int) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(length))
            self.send_header("Content-Security-Policy", POLICY)
            self.send_header("Referrer-Policy", "no-referrer")
            self.end_headers()

        def log_message(self, format: str, *args: Any) -> None:
            """Print nothing: the terminal belongs to the command."""

    return Handler


def _viewer() -> list[str]:
    """The path of the viewer's program; started through Python it would outlive the process that started it."""
    from importlib.util import find_spec

    spec = find_spec("rerun_cli")
    folder = Path(spec.origin).parent if spec is not None and spec.origin else Path()
    programs = [folder / "Rerun.app" / "Contents" / "MacOS" / "Rerun", folder / "rerun", folder / "rerun.exe"]
    found = [str(program) for program in programs if program.is_file()]
    if not found:
        raise NotSolvedError(f"the rerun viewer is not in {folder}; install rerun-sdk, or write a file (--out)")
    return found[:1]


def _quiet() -> dict[str, str]:
    """The environment variables for a viewer that sends no usage statistics."""
    return {**{k: v for k, v in os.environ.items() if k != "FORCE_RERUN_ANALYTICS"}, "CI": "true"}


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


def _wait_for(address: str, process: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + START_LIMIT
    while time.monotonic() < end and process.poll() is None:
        try:
            with urllib.request.urlopen(address):
                return
        except OSError:
            time.sleep(0.1)
    raise NotSolvedError("the web viewer did not start; write a file (--out) and open it with the rerun viewer instead")
