"""The graph of a style, as text and as SVG."""
