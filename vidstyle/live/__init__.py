"""Live restyling: from cameras, screens and streams to pages, virtual cameras, files and streams."""
