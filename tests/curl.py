"""As much of curl as the README asks for, where curl itself is not installed."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import httpx


def main() -> None:
    """Send one request; write the body of the answer."""
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("-s", "--silent", action="store_true")
    parser.add_argument("-H", "--header", action="append", default=[])
    parser.add_argument("-F", "--form", action="append", default=[])
    parser.add_argument("-o", "--output")
    parser.add_argument("-d", "--data", "--data-binary", dest="data")
    parser.add_argument("url")
    options = parser.parse_args()
    headers = dict(header.split(": ", 1) for header in options.header)
    body = (options.data or "").encode()
    if options.data and options.data.startswith("@"):
        name = options.data[1:]
        body = sys.stdin.buffer.read() if name == "-" else Path(name).read_bytes()
    fields = [(name, Path(path)) for name, _, path in (one.partition("=@") for one in options.form)]
    files = [(name, (path.name, path.read_bytes())) for name, path in fields]
    method = "GET" if options.data is None and not files else "POST"
    sent = {"files": files} if files else {"content": body}
    content = httpx.request(method, options.url, headers=headers, timeout=60, **sent).content
    if options.output:
        Path(options.output).write_bytes(content)
    else:
        sys.stdout.buffer.write(content)


if __name__ == "__main__":
    main()
