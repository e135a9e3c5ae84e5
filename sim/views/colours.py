"""The colours of pictures and charts: those that people with colour blindness can distinguish."""

# M. Okabe and K. Ito, "Color universal design", 2008.
BLUE = "#0072b2"
ORANGE = "#e69f00"
VERMILION = "#d55e00"
GREEN = "#009e73"
PURPLE = "#cc79a7"
SKY = "#56b4e9"

# Beside them, for what is not told apart by its colour.
BLACK = "#222222"
GREY = "#8a8a8a"
PALE = "#d9d9d9"
PALE_ORANGE = "#fbe6bd"
BROWN = "#8a6d3b"
