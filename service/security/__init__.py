"""Certificates and roles on a secured bus."""
