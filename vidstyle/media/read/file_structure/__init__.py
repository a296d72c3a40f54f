"""The structure of media files, read from their bytes: headers, tables and parts."""
