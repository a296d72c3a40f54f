"""Learned filters: banks of small linear filters, one is selected for each pixel by the local structure."""
