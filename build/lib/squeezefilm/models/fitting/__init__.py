"""Parameters from forces: searches, and what the forces say of them."""
