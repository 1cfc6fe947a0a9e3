"""The learned model in the forms of other tools, by each tool's own documentation (`incsvr export`)."""
