"""Eigenvalues and stencils."""
import math

import models
from maker import sheet
from sheet import BLUE, GREY, INK, PALE, RED, Plane, Sheet


def ridge(valence):
    """A fan of triangles bent to a parabolic ridge: smooth by nature, whatever ripples on it is the scheme's doing."""
    points, faces = models.triangle_fan(valence, 2)
    return [(x, y, -0.35 * x * x) for x, y, _ in points], faces


@sheet
def high_valence(make):
    s = Sheet("Loop at high valence: eigenvalues cluster at 5/8, and the surface ripples", 3, (420, 380),
              "other eigenvalues come up to the tangents' own, and a smooth ridge gets a pinch; tuned-loop has none")
    p = Plane((420, 380), (-4, -3), (67, 60))
    at = lambda n: 62 * math.log(n / 3) / math.log(64 / 3) + 1.5
    unit = 57.5
    valences = (3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64)
    for level in (0.25, 0.375, 0.5, 0.625, 1):
        p.line([(0, level * unit), (64, level * unit)], PALE, 1)
        p.text((-1.6, level * unit), f"{level:g}", GREY, 10)
    for n in valences:
        values = make.scheme("loop", n)["eigenvalues"]
        for v in values:
            if abs(v["imaginary"]) < 1e-9 and v["real"] > 0.02:
                p.dot((at(n), v["real"] * unit), RED if v["mode"] == 1 and v["real"] > 0.24 and v["real"] == max(w["real"] for w in values if w["mode"] == 1) else BLUE, 2.4)
        p.text((at(n), -1.5), str(n), GREY, 9)
    s.add(p.picture(), "eigenvalues by valence (logarithmic)\nred: the tangents', blue: all others")
    for n in (6, 12, 24, 48):
        for scheme in ("loop",) if n != 24 else ("loop", "tuned-loop"):
            fine = make.refine(make.obj(f"ridge_{n}", *ridge(n)), scheme, 5)
            s.add(make.picture(*fine, (420, 380), camera="35,42", up="z"), f"{scheme}, a ridge at valence {n}\n")
    make.save(s, "high_valence")


@sheet
def uneven_rings(make):
    s = Sheet("Rings of triangles around a vertex: Loop, and prescribed eigenvalues (subdominant 1/2)", 7, (250, 250),
              "three steps on a flat fan; the scheme tuned-loop has lambda = 1/2 at every valence, so its triangles are even")
    for scheme in ("loop", "tuned-loop"):
        for n in range(3, 10):
            points, faces = models.triangle_fan(n, 4)
            fine, triangles = make.refine(make.obj(f"fan_{n}", points, faces), scheme, 3, keep=False)
            p = Plane((250, 250), (-1, -1), (1, 1))
            for f in triangles:
                p.line([fine[v][:2] for v in f], INK, 0.7, closed=True)
            s.add(p.picture(), f"{scheme}, valence {n}\nlambda {make.scheme(scheme, n)['subdominant'][0]:.3f}")
    make.save(s, "uneven_rings")


@sheet
def tuned_loop(make):
    s = Sheet("Tuned Loop beside Loop", 5, (330, 320), "a ridge: even triangles against ripples, one parameter from Loop (0) to prescribed eigenvalues (1)")
    for n in (12, 24):
        control = make.obj(f"ridge_{n}", *ridge(n))
        for tuning in (0, 0.5, 1):
            fine = make.refine(control, "tuned-loop", 5, tuning)
            s.add(make.picture(*fine, (330, 320), camera="35,42", up="z"),
                  f"valence {n}, tuning {tuning}\n" + ("Loop" if tuning == 0 else ""))
        for tuning in (0, 1):
            fine, triangles = make.refine(control, "tuned-loop", 3, tuning, keep=False)
            p = Plane((330, 320), (-0.8, -0.8), (0.8, 0.8))
            for f in triangles:
                p.line([fine[v][:2] for v in f], INK, 0.7, closed=True)
            s.add(p.picture(), f"valence {n}, tuning {tuning}, from above\n3 steps")
    make.save(s, "tuned_loop")


def fraction(x):
    for d in (1, 2, 4, 5, 8, 16, 20, 32, 64, 128, 256, 40, 80, 160, 320, 640, 1280):
        if abs(x * d - round(x * d)) < 1e-9:
            return f"{round(x * d)}/{d}" if d > 1 else f"{round(x)}"
    return f"{x:.3f}"


def mask_picture(points, terms, size, faces, new):
    """The points of a mask with their weights, and in red where the new point lies."""
    used = [points[v] for v in terms] + [new]
    low, high = [min(p[i] for p in used) for i in (0, 1)], [max(p[i] for p in used) for i in (0, 1)]
    reach = 0.5 * max(high[0] - low[0], high[1] - low[1], 1.5) + 0.35
    centre = [0.5 * (low[i] + high[i]) for i in (0, 1)]
    p = Plane((size, size), [c - reach for c in centre], [c + reach for c in centre])
    for f in faces:
        p.line([points[v][:2] for v in f], GREY, 1.2, closed=True)
    most = max(abs(w) for w in terms.values())
    for v, w in terms.items():
        p.dot(points[v], BLUE, 3 + 5 * math.sqrt(abs(w) / most))
    for v, w in terms.items():
        p.text(points[v], fraction(w), INK, 12, below=19)
    x, y = p.at(new)
    r = 9 * 3
    p.draw.ellipse((x - r, y - r, x + r, y + r), outline=RED, width=6)
    return p.picture()


@sheet
def factorization(make):
    s = Sheet("Stencils of dual schemes as products of simple steps", 6, (310, 310),
              "weights of one new point (red) at a regular face and at a 5-gon; each averaging step takes the means of the quads around")
    for corners in (4, 5):
        points, faces = models.face_fan(corners, 2)
        at = "regular" if corners == 4 else "5-gon"
        for scheme, option, caption in (("averaging", 0, "bilinear split\nthe face's point; edges: 1/2, 1/2"),
                                        ("averaging", 1, "1 averaging step\nDoo-Sabin, Catmull and Clark's weights"),
                                        ("doo-sabin", None, "Doo-Sabin\nDoo and Sabin's weights"),
                                        ("midedge-simplest", None, "midedge, simplest form\ntwo rounds of midpoints"),
                                        ("averaging", 2, "2 averaging steps\nnearly Catmull-Clark"),
                                        ("averaging", 3, "3 averaging steps\nbiquartic")):
            # The weights of the new point are what it is of unit heights, one control point after the other.
            fine_points, _ = make.refine(make.obj("_plane", points, faces), scheme, 1, option, keep=False)
            corner = points[0]
            # The face's point; of two steps the vertex; else the child of the corner within the face.
            goal = 0 if option == 0 else 1 if option == 2 else 0.55
            target = min(range(len(fine_points)), key=lambda i: math.dist(fine_points[i][:2], [goal * c for c in corner[:2]]))
            terms = {}
            for v, q in enumerate(points):
                if math.hypot(*q[:2]) > 2.6:
                    continue
                raised = [(x, y, 1.0 if i == v else 0.0) for i, (x, y, _) in enumerate(points)]
                weight = make.refine(make.obj("_unit", raised, faces), scheme, 1, option, keep=False)[0][target][2]
                if abs(weight) > 1e-12:
                    terms[v] = weight
            s.add(mask_picture(points, terms, 310, faces, fine_points[target]), f"{at}: {caption}")
    make.save(s, "factorization")
