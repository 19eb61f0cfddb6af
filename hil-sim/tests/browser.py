"""A headless Chromium that is spoken with by the DevTools protocol."""

import base64
import json
import re
import subprocess
import tempfile

from websockets.sync.client import connect


class Browser:
    """One tab. What its console says and what it asks for is kept."""

    def __init__(self, url):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0", "--window-size=1280,1500"]
        command = ["chromium", *flags, f"--user-data-dir={self.folder.name}", "about:blank"]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if found := re.search(r"ws://\S+", line):
                break
        self.socket = connect(found.group(), max_size=None)
        self.session = None
        self.ids = iter(range(1, 1 << 30))
        self.complaints, self.requests = [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self.call(f"{domain}.enable")
        self.call("Page.navigate", url=url)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.process.stderr.close()
        self.folder.cleanup()

    def call(self, method, **params):
        message = {"id": next(self.ids), "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        self.socket.send(json.dumps(message))
        while True:
            answer = json.loads(self.socket.recv(timeout=60))
            if answer.get("id") == message["id"]:
                assert "error" not in answer, answer
                return answer["result"]
            self.note(answer)

    def note(self, event):
        kind, params = event["method"], event["params"]
        if kind == "Runtime.exceptionThrown":
            self.complaints.append(params["exceptionDetails"])
        elif kind == "Runtime.consoleAPICalled":
            self.complaints.append(params["args"])
        elif kind == "Log.entryAdded":
            self.complaints.append(params["entry"])
        elif kind == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])

    def value(self, expression):
        """What an expression is in the page, as plain data."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def wait_for(self, expression, seconds=60):
        """Waits until an expression holds in the page."""
        poll = f"""new Promise((held, failed) => {{
            const until = performance.now() + {1000 * seconds};
            const look = () => {{
                if ({expression}) held(true);
                else if (performance.now() > until) held(false);
                else setTimeout(look, 50);
            }};
            look();
        }})"""
        assert self.value(poll), (expression, self.value("document.body.innerText"), self.complaints)

    def screenshot(self, path, dark=False):
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        picture = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)
        with open(path, "wb") as file:
            file.write(base64.b64decode(picture["data"]))
