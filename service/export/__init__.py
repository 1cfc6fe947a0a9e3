"""What was learned, for others: one file a tool, as that tool's own documentation has it (`incsvr export`)."""
