"""How much a surface over the plane ripples around a vertex: its heights along circles."""
import cmath
import math

SAMPLES_PER_SECTOR = 16


def heights(points, faces, radius, count):
    """At `count` places of a circle around the origin, of a mesh of triangles that lie beside each other."""
    result = [None] * count
    for f in faces:
        a, b, c = (points[v] for v in f)
        far = max(math.hypot(p[0], p[1]) for p in (a, b, c))
        if far < radius:
            continue
        size = max(math.dist(a[:2], b[:2]), math.dist(b[:2], c[:2]), math.dist(c[:2], a[:2]))
        if far - size > radius:
            continue
        det = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        middle = cmath.phase(complex(a[0] + b[0] + c[0], a[1] + b[1] + c[1])) / (2 * math.pi) * count
        reach = size / radius / (2 * math.pi) * count + 2
        for k in range(math.floor(middle - reach), math.ceil(middle + reach) + 1):
            t = 2 * math.pi * k / count
            x, y = radius * math.cos(t) - a[0], radius * math.sin(t) - a[1]
            u = (x * (c[1] - a[1]) - y * (c[0] - a[0])) / det
            v = ((b[0] - a[0]) * y - (b[1] - a[1]) * x) / det
            if min(u, v, 1 - u - v) >= -1e-9:
                result[k % count] = (1 - u - v) * a[2] + u * b[2] + v * c[2]
    return result


def waves(z):
    """Amplitudes of the waves around the circle, by how many of them there are."""
    n = len(z)
    return [abs(sum(x * cmath.exp(-2j * math.pi * m * k / n) for k, x in enumerate(z))) * (2 if m else 1) / n for m in range(n // 2)]


def short_waves(z, valence):
    """The heights without the waves that are longer than nearly a sector."""
    n = len(z)
    rest = list(z)
    for m in range(valence - 2):
        part = sum(x * cmath.exp(-2j * math.pi * m * k / n) for k, x in enumerate(z)) * (2 if m else 1) / n
        rest = [x - (part * cmath.exp(2j * math.pi * m * k / n)).real for k, x in enumerate(rest)]
    return rest


def ripple(points, faces, valence, radius):
    """The root of the mean square height along a circle of what has as many waves as there are sectors, or nearly, or
    more: nothing that the shape itself has few waves of."""
    amplitude = waves(heights(points, faces, radius, SAMPLES_PER_SECTOR * valence))
    return math.sqrt(sum(a * a for a in amplitude[valence - 2:]) / 2)
