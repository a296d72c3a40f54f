"""Previews of styles: one picture in several styles, as a page or a sheet."""
