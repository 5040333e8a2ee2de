"""Zoom and pan of a picture in a rectangle of the screen, without any GUI."""

from dataclasses import dataclass

Rectangle = tuple[float, float, float, float]
"""Left, top, width, height."""
MIN_ZOOM_SHARE = 0.5  # of the zoom that fits the picture
MAX_ZOOM = 64.0


@dataclass
class View:
    """What part of a picture a screen rectangle shows.

    width, height : of the picture, pixels
    screen_width, screen_height : of the rectangle, screen pixels
    zoom : screen pixels per picture pixel; None shows all of it
    x, y : picture pixel in the rectangle's middle; pixel (0, 0) covers 0 … 1
    """

    width: int
    height: int
    screen_width: float = 1.0
    screen_height: float = 1.0
    zoom: float | None = None
    x: float = 0.0
    y: float = 0.0

    def __post_init__(self) -> None:
        self.x, self.y = self.width / 2, self.height / 2

    @property
    def fitting(self) -> float:
        """The zoom that just shows everything."""
        return min(self.screen_width / self.width, self.screen_height / self.height)

    @property
    def scale(self) -> float:
        """The zoom in use."""
        return self.fitting if self.zoom is None else self.zoom

    def resize(self, screen_width: float, screen_height: float) -> None:
        """The rectangle has another size now."""
        self.screen_width, self.screen_height = max(screen_width, 1.0), max(screen_height, 1.0)

    def to_picture(self, sx: float, sy: float) -> tuple[float, float]:
        """Picture coordinates of a point of the rectangle, (0, 0) its upper left corner."""
        return (
            self.x + (sx - self.screen_width / 2) / self.scale,
            self.y + (sy - self.screen_height / 2) / self.scale,
        )

    def to_screen(self, px: float, py: float) -> tuple[float, float]:
        """Where a point of the picture is shown."""
        return (
            (px - self.x) * self.scale + self.screen_width / 2,
            (py - self.y) * self.scale + self.screen_height / 2,
        )

    def pixel_at(self, sx: float, sy: float) -> tuple[int, int] | None:
        """(row, column) under a point of the rectangle, or None beside the picture."""
        px, py = self.to_picture(sx, sy)
        if 0 <= px < self.width and 0 <= py < self.height:
            return int(py), int(px)
        return None

    def zoom_at(self, sx: float, sy: float, factor: float) -> None:
        """Zoom by a factor; what is under the point stays under it."""
        px, py = self.to_picture(sx, sy)
        wanted = self.scale * factor
        if wanted <= self.fitting and factor < 1:
            self.fit()
            return
        self.zoom = min(max(wanted, self.fitting * MIN_ZOOM_SHARE), MAX_ZOOM)
        self.x = px - (sx - self.screen_width / 2) / self.zoom
        self.y = py - (sy - self.screen_height / 2) / self.zoom
        self._keep_inside()

    def pan(self, dx: float, dy: float) -> None:
        """Move the picture by so many screen pixels."""
        self.zoom = self.scale
        self.x -= dx / self.zoom
        self.y -= dy / self.zoom
        self._keep_inside()

    def show(self, px: float, py: float, zoom: float) -> None:
        """Centre on a point of the picture at a zoom."""
        self.zoom, self.x, self.y = min(zoom, MAX_ZOOM), px, py
        self._keep_inside()

    def fit(self) -> None:
        """Show everything."""
        self.zoom, self.x, self.y = None, self.width / 2, self.height / 2

    def _keep_inside(self) -> None:
        self.x = min(max(self.x, 0.0), float(self.width))
        self.y = min(max(self.y, 0.0), float(self.height))
