#!/usr/bin/env python3
"""Writes the control meshes of data/: small models, drawn by formula, that are worth looking at when subdivided.

Usage: tools/make_data.py [folder]        (default: the data folder beside tools)

Only Python's standard library is used, and coordinates are rounded to 6 decimals, so every machine writes the same
bytes. Each mesh is checked before it is written: an oriented 2-manifold with the number of boundary loops it should
have, and a positive volume where it is closed. Tags follow OpenSubdiv's convention, `t crease 2/1/0 i j sharpness`
with 0-based vertices; from sharpness 10 on an edge counts as infinitely sharp.
"""
import math
import os
import sys

INFINITE = 10.0


class Mesh:
    """Polygons, crease sharpness by edge, and (optionally) one UV per face corner."""

    def __init__(self):
        self.vertices = []
        self.faces = []
        self.creases = {}
        self.corner_uv = None  # function of (face number, corner number) -> (u, v)

    def vertex(self, x, y, z):
        self.vertices.append((x, y, z))
        return len(self.vertices) - 1

    def face(self, *corners):
        self.faces.append(tuple(corners))
        return len(self.faces) - 1

    def crease(self, a, b, sharpness):
        if sharpness > 0:
            self.creases[(min(a, b), max(a, b))] = sharpness

    def crease_loop(self, loop, sharpness):
        for a, b in zip(loop, loop[1:] + loop[:1]):
            self.crease(a, b, sharpness)

    def normal(self, f):
        """Area vector of a face (Newell), half the sum of its edges' cross products."""
        n = [0.0, 0.0, 0.0]
        corners = [self.vertices[v] for v in self.faces[f]]
        for p, q in zip(corners, corners[1:] + corners[:1]):
            n[0] += (p[1] * q[2] - p[2] * q[1]) / 2
            n[1] += (p[2] * q[0] - p[0] * q[2]) / 2
            n[2] += (p[0] * q[1] - p[1] * q[0]) / 2
        return tuple(n)

    def centre(self, f):
        return mean([self.vertices[v] for v in self.faces[f]])

    def edges(self):
        """Directed edges to their face."""
        result = {}
        for f, corners in enumerate(self.faces):
            for a, b in zip(corners, corners[1:] + corners[:1]):
                if (a, b) in result:
                    raise ValueError(f"edge {a} {b} is used twice in one direction")
                result[(a, b)] = f
        return result

    def triangulated(self):
        """The same surface with every quad cut along its shorter diagonal."""
        result = Mesh()
        result.vertices = list(self.vertices)
        result.creases = dict(self.creases)
        source = []  # per triangle: the face and the face's corners it has
        for f, corners in enumerate(self.faces):
            left = list(range(len(corners)))
            while len(left) > 3:
                ends = [(self.vertices[corners[left[i - 1]]], self.vertices[corners[left[(i + 1) % len(left)]]])
                        for i in range(len(left))]
                ear = min(range(len(left)), key=lambda i: (round(distance(*ends[i]), 9), i))
                source.append((f, (left[ear - 1], left[ear], left[(ear + 1) % len(left)])))
                del left[ear]
            source.append((f, tuple(left)))
        result.faces = [tuple(self.faces[f][c] for c in corners) for f, corners in source]
        if self.corner_uv:
            result.corner_uv = lambda t, corner: self.corner_uv(source[t][0], source[t][1][corner])
        return result


def mean(points):
    return tuple(sum(p[k] for p in points) / len(points) for k in range(3))


def distance(p, q):
    return math.sqrt(sum((a - b) ** 2 for a, b in zip(p, q)))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def scaled(a, s):
    return tuple(x * s for x in a)


def added(a, b):
    return tuple(x + y for x, y in zip(a, b))


def unit(a):
    return scaled(a, 1 / math.sqrt(dot(a, a)))


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


# ---------------------------------------------------------------------------------------------------------------------
# Chess pieces


