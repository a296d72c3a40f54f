"""Previews of styles: a picture in every style, on a page or a sheet."""
