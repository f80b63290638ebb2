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

    def good(self, what):
        """No error in the console, and nothing loaded from anywhere."""
        errors = [entry["message"] for entry in self.post("/se/log", {"type": "browser"}) if entry["level"] == "SEVERE"]
        check(errors == [], f"{what}: no error: {errors}")
        loaded = self.run("return performance.getEntriesByType('resource').map((e) => e.name).filter((name) => !/^(blob|data):/.test(name))")
        check(loaded == [], f"{what}: nothing is loaded: {loaded}")

    def ready(self):
        self.until("document.querySelector('#view').dataset.ready === 'yes'", "the view is there")

    def keys(self, css, text):
        element = self.post("/element", {"using": "css selector", "value": css})
        self.post(f"/element/{next(iter(element.values()))}/value", {"text": text})

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


def nearest_picture(browser, frame):
    """Which of the pictures of the frames around `frame` the movie is most like."""
    around = range(max(0, frame - 2), frame + 3)
    urls = ["data:image/png;base64," + base64.b64encode((FOLDER / f"run/frames/frame_{k:06d}.png").read_bytes()).decode()
            for k in around if (FOLDER / f"run/frames/frame_{k:06d}.png").exists()]
    differences = browser.post("/execute/async", {"script": """
        const done = arguments[arguments.length - 1];
        const video = document.querySelector('video');
        const pixels = (source, w, h) => {
          const canvas = document.createElement('canvas');
          canvas.width = w; canvas.height = h;
          const ink = canvas.getContext('2d');
          ink.drawImage(source, 0, 0, w, h);
          return ink.getImageData(0, 0, w, h).data;
        };
        const movie = pixels(video, 320, 240);
        Promise.all(arguments[0].map((url) => new Promise((good) => {
          const image = new Image();
          image.onload = () => { const p = pixels(image, 320, 240); let sum = 0; p.forEach((v, i) => { sum += Math.abs(v - movie[i]); }); good(sum); };
          image.src = url;
        }))).then(done);""", "args": [urls]})
    return around[differences.index(min(differences))]


def use_a_run(browser):
    page = FOLDER / "run/report.html"
    check(page.stat().st_size < 30e6, "the page is below 30 MB")
    browser.open(page)
    browser.ready()
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
    check(nearest_picture(browser, frame) == frame, "what the movie shows is the picture of the frame")
    check(browser.run("return Number(document.querySelector('#slider').value)") == frame, "the slider shows the frame")
    there = left()
    browser.run("clothPage.cursor.set(2)")
    check(left() < there, "the cursor moves in the curves")
    # The frames worth a look are links.
    check(browser.run("return document.querySelector('.frames a').textContent").startswith("max_stretch is broken"), "what is broken comes first")
    browser.click(".frames a")
    linked = browser.run("return clothPage.cursor.frame")
    check(linked != 2 and browser.run("return location.hash") == f"#frame={linked}", "a link seeks, and is an address")
    browser.run("location.hash = '#frame=7'")
    browser.until("clothPage.cursor.frame === 7", "an address seeks")
    # Keys play and step.
    browser.keys("body", "\ue014")
    check(browser.run("return clothPage.cursor.frame") == 8, "an arrow key steps")
    # The view turns, follows the frames, and is coloured.
    look = lambda: browser.run("return document.querySelector('#view').toDataURL()")
    before = look()
    browser.drag("#view", (0.4, 0.5), (0.6, 0.55))
    turned = look()
    check(turned != before, "dragging turns the view")
    browser.run("clothPage.cursor.set(39)")
    fallen = look()
    check(fallen != turned, "the view follows the frames")
    names = browser.run("return [...document.querySelectorAll('#field option')].map((o) => o.value)")
    check(names == ["", "stretch", "bending", "kinetic", "gap", "strain_rate"], f"what it can be coloured by: {names}")
    looks = {fallen}
    for name in names[1:]:
        browser.run("const c = document.querySelector('#field'); c.value = arguments[0]; c.dispatchEvent(new Event('change'))", name)
        looks.add(look())
    check(len(looks) == 6, "the view is coloured by each field")
    shaded = look()
    browser.click("#edges")
    check(look() != shaded, "the edges of triangles can be seen")
    browser.click("#edges")
    browser.keys("#view", "\ue012")
    check(look() != shaded, "arrow keys turn the view")
    check(browser.run("return clothPage.cursor.frame") == 39, "and do not step there")
    browser.click("#as-movie")
    back = look()
    browser.keys("#view", "\ue013")
    browser.click("#as-movie")
    check(look() == back, "the view goes back to the movie's camera")
    # Playing moves the view.
    browser.run("clothPage.cursor.set(0)")
    start = look()
    browser.click("#play")
    browser.until("clothPage.cursor.frame > 10", "it plays again")
    check(look() != start, "playing moves the view")
    browser.click("#play")
    browser.run("document.querySelector('details').open = true; clothPage.cursor.set(29)")
    browser.until("document.querySelector('[data-measure=draw] canvas').clientWidth > 100", "more curves unfold")
    browser.picture("run")
    browser.picture("run_whole", whole=True)
    browser.good("a run")