def lathe(mesh, profile, segments):
    """Turns (radius, height, sharpness of the ring) around the y axis, bottom to top; returns the rings."""
    rings = []
    for radius, height, sharpness in profile:
        ring = []
        for j in range(segments):
            a = 2 * math.pi * j / segments
            ring.append(mesh.vertex(radius * math.cos(a), height, radius * math.sin(a)))
        mesh.crease_loop(ring, sharpness)
        rings.append(ring)
    return rings


def band(mesh, lower, upper):
    n = len(lower)
    return [mesh.face(lower[j], upper[j], upper[(j + 1) % n], lower[(j + 1) % n]) for j in range(n)]


def cap(mesh, ring, height, up):
    """Closes a ring of an even number of vertices by quads around a middle vertex."""
    c = mesh.vertex(0, height, 0)
    n = len(ring)
    for k in range(0, n, 2):
        three = [ring[k], ring[k + 1], ring[(k + 2) % n]]
        mesh.face(c, *(reversed(three) if up else three))


def pawn():
    mesh = Mesh()
    rings = lathe(mesh, [
        (0.96, 0.00, INFINITE), (1.00, 0.12, 2.0), (1.00, 0.34, 3.5), (0.79, 0.46, 0.0), (0.76, 0.60, 2.5),
        (0.50, 0.90, 0.0), (0.37, 1.35, 0.0), (0.32, 1.80, 0.0), (0.34, 1.90, 2.2), (0.62, 1.97, 4.2),
        (0.60, 2.10, 2.7), (0.36, 2.17, 1.5), (0.56, 2.36, 0.0), (0.66, 2.62, 0.0), (0.53, 2.90, 0.0),
        (0.26, 3.04, 0.0)], 8)
    for lower, upper in zip(rings, rings[1:]):
        band(mesh, lower, upper)
    cap(mesh, rings[0], 0.0, up=False)
    cap(mesh, rings[-1], 3.09, up=True)
    return mesh


def rook():
    mesh = Mesh()
    segments = 12
    rim = 2.66
    rings = lathe(mesh, [
        (0.98, 0.00, INFINITE), (1.04, 0.12, 2.0), (1.04, 0.38, 3.4), (0.84, 0.50, 0.0), (0.81, 0.66, 2.4),
        (0.62, 1.00, 0.0), (0.54, 1.50, 0.0), (0.54, 1.92, 0.0), (0.58, 2.04, 2.6), (0.80, 2.16, 4.5),
        (0.82, rim, 0.0), (0.56, rim, 0.0), (0.55, 2.40, 3.1)], segments)
    outer, inner = rings[-3], rings[-2]
    for lower, upper in zip(rings, rings[1:]):
        if lower is not outer:
            band(mesh, lower, upper)
    cap(mesh, rings[0], 0.0, up=False)
    cap(mesh, rings[-1], 2.38, up=True)
    raised = {}
    for j in range(segments):  # even segments of the rim rise as merlons, odd ones stay low
        k = (j + 1) % segments
        low = (outer[j], inner[j], inner[k], outer[k])
        if j % 2:
            mesh.face(*low)
            for a, b, s in ((low[0], low[3], 4.3), (low[1], low[2], 4.3), (low[0], low[1], 2.5), (low[3], low[2], 2.5)):
                mesh.crease(a, b, s)
            continue
        high = []
        for v in low:
            x, _, z = mesh.vertices[v]
            raised[v] = mesh.vertex(x, 3.08, z)
            high.append(raised[v])
        mesh.face(*high)
        mesh.crease_loop(high, 3.7)
        for i in range(4):
            a, b = low[i], low[(i + 1) % 4]
            mesh.face(a, b, raised[b], raised[a])
            mesh.crease(a, raised[a], 3.7)
    return mesh


# ---------------------------------------------------------------------------------------------------------------------
# Simple solids


def cube():
    mesh = Mesh()
    for z in (-1, 1):
        for y in (-1, 1):
            for x in (-1, 1):
                mesh.vertex(x, y, z)
    for corners in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)):
        mesh.face(*corners)
    return mesh


