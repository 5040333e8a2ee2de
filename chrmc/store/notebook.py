"""What notebooks show of a video and a field: a table and a picture; and the records as a table."""

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from chrmc.slm import SLM

if TYPE_CHECKING:
    import pandas

    from chrmc.store.video import Video

WIDTH = 480
"""Pixels on a page that a picture takes; the picture itself keeps all of its own."""


@dataclass(frozen=True, eq=False, repr=False)
class FieldView:
    """A field as notebooks show it, see `show_field`.

    field : (H, W) complex or real
    slm : the panel it lies on, or None
    """

    field: NDArray[Any]
    slm: SLM | None = None

    def __repr__(self) -> str:
        rows, columns = self.field.shape
        return f"FieldView({columns} × {rows}, {self.field.dtype}, rms {_rms(self.field):.4g})"

    def _repr_html_(self) -> str:
        rows, columns = self.field.shape
        told = {"pixels": f"{columns} × {rows}", "type": str(self.field.dtype)}
        if self.slm is not None:
            width, height = columns * self.slm.pixel_pitch, rows * self.slm.pixel_pitch
            told["size"] = f"{1e3 * width:.4g} × {1e3 * height:.4g} mm"
        told["rms"] = f"{_rms(self.field):.4g}"
        if not np.iscomplexobj(self.field):
            return _page(told, {"values": _png(self.field)})
        modulus = np.abs(self.field)
        pictures = {
            "amplitude": _png(modulus, 0, float(modulus.max()) or 1.0),
            "phase, −π to π": _png(np.angle(self.field), -np.pi, np.pi, "twilight"),
        }
        return _page(told, pictures)


def show_field(field: NDArray[Any], slm: SLM | None = None) -> FieldView:
    """A field for a notebook: its size, amplitude and phase; grey levels or an image as they are.

    field : (H, W), complex or real
    slm : adds the size in millimetres
    """
    array = np.asarray(field)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "fiubc":
        raise ValueError(f"a field is (H, W) numbers, not {array.dtype} {array.shape}")
    return FieldView(array, slm)


def video_html(video: "Video") -> str:
    """A stored video: what it is, and its first frame."""
    from chrmc.python_file import label
    from chrmc.store.video import ranges

    slm, methods = video.slm, video.methods
    told = {
        "folder": str(video.folder),
        "scene": str(video.scene.get("name", "")),
        "frames": ranges(video.numbers) or "none yet",
        "panel": f"{slm.name}, {slm.width} × {slm.height}, {1e6 * slm.pixel_pitch:.4g} µm",
        "wavelength": f"{1e9 * video.wavelength:.5g} nm",
        "methods": f"{label(methods.get('cgh'))}, {label(methods.get('compensation'))}",
        "encoding": video.encoding,
    }
    errors = [e for f in video.frames if (e := f.get("error_reference")) is not None]
    if errors:
        told["field error"] = f"median {np.median(errors):.1e}, worst {max(errors):.1e}"
    pictures = {}
    if video.frames:
        number = video.numbers[0]
        try:
            pictures[f"frame {number}"] = _png(video.read(number), 0, 255)
        except (OSError, ValueError) as error:
            told["picture"] = str(error)
    return _page(told, pictures)


def dataframe(video: "Video") -> "pandas.DataFrame":
    """One row per frame, indexed by its number; see `Video.to_dataframe`."""
    try:
        import pandas
    except ImportError:
        raise ImportError("to_dataframe needs pandas: pip install pandas") from None
    rows = []
    for entry in video.frames:
        row = {k: v for k, v in entry.items() if not isinstance(v, dict | list)}
        row |= {f"seconds {k}": v for k, v in entry.get("stage_seconds", {}).items()}
        row |= {f"depth {o['name']}": o.get("depth") for o in entry.get("objects", [])}
        rows.append(row)
    return pandas.DataFrame(rows, index=None if rows else []).set_index("number")


def _page(told: Mapping[str, str], pictures: Mapping[str, bytes]) -> str:
    lines = "".join(
        f'<tr><th style="text-align:left">{escape(k)}</th>'
        f'<td style="text-align:left">{escape(v)}</td></tr>'
        for k, v in told.items()
    )
    shown = "".join(
        f'<figure style="display:inline-block;margin:4px"><img width="{WIDTH}" alt="{escape(k)}" '
        f'src="data:image/png;base64,{b64encode(v).decode()}"/>'
        f"<figcaption>{escape(k)}</figcaption></figure>"
        for k, v in pictures.items()
    )
    return f"<table>{lines}</table><div>{shown}</div>"


def _png(
    values: NDArray[Any], low: float | None = None, high: float | None = None, colours: str = "gray"
) -> bytes:
    from matplotlib.image import imsave

    memory = BytesIO()
    imsave(memory, values.astype(np.float32), vmin=low, vmax=high, cmap=colours, format="png")
    return memory.getvalue()


def _rms(field: NDArray[Any]) -> float:
    return float(np.sqrt(np.mean(np.abs(field.astype(np.complex128)) ** 2)))
