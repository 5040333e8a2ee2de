"""Changes to the core files that no test can see, and why (see mutation.py)."""

# file: (how a line begins, the change there or "" for any, why no test can see it)
UNSEEN: dict[str, list[tuple[str, str, str]]] = {
    "chrmc/optics/propagation.py": [
        ("return ceil(2 * sqrt(", "2 → 3", "a wider margin costs time"),
        ("walk = spread(self.wavelength, f_max", "1 → 2", "a wider margin costs time"),
        ("walk = spread(self.wavelength, f_max", "spread(self.wavelength, f_max, self.longest) / p "
         "+ 1 → (spread(self.wavelength, f_max, self.longest) / p - 1)", "a sample of a soft cut"),
        ("padded.append(", "False → True", "another quick length of a transform"),
        ("kz = np.sqrt(np.maximum(w2", "0 → 1", "evanescent waves are cut anyway"),
        ("rise = np.sin(", "2 → 3", "sin³ is as soft an edge"),
        ("low = min(max(low, 0), n - 1)", "0 → 1", "any one sample will do"),
        ("if rows * x.grid", "", "which of two equal products is quicker"),
        ("if self.grid[0] * self.grid[1] >", "self.grid[0] * self.grid[1] > MOST_SAMPLES → "
         "(self.grid[0] * self.grid[1] >= MOST_SAMPLES)", "one grid of one size"),
        ("ramp = (np.arange(min(soft", "0.5 → 1.0", "half a sample along a soft cut"),
        ("ramp = (np.arange(min(soft", "np.arange(min(soft, count)) + 0.5 → "
         "(np.arange(min(soft, count)) - 0.5)", "the same"),
    ],
    "chrmc/encodings/binary.py": [
        ("wanted = np.clip(signal", "0.0 → 1.0", "a scale of 0 has a signal of 0"),
        ("lit = line >= 0.5", "line >= 0.5 → (line > 0.5)", "a dark field's even grey"),
        ("amplitude = np.minimum(", "1.0 → 2.0", "no light over any scale is none"),
    ],
    "chrmc/encodings/phase.py": [
        ("return levels_of(np.angle(field) + apart", "", "the checkerboard's other half"),
        ("amplitude = np.minimum(", "1.0 → 2.0", "no light over any scale is none"),
    ],
    "chrmc/grey_levels.py": [
        ("if coding.carrier == 0", "0 → 1", "the product with a carrier of 1 is the same"),
        ("_BLOCK = ", "", "rows at a time"),
        ("bits: int = 8,", "8 → 9", "frames hold 8 bits"),
        ("if bits < 8", "bits < 8 → (bits <= 8)", "of 256 levels all are allowed"),
    ],
    "chrmc/compensation/ch_rmc_paper/cost.py": [
        ("chosen = random.choice(", "False → True", "which points stand for an object"),
    ],
    "chrmc/compensation/ch_rmc_paper/image_measures.py": [
        ("whole = propagate(field", "-plane → plane", "the transfer function holds the distance"),
        ("high = min(count, ceil(at.max())", "1 → 2", "a dark pixel of a margin of twelve"),
        ("high = min(count, ceil(at.max())", "ceil(at.max()) + MARGIN + 1 → "
         "(ceil(at.max()) + MARGIN - 1)", "two dark pixels of it"),
    ],
    "chrmc/compensation/ch_rmc_paper/error_correction.py": [
        ("width = max(c[:, 0].max()", "1 → 2", "a column that no point falls into"),
    ],
    "chrmc/compensation/ch_rmc_paper/cylinder.py": [
        ("_ROOM = ", "", "a column of padding"),
    ],
    "chrmc/compensation/ch_rmc_object/cost.py": [
        (f"_{name} = ", "", "a weight of a count, as measured: how long, not what")
        for name in ("CHOSEN", "SOME", "KEY", "FEW", "CHOOSE", "FOUND_OUT", "LOOK_UP", "WAVE")
    ] + [
        ("outline = outline_of(body.select(", "1 → 2", "points that stand for an outline"),
        *((f"{kind}=max(fresh.", "0.0 → 1.0", "one of millions")
          for kind in ("products", "bytes", "calls")),
        ("return len(cloud), *np.rint(8", "8 → 9", "how like are alike"),
        ("return len(cloud), *np.rint(8", "1e-9 → 2e-09", "the same"),
        ("return len(cloud), *np.rint(8", "8 * np.log(np.maximum(lengths, 1e-9)) → "
         "(8 / np.log(np.maximum(lengths, 1e-09)))", "the same"),
    ],
    "chrmc/compensation/ch_rmc_object/plan.py": [
        ("k = np.arange(_DIRECTIONS) + 0.5", "0.5 → 1.0", "a half of 200 directions, with room"),
        ("far = size + (centre", "", "what it leaves out the first frame's places add"),
        ("beyond = 4 * ", "4 → 5", "a pixel of room"),
    ],
    "chrmc/compensation/ch_rmc_object/grid.py": [
        ("ceil((high - low) / step) + 2", "1 → 2", "one place of room"),
    ],
    "chrmc/compensation/ch_rmc_object/sums.py": [
        ("_AT_ONCE = ", "", "points at once"),
        ("_FEW = ", "", "the same"),
        ("half = (high - low)", "", "places farther apart, and more of them"),
        ("few = 4 + ceil(", "4 → 5", "a place more than are needed"),
    ],
    "chrmc/compensation/ch_rmc_object/promise.py": [
        ("if total.relative <= _UNSEEN",
         "total.relative <= _UNSEEN * self.tolerance * sqrt(kept) → "
         "(total.relative < _UNSEEN * self.tolerance * sqrt(kept))",
         "measured numbers are not equal"),
    ],
    "chrmc/compensation/ch_rmc_object/video.py": [
        ("later = [n for n in self._numbers", "n > number → (n >= number)", "a frame twice"),
    ],
    "chrmc/compensation/ch_rmc_paper/paper.py": [
        ("extraction = (time", "", "seconds of a stage"),
    ],
    "reconstruct/four_f_system.py": [
        ("rows, columns = (scipy.fft.next_fast_len(2 * n", "", "more dark room beside the light"),
        ("walk = ceil(spread(", "", "what would come round the grid, its transfer function cuts"),
        ("rows, columns = (scipy.fft.next_fast_len(n + 2 * walk", "", "the same"),
        ("passed[:, np.abs(x) >=", "np.abs(x) >= unit * aperture.fx_max → "
         "(np.abs(x) > unit * aperture.fx_max)", "rounding decides on the sample at the edge"),
        ("(np.where(np.arange(g)", "np.arange(g) < (n + g) // 2 → (np.arange(g) <= (n + g) // 2)",
         "a sample in the middle of the dark"),
    ],
    "chrmc/compensation/ch_rmc_object/group.py": [
        ("radians = radians.astype(m.real", "m.real → m.imag", "of one type"),
    ],
    "chrmc/compensation/ch_rmc_object/sphere.py": [
        ("for _ in range(20):", "20 → 21", "Newton's steps past convergence"),
        ("ends = (float(alpha[0]), float(alpha[-1]))", "0 → 1",
         "a series holds one place past its end"),
        ("ends = (float(alpha[0]), float(alpha[-1]))", "1 → 2", "the same"),
        ("if np.max(np.abs(step)) <= _EXACT", "np.max(np.abs(step)) <= _EXACT * self.grid.step[1]"
         " * np.max(r) → (np.max(np.abs(step)) < _EXACT * self.grid.step[1] * np.max(r))",
         "measured numbers are not equal"),
        ("if first < 0 or", "first + rows > grid.count[1] → (first + rows >= grid.count[1])",
         "one place of room"),
        ("slack = 1e-6", "", "rounding has room"),
        ("inside = grid.span[0]", "grid.span[0] - slack <= 1 / r.max() → "
         "(grid.span[0] - slack < 1 / r.max())", "measured numbers are not equal"),
        ("inside = grid.span[0]", "1 / r.min() <= grid.span[1] + slack → "
         "(1 / r.min() < grid.span[1] + slack)", "the same"),
        ("if first < 0 or", "first < 0 → (first <= 0)", "the same"),
        ("if low < 0 or high", "low < 0 → (low <= 0)", "the same"),
        ("if low < 0 or high", "high > grid.count[0] → (high >= grid.count[0])", "the same"),
        ("_EXACT = ", "", "a hundred-millionth of a step"),
        ("if 2 * len(change) <= ", "2 * len(change) <= np.count_nonzero(visible) → "
         "(2 * len(change) < np.count_nonzero(visible))", "which of two equal costs"),
    ],
    "chrmc/cgh/curved/__init__.py": [
        ("if work <= SMALL", "work <= SMALL → (work < SMALL)", "one amount of work of millions"),
        ("if work <= BEARABLE", "work <= BEARABLE → (work < BEARABLE)", "the same"),
        ("if not pay and work > QUICK", "work > QUICK → (work >= QUICK)", "the same"),
    ],
    "chrmc/cgh/curved/baseband.py": [
        ("_QUICK = ", "", "when one way gives place to another: how long, not what"),
        ("_MOST_LEAVES = ", "", "the same"),
        ("_SAMPLES = ", "", "the same"),
        ("_MOST_TERMS, _FEW = ", "", "the same"),
        ("max(20_000, _SAMPLES", "20_000 → 40000", "the same"),
        ("tables = Tables() if len(cloud) <= MOST", "", "whether tables are made beforehand"),
    ],
    "chrmc/cgh/curved/edge.py": [
        ("model = models[0]", "0 → 1", "they differ in what is not separable, which is not asked"),
    ],
    "chrmc/cgh/curved/cost.py": [
        ("products = bytes_ = 0.0", "0.0 → 1.0", "one of billions"),
    ],
    "chrmc/cgh/curved/direct.py": [
        (begins, "", "how much is worked out at once")
        for begins in (
            "_BLOCK = ", "_PIECES = ", "_TABLES = ", "columns = len(u) if",
            "rows = max(1, min(", "step = max(1, _", "held = max(1, _TABLES",
            "points = min(len(cloud)", "if len(x) < len(y):",
        )
    ],
    "chrmc/cgh/curved/tables.py": [
        ("_BLOCK = ", "", "how much is worked out at once"),
        ("MOST_AT_ONCE = ", "", "the same"),
        ("step = max(1, _BLOCK", "", "the same"),
        ("cuts = np.linspace(0, ny", "", "the same"),
        ("out = np.empty((", "2 → 3", "room that is left"),
        ("out = np.empty((", "3 → 4", "the same"),
        ("pieces.insert(1", "1 → 2", "in which order"),
    ],
    "chrmc/cgh/curved/predict.py": [
        ("_POINTS = ", "", "how many are tried"),
        ("_OTHERS = ", "", "the same"),
        ("_TARGETS = ", "", "the same"),
        ("at_least = 120", "120 → 240", "the same"),
        ("rest = np.linspace(0, count - 1", "0 → 1", "the same"),
        ("rest = np.linspace(0, count - 1", "1 → 2", "the same"),
        ("return budget.relative <= error_allowed(", "budget.relative <= error_allowed(factors, "
         "tolerance, points) → (budget.relative < error_allowed(factors, tolerance, points))",
         "measured numbers are not equal"),
    ],
    "chrmc/cgh/curved/verify.py": [
        ("_LINES = ", "", "how many lines are drawn"),
        ("_FEW_LINES = ", "", "the same"),
        ("(np.unique(np.linspace(0, n - 1, min(n, 160))", "160 → 320", "the same"),
        ("random = np.random.default_rng(0)", "0 → 1", "another draw"),
    ],
    "chrmc/compensation/ch_rmc_object/transforms.py": [
        ("ends = (float(alpha[0]), float(alpha[-1]))", change,
         "a series holds one place past its end")
        for change in ("0 → 1", "1 → 2")
    ],
    "chrmc/cgh/curved/series.py": [
        ("counts.append(1)", "1 → 2", "a sample more of what does not change"),
        ("MOST_SAMPLES = ", "", "when one way gives place to another: how long, not what"),
        ("counts.append(1 + node_count(1.15", "1.15 → 2.3", "more samples cost time"),
    ],
    "reconstruct/focus.py": [
        ("seen = np.isfinite(tile_depth)", "tile_light >= DARK * tile_light.max() → "
         "(tile_light > DARK * tile_light.max())", "measured numbers are not equal"),
        ("if not np.isfinite(depth) or rise", "rise * sqrt(grains) < PROMINENCE → "
         "(rise * sqrt(grains) <= PROMINENCE)", "measured numbers are not equal"),
        ("floor = ", "", "keeps 0/0 away"),
        ("rise = float(curve.max())", "1e-300 → 2e-300", "the same"),
    ],
}  # fmt: skip
