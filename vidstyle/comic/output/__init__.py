"""Pages to files: draw the panels, assemble the sheets, encode PNG, PDF, CBZ, SVG or HTML."""
