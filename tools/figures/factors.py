"""The stencils of dual schemes step by step. A point is its control points' weights and where it lies in the plane."""
import cmath
import math

from PIL import Image

import models
from sheet import BLUE, GREY, INK, ORANGE, PALE, RED, Plane


class Point:
    def __init__(self, terms, place):
        self.terms, self.place = terms, place

    @staticmethod
    def mix(parts):
        """Of (point, weight)."""
        terms = {}
        for point, weight in parts:
            for v, w in point.terms.items():
                terms[v] = terms.get(v, 0) + weight * w
        return Point({v: w for v, w in terms.items() if abs(w) > 1e-12}, sum(weight * point.place for point, weight in parts))


def mean(points):
    return Point.mix([(p, 1 / len(points)) for p in points])


def fraction(x):
    for d in (1, 2, 3, 4, 5, 6, 8, 16, 20, 32, 40, 64, 80, 128, 160, 256, 320, 640, 1280):
        if abs(x * d - round(x * d)) < 1e-9:
            return f"{round(x * d)}/{d}" if d > 1 else f"{round(x)}"
    return f"{x:.3f}"


class Drawing:
    """Places of one block: the same window for all steps."""

    def __init__(self, size, reach, centre, control):
        self.size, self.reach, self.centre, self.control = size, reach, centre, control

    def picture(self, parts, new, mesh):
        """@param mesh  faces as lists of places"""
        p = Plane((self.size, self.size), (self.centre.real - self.reach, self.centre.imag - self.reach), (self.centre.real + self.reach, self.centre.imag + self.reach))
        at = lambda z: (z.real, z.imag)
        for f in self.control:
            p.line([at(z) for z in f], PALE, 2.4, closed=True)
        for f in mesh:
            p.line([at(z) for z in f], GREY, 1.2, closed=True)
        most = max(abs(w) for _, w in parts)
        for place, w in parts:
            p.dot(at(place), BLUE if w > 0 else ORANGE, 3 + 4 * math.sqrt(abs(w) / most))
        p.ring(at(new), RED, 9, 2)
        taken = [(p.pixel(at(place)), (8, 8)) for place, _ in parts] + [(p.pixel(at(new)), (10, 10))]
        for place, w in parts:
            label(p, at(place), fraction(w), taken)
        return p.picture()


def label(p, place, text, taken):
    """Below its dot, or above or beside it where that covers something. @param taken  middles and half sizes, pixels"""
    x, y = p.pixel(place)
    half = (4 + 4 * len(text), 8)
    best = None
    for dx, dy in ((0, 19), (0, -19), (half[0] + 10, 0), (-half[0] - 10, 0), (half[0], 16), (-half[0], 16), (half[0], -16), (-half[0], -16)):
        cx, cy = x + dx, y + dy
        if not (half[0] < cx < p.size[0] - half[0] and half[1] < cy < p.size[1] - half[1]):
            continue
        covered = sum(max(0, half[0] + w - abs(cx - mx)) * max(0, half[1] + h - abs(cy - my)) for (mx, my), (w, h) in taken)
        if best is None or covered < best[0]:
            best = (covered, dx, dy)
    _, dx, dy = best
    taken.append(((x + dx, y + dy), half))
    p.text(place, text, INK, 12, (dx, dy))


def checked(make, product, points, faces, scheme, option=None):
    """What the program's own step makes of unit heights at the same place."""
    fine, _ = make.refine(make.obj("_plane", points, faces), scheme, 1, option, keep=False)
    target = min(range(len(fine)), key=lambda i: abs(complex(*fine[i][:2]) - product.place))
    assert abs(complex(*fine[target][:2]) - product.place) < 1e-6, (scheme, "another place")
    for v in range(len(points)):
        raised = [(x, y, 1.0 if i == v else 0.0) for i, (x, y, _) in enumerate(points)]
        weight = make.refine(make.obj("_unit", raised, faces), scheme, 1, option, keep=False)[0][target][2]
        assert abs(weight - product.terms.get(v, 0)) < 1e-9, (scheme, option, v, weight, product.terms.get(v, 0))