def look_on_a_phone(browser):
    for name in ("run/report.html", "two.html"):
        browser.open(FOLDER / name, 390, 844, dark=True)
        browser.ready()
        wide = browser.run("return [document.documentElement.scrollWidth, innerWidth]")
        check(wide[0] <= wide[1], f"{name} is not wider than a phone: {wide}")
        check(browser.run("return getComputedStyle(document.body).backgroundColor") != "rgb(255, 255, 255)", "dark is dark")
        browser.picture("phone_" + pathlib.Path(name).stem, whole=True)
        browser.good(name)


def use_two_runs(browser):
    browser.open(FOLDER / "two.html")
    browser.ready()
    check(browser.run("return document.querySelector('#verdict').textContent") == "they part in frame 1", "where they part is said")
    check(browser.run("return document.querySelector('#field').value") == "apart", "the view shows how far they are apart")
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
    browser.good("two runs")


def use_goldens(browser):
    browser.open(FOLDER / "compared/golden.html")
    check(browser.run("return document.querySelector('#verdict').textContent") == "differ", "the verdict")
    check(browser.run("return [...document.querySelectorAll('tbody tr')].slice(0, 2).map((r) => r.children[1].textContent)") == ["same", "differs"], "the table")
    check(browser.run("return [...document.querySelectorAll('#golden-20 figure')].length") == 2, "before and after, and their difference")
    edge = lambda: browser.run("return document.querySelector('.slider .edge').style.left")
    check(edge() == "50%", "the edge stands in the middle")
    browser.drag(".slider input", (0.5, 0.5), (0.8, 0.5))
    check(float(edge()[:-1]) > 70, "the edge can be drawn")
    browser.picture("golden", whole=True)
    browser.good("goldens")


def look_at_a_large_run(browser):
    """300 frames of 6,400 vertices, and a movie without loss under a camera that turns."""
    page = FOLDER / "large/report.html"
    check(2e6 < page.stat().st_size < 30e6, f"300 frames are below 30 MB: {page.stat().st_size / 1e6:.1f} MB")
    browser.open(page)
    browser.ready()
    check("frame is here, so that the page stays small" in browser.run("return document.body.textContent"), "it says what is left out")
    browser.run("clothPage.cursor.set(299)")
    browser.until("!document.querySelector('video').seeking", "the movie has sought")
    browser.good("300 frames")


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
    (FOLDER / "large.toml").write_text('version = 1\n[simulation]\nintegrator = "linearly_implicit_euler"\n'
                                       'contact = "velocity_filter"\n[[cloth]]\nresolution = 80\nrotate = [-90, 0, 0]\nfabric.strain_limit = 0\n'
                                       "[output]\nframes = 300\nsize = [480, 270]\nquality = 0\n[camera]\n"
                                       "turntable = 40\n[[pin]]\nnearest = [-0.5, 0, -0.5]\n[[pin]]\nnearest = [0.5, 0, -0.5]\n")
    program("--scene", "large.toml", "--out", "large", "--quiet")
    browser = Browser(driver, chromium)
    try:
        for use in (use_a_run, use_two_runs, look_on_a_phone, use_goldens, look_at_a_large_run):
            use(browser)
            print(use.__name__.replace("_", " "), "good")
    finally:
        browser.close()
    return 0


sys.exit(main())
