"""Chromium by its own protocol (DevTools) over a pipe, with nothing but Python's standard library."""
import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time


def find_chromium():
    """The program's path, or None."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Page:
    """One page in a headless browser, at a width and height [px]. Use it in a `with`."""

    def __init__(self, program, profile, width=1400, height=1000, dark=False):
        down, self.to = os.pipe()
        self.of, up = os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 20) for end in (down, up)]  # out of the way of 3 and 4

        def at_three_and_four():
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.browser = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=at_three_and_four, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for end in (down, up, *ends):
            os.close(end)
        self.text, self.number, self.session, self.said = b"", 0, None, []
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.resize(width, height)
        self.send("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.session = None
            self.send("Browser.close")
        finally:
            self.browser.kill()
            self.browser.wait()
            os.close(self.to)
            os.close(self.of)

    def listen(self):
        """From now on errors and warnings of the console; what it returns gives them."""
        for domain in ("Runtime", "Log", "Page"):
            self.send(domain + ".enable")
        self.said = []

        def heard():
            self.run("0")
            return self.said
        return heard

    def hear(self, event):
        parameters = event.get("params", {})
        if event["method"] == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.said.append(details.get("exception", {}).get("description", details["text"]))
        if event["method"] == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "assert"):
            self.said.append(str(parameters["args"]))
        if event["method"] == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.said.append(parameters["entry"]["text"])

    def receive(self, deadline):
        while b"\0" not in self.text:
            if not select.select([self.of], [], [], max(0, deadline - time.time()))[0]:
                raise TimeoutError("Chromium does not answer")
            part = os.read(self.of, 1 << 20)
            if not part:
                raise EOFError("Chromium has ended")
            self.text += part
        message, self.text = self.text.split(b"\0", 1)
        return json.loads(message)

    def send(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        deadline = time.time() + 120
        while True:
            answer = self.receive(deadline)
            if "method" in answer:
                self.hear(answer)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def resize(self, width, height):
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                  mobile=width < 600)

    def open(self, path):
        """Opens a file and waits until its scripts are done."""
        self.send("Page.navigate", url="file://" + os.path.abspath(path))
        self.wait("document.documentElement?.dataset.ready === 'yes'")

    def run(self, script):
        """The value of a script, as JSON has it."""
        result = self.send("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["exception"].get("description", "?"))
        return result["result"].get("value")

    def wait(self, condition, seconds=60):
        deadline = time.time() + seconds
        while not self.run(condition):
            if time.time() > deadline:
                raise TimeoutError(condition)
            time.sleep(0.05)

    def mouse(self, kind, x, y, buttons=0, clicks=0):
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left" if buttons or clicks else "none",
                  buttons=buttons, clickCount=clicks, pointerType="mouse")

    def hover(self, x, y):
        self.mouse("mouseMoved", x, y)

    def click(self, x, y, times=1):
        self.hover(x, y)
        for count in range(1, times + 1):
            self.mouse("mousePressed", x, y, 1, count)
            self.mouse("mouseReleased", x, y, 0, count)

    def drag(self, x, y, to_x, to_y):
        self.hover(x, y)
        self.mouse("mousePressed", x, y, 1, 1)
        for share in (0.3, 0.7, 1):
            self.mouse("mouseMoved", x + share * (to_x - x), y + share * (to_y - y), 1)
        self.mouse("mouseReleased", to_x, to_y, 0, 1)

    def place(self, script):
        """The middle of the element that a script gives, scrolled to."""
        return self.run(f"(() => {{ const e = {script}; e.scrollIntoView({{block: 'center'}}); "
                        "const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")

    def save(self, path):
        """A picture of the whole page."""
        height = self.run("document.documentElement.scrollHeight")
        picture = self.send("Page.captureScreenshot", captureBeyondViewport=True,
                            clip={"x": 0, "y": 0, "width": self.run("innerWidth"), "height": height, "scale": 1})
        with open(path, "wb") as file:
            file.write(base64.b64decode(picture["data"]))
