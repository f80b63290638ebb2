"""Opens the pages that the program makes in Chromium, and uses them as a person does: plays, seeks, drags, turns.

    report_page.py PROGRAM FOLDER [SCREENSHOTS]

Speaks the W3C WebDriver protocol to chromedriver with nothing but Python. Where there is no chromedriver or chromium
it says so and ends with 77, which the tests take for skipped."""
import base64
import json
import pathlib
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

PROGRAM, FOLDER = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
RATE = 10  # frames per second of the movies: slow, so that none ends while it is looked at
PICTURES = pathlib.Path(sys.argv[3]).resolve() if len(sys.argv) > 3 else None


class Browser:
    def __init__(self, driver, chromium):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.base = f"http://127.0.0.1:{port}"
        self.driver = subprocess.Popen([driver, f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(100):
            try:
                if self.ask("GET", "/status")["ready"]:
                    break
            except (urllib.error.URLError, ConnectionError):
                time.sleep(0.1)
        options = {"binary": chromium,
                   "args": ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader",
                            "--use-gl=angle", "--use-angle=swiftshader", "--autoplay-policy=no-user-gesture-required"]}
        session = self.ask("POST", "/session", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session = "/session/" + session["sessionId"]

    def ask(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data, {"Content-Type": "application/json"}, method=method)
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

    def post(self, path, body):
        return self.ask("POST", self.session + path, body)

    def run(self, script, *arguments):
        return self.post("/execute/sync", {"script": script, "args": list(arguments)})

    def until(self, script, what, seconds=30):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.run("return " + script):
                return
            time.sleep(0.1)
        raise AssertionError(f"{what}: never so: {script}")

    def open(self, page, width=1280, height=900, dark=False):
        self.post("/window/rect", {"width": width, "height": height})
        self.post("/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}})
        self.post("/goog/cdp/execute", {"cmd": "Emulation.setEmulatedMedia", "params": {
            "features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]}})
        self.post("/url", {"url": page.as_uri()})

    def click(self, css):
        element = self.post("/element", {"using": "css selector", "value": css})
        self.post(f"/element/{next(iter(element.values()))}/click", {})

    def drag(self, css, start, end):
        """From one share of the element's box to another."""
        x, y, w, h = self.run("arguments[0] = document.querySelector(arguments[0]); arguments[0].scrollIntoView({block: 'center'});"
                              "const b = arguments[0].getBoundingClientRect(); return [b.x, b.y, b.width, b.height]", css)
        at = lambda share: {"x": round(x + share[0] * w), "y": round(y + share[1] * h)}
        move = lambda share, ms: {"type": "pointerMove", "duration": ms, **at(share)}
        self.post("/actions", {"actions": [{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
                  "actions": [move(start, 0), {"type": "pointerDown", "button": 0}, move(end, 200), {"type": "pointerUp", "button": 0}]}]})

    def errors(self):
        return [entry["message"] for entry in self.post("/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]

    def picture(self, name, whole=False):
        if PICTURES is None:
            return
        PICTURES.mkdir(parents=True, exist_ok=True)
        if whole:
            shot = self.post("/goog/cdp/execute", {"cmd": "Page.captureScreenshot", "params": {"captureBeyondViewport": True, "clip": {
                **dict(zip(("width", "height"), self.run("return [innerWidth, document.documentElement.scrollHeight]"))),
                "x": 0, "y": 0, "scale": 1}}})["data"]
        else:
            shot = self.ask("GET", self.session + "/screenshot")
        (PICTURES / (name + ".png")).write_bytes(base64.b64decode(shot))

    def close(self):
        try:
            self.ask("DELETE", self.session)
        finally:
            self.driver.terminate()
            self.driver.wait()


def program(*arguments, code=0):
    done = subprocess.run([str(PROGRAM), *arguments], cwd=FOLDER, capture_output=True, text=True)
    assert done.returncode == code, f"{arguments}: {done.returncode}\n{done.stderr}"
    return done.stdout


def check(good, what):
    if not good:
        raise AssertionError(what)


def scene(name, extra=""):
    # A name and a description that would end a script, were they not escaped.
    (FOLDER / name).write_text('version = 1\ndescription = "</script><b id=\'broken\'>&amp;"\n[[cloth]]\nresolution = 14\n'
                               "translate = [0, 0.5, 0]\nrotate = [-90, 0, 0]\n[[collider]]\nradius = 0.2\n"
                               f"[output]\nframes = 40\nsize = [320, 240]\nplayback_rate = {RATE}\n{extra}")


def use_a_run(browser):
    page = FOLDER / "run/report.html"
    check(page.stat().st_size < 30e6, "the page is below 30 MB")
    browser.open(page)
    browser.until("document.querySelector('#view').dataset.ready === 'yes'", "the view is there")
    check(browser.run("return document.querySelector('#broken')") is None, "texts stay texts")
    check(browser.run("return document.querySelector('#verdict').textContent") == "a limit is broken", "the verdict")
    browser.until("document.querySelector('video').readyState >= 2", "the movie is loaded")
    # Playing moves the cursor.
    browser.click("#play")
    browser.until("clothPage.cursor.frame > 5", "playing moves the cursor")
    browser.click("#play")
    # Dragging over a curve seeks: movie, slider and view.
    left = lambda: browser.run("return parseFloat(document.querySelector('[data-measure=largest_stretch] .cursor').style.left)")
    browser.drag("[data-measure=largest_stretch] .plot", (0.3, 0.5), (0.85, 0.5))
    frame = browser.run("return clothPage.cursor.frame")
    check(28 < frame < 38, f"dragging to 85 % seeks, to frame {frame}")
    browser.until("!document.querySelector('video').seeking", "the movie has sought")
    check(browser.run("const v = document.querySelector('video'); return Math.floor(v.currentTime * arguments[0])", RATE) == frame, "the movie shows the frame")
    check(browser.run("return Number(document.querySelector('#slider').value)") == frame, "the slider shows the frame")
    there = left()
    browser.run("clothPage.cursor.set(2)")
    check(left() < there, "the cursor moves in the curves")
    # The frames worth a look are links.
    browser.click(".frames button")
    check(browser.run("return clothPage.cursor.frame") != 2, "a link seeks")
    # The view turns, follows the frames, and is coloured.
    look = lambda: browser.run("return document.querySelector('#view').toDataURL()")
    before = look()
    browser.drag("#view", (0.4, 0.5), (0.6, 0.55))
    turned = look()
    check(turned != before, "dragging turns the view")
    browser.run("clothPage.cursor.set(39)")
    fallen = look()
    check(fallen != turned, "the view follows the frames")
    browser.run("const c = document.querySelector('#field'); c.value = 0; c.dispatchEvent(new Event('change'))")
    check(look() != fallen, "the view is coloured by a field")
    browser.picture("run")
    browser.picture("run_whole", whole=True)
    check(browser.errors() == [], f"no error: {browser.errors()}")


def look_on_a_phone(browser):
    for name in ("run/report.html", "two.html"):
        browser.open(FOLDER / name, 390, 844, dark=True)
        browser.until("document.querySelector('#view').dataset.ready === 'yes'", "the view is there")
        wide = browser.run("return [document.documentElement.scrollWidth, innerWidth]")
        check(wide[0] <= wide[1], f"{name} is not wider than a phone: {wide}")
        check(browser.run("return getComputedStyle(document.body).backgroundColor") != "rgb(255, 255, 255)", "dark is dark")
        browser.picture("phone_" + pathlib.Path(name).stem, whole=True)
        check(browser.errors() == [], f"no error: {browser.errors()}")


def use_two_runs(browser):
    browser.open(FOLDER / "two.html")
    browser.until("document.querySelector('#view').dataset.ready === 'yes'", "the view is there")
    check("is the first whose state differs" in browser.run("return document.body.textContent"), "where they part is said")
    check(browser.run("return document.querySelectorAll('video').length") == 2, "both movies are there")
    browser.click("#play")
    browser.until("clothPage.cursor.frame > 3", "playing moves the cursor")
    browser.until("[...document.querySelectorAll('video')].every((v) => v.currentTime > 0.02)", "both movies play")
    browser.click("#play")
    browser.run("clothPage.cursor.set(30)")
    browser.until(f"[...document.querySelectorAll('video')].every((v) => !v.seeking && Math.floor(v.currentTime * {RATE}) === 30)",
                  "both movies have sought")
    time.sleep(0.5)
    browser.picture("two", whole=True)
    check(browser.errors() == [], f"no error: {browser.errors()}")


def use_goldens(browser):
    browser.open(FOLDER / "compared/golden.html")
    check(browser.run("return document.querySelector('#verdict').textContent") == "differ", "the verdict")
    edge = lambda: browser.run("return document.querySelector('.slider .edge').style.left")
    check(edge() == "50%", "the edge stands in the middle")
    browser.drag(".slider input", (0.5, 0.5), (0.8, 0.5))
    check(float(edge()[:-1]) > 70, "the edge can be drawn")
    browser.picture("golden", whole=True)
    check(browser.errors() == [], f"no error: {browser.errors()}")


def main():
    driver, chromium = shutil.which("chromedriver"), shutil.which("chromium")
    if not driver or not chromium:
        print("skipped: no chromedriver and chromium here (packages chromium, chromium-driver)")
        return 77
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    scene("a.toml", "[expect]\nmax_stretch = 1.0001\n")
    scene("b.toml", "[simulation]\ngravity = [0, -9.7, 0]\n[expect]\nframes = [0, 20]\n")
    program("--scene", "a.toml", "--out", "run", "--quiet", code=8)
    program("--scene", "b.toml", "--out", "other", "--quiet")
    program("report", "run", "other", "--file", "two.html")
    program("bless", "b.toml", "--golden", "g", "--out", "blessed")
    program("compare", "b.toml", "--golden", "g", "--out", "compared", "--set", "simulation.gravity=[0,-9.5,0]", code=6)
    browser = Browser(driver, chromium)
    try:
        for use in (use_a_run, use_two_runs, look_on_a_phone, use_goldens):
            use(browser)
            print(use.__name__.replace("_", " "), "good")
    finally:
        browser.close()
    return 0


sys.exit(main())
