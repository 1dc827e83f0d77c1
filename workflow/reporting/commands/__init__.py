"""What people do with a finished study: figures, the recommended model, the check."""
