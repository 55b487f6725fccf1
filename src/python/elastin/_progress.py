"""What is being done, as it is done."""

import contextlib
import re
import sys
import time

WIDTH, BAR = 100, 20


class Line:
    """One line on standard error that says what is being done, with a bar where that says "2 of 5"; it is gone in the end."""

    def __init__(self, stream=None):
        self.stream, self.begun, self.written = stream or sys.stderr, time.monotonic(), 0

    def __call__(self, doing):
        counted = re.search(r"(\d+) of (\d+)", doing)
        bar = ""
        if counted and int(counted[2]) > 0:
            full = min(BAR, BAR * int(counted[1]) // int(counted[2]))
            bar = f"[{'#' * full}{'-' * (BAR - full)}] "
        self.write(f"{bar}{doing} ({time.monotonic() - self.begun:.0f} s)"[:WIDTH])

    def write(self, text):
        self.stream.write("\r" + text.ljust(self.written))
        self.stream.flush()
        self.written = len(text)

    def close(self):
        self.write("")
        self.stream.write("\r")


@contextlib.contextmanager
def shown(progress):
    """What C++ calls: of `progress` a function itself, of True a Line, of None or False nothing."""
    if progress is not True:
        yield progress or None
        return
    line = Line()
    try:
        yield line.__call__
    finally:
        line.close()
