"""The 11 Archimedean tilings, from their vertices in one cell and the two translations; edges have length one. Their
duals are the Laves tilings."""
import cmath
import math

R3, R7 = math.sqrt(3), math.sqrt(7)


def turned(count, first, radius, centre=0):
    return [centre + cmath.rect(radius, math.radians(first + 360 / count * i)) for i in range(count)]


def hexagonal(period):
    return period, period * cmath.rect(1, math.pi / 3)


def cells():
    """Name, tiles of a vertex: translations and vertices."""
    p12, p488 = 2 + R3, 1 + math.sqrt(2)
    a, b = hexagonal(p12)
    b12 = (a + b) / 3
    snub = 2 * math.cos(math.pi / 12)
    e1, e2 = 1, cmath.rect(1, math.pi / 3)
    return {
        "3^6": (*hexagonal(1), [0]),
        "4^4": (1, 1j, [0]),
        "6^3": (complex(R3, 0), complex(R3 / 2, 1.5), [0, 1j]),
        "3.6.3.6": (*hexagonal(2), [0, 1, e2]),
        "4.8^2": (p488, 1j * p488, turned(4, 0, math.sqrt(0.5))),
        "3.12^2": (a, b, turned(3, 30, 1 / R3) + turned(3, 210, 1 / R3, b12)),
        "4.6.12": (*hexagonal(3 + R3), turned(12, 15, 0.5 / math.sin(math.pi / 12))),
        "3.4.6.4": (*hexagonal(1 + R3), turned(6, 30, 1)),
        "3^3.4^2": (1, complex(0.5, 1 + R3 / 2), [0, 1j]),
        "3^2.4.3.4": (snub, 1j * snub, turned(4, 60, math.sqrt(0.5))),
        "3^4.6": (2 * e1 + e2, 3 * e2 - e1, turned(6, 0, 1)),
    }


def tiling(name, reach):
    """Vertices (complex numbers) and faces, counter-clockwise, within a distance of the origin."""
    t1, t2, seeds = cells()[name]
    span = int(reach / min(abs(t1), abs(t2)) * 2) + 4
    points = [s + i * t1 + j * t2 for i in range(-span, span + 1) for j in range(-span, span + 1) for s in seeds]
    points = [p for p in points if abs(p) < reach + 3]
    boxes = {}
    for i, p in enumerate(points):
        boxes.setdefault((math.floor(p.real), math.floor(p.imag)), []).append(i)
    ring = []
    for p in points:
        x, y = math.floor(p.real), math.floor(p.imag)
        near = [j for dx in (-2, -1, 0, 1, 2) for dy in (-2, -1, 0, 1, 2) for j in boxes.get((x + dx, y + dy), [])
                if abs(abs(points[j] - p) - 1) < 1e-6]
        ring.append(sorted(near, key=lambda j: cmath.phase(points[j] - p)))
    faces, seen = [], set()
    for i in range(len(points)):
        for j in ring[i]:
            face, a, b = [], i, j
            while (a, b) not in seen:
                seen.add((a, b))
                face.append(a)
                # The next edge of the face on the left: the one before the way back, counter-clockwise.
                back = ring[b].index(a)
                a, b = b, ring[b][back - 1]
            centre = sum(points[v] for v in face) / len(face) if face else 0
            if 3 <= len(face) <= 12 and abs(centre) < reach and all(abs(points[v]) < reach + 2.5 for v in face):
                faces.append(face)
    return points, faces


def dual(points, faces):
    """The tiling whose vertices are the tiles' centres."""
    centres = [sum(points[v] for v in f) / len(f) for f in faces]
    around = {}
    for i, face in enumerate(faces):
        for v in face:
            around.setdefault(v, []).append(i)
    result = []
    for v, tiles in around.items():
        # A whole turn of tiles.
        angles = sum(math.pi - 2 * math.pi / len(faces[i]) for i in tiles)
        if abs(angles - 2 * math.pi) < 1e-6:
            result.append(sorted(tiles, key=lambda i: cmath.phase(centres[i] - points[v])))
    return centres, result
