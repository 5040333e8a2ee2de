"""The encodings, by the kind of panel that they are for; `chrmc.encoding` lists them."""
