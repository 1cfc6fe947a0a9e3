"""What stands in for the vehicle: the Leng plant, recorded runs, the player."""
