"""What pictures and pages show of a run, beside its samples."""
