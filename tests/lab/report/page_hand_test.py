"""A visitor's hand on the page that `compare --out` leaves: real events of a mouse, by Chromium's own protocol.

usage: page_hand_test.py ELASTIN; exits with 77 where there is no Chromium.
"""
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

from chromium import Page, find_chromium

SCENE = """title: Block under the hand
body:
  lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 1 mm, connections: [axis, face]}
  cells: delaunay
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.25}
stiffness: lattice
strategies: [standard, lattice, neo_hookean, neo_hookean_membrane, "calibrated:standard"]
experiment: {kind: tension, axis: z, displacement: 0.3 mm, load_steps: 3}
"""
BAR = """title: Bar of hexahedra
body:
  lattice: {kind: cubic, molecules: [4, 4, 4], spacing: 1 mm, order: 1}
material: {youngs_modulus: 5 kPa, poissons_ratio: 0.25}
stiffness: neo_hookean
experiment: {kind: tension, axis: z, displacement: 0.3 mm}
"""
MARK = "document.querySelectorAll('figure')[1].querySelector('svg.wide .series[data-series=\"%s\"] > :last-child')"
UNITS = {"Pa": 1, "kPa": 1e3, "mPa": 1e-3, "%": 0.01}


def number(text):
    value, unit = re.match(r"([-\d.e]+) ?(\S+)", text).groups()
    return float(value) * UNITS[unit]


# How many pixels a viewer covers.
PIXELS = ("(() => { const v = %s; v.draw(); const {width, height} = v.canvas, paper = Object.assign(document.createElement('canvas'), "
          "{width, height}).getContext('2d'); paper.drawImage(v.canvas, 0, 0); const p = paper.getImageData(0, 0, width, height).data; "
          "let n = 0; for (let i = 3; i < p.length; i += 4) n += p[i] > 0; return n; })()")


