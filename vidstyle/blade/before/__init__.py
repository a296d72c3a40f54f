"""Steps that a bank may have before its filters: blocks that styles cannot name."""
