"""Learned filters: banks of small linear filters, one chosen at each pixel from the local structure."""
