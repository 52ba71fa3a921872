"""Curves, tilings and the refinement rules on them."""
import json

import tilings
from maker import sheet, run
from sheet import BLUE, GREY, INK, ORANGE, PALE, RED, Plane, Sheet


def plane_points(points):
    return [(p.real, p.imag, 0.0) for p in points]


# --- curves and tilings ---------------------------------------------------------------------------------------------


@sheet
def curves(make):
    data = json.loads(run(make.tool, "curves"))
    s = Sheet("Curves: Bezier split, B-splines of degree 1 to 4, four-point", 3, (420, 285),
              "grey: control polygon; orange: the points of one step; blue: the curve, within 0.0001")

    def draw(control, step, curve, closed=None):
        p = Plane((420, 285), (-0.3, -0.2), (3.35, 2.2))
        p.line(control, GREY, 1.3)
        if closed:
            p.line(closed, (170, 200, 235), 1.6, closed=True)
        p.line(curve, BLUE, 2.4)
        for q in step:
            p.dot(q, ORANGE, 3)
        for q in control:
            p.dot(q, INK, 4)
        return p.picture()

    b = data["bezier"]
    p = Plane((420, 285), (-0.3, -0.2), (3.35, 2.2))
    p.line(b["control"], GREY, 1.3)
    p.line(b["first"], RED, 1.3)
    p.line(b["second"], ORANGE, 1.3)
    p.line(b["curve"], BLUE, 2.4)
    for points, colour in ((b["control"], INK), (b["first"], RED), (b["second"], ORANGE)):
        for q in points:
            p.dot(q, colour, 4)
    s.add(p.picture(), "Bezier, split at 1/2\nde Casteljau: the two halves' control points")
    p = Plane((420, 285), (-0.3, -0.2), (3.35, 2.2))
    p.line(b["control"], PALE, 1.3)
    p.line(b["curve"], BLUE, 2.4)
    for part, colour in (("first_first", RED), ("first_second", ORANGE), ("second", INK)):
        p.line(b[part], colour, 1.3)
        for q in b[part]:
            p.dot(q, colour, 3.5)
    s.add(p.picture(), "and the first half once more\npolygons approach the curve")
    for c in data["bspline"]:
        s.add(draw(c["control"], c["step"], c["curve"], c["closed"]),
              f"B-spline of degree {c['degree']}\nopen (ends recede), pale: closed")
    c = data["four_point"]
    s.add(draw(c["control"], c["step"], c["curve"], c["closed"]), "four-point, interpolating\nopen (cubic ends), pale: closed")
    make.save(s, "curves")


TILE_COLOURS = {3: (246, 226, 180), 4: (190, 214, 236), 5: (210, 232, 206), 6: (233, 200, 190), 8: (214, 202, 230), 12: (205, 226, 222)}


def tiling_picture(points, faces, reach, size=300):
    p = Plane((size, size), (-reach, -reach), (reach, reach))
    for f in faces:
        p.polygon([(points[v].real, points[v].imag) for v in f], TILE_COLOURS.get(len(f), (240, 240, 240)))
    for f in faces:
        p.line([(points[v].real, points[v].imag) for v in f], INK, 1.4, closed=True)
    return p.picture()


@sheet
def archimedean_tilings(make):
    s = Sheet("The 11 Archimedean tilings", 4, (300, 300), "named by the tiles around a vertex")
    for name in tilings.cells():
        reach = 4.4 if "12" in name or "8" in name else 3.4
        s.add(tiling_picture(*tilings.tiling(name, reach * 1.5 + 3), reach), name)
    make.save(s, "archimedean_tilings")


@sheet
def laves_tilings(make):
    s = Sheet("The 11 Laves tilings", 4, (300, 300), "named by the valences around a tile; each is the dual of the Archimedean tiling of that name")
    for name in tilings.cells():
        reach = 4.4 if "12" in name or "8" in name else 3.4
        s.add(tiling_picture(*tilings.dual(*tilings.tiling(name, reach * 1.5 + 3)), reach), f"[{name}]")
    make.save(s, "laves_tilings")


