"""Eigenvalues and stencils."""
import math

import models
import ripples
from factors import factor_rows
from maker import run, sheet
from sheet import BLUE, GREY, INK, ORANGE, PALE, RED, Plane, Sheet


def ridge(valence):
    """A fan of triangles bent to a parabolic ridge: smooth by nature, whatever ripples on it is the scheme's doing."""
    points, faces = models.triangle_fan(valence, 2)
    return [(x, y, -0.35 * x * x) for x, y, _ in points], faces


# Where the waves are measured: inside the first ring, whose edges have length one, and beyond it.
RIPPLE_RADIUS, OUTER_RADIUS = 0.6, 1.2


def ridge_limit(make, valence, tuning):
    """The limit of the ridge, fine enough for its ripples to be more than those of its triangles."""
    out = make.work / f"ridge_{valence}_{tuning}_limit.obj"
    run(make.build / "tetrakis", "refine", make.obj(f"ridge_{valence}", *ridge(valence)), "--scheme", "tuned-loop",
        "--tuning", tuning, "--levels", 6, "--limit", "-o", out)
    return models.read_obj(out)


def ripple_text(surface, valence):
    """Shares of an edge's length."""
    near, far = (ripples.ripple(*surface, valence, radius) for radius in (RIPPLE_RADIUS, OUTER_RADIUS))
    return f"ripples {near:.5f}, further out {far:.4f}"


@sheet
def high_valence(make):
    s = Sheet("Loop at high valence: eigenvalues cluster at 5/8, and the surface is pinched", 3, (420, 380),
              f"a smooth ridge gets a crease that ends at the vertex; tuned-loop has none. Ripples: heights of the short waves {RIPPLE_RADIUS:g} and {OUTER_RADIUS:g} edges from it,\nas shares of an edge. Near it tuned-loop's are ten times Loop's, but too small to see; those seen further out are alike")
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
            limit = ridge_limit(make, n, 0 if scheme == "loop" else 1)
            s.add(make.picture(*fine, (420, 380), camera="35,42", up="z"), f"{scheme}, a ridge at valence {n}\n{ripple_text(limit, n)}")
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


RIPPLE_COLOURS = {0: BLUE, 0.5: ORANGE, 1: RED}


def ripple_picture(valence, surfaces, size):
    """The heights along a third of the circle, without the long waves that the ridge itself has, in one scale."""
    left, right, bottom, top = -17, 133, -1.3e-3, 1.3e-3
    scale = 150 / (top - bottom) * size[1] / size[0]  # a square window has as much up as across
    p = Plane(size, (left, bottom * scale), (right, top * scale))
    for level in (-1e-3, -5e-4, 0, 5e-4, 1e-3):
        p.line([(0, level * scale), (120, level * scale)], PALE, 1)
        p.text((-7, level * scale), f"{level:g}", GREY, 9)
    for sector in range(valence // 3 + 1):
        p.line([(sector * 360 / valence, -1.05e-3 * scale), (sector * 360 / valence, 1.05e-3 * scale)], PALE, 1)
    for degrees in (0, 60, 120):
        p.text((degrees, 1.2e-3 * scale), f"{degrees} deg", GREY, 9)
    count = ripples.SAMPLES_PER_SECTOR * valence
    for tuning, surface in surfaces.items():
        short = ripples.short_waves(ripples.heights(*surface, RIPPLE_RADIUS, count), valence)
        p.line([(360 * k / count, short[k] * scale) for k in range(count // 3 + 1)], RIPPLE_COLOURS[tuning], 1.6)
    return p.picture()


@sheet
def tuned_loop(make):
    s = Sheet("Tuned Loop beside Loop", 6, (330, 320),
              f"a ridge, from Loop (0) to prescribed eigenvalues (1): the pinch goes, triangles get even, and ripples near the vertex (heights {RIPPLE_RADIUS:g} edges from it, as shares of an edge) grow to\n"
              f"seven and ten times Loop's, still too small for the shaded pictures; further out ({OUTER_RADIUS:g} edges) they are alike")
    for n in (12, 24):
        control = make.obj(f"ridge_{n}", *ridge(n))
        surfaces = {tuning: ridge_limit(make, n, tuning) for tuning in (0, 0.5, 1)}
        for tuning, surface in surfaces.items():
            fine = make.refine(control, "tuned-loop", 5, tuning)
            s.add(make.picture(*fine, (330, 320), camera="35,42", up="z"),
                  f"valence {n}, tuning {tuning:g}" + (" (Loop)" if tuning == 0 else "") + "\n" + ripple_text(surface, n))
        s.add(ripple_picture(n, surfaces, (330, 320)), f"valence {n}: heights {RIPPLE_RADIUS:g} edges out\ntuning 0 blue, 0.5 orange, 1 red")
        for tuning in (0, 1):
            fine, triangles = make.refine(control, "tuned-loop", 3, tuning, keep=False)
            p = Plane((330, 320), (-0.8, -0.8), (0.8, 0.8))
            for f in triangles:
                p.line([fine[v][:2] for v in f], INK, 0.7, closed=True)
            s.add(p.picture(), f"valence {n}, tuning {tuning}, from above\n3 steps")
    make.save(s, "tuned_loop")


@sheet
def factorization(make):
    s = Sheet("Stencils of dual schemes as products of simple steps", 6, (310, 310),
              "blue (negative: orange): weights, and the points that they belong to, of one new point (red). Grey: the mesh that the step starts from; pale: the control mesh. "
              "Decimals stand for weights that are no fractions")
    for picture, caption in factor_rows(make, 310):
        s.add(picture, caption)
    make.save(s, "factorization")