class Hand(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        cls.out = cls.folder.name + "/out"
        scene = cls.folder.name + "/block.yaml"
        with open(scene, "w", encoding="utf8") as file:
            file.write(SCENE)
        subprocess.run([ELASTIN, "compare", scene, "--quiet", "--out", cls.out], check=True)
        cls.page = Page(CHROMIUM, cls.folder.name + "/profile").__enter__()
        cls.page.open(cls.out + "/report.html")

    @classmethod
    def tearDownClass(cls):
        errors = cls.page.run("document.documentElement.dataset.errors ?? ''")
        cls.page.__exit__()
        cls.folder.cleanup()
        if errors:
            raise AssertionError(f"errors on the page: {errors}")

    def setUp(self):
        self.page.run("document.querySelectorAll('[data-zoom=reset]').forEach(button => button.click())")

    def mark(self, strategy):
        """Place of the last point of a strategy's response curve."""
        return self.page.place(MARK % strategy)

    def tip(self):
        return self.page.run("getComputedStyle(document.getElementById('tip')).visibility === 'visible' "
                             "? document.getElementById('tip').textContent : ''")

    def test_the_crosshair_reads_the_values_of_the_curve(self):
        x, y = self.mark("lattice")
        self.page.hover(x + 3, y - 2)  # near is near enough
        strain, stress = re.search(r"strain (\S+ %), nominal stress (\S+ \S+)$", self.tip()).groups()
        with open(self.out + "/block-lattice-curve.csv", encoding="utf8") as file:
            last = list(csv.DictReader(file))[-1]
        self.assertAlmostEqual(number(strain) / float(last["strain"]), 1, delta=1e-3)  # four digits are shown
        self.assertAlmostEqual(number(stress) / float(last["stress [Pa]"]), 1, delta=1e-3)
        cross = self.page.run("(() => { const c = document.querySelectorAll('figure')[1].querySelector('svg.wide .cross'), "
                              "b = c.getBoundingClientRect(), l = c.ownerSVGElement.dataset.box.split(' ').map(Number); "
                              "return [c.style.visibility, c.getAttribute('d')]; })()")
        self.assertEqual(cross[0], "visible")
        self.page.hover(5, 5)
        self.assertEqual(self.tip(), "")

    def test_a_box_zooms_and_a_double_click_goes_back(self):
        view = "document.querySelectorAll('figure')[1].querySelector('svg.wide')"
        inner = (MARK % "neo_hookean").replace(":last-child", ":nth-last-child(2)")
        x, y = self.page.place(inner)
        left, top = round(x) - 60, round(y) - 60  # a mouse is at whole pixels
        labels = f"[...{view}.querySelectorAll('.ticks text')].map(t => t.textContent)"
        before = self.page.run(labels)
        self.page.drag(left, top, left + 80, top + 80)
        zoomed = self.page.run(labels)
        self.assertNotEqual(before, zoomed)
        # Where the point stood in the box, it stands in the whole plot now.
        box = self.page.run(f"(() => {{ const v = {view}, m = v.getScreenCTM(), b = v.dataset.box.split(' ').map(Number); "
                            "const p = (x, y) => { const q = new DOMPoint(x, y).matrixTransform(m); return [q.x, q.y]; }; "
                            "return [...p(b[0], b[1]), ...p(b[2], b[3])]; })()")
        now = self.page.run(f"(() => {{ const b = ({inner}).getBoundingClientRect(); "
                            "return [b.x + b.width / 2, b.y + b.height / 2]; })()")
        self.assertAlmostEqual((now[0] - box[0]) / (box[2] - box[0]), (x - left) / 80, delta=0.01)
        self.assertAlmostEqual((now[1] - box[1]) / (box[3] - box[1]), (y - top) / 80, delta=0.01)
        self.assertFalse(self.page.run("document.querySelectorAll('[data-zoom=reset]')[1].hidden"))
        self.page.click(*self.page.place(view), times=2)
        self.assertEqual(self.page.run(labels), before)

    def test_the_legend_switches_a_series_off_in_all_plots(self):
        shown = "[...document.querySelectorAll('svg.wide .series[data-series=standard]')].map(s => getComputedStyle(s).display)"
        key = "document.querySelector('svg.wide .key[data-series=standard]')"
        self.page.click(*self.page.place(key))
        self.assertEqual(self.page.run(shown), ["none"] * 3)  # error, stress–strain, force over elongation
        self.assertEqual(self.page.run(key + ".getAttribute('aria-pressed')"), "false")
        self.page.click(*self.page.place(key))
        self.assertEqual(self.page.run(shown), ["inline"] * 3)

    def test_a_click_on_a_curve_shows_its_body(self):
        for strategy in ("standard", "neo_hookean"):
            self.page.click(*self.mark(strategy))
            self.assertEqual(self.page.run("document.querySelector('[data-part=strategy]').value"), strategy)
            self.assertEqual(self.page.run("document.querySelector('tr.chosen').dataset.series"), strategy)

    def test_molecules_and_cells_are_picked_and_read(self):
        stage = "document.querySelector('.scene').stage"
        box = ("(name, on) => { const b = %s.part(name); if (b.checked !== on) b.click(); }" % stage)
        self.page.run(f"(({box}))('molecules', true), (({box}))('surface', false), {stage}.viewer.reset(), {stage}.viewer.draw(), 0")
        self.page.place(f"{stage}.canvas")
        # The corner (3, 0, 3) mm is the nearest to the eye of a cube seen from the front, the left and above, or close.
        x, y, molecule = self.page.run(
            f"(() => {{ const s = {stage}, v = s.viewer, eye = v.camera.position, b = s.canvas.getBoundingClientRect(); "
            "const place = m => new THREE.Vector3(...v.positions.slice(3 * m, 3 * m + 3)); "
            "const m = [...s.body.radius.keys()].sort((a, b) => eye.distanceTo(place(a)) - eye.distanceTo(place(b)))[0]; "
            "const p = place(m).project(v.camera); "
            "return [b.x + (p.x + 1) / 2 * b.width, b.y + (1 - p.y) / 2 * b.height, m]; })()")
        self.page.click(x, y)
        rest = [molecule % 4, molecule // 4 % 4, molecule // 16]  # in mm: a lattice numbers along x, y, z
        text = self.page.run(f"{stage}.part('picked').textContent")
        told = re.search(rf"^Molecule {molecule}: at rest \(([^)]*)\)", text)
        self.assertIsNotNone(told, text)
        self.assertEqual([float(place.split(" ")[0]) for place in told[1].split(", ")], rest)
        self.page.run(f"(({box}))('molecules', false), (({box}))('connections', false), (({box}))('surface', true), 0")
        self.page.click(*self.page.place(f"{stage}.canvas"))
        self.assertRegex(self.page.run(f"{stage}.part('picked').textContent"), r"^Cell \d+, side of molecules .*strain .* %; von Mises stress")
        self.page.run(f"(({box}))('molecules', true), (({box}))('connections', true), 0")

    def test_play_becomes_pause_and_stops(self):
        play = "document.querySelector('[data-part=play]')"
        step = "+document.querySelector('[data-part=step]').value"
        self.page.run("(() => { const s = document.querySelector('[data-part=step]'); s.value = 0; s.dispatchEvent(new Event('input')); })()")
        # Stopped at once in the page, so that a slow machine does not play to the end meanwhile.
        seen = self.page.run(
            f"new Promise(done => {{ const play = {play}, step = document.querySelector('[data-part=step]'), seen = []; play.click(); "
            "const note = () => seen.push(play.getAttribute('aria-label'), +step.value); note(); "
            "const wait = () => { if (+step.value <= 0.02) return requestAnimationFrame(wait); note(); play.click(); note(); "
            "setTimeout(() => { note(); done(seen); }, 300); }; wait(); })")
        self.assertEqual(seen[0::2], ["pause", "pause", "play", "play"])
        self.assertTrue(seen[1] < seen[3] == seen[5] == seen[7])
        self.page.click(*self.page.place(play))
        self.page.wait(play + ".getAttribute('aria-label') === 'play'")
        self.assertEqual(self.page.run(f"{step} === +document.querySelector('[data-part=step]').max"), True)

    def test_fields_have_a_range_that_can_be_typed(self):
        stage = "document.querySelector('.scene').stage"
        self.page.run(f"{stage}.choose_strategy('neo_hookean')")
        self.page.run("(() => { const c = document.querySelector('[data-part=colour]'); c.value = 'stress'; c.dispatchEvent(new Event('change')); })()")
        self.assertEqual(self.page.run(f"{stage}.part('title').textContent"), "von Mises stress")
        self.assertTrue(self.page.run(f"{stage}.part('surface').checked"))
        high = number(self.page.run(f"{stage}.part('high').value"))
        self.assertGreater(high, 0)
        low = self.page.run(f"(() => {{ const p = {stage}.part('low'), q = {stage}.part('high'); p.value = '100 Pa'; q.value = '1 kPa'; "
                            f"q.dispatchEvent(new Event('change')); return {stage}.range(); }})()")
        self.assertEqual((low["low"], low["high"]), (100, 1000))
        self.page.run(f"(() => {{ const q = {stage}.part('high'); q.value = ''; q.dispatchEvent(new Event('change')); }})()")
        self.assertAlmostEqual(number(self.page.run(f"{stage}.part('high').value")), high, delta=1e-3 * high)

    def test_a_cut_takes_away_what_lies_before_it(self):
        stage = "document.querySelector('.scene').stage"
        pixels = PIXELS % f"{stage}.viewer"
        cut = (f"(() => {{ const c = {stage}.part('cut'); c.value = '%s'; c.dispatchEvent(new Event('change')); }})()")
        whole = self.page.run(pixels)
        self.page.run(cut % "z")
        self.assertLess(self.page.run(pixels), 0.8 * whole)
        self.page.run(cut % "")
        self.assertEqual(self.page.run(pixels), whole)

    def test_runs_are_filtered_by_outcome_and_name(self):
        shown = "[...document.querySelectorAll('tr[data-outcome]')].filter(r => !r.hidden).map(r => r.dataset.series)"
        choose = "(() => { const s = document.querySelector('[data-filter=outcome]'); s.value = '%s'; s.dispatchEvent(new Event('change')); })()"
        self.page.run(choose % "not suited")
        self.assertEqual(self.page.run(shown), ["neo_hookean_membrane"])
        self.assertEqual(self.page.run("document.querySelector('[data-filter=count]').textContent"), "1 of 5 runs")
        self.page.run(choose % "")
        self.page.click(*self.page.place("document.querySelector('[data-filter=text]')"))
        self.page.send("Input.insertText", text="STANDARD")
        self.assertEqual(sorted(self.page.run(shown)), ["calibrated:standard", "standard"])
        self.page.run("(() => { const s = document.querySelector('[data-filter=text]'); s.value = ''; s.dispatchEvent(new Event('input')); })()")
        self.assertEqual(len(self.page.run(shown)), 5)

    def test_a_phone_shows_the_errors(self):
        self.page.resize(390, 800)
        try:
            right = self.page.run("[...document.querySelectorAll('th')].find(h => /error/.test(h.textContent)).getBoundingClientRect().right")
            self.assertLess(right, 390)
            self.assertLessEqual(self.page.run("document.documentElement.scrollWidth"), 390)
        finally:
            self.page.resize(1400, 1000)


class Layout(unittest.TestCase):
    HIDE = "addEventListener('DOMContentLoaded', () => { document.querySelector('.view').style.display = 'none'; })"
    VIEWER = "document.querySelector('.scene').stage.viewer"
    PIXELS = PIXELS % VIEWER

    def test_a_body_is_drawn_that_has_no_size_or_a_lost_camera_at_first(self):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            scene = folder + "/bar.yaml"
            with open(scene, "w", encoding="utf8") as file:
                file.write(BAR)
            subprocess.run([ELASTIN, "run", scene, "--quiet", "--out", folder], check=True)
            with Page(CHROMIUM, folder + "/profile") as page:
                page.send("Page.enable")
                page.send("Page.addScriptToEvaluateOnNewDocument", source=self.HIDE)
                page.open(folder + "/report.html")
                self.assertEqual(page.run(self.VIEWER + ".canvas.clientHeight"), 0)
                page.run("document.querySelector('.view').style.display = ''")
                page.wait(f"Number.isFinite({self.VIEWER}.camera.position.length()) && {self.VIEWER}.middle !== undefined")
                seen = page.run(self.PIXELS)
                self.assertGreater(seen, 1000)
                page.run(self.VIEWER + ".camera.position.set(NaN, NaN, NaN), 0")
                self.assertEqual(page.run(self.PIXELS), seen)
                page.run(self.VIEWER + ".positions[0] = NaN, " + self.VIEWER + ".reset(), 0")
                self.assertGreater(page.run(self.PIXELS), 1000)
                self.assertEqual(page.run("document.documentElement.dataset.errors ?? ''"), "")


class Run(unittest.TestCase):
    def test_run_leaves_a_page_with_the_stress_of_its_cells(self):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            scene = folder + "/bar.yaml"
            with open(scene, "w", encoding="utf8") as file:
                file.write(BAR)
            subprocess.run([ELASTIN, "run", scene, "--quiet", "--out", folder], check=True)
            with open(folder + "/runs.json", encoding="utf8") as file:
                measures = json.load(file)["runs"][0]["measures"]
            # Uniaxial tension: von Mises' stress is Cauchy's, the force over the area that is left.
            wanted = measures["stress"] / (1 - measures["poissons_ratio"] * measures["strain"]) ** 2
            with Page(CHROMIUM, folder + "/profile") as page:
                page.open(folder + "/report.html")
                stresses = page.run("[...document.querySelector('.scene').stage.runs.values()][0].frames.at(-1).stresses.reduce("
                                    "([low, high], s) => [Math.min(low, s), Math.max(high, s)], [Infinity, 0])")
            for stress in stresses:
                self.assertAlmostEqual(stress / wanted, 1, delta=1e-3)  # stresses are stored in steps of 2^-12


class Modes(unittest.TestCase):
    def test_the_slider_goes_from_mode_to_mode(self):
        """Each mode by its number and frequency, its largest displacement a tenth of the body's size; no stress of rounding."""
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            scene = folder + "/bar.yaml"
            with open(scene, "w", encoding="utf8") as file:
                file.write(re.sub("material: {", "material: {density: 1000 kg/m3, ", re.sub(
                    "experiment: .*", "experiment: {kind: vibration, count: 3, fixture: {kind: tension, axis: z, force: 1 N}}", BAR)))
            subprocess.run([ELASTIN, "run", scene, "--quiet", "--out", folder], check=True)
            with open(folder + "/runs.json", encoding="utf8") as file:
                measures = json.load(file)["runs"][0]["measures"]
            with Page(CHROMIUM, folder + "/profile") as page:
                page.open(folder + "/report.html")
                stage = "document.querySelector('.scene').stage"
                texts = page.run(f"[0, 1, 2, 3].map(step => {{ {stage}.part('step').value = step; {stage}.show(); return {stage}.part('at').textContent; }})")
                longest = page.run(f"Math.max(...lengths_of({stage}.state.displacements)) / {stage}.body.size")
                colours = page.run(f"[...{stage}.part('colour').options].map(option => option.value)")
                self.assertEqual(page.run("document.documentElement.dataset.errors ?? ''"), "")
        self.assertEqual(texts[0], "without vibration")
        for mode in (1, 2, 3):
            number, count, frequency, unit = re.match(r"mode (\d) of (\d), ([\d.]+) (\w+)$", texts[mode]).groups()
            self.assertEqual((number, count, unit), (str(mode), "3", "Hz"))
            self.assertAlmostEqual(float(frequency) / measures[f"frequency_{mode}"], 1, delta=0.01)
        self.assertAlmostEqual(longest, 0.1, delta=1e-4)
        self.assertEqual(colours, ["strain", "displacement"] + (["error"] if "error" in colours else []))


class Obstacles(unittest.TestCase):
    def test_obstacles_are_drawn_where_they_are(self):
        """Every shape: as far from its middle as it is large, and a plane's square in the plane."""
        shapes = {"sphere: {radius: 3 mm}": 3e-3, "box: {size: [4 mm, 4 mm, 2 mm]}": 3e-3,
                  "cylinder: {radius: 3 mm, length: 8 mm}": 5e-3, "capsule: {radius: 1 mm, length: 8 mm}": 5e-3}
        obstacles = "".join(f"    - {{name: thing{i}, {shape}, at: [{20 * i} mm, -20 mm, 1 mm]}}\n" for i, shape in enumerate(shapes))
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            with open(folder + "/bar.yaml", "w", encoding="utf8") as file:
                file.write(BAR + "contact:\n  obstacles:\n" + obstacles +
                           "    - {name: floor, plane: {point: [0 mm, 0 mm, -1 mm], normal: [0, 0, 1]}}\n")
            subprocess.run([ELASTIN, "run", folder + "/bar.yaml", "--quiet", "--out", folder], check=True)
            with Page(CHROMIUM, folder + "/profile") as page:
                page.open(folder + "/report.html")
                stage = "document.querySelector('.scene').stage"
                reach = page.run(f"(() => {{ const s = {stage}, pose = i => s.state[`pose ${{i}}`]; "
                                 "return s.body.obstacles.map(({lines}, i) => { const at = lines_in_space(lines, pose(i)); let r = 0; "
                                 "for (let k = 0; k < at.length; k += 3) r = Math.max(r, Math.hypot(at[k] - pose(i)[9], "
                                 "at[k + 1] - pose(i)[10], at[k + 2] - pose(i)[11])); "
                                 "return [r, pose(i)[9], Math.max(...at.filter((_, k) => k % 3 === 2))]; }); })()")
                drawn = f"{stage}.viewer.painter.lines.length"
                self.assertGreater(page.run(drawn), 0)
                page.run(f"{stage}.part('scale').append(new Option('5', 5)), {stage}.part('scale').value = 5, {stage}.aim(), 0")
                self.assertEqual(page.run(drawn), 0)  # enlarged, the body would not meet them
                self.assertEqual(page.run("document.documentElement.dataset.errors ?? ''"), "")
        for i, wanted in enumerate(shapes.values()):
            self.assertAlmostEqual(reach[i][0] / wanted, 1, delta=0.01)
            self.assertAlmostEqual(reach[i][1], 20e-3 * i, delta=1e-6)
        self.assertAlmostEqual(reach[-1][2], -1e-3, delta=1e-7)


class Kinds(unittest.TestCase):
    """Every kind of page opens without a word on the console, shows its plots, sorts its tables and says what it is of."""

    STEPPERS = SCENE + "steppers: {methods: [symplectic_euler, backward_euler]}\n"
    STUDY = SCENE + "study: {vary: [{body.lattice.spacing: [1 mm, 2 mm]}]}\n"
    IDENTIFY = """title: Rubber
material: {law: mooney_rivlin, c1: 100 kPa, c2: 10 kPa}
identify:
  tests: [{name: pull, kind: uniaxial, file: pull.csv}]
"""

    def check(self, folder, page, command, name):
        subprocess.run([ELASTIN, *command, "--quiet", "--out", folder + "/out"], check=True, cwd=folder,
                       stdout=subprocess.DEVNULL)
        said = page.listen()
        for width in (1400, 390):
            page.resize(width, 1000)
            page.open(folder + "/out/" + name)
            for head in range(page.run("document.querySelectorAll('thead button').length")):
                page.run(f"document.querySelectorAll('thead button')[{head}].click()")
            self.assertGreater(page.run("document.querySelectorAll('.plot').length"), 0)
            self.assertLessEqual(page.run("document.documentElement.scrollWidth"), width)
            # Heads that say nothing, and what scrolls but takes no keys, shut out who cannot use a mouse.
            self.assertEqual(page.run("document.querySelectorAll('th:empty, .scroll:not([tabindex])').length"), 0)
            self.assertEqual(page.run("[...document.querySelectorAll('[data-save=svg]')].filter(b => !b.closest('[hidden]')).every("
                                      "b => b.closest('.card').querySelector('svg') || b.closest('.card').querySelector('.view'))"), True)
            self.assertEqual(page.run("document.documentElement.dataset.errors ?? ''"), "")
            self.assertRegex(page.run("document.getElementById('made').textContent"),
                             r"^Elastin \d+\.\d+\.\d+(, commit [0-9a-f]{12})?, \d{4}-\d\d-\d\d \d\d:\d\d UTC; .*cores")
        self.assertEqual(said(), [])

    def test_every_kind(self):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            for name, text in (("block", SCENE), ("second", SCENE), ("bar", BAR), ("steps", self.STEPPERS), ("study", self.STUDY),
                               ("rubber", self.IDENTIFY)):
                with open(f"{folder}/{name}.yaml", "w", encoding="utf8") as file:
                    file.write(text.replace("title: ", "title: " + 12 * "A_name_without_a_blank_"))
            with open(folder + "/pull.csv", "w", encoding="utf8") as file:
                file.write("nominal_strain,nominal_stress [kPa]\n")
                for step in range(1, 13):  # incompressible Mooney-Rivlin, c1 = 100 kPa, c2 = 10 kPa
                    stretch = 1 + 0.05 * step
                    file.write(f"{stretch - 1},{2 * (stretch - stretch ** -2) * (100 + 10 / stretch)}\n")
            with Page(CHROMIUM, folder + "/profile") as page:
                for command, name in ((["compare", "block.yaml", "second.yaml"], "report.html"),
                                      (["run", "bar.yaml"], "report.html"), (["compare", "study.yaml"], "report.html"),
                                      (["compare", "steps.yaml"], "steppers.html"), (["identify", "rubber.yaml"], "report.html")):
                    with self.subTest(command=command):
                        self.check(folder, page, command, name)
                page.open(folder + "/out/report.html")

    def test_a_page_is_a_record_of_its_scene_and_is_printed_whole(self):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            for name in ("block", "second"):
                with open(f"{folder}/{name}.yaml", "w", encoding="utf8") as file:
                    file.write(SCENE)
            subprocess.run([ELASTIN, "compare", "block.yaml", "second.yaml", "--quiet", "--out", "out"], check=True, cwd=folder)
            with Page(CHROMIUM, folder + "/profile") as page:
                page.open(folder + "/out/report.html")
                self.assertIn("molecules: [4, 4, 4]", page.run("[...document.querySelectorAll('details pre')].at(-1).textContent"))
                page.send("Emulation.setEmulatedMedia", media="print")
                page.run("dispatchEvent(new Event('beforeprint'))")
                self.assertTrue(page.run("[...document.querySelectorAll('.scene, details')].every(e => e.getClientRects().length && "
                                         "e.open !== false)"))
                page.resize(760, 1000)  # of A4
                self.assertEqual(page.run("[...document.querySelectorAll('table')].filter(t => t.getBoundingClientRect().right > "
                                          "innerWidth + 1).length"), 0)


class Size(unittest.TestCase):
    def test_a_thousand_molecules_with_all_strategies_fit_into_a_megabyte(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = folder + "/cube.yaml"
            with open(scene, "w", encoding="utf8") as file:
                file.write(SCENE.replace("[4, 4, 4]", "[10, 10, 10]"))
            subprocess.run([ELASTIN, "compare", scene, "--strategies", "standard,lattice,patch,neo_hookean,van_gelder,lloyd",
                            "--quiet", "--out", folder], check=True)
            self.assertLess(os.path.getsize(folder + "/report.html"), 1_000_000)


if __name__ == "__main__":
    ELASTIN = os.path.abspath(sys.argv.pop(1))
    CHROMIUM = find_chromium()
    if not CHROMIUM:
        print("no Chromium here: the page was not tried")
        sys.exit(77)
    unittest.main()