@sheet
def refinement_rules(make):
    s = Sheet("Refinement rules on their tilings", 5, (330, 330), "grey, wide: before; blue: after one step of the scheme in brackets")
    simple = {"sqrt3, one simple step", "4-8, one simple step"}
    rules = [("3^6", "midpoint", "face split of triangles\n(midpoint)"),
             ("4^4", "bilinear", "face split of quads\n(bilinear)"),
             ("4^4", "doo-sabin", "vertex split of quads\n(doo-sabin)"),
             ("3^6", "dual", "vertex split of triangles: hexagons\nthe duals of face splits; they do not nest"),
             ("3^6", "doo-sabin", "a step for quads, on triangles\n(doo-sabin): 3.4.6.4, another tiling"),
             ("6^3", "honeycomb", "honeycomb\n(honeycomb)"),
             ("3^6", "sqrt3, one simple step", "sqrt(3), one simple step\n(sqrt3): centres inserted, edges flipped"),
             ("3^6", "sqrt3", "sqrt(3), two simple steps\n(sqrt3)"),
             ("4.8^2 dual", "4-8, one simple step", "bisection, one simple step\n(4-8, on the tiling [4.8^2])"),
             ("4.8^2 dual", "4-8", "bisection, two simple steps\n(4-8)")]
    for name, scheme, caption in rules:
        reach = 1.75
        if name.endswith("dual"):
            # The blocks of the tetrakis tiling are squares, which the scheme takes; its triangles are their quarters.
            points, faces = tilings.tiling("4^4", 7)
            control = make.obj("_blocks", plane_points(points), faces)
        else:
            points, faces = tilings.tiling(name, 7)
            control = make.obj("_tiling", plane_points(points), faces)
        if scheme == "dual":
            # A vertex becomes a face, a face a vertex, before and after a face split; no scheme here refines hexagons so.
            fine_points, fine = make.refine(control, "midpoint", 1, keep=False)
            fine_points, fine = tilings.dual([complex(*q[:2]) for q in fine_points], fine)
            fine_points = plane_points(fine_points)
        elif scheme in simple:
            # On quads the first half-step of 4-8 makes the tetrakis tiling itself.
            if name.endswith("dual"):
                fine_points, fine, _ = make.factored(control, "4-8", 2)
            else:
                data = json.loads(run(make.tool, "adaptive", control, "sqrt3", "1:1", "0,0,0", 0, "-"))
                fine_points, fine = data["points"], data["faces"]
        else:
            fine_points, fine = make.refine(control, scheme, 1, keep=False)
        if name.endswith("dual"):
            cut = lambda p, q: ([*p, *(tuple(sum(p[v][i] for v in f) / 4 for i in range(3)) for f in q)],
                                [[a, b, len(p) + k] for k, f in enumerate(q) for a, b in zip(f, f[1:] + f[:1])])
            before_points, before = cut(plane_points(points), faces)
            if scheme not in simple:
                fine_points, fine = cut(fine_points, fine)
        elif scheme == "dual":
            before_points, before = tilings.dual(points, faces)
            before_points = plane_points(before_points)
        else:
            before_points, before = plane_points(points), faces
        if name == "6^3":
            reach = 2.3
        p = Plane((330, 330), (-reach, -reach), (reach, reach))
        if scheme == "dual":
            for f in faces:
                p.line([(points[v].real, points[v].imag) for v in f], PALE, 1.6, closed=True)
        for f in before:
            p.line([before_points[v][:2] for v in f], (196, 202, 212), 6, closed=True)
        for f in fine:
            p.line([fine_points[v][:2] for v in f], BLUE, 1.6, closed=True)
        s.add(p.picture(), caption)
    make.save(s, "refinement_rules")
