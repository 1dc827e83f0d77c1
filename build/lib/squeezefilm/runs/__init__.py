"""What keeps runs safe and traceable: whole files, locks, caches, cards."""