def tetrahedron():
    mesh = Mesh()
    for p in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)):
        mesh.vertex(*p)
    for corners in ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)):
        mesh.face(*corners)
    return mesh


def extruded_pentagon():
    """A prism over a pentagon, two of its faces being pentagons, with a semi-sharp rim at the bottom."""
    mesh = Mesh()
    rings = lathe(mesh, [(1.0, 0.0, 1.5), (1.0, 1.4, 0.0)], 5)
    band(mesh, rings[0], rings[1])
    mesh.face(*rings[0])
    mesh.face(*reversed(rings[1]))
    return mesh


def pipe3():
    """Three pipes that meet at 120 degrees, open at their ends. The two poles of the joint have valence 3."""
    mesh = Mesh()
    radius, reach = 0.5, 0.75
    poles = (mesh.vertex(0, 0, radius), mesh.vertex(0, 0, -radius))
    arcs = []  # arcs[k]: the seam between the legs k and k + 1, three vertices from the upper pole to the lower
    for k in range(3):
        a = 2 * math.pi * (k + 0.5) / 3
        arcs.append([mesh.vertex(radius * r * math.cos(a), radius * r * math.sin(a), radius * z)
                     for r, z in ((0.85, 0.72), (1.15, 0.0), (0.85, -0.72))])
    for k in range(3):
        a = 2 * math.pi * k / 3
        axis = (math.cos(a), math.sin(a), 0.0)
        side = (-math.sin(a), math.cos(a), 0.0)
        loop = [poles[0], *arcs[k], poles[1], *reversed(arcs[k - 1])]
        for step, flare in ((0, 0.92), (1, 0.86), (2, 0.86), (3, 1.0), (4, 1.25)):
            ring = []
            for i in range(8):
                b = math.pi / 4 * i
                along = scaled(axis, reach + 0.42 * step)
                across = added(scaled(side, radius * flare * math.sin(b)), (0, 0, radius * flare * math.cos(b)))
                ring.append(mesh.vertex(*added(along, across)))
            for i in range(8):
                mesh.face(loop[i], ring[i], ring[(i + 1) % 8], loop[(i + 1) % 8])
            if step == 3:
                mesh.crease_loop(ring, 2.3)
            loop = ring
    return mesh


# ---------------------------------------------------------------------------------------------------------------------
# A bracket: the boundary of a set of boxes, round holes, creases by the angle between faces


