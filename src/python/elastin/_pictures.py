"""Pictures of bodies: small ones as SVG, for notebooks, and those that turn."""

from html import escape

import numpy

WIDTH, HEIGHT, MARGIN = 260, 200, 8
MOST = 3000
# From the right above; rows are the screen's right, up, and towards the eye.
VIEW = numpy.array([[0.80, 0.60, 0.0], [-0.25, 0.33, 0.91], [0.546, -0.728, 0.415]])
TENSION, PRESSURE, FACE, LINE = "#b2182b", "#2166ac", (120, 160, 200), "#5b6b7b"


def write(path, html):
    with open(path, "w", encoding="utf8") as stream:
        stream.write(html)


class View:
    """A body in 3D, which a notebook shows: drag turns it. `html` is a page that needs no other file."""

    def __init__(self, html):
        self.html = html

    def to_html(self, path):
        """Writes it as a page."""
        write(path, self.html)

    def _repr_html_(self):
        return (f'<iframe srcdoc="{escape(self.html)}" title="the body in 3D" '
                'style="width:100%;height:690px;border:0"></iframe>')

    def __repr__(self):
        return f"<elastin.View: {len(self.html)} bytes of HTML>"


def of_body(body, positions=None, tensions=None):
    """The surface of its cells, shaded, or its connections, coloured by their tension; '' of nothing to see."""
    positions = numpy.asarray(body.positions if positions is None else positions)
    if len(positions) == 0 or not numpy.isfinite(positions).all():
        return ""
    seen = positions @ VIEW.T
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    size = numpy.maximum(high - low, 1e-300)
    scale = min((WIDTH - 2 * MARGIN) / max(size[0], 1e-9 * size[1]), (HEIGHT - 2 * MARGIN) / max(size[1], 1e-9 * size[0]))
    screen = (seen[:, :2] - (low + high) / 2) * scale * (1, -1) + (WIDTH / 2, HEIGHT / 2)
    faces = surface(body)
    drawn = shaded(faces, seen, screen) if len(faces) else lines(body, seen, screen, tensions)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
            f'viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="the body">{drawn}</svg>')


def of_result(result):
    return of_body(result.body, result.positions, result.tensions) if len(result.positions) else ""


def surface(body):
    """Triangles that bound its tetrahedra, outward; or its own."""
    tetrahedra = numpy.asarray(body.tetrahedra)
    if len(tetrahedra) == 0:
        return numpy.asarray(body.triangles)
    faces = tetrahedra[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
    _, first, count = numpy.unique(numpy.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[numpy.sort(first[count == 1])]


def shaded(faces, seen, screen):
    corners = seen[faces]
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = numpy.linalg.norm(normals, axis=1)
    light = abs(normals @ (0.3, 0.5, 0.81)) / numpy.maximum(sizes, 1e-300)
    order = numpy.argsort(corners[:, :, 2].mean(axis=1), kind="stable")
    if len(order) > MOST:  # the nearest ones are in front of the others
        order = order[-MOST:]
    parts = []
    for face in order:
        colour = "#%02x%02x%02x" % tuple(int(value * (0.45 + 0.55 * light[face])) for value in FACE)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in screen[faces[face]])
        parts.append(f'<polygon points="{points}" fill="{colour}" stroke="{colour}" stroke-width=".4"/>')
    return "".join(parts)


def lines(body, seen, screen, tensions):
    ends = numpy.asarray(body.connections)
    known = tensions is not None and len(tensions) and abs(tensions).max() > 0
    largest = abs(tensions).max() if known else 1
    order = numpy.argsort(seen[ends, 2].mean(axis=1), kind="stable")
    order = order[:: len(order) // MOST + 1]
    parts = []
    for one in order:
        (x, y), (u, v) = screen[ends[one]]
        share = tensions[one] / largest if known and one < len(tensions) else 0
        colour = LINE if abs(share) < 0.05 else TENSION if share > 0 else PRESSURE
        parts.append(f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}" stroke="{colour}" '
                     f'stroke-width="{0.6 + 0.9 * abs(share):.1f}"/>')
    if not parts:
        parts = [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2" fill="{LINE}"/>' for x, y in screen[:MOST]]
    return "".join(parts)
