"""Contact sheets and drawings in the plane, with Pillow."""
import math
import sys

from PIL import Image, ImageDraw, ImageFont

INK, GREY, PALE, BLUE, RED, ORANGE = (36, 43, 56), (150, 158, 170), (222, 228, 236), (31, 84, 158), (204, 56, 41), (224, 122, 26)
SAMPLES = 6  # per pixel and axis


def font(size, bold=False):
    return ImageFont.truetype("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf", size)


class Sheet:
    """Pictures in rows, each with its caption, under one title."""

    def __init__(self, title, columns, cell, note=""):
        self.title, self.note, self.columns, self.cell, self.items = title, note, columns, cell, []

    def add(self, picture, caption):
        if all(low == high for low, high in picture.convert("RGB").getextrema()):
            sys.exit(f"figures: {self.title}: the picture of {caption!r} is blank")
        self.items.append((picture, caption))

    def save(self, path):
        margin, head, line = 24, 64 + (26 + 21 * self.note.count("\n") if self.note else 0), 20
        lines = max(caption.count("\n") + 1 for _, caption in self.items)
        width, height = self.cell
        step = height + lines * line + 22
        rows = -(-len(self.items) // self.columns)
        # A narrow sheet still has room for its title.
        room = int(max(font(26, True).getlength(self.title), *(font(16).getlength(text) for text in self.note.split("\n"))))
        sheet = Image.new("RGB", (2 * margin + max(room, self.columns * (width + 12) - 12), head + rows * step + margin), "white")
        draw = ImageDraw.Draw(sheet)
        draw.text((margin, 18), self.title, INK, font(26, True))
        for k, text in enumerate(self.note.split("\n")):
            draw.text((margin, 56 + 21 * k), text, GREY, font(16))
        for i, (picture, caption) in enumerate(self.items):
            x, y = margin + (i % self.columns) * (width + 12), head + (i // self.columns) * step
            sheet.paste(picture.convert("RGB"), (x + (width - picture.width) // 2, y + (height - picture.height) // 2))
            for k, text in enumerate(caption.split("\n")):
                draw.text((x + 4, y + height + 5 + k * line), text, INK if k == 0 else GREY, font(15, k == 0))
        sheet.save(path)


class Plane:
    """A window of the plane as a picture; y points upwards."""

    def __init__(self, size, low, high, background="white"):
        self.size = size
        self.image = Image.new("RGB", (size[0] * SAMPLES, size[1] * SAMPLES), background)
        self.draw = ImageDraw.Draw(self.image)
        self.scale = min(size[0] / (high[0] - low[0]), size[1] / (high[1] - low[1])) * SAMPLES
        self.middle = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)

    def at(self, p):
        """In samples."""
        return (self.image.width / 2 + (p[0] - self.middle[0]) * self.scale,
                self.image.height / 2 - (p[1] - self.middle[1]) * self.scale)

    def pixel(self, p):
        """Where a point is in the finished picture."""
        return tuple(c / SAMPLES for c in self.at(p))

    def polygon(self, points, fill):
        self.draw.polygon([self.at(p) for p in points], fill)

    def line(self, points, colour, width=1.5, closed=False):
        # By polygons: the library's own wide lines are thinner where they are slanted.
        corners = [self.at(p) for p in points]
        r = 0.5 * width * SAMPLES
        for (ax, ay), (bx, by) in zip(corners, corners[1:] + (corners[:1] if closed else [])):
            length = math.hypot(bx - ax, by - ay)
            if length == 0 or max(ax, bx) < -r or min(ax, bx) > self.image.width + r or max(ay, by) < -r or min(ay, by) > self.image.height + r:
                continue
            nx, ny = (ay - by) * r / length, (bx - ax) * r / length
            self.draw.polygon([(ax + nx, ay + ny), (bx + nx, by + ny), (bx - nx, by - ny), (ax - nx, ay - ny)], colour)
            if r > 1:
                self.draw.ellipse((bx - r, by - r, bx + r, by + r), colour)

    def dot(self, p, colour, radius=4):
        x, y = self.at(p)
        r = radius * SAMPLES
        self.draw.ellipse((x - r, y - r, x + r, y + r), colour)

    def ring(self, p, colour, radius, width):
        """A circle's outline; radius and width in pixels."""
        x, y = self.at(p)
        r = radius * SAMPLES
        self.draw.ellipse((x - r, y - r, x + r, y + r), outline=colour, width=width * SAMPLES)

    def text(self, p, text, colour=INK, size=13, offset=(0, 0)):
        """The text's middle is at p, moved by the offset: pixels to the right and downwards."""
        x, y = (c + SAMPLES * d for c, d in zip(self.at(p), offset))
        letters = font(size * SAMPLES)
        box = self.draw.textbbox((x, y), text, letters, anchor="mm")
        self.draw.rectangle((box[0] - SAMPLES, box[1] - SAMPLES, box[2] + SAMPLES, box[3] + SAMPLES), "white")
        self.draw.text((x, y), text, colour, letters, anchor="mm")

    def picture(self):
        return self.image.resize(self.size, Image.LANCZOS)