def bracket():
    """Two plates at a right angle, each with a round hole: infinitely sharp rims, semi-sharp edges, a smooth fillet."""
    mesh = Mesh()
    long_side = (0.0, 0.45, 0.9, 1.4, 1.9, 2.4)
    width = (0.0, 0.45, 0.95, 1.45, 1.9)
    hole_centre = (1.4, 0.95)
    hole_radius = 0.42
    hole_long, hole_wide = (2, 3), (1, 2)  # the cells a hole takes away

    def filled(i, j, k):
        if not (0 <= i < 5 and 0 <= j < 5 and 0 <= k < 4) or min(i, j) != 0:
            return False
        return not (max(i, j) in hole_long and k in hole_wide)

    numbers = {}

    def number(i, j, k):
        if (i, j, k) not in numbers:
            x, y, z = long_side[i], long_side[j], width[k]
            if min(i, j) <= 1 and 2 <= max(i, j) <= 4 and 1 <= k <= 3:  # on the square around a hole: make it round
                dx, dz = max(x, y) - hole_centre[0], z - hole_centre[1]
                stretch = hole_radius / math.hypot(dx, dz)
                along, z = hole_centre[0] + dx * stretch, hole_centre[1] + dz * stretch
                x, y = (along, y) if i >= j else (x, along)
            elif min(i, j) <= 1 and max(i, j) == 5 and k in (0, 4):  # the free corners of the plates: round them a little
                along = max(x, y) - 0.12
                z += 0.12 if k == 0 else -0.12
                x, y = (along, y) if i >= j else (x, along)
            numbers[(i, j, k)] = mesh.vertex(x, y, z)
        return numbers[(i, j, k)]

    for i in range(5):
        for j in range(5):
            for k in range(4):
                if not filled(i, j, k):
                    continue
                for axis in range(3):
                    for up in (0, 1):
                        beyond = [i, j, k]
                        beyond[axis] += 1 if up else -1
                        if filled(*beyond):
                            continue
                        corners = []
                        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                            at = [i, j, k]
                            at[axis] += up
                            at[(axis + 1) % 3] += a
                            at[(axis + 2) % 3] += b
                            corners.append(number(*at))
                        mesh.face(*(corners if up else reversed(corners)))

    places = {v: at for at, v in numbers.items()}

    def on_hole(v):
        i, j, k = places[v]
        return 2 <= max(i, j) <= 4 and 1 <= k <= 3

    edges = mesh.edges()
    for (a, b), f in edges.items():
        if a > b:
            continue
        g = edges[(b, a)]
        if dot(unit(mesh.normal(f)), unit(mesh.normal(g))) > math.cos(math.radians(60)):
            continue
        (ia, ja, _), (ib, jb, _) = places[a], places[b]
        if on_hole(a) and on_hole(b):
            mesh.crease(a, b, INFINITE)
        elif (ia, ja, ib, jb) == (1, 1, 1, 1):
            continue  # the inner corner of the two plates: a fillet
        elif (ia, ja, ib, jb) == (0, 0, 0, 0):
            mesh.crease(a, b, 1.2)
        elif max(ia, ja) == 5 and max(ib, jb) == 5 and places[a][2] == places[b][2]:
            mesh.crease(a, b, 0.8)  # the rounded free corners
        else:
            mesh.crease(a, b, 3.3)
    return mesh


# ---------------------------------------------------------------------------------------------------------------------
# A knotted tube


def knot(around, along):
    """A tube around the (2, 3) torus knot, its frame carried without twist and then closed by an even one."""
    mesh = Mesh()

    def curve(t):
        r = 2 + math.cos(3 * t)
        return (r * math.cos(2 * t), r * math.sin(2 * t), 1.1 * math.sin(3 * t))

    def tangent(t):
        h = 1e-4
        return unit(tuple(a - b for a, b in zip(curve(t + h), curve(t - h))))

    steps = 16  # of the frame, per ring
    t0 = tangent(0.0)
    normal = unit(cross(t0, (0.3, 0.2, 1.0)))
    frames = []
    for i in range(along * steps + 1):
        d = tangent(2 * math.pi * i / (along * steps))
        normal = unit(added(normal, scaled(d, -dot(normal, d))))
        frames.append((normal, cross(d, normal)))
    first, last = frames[0], frames[-1]
    gap = math.atan2(dot(last[0], first[1]), dot(last[0], first[0]))
    rings = []
    for i in range(along):
        n, b = frames[i * steps]
        p = curve(2 * math.pi * i / along)
        ring = []
        for j in range(around):
            a = 2 * math.pi * j / around - gap * i / along
            r = 0.46
            ring.append(mesh.vertex(*added(p, added(scaled(n, r * math.cos(a)), scaled(b, r * math.sin(a))))))
        rings.append(ring)
    for i in range(along):
        ring, after = rings[i], rings[(i + 1) % along]
        for j in range(around):
            mesh.face(ring[j], ring[(j + 1) % around], after[(j + 1) % around], after[j])

    def corner_uv(f, corner):
        i, j = divmod(f, around)
        di, dj = ((0, 0), (0, 1), (1, 1), (1, 0))[corner]
        return ((j + dj) / around, (i + di) / along)

    mesh.corner_uv = corner_uv
    return mesh


# ---------------------------------------------------------------------------------------------------------------------
# A head: a cube's grid blown up to a skull, eye sockets, mouth and ears by insetting groups of faces, a neck


