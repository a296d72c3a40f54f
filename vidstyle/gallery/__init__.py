"""What styles make of somebody's own picture: on a page, on a sheet, and step by step."""
