"""Zenoh: sessions, endpoints, clients, what comes in and what goes out."""
