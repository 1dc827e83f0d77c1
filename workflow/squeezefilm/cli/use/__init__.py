"""Commands for one force, one model, one study of your own."""