def smoothstep(t):
    t = min(1.0, max(0.0, t))
    return t * t * (3 - 2 * t)


def skull(d):
    """Place of the head's surface in a direction from its middle: x to its left, y up, z where it looks."""
    x, y, z = d
    low = smoothstep(-y / 0.9)
    px, py, pz = 0.76 * x, 1.05 * y, 0.94 * z
    px *= 1 - 0.30 * low
    if z < 0:
        pz *= 1 - 0.38 * low
    else:
        pz *= 1 + 0.06 * low
        pz += 0.06 * math.exp(-((y - 0.24) / 0.10) ** 2 - (x / 0.5) ** 4)  # brow
        pz += 0.30 * math.exp(-(x / 0.11) ** 2 - ((y + 0.17) / 0.19) ** 2)  # nose
        pz += 0.05 * math.exp(-(x / 0.11) ** 2 - ((y - 0.08) / 0.14) ** 2)  # its ridge
        pz += 0.09 * math.exp(-(x / 0.24) ** 2 - ((y + 0.80) / 0.14) ** 2)  # chin
        pz += 0.05 * math.exp(-((abs(x) - 0.42) / 0.15) ** 2 - ((y + 0.16) / 0.14) ** 2)  # cheeks
    return (px, py, pz)


class Head:
    n = 8  # cells per side of the cube

    def __init__(self):
        self.mesh = Mesh()
        self.direction = []  # per vertex: where it sits on the unit sphere, which gives its UV
        self.cells = {}      # (axis, side, a, b) -> face
        numbers = {}
        for axis in range(3):
            for side in (0, 1):
                for a in range(self.n):
                    for b in range(self.n):
                        corners = []
                        for da, db in ((0, 0), (1, 0), (1, 1), (0, 1)):
                            at = [0, 0, 0]
                            at[axis] = self.n * side
                            at[(axis + 1) % 3] = a + da
                            at[(axis + 2) % 3] = b + db
                            at = tuple(at)
                            if at not in numbers:
                                c = [math.tan(math.pi / 4 * (2 * i / self.n - 1)) for i in at]
                                numbers[at] = self.add(skull(unit(c)), unit(c))
                            corners.append(numbers[at])
                        self.cells[(axis, side, a, b)] = self.mesh.face(*(corners if side else reversed(corners)))

    def add(self, position, direction):
        self.direction.append(direction)
        return self.mesh.vertex(*position)

    def rim(self, group):
        """The loop of directed edges around a group of faces, in order."""
        after = {}
        for f in group:
            corners = self.mesh.faces[f]
            for a, b in zip(corners, corners[1:] + corners[:1]):
                after[a] = after.get(a, []) + [b]
        inner = {(a, b) for a in after for b in after[a]}
        loop_next = {a: b for a, b in inner if (b, a) not in inner}
        loop = [min(loop_next)]
        while loop_next[loop[-1]] != loop[0]:
            loop.append(loop_next[loop[-1]])
        return loop

    def inset(self, group, shrink, offset, sharpness=0.0):
        """Shrinks a group of faces towards its middle and moves it; a ring of quads joins it to its old rim."""
        loop = self.rim(group)
        used = sorted({v for f in group for v in self.mesh.faces[f]})
        middle = mean([self.mesh.vertices[v] for v in used])
        middle_direction = mean([self.direction[v] for v in used])

        def moved(v):
            return added(mix(self.mesh.vertices[v], middle, 1 - shrink), offset)

        new = {}
        for v in used:
            if v in loop:
                new[v] = self.add(moved(v), mix(self.direction[v], middle_direction, 1 - shrink))
            else:
                self.mesh.vertices[v] = moved(v)
                new[v] = v
        for f in group:
            self.mesh.faces[f] = tuple(new[v] for v in self.mesh.faces[f])
        for a, b in zip(loop, loop[1:] + loop[:1]):
            self.mesh.face(a, b, new[b], new[a])
        self.mesh.crease_loop([new[v] for v in loop], sharpness)

    def remove(self, group):
        gone = set(group)
        self.mesh.faces = [c for f, c in enumerate(self.mesh.faces) if f not in gone]
        used = sorted({v for c in self.mesh.faces for v in c})
        number = {v: i for i, v in enumerate(used)}
        self.mesh.vertices = [self.mesh.vertices[v] for v in used]
        self.direction = [self.direction[v] for v in used]
        self.mesh.faces = [tuple(number[v] for v in c) for c in self.mesh.faces]
        self.mesh.creases = {(number[a], number[b]): s for (a, b), s in self.mesh.creases.items()
                             if a in number and b in number}


