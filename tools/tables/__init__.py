"""Makes the tables that blocks come with."""
