"""Draws hall.dxf, the picking hall, as a drawing office would leave it: in millimetres, by layer.

python draw.py
"""

from pathlib import Path

import ezdxf
from ezdxf import units

FILE = Path(__file__).with_name("hall.dxf")
LAYERS = ("A-WALL", "A-BNDY", "S-COLS", "STOR-RACK", "EQPM-BENCH", "A-TEXT")
RACKS = range(10)
"""Double racks, 26 m long, with aisles of 3 m between them."""


def rectangle(space, layer, x0, y0, x1, y1):
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})


def main():
    ezdxf.options.write_fixed_meta_data_for_testing = True  # the same bytes every time
    drawing = ezdxf.new("R2000", setup=False)
    drawing.units = units.MM
    for layer in LAYERS:
        drawing.layers.add(layer)
    space = drawing.modelspace()
    rectangle(space, "A-BNDY", 0, 0, 64_000, 40_000)
    rectangle(space, "A-WALL", 0, 0, 64_000, 300)
    rectangle(space, "A-WALL", 0, 39_700, 64_000, 40_000)
    for y0, y1 in ((300, 16_000), (20_000, 39_700)):
        rectangle(space, "A-WALL", 0, y0, 300, y1)
    rectangle(space, "A-WALL", 63_700, 300, 64_000, 39_700)
    rack = drawing.blocks.new("RACK")
    rectangle(rack, "0", 0, 0, 2_400, 26_000)
    for k in RACKS:
        at = (10_000 + 5_400 * k, 7_000)
        space.add_blockref("RACK", at, dxfattribs={"layer": "STOR-RACK"})
        space.add_text(f"R{k + 1}", height=500, dxfattribs={"layer": "A-TEXT", "insert": at})
    for k in range(6):
        rectangle(space, "EQPM-BENCH", 1_500, 5_000 + 5_000 * k, 3_000, 7_500 + 5_000 * k)
    for x in (22_900, 44_500):
        for y in (3_500, 36_500):
            space.add_circle((x, y), 300, dxfattribs={"layer": "S-COLS"})
    drawing.saveas(FILE)


if __name__ == "__main__":
    main()