def head():
    build = Head()
    cells = build.cells
    front, left, right, below = (2, 1), (0, 1), (0, 0), (1, 0)
    for columns in ((1, 2), (5, 6)):
        eye = [cells[(*front, a, 4)] for a in columns]
        build.inset(eye, 0.92, (0, -0.01, -0.075), 1.4)
        build.inset(eye, 0.80, (0, 0, 0.0), 0.7)
        build.inset(eye, 0.70, (0, 0, 0.035))
    mouth = [cells[(*front, a, 1)] for a in (2, 3, 4, 5)]
    build.inset(mouth, 0.88, (0, -0.01, 0.045))
    build.inset(mouth, 0.62, (0, 0, -0.06), 1.0)
    for side, out in ((left, 1), (right, -1)):
        ear = [cells[(*side, a, 3)] for a in (3, 4)]  # axes of this side: y, then z
        build.inset(ear, 0.80, (0.05 * out, 0.02, -0.04))
        build.inset(ear, 1.45, (0.08 * out, 0.03, -0.07), 0.8)
        build.inset(ear, 0.70, (0.00 * out, 0, 0.01))
        build.inset(ear, 0.75, (-0.05 * out, 0, 0.02))
    throat = [cells[(*below, a, b)] for a in range(2, 6) for b in range(2, 6)]  # axes: z, then x
    loop = build.rim(throat)
    for step in range(3):
        ring = []
        for i, v in enumerate(loop):
            x, y, z = build.mesh.vertices[v]
            a = math.atan2(build.direction[v][0], build.direction[v][2])
            r = (0.36, 0.36, 0.47)[step]
            goal = (r * math.sin(a), -1.12 - 0.22 * step, r * math.cos(a) - 0.06 - 0.05 * step)
            d = build.direction[v]
            ring.append(build.add(goal, (d[0], d[1] - 0.3, d[2])))
        for i in range(len(loop)):
            j = (i + 1) % len(loop)
            build.mesh.face(loop[i], loop[j], ring[j], ring[i])
        loop = ring
    build.remove(throat)
    mesh = build.mesh

    def longitude(d):
        return math.atan2(d[0], d[2]) / (2 * math.pi) + 0.5

    def corner_uv(f, corner):
        v = mesh.faces[f][corner]
        d = build.direction[v]
        around_face = longitude(mean([build.direction[w] for w in mesh.faces[f]]))
        # At the crown, on the axis, a face has no longitude of its own at that corner: it takes its middle's.
        u = around_face if math.hypot(d[0], d[2]) < 1e-9 else longitude(d)
        if u - around_face > 0.5:
            u -= 1
        if around_face - u > 0.5:
            u += 1
        return (u, (d[1] + 2) / 3)

    mesh.corner_uv = corner_uv
    return mesh


# ---------------------------------------------------------------------------------------------------------------------
# Checks and output


def boundary_loops(mesh):
    edges = mesh.edges()
    after = {b: a for (a, b) in edges if (b, a) not in edges}
    loops = 0
    while after:
        loops += 1
        start, at = next(iter(after.items()))
        del after[start]
        while at != start:
            at = after.pop(at)
    return loops


