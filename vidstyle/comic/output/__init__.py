"""Output of comics: restyled panels, page files, and PNG, JPEG, PDF, CBZ, SVG and HTML."""
