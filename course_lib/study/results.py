"""What a study found: a tidy table, curves, and what the seeds of each setting say together."""

import numpy as np

from course_lib.study.plan import as_text, labels_of, plain
from course_lib.study.statistics import band, bootstrap, interquartile_mean


class Results:
    """The measures and curves of S settings with n seeds each.

    settings   list of S dictionaries;  labels: list of S texts, what each has different from the others
    seeds      int64[n]
    measures   {name: float64[S, n]}
    curves     {name: {label: float64[n, N]}}, as `plots.learning_curves` takes them
    table      a pandas DataFrame, a row a setting and seed: the settings' columns, `seed`, the measures
    """

    def __init__(self, settings, seeds, cells, arrays):
        self.settings, self.labels, self.seeds = settings, labels_of(settings), np.array(seeds, np.int64)
        parts = [[] for _ in settings]
        for cell, part in zip(cells, arrays, strict=True):
            parts[cell.setting].append(part)
        whole = [{name: np.concatenate([part[name] for part in own]) for name in own[0]} for own in parts]
        numbers = [name for name, array in whole[0].items() if array.ndim == 1]
        self.measures = {name: np.array([own[name] for own in whole]) for name in numbers}
        self.curves = {
            name: {label: own[name] for label, own in zip(self.labels, whole, strict=True)}
            for name in whole[0]
            if name not in numbers
        }

    def __repr__(self):
        names = ", ".join([*self.measures, *self.curves])
        return f"Results: {len(self.settings)} settings × {len(self.seeds)} seeds: {names}"

    @property
    def table(self):
        """The tidy table, made anew at each look; a setting that is itself a list or a dictionary stands as text."""
        import pandas as pd

        rows = self._columns().loc[np.repeat(np.arange(len(self.settings)), len(self.seeds))].reset_index(drop=True)
        rows["seed"] = np.tile(self.seeds, len(self.settings))
        return pd.concat([rows, pd.DataFrame({name: array.ravel() for name, array in self.measures.items()})], axis=1)

    def scores(self, measure, **settings):
        """float64[n], that measure of the one setting that has these values; `ValueError` for none, or several."""
        array, wanted = self._measure(measure), {name: as_text(plain(name, value)) for name, value in settings.items()}
        which = [
            i
            for i, chosen in enumerate(self.settings)
            if all(name in chosen and as_text(chosen[name]) == text for name, text in wanted.items())
        ]
        if len(which) != 1:
            there = " or ".join(self.labels[:6]) + (" …" if len(self.labels) > 6 else "")
            raise ValueError(f"{settings} must be one setting, and is {len(which)}; there are: {there}")
        return array[which[0]]

    def summary(self, measure=None, *, statistic=interquartile_mean, confidence=0.95, resamples=2000, seed=0):
        """A tidy DataFrame, a row a setting and measure: settings, measure, n, iqm, low, high (see `bootstrap`).

        measure   the one to summarise; None: all, with a column that names them
        statistic of another name has a column of that name in place of `iqm`. With one seed there is no interval, and
        low and high are NaN. `ValueError` for an unknown measure, for one with NaN or infinity, and for a setting
        that is called like another column.
        """
        import pandas as pd

        name = "iqm" if statistic is interquartile_mean else statistic.__name__
        columns = ["n", name, "low", "high"] + ["measure"] * (measure is None)
        taken = [column for column in columns if any(column in chosen for chosen in self.settings)]
        if taken:
            raise ValueError(f"a summary has columns of its own called {', '.join(taken)}: rename those settings")
        tables = []
        for each in list(self.measures) if measure is None else [measure]:
            rows = self._columns()
            if measure is None:
                rows["measure"] = each
            estimates = [
                self._estimate(each, label, scores, statistic, confidence=confidence, resamples=resamples, seed=seed)
                for label, scores in zip(self.labels, self._measure(each), strict=True)
            ]
            found = pd.DataFrame(estimates, columns=[name, "low", "high"])
            tables.append(pd.concat([rows.assign(n=len(self.seeds)), found], axis=1))
        return pd.concat(tables, ignore_index=True) if tables else self._columns()

    def bands(self, curve, *, statistic=interquartile_mean, confidence=0.95, resamples=1000, seed=0):
        """{label: `Estimate` of float64[N]}: the curve's interquartile mean and its interval, point by point.

        For `plots.bands`. `ValueError` for a curve that there is not, and for fewer than 2 seeds.
        """
        if curve not in self.curves:
            raise ValueError(f"there is no curve {curve!r}; there are: {', '.join(self.curves) or 'none'}")
        how = {"confidence": confidence, "resamples": resamples, "seed": seed}
        return {label: band(runs, statistic, **how) for label, runs in self.curves[curve].items()}

    def _estimate(self, measure, label, scores, statistic, **how):
        try:
            if len(scores) > 1:
                return tuple(bootstrap(scores, statistic, **how))
            return (statistic(scores), np.nan, np.nan)
        except ValueError as error:
            raise ValueError(f"{measure} of {label}: {error}") from None

    def _measure(self, name):
        if name not in self.measures:
            raise ValueError(f"there is no measure {name!r}; there are: {', '.join(self.measures) or 'none'}")
        return self.measures[name]

    def _columns(self):
        """The settings as a table, a row each."""
        import pandas as pd

        rows = [
            {name: as_text(value) if isinstance(value, list | dict) else value for name, value in chosen.items()}
            for chosen in self.settings
        ]
        return pd.DataFrame(rows, index=range(len(rows)))