def check(name, mesh, loops):
    found = boundary_loops(mesh)
    if found != loops:
        raise ValueError(f"{name}: {found} boundary loops instead of {loops}")
    if {v for corners in mesh.faces for v in corners} != set(range(len(mesh.vertices))):
        raise ValueError(f"{name}: a vertex without faces")
    edges = mesh.edges()
    around = {}  # one fan of faces per vertex: as many faces as its walk meets
    for corners in mesh.faces:
        for v in corners:
            around[v] = around.get(v, 0) + 1
    for v, count in around.items():
        starts = [b for (a, b) in edges if a == v and (b, a) not in edges] or [next(b for a, b in edges if a == v)]
        if len(starts) > 1:
            raise ValueError(f"{name}: vertex {v} has two fans")
        met, b = 0, starts[0]
        while (v, b) in edges:
            met += 1
            corners = mesh.faces[edges[(v, b)]]
            b = corners[corners.index(v) - 1]
            if b == starts[0]:
                break
        if met != count:
            raise ValueError(f"{name}: vertex {v} has two fans")
    if any((a, b) not in edges and (b, a) not in edges for a, b in mesh.creases):
        raise ValueError(f"{name}: a crease that is no edge")
    if loops == 0:
        volume = sum(dot(mesh.centre(f), mesh.normal(f)) for f in range(len(mesh.faces))) / 3
        if volume <= 0:
            raise ValueError(f"{name}: inside out, volume {volume}")


def number_text(x):
    text = f"{x:.6f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def obj_text(name, mesh, about):
    lines = [f"# {about}", "# Written by tools/make_data.py", f"o {name}"]
    lines += ["v " + " ".join(number_text(c) for c in p) for p in mesh.vertices]
    uv_numbers = {}
    face_lines = []
    for f, corners in enumerate(mesh.faces):
        words = []
        for corner, v in enumerate(corners):
            if mesh.corner_uv is None:
                words.append(str(v + 1))
            else:
                uv = "vt " + " ".join(number_text(c) for c in mesh.corner_uv(f, corner))
                words.append(f"{v + 1}/{uv_numbers.setdefault(uv, len(uv_numbers) + 1)}")
        face_lines.append("f " + " ".join(words))
    lines += list(uv_numbers) + face_lines
    lines += [f"t crease 2/1/0 {a} {b} {number_text(s)}" for (a, b), s in sorted(mesh.creases.items())]
    return "\n".join(lines) + "\n"


def models():
    """(name, mesh, boundary loops, what it is)"""
    quad_knot, quad_bracket = knot(8, 64), bracket()
    yield "cube", cube(), 0, "A cube"
    yield "tetrahedron", tetrahedron(), 0, "A regular tetrahedron"
    yield "extruded_pentagon", extruded_pentagon(), 0, "A prism over a pentagon, semi-sharp at the bottom"
    yield "pipe3", pipe3(), 3, "Three pipes that meet, open at their ends"
    yield "pawn", pawn(), 0, "A chess pawn with semi-sharp creases"
    yield "rook", rook(), 0, "A chess rook with battlements and semi-sharp creases"
    yield "bracket", quad_bracket, 0, "A bracket with two holes: sharp, semi-sharp and smooth edges"
    yield "bracket_tri", quad_bracket.triangulated(), 0, "The bracket in triangles, for Loop"
    yield "knot", quad_knot, 0, "A tube around a torus knot, with UVs"
    yield "knot_tri", quad_knot.triangulated(), 0, "The knot in triangles, for Loop"
    yield "head", head(), 1, "A head with eye sockets, nose, mouth and ears, open at the neck, with UVs"


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "..", "data")
    os.makedirs(folder, exist_ok=True)
    for name, mesh, loops, about in models():
        check(name, mesh, loops)
        text = obj_text(name, mesh, about)
        with open(os.path.join(folder, name + ".obj"), "w", encoding="ascii", newline="\n") as out:
            out.write(text)
        print(f"{name}.obj: {len(mesh.vertices)} vertices, {len(mesh.faces)} faces, {len(mesh.creases)} creases, "
              f"{len(text)} bytes")


if __name__ == "__main__":
    main()