def modes(k, mode, share):
    """Weights of the k midpoints around a corner, from the eigenvalues of Fourier modes 0, 1, ...: a corner's share
    aside, since midpoints scale mode m by cos(pi m / k) and turn it by half a step."""
    weights = []
    for i in range(k):
        w = (mode(0) - share) / k
        for m in range(1, (k + 1) // 2):
            w += 2 * (mode(m) - share) / math.cos(math.pi * m / k) * math.cos(2 * math.pi * m * (i + 0.5) / k) / k
        weights.append(w)
    return weights


def factor_rows(make, size):
    """Pictures and captions, six to a row: three steps of the regular face and of the 5-gon, then the longer products."""
    rows = []
    settings = []
    for k in (4, 5):
        turn = cmath.rect(1, math.radians(45 if k == 4 else 18))
        plane, faces = models.face_fan(k, 1)
        plane = [complex(x, y) * turn for x, y, _ in plane]
        control = [[plane[v] for v in f] for f in faces]
        points = [(z.real, z.imag, 0.0) for z in plane]
        corners = [Point({v: 1}, plane[v]) for v in range(k)]
        reach = 1.25 * abs(plane[0])
        settings.append((k, "regular" if k == 4 else "5-gon", points, faces, control, corners, Drawing(size, reach, 0j, control)))

    def pictures(parts, new, drawing, mesh):
        return drawing.picture([(p.place, w) for p, w in parts], new.place, mesh)

    for scheme, title in (("doo-sabin", "Doo-Sabin"), ("midedge-simplest", "midedge (Peters, Reif)"), ("midedge", "midedge (Habib, Warren)")):
        for k, at, points, faces, control, corners, drawing in settings:
            mids = [mean([corners[i], corners[(i + 1) % k]]) for i in range(k)]
            # The block, cut at the midpoints; Doo and Sabin's step sees its centre, too.
            blocks = [[c.place for c in corners]] + ([[mids[i].place, 0j] for i in range(k)] if scheme == "doo-sabin" else [[m.place for m in mids]])
            first = [(corners[0], 0.5), (corners[1], 0.5)]
            if scheme == "doo-sabin":
                share = 0.25
                weights = modes(k, lambda m: 1 if m == 0 else 0.5 if m == 1 else 0.25, share)
                # What all midpoints have in common is a weight of the centre, their mean.
                common = sorted(weights)[0] if k == 4 else 0.0
                parts = [(corners[0], share)] + [(mids[i], w - common) for i, w in enumerate(weights)] + [(mean(corners), k * common)]
                texts = ("midpoints of the edges", "then a corner of the block from\nits old place, midpoints" + (" and centre" if k == 4 else ", all of them"))
            elif scheme == "midedge-simplest":
                parts = [(mids[0], 0.5), (mids[k - 1], 0.5)]
                texts = ("round 1: midpoints of the edges", "round 2: midpoints of\nwhat round 1 has joined")
            else:
                parts = list(zip(mids, modes(k, lambda m: 2.0 ** -m, 0.0)))
                texts = ("round 1: midpoints of the edges", "round 2: from all midpoints,\nso that the subdominant is 1/2")
            parts = [(p, w) for p, w in parts if abs(w) > 1e-12]
            product = Point.mix(parts)
            checked(make, product, points, faces, scheme)
            rows.append((pictures(first, mids[0], drawing, [[c.place for c in corners]]), f"{title}, {at}\n{texts[0]}"))
            rows.append((pictures(parts, product, drawing, blocks), f"{title}, {at}\n{texts[1]}"))
            rows.append((pictures([(corners[v], w) for v, w in product.terms.items()], product, drawing, []), f"{title}, {at}\nthe product of the two" + ("\n(Doo and Sabin's, at 5-gons)" if scheme == "midedge" and k == 5 else "")))

    for k, at, _, _, _, _, _ in settings:
        rows += averaging_row(make, size, k, at)
    return rows


def averaging_row(make, size, k, at):
    points, faces = models.face_fan(k, 2)
    turn = cmath.rect(1, math.radians(45 if k == 4 else 18))
    plane = [complex(x, y) * turn for x, y, _ in points]
    points = [(z.real, z.imag, 0.0) for z in plane]
    vertex = [Point({v: 1}, z) for v, z in enumerate(plane)]
    # Bilinear: faces' centres, edges' midpoints and the vertices themselves; each corner of a face becomes a quad.
    centre = [mean([vertex[v] for v in f]) for f in faces]
    middle = lambda a, b: mean([vertex[a], vertex[b]])
    mesh = []
    for c, f in zip(centre, faces):
        for i, v in enumerate(f):
            mesh.append([c, middle(v, f[(i + 1) % len(f)]), vertex[v], middle(f[i - 1], v)])
    split = [[p.place for p in q] for q in mesh]
    near = lambda p, q: abs(p.place - q.place) < 1e-9

    def averaged(mesh):
        """The means of the faces, joined around the inner points of the mesh, counter-clockwise."""
        means = [mean(f) for f in mesh]
        around = {}
        for m, f in zip(means, mesh):
            for p in f:
                around.setdefault((round(p.place.real, 6), round(p.place.imag, 6)), (p, []))[1].append(m)
        result = []
        for p, ring in around.values():
            ring.sort(key=lambda m: cmath.phase(m.place - p.place))
            gaps = [cmath.phase((b.place - p.place) / (a.place - p.place)) % (2 * math.pi) for a, b in zip(ring, ring[1:] + ring[:1])]
            if len(ring) > 2 and max(gaps) < 0.9 * math.pi:
                result.append(ring)
        return result

    meshes = [mesh]
    for _ in range(2):
        meshes.append(averaged(meshes[-1]))
    v0 = plane[0]
    # The child of corner 0 in the face of k corners.
    goal = 0.5 * v0
    nearest = lambda faces, z: min(faces, key=lambda f: abs(mean(f).place - z))
    quad = nearest(meshes[0], goal)
    first = mean(quad)
    ring = nearest(meshes[1], 0j)
    second = mean(ring)
    last_quad = nearest(meshes[2], goal)
    last = mean(last_quad)
    product = last
    control = [[plane[v] for v in f] for f in faces]
    inner = Drawing(size, 1.3 * abs(v0), 0j, control)
    # The product reaches one ring further.
    used = [plane[v] for v in product.terms]
    low = complex(min(z.real for z in used), min(z.imag for z in used))
    high = complex(max(z.real for z in used), max(z.imag for z in used))
    outer = Drawing(size, 0.5 * max((high - low).real, (high - low).imag) + 0.3, 0.5 * (low + high), control)
    checked(make, first, points, faces, "averaging", 1)
    checked(make, product, points, faces, "averaging", 3)
    places = lambda mesh: [[p.place for p in f] for f in mesh]
    corner_parts = [(vertex[v], 1 / k) for v in range(k)]
    draw = lambda drawing, parts, new, mesh: drawing.picture([(p.place, w) for p, w in parts], new.place, mesh)
    weights = lambda p: [(vertex[v], w) for v, w in p.terms.items()]
    title = f"biquartic, {at}"
    return [(draw(inner, corner_parts, centre[0], []), f"{title}\nsplit: the centre of a face\n(edges 1/2, 1/2; vertices stay)"),
            (draw(inner, [(p, 1 / 4) for p in quad], first, split), f"{title}\naverage 1: the mean of\na quad of the split"),
            (draw(inner, [(p, 1 / len(ring)) for p in ring], second, places(meshes[1])), f"{title}\naverage 2: the mean of a face of\naverage 1 (quads elsewhere)"),
            (draw(inner, [(p, 1 / len(last_quad)) for p in last_quad], last, places(meshes[2])), f"{title}\naverage 3: the mean of\na quad of average 2"),
            (draw(inner, weights(first), first, []), f"{title}\nsplit and average 1: Doo-Sabin\nwith Catmull and Clark's weights"),
            (draw(outer, weights(product), product, []), f"{title}\nthe product of all four")]
