"""Matplotlib's figures and pictures of pixels as elements of a page."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..page_charts import as_element
from ..plots.style import as_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_element(figure: Figure, name: str, words: str) -> str:
    """Return a figure as an SVG element; `name` is that of no other on the page."""
    drawn = as_element(as_svg(figure, name))
    return drawn.replace("<svg", f'<svg role="img" aria-label="{html.escape(words)}"', 1)


def picture_element(pixels: NDArray[np.uint8], words: str) -> str:
    """Return a picture, (height, width, 3) in red, green and blue, as an image in the page."""
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "png", optimize=True)
    data = base64.b64encode(file.getvalue()).decode()
    height, width, _ = pixels.shape
    size = f'width="{width}" height="{height}"'
    return f'<img src="data:image/png;base64,{data}" alt="{html.escape(words)}" {size}>'
