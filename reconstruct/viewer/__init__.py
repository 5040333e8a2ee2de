"""The viewer: `model` knows optics and no GUI, `window` draws it and passes hands on."""
