"""Repeated measurements: their median and range, and whether two of them differ by more than they spread."""
import statistics


class Spread:
    """Of the values of one figure over its repeats."""

    def __init__(self, values):
        self.values = sorted(values)
        self.median = statistics.median(self.values)
        self.low, self.high = self.values[0], self.values[-1]

    @property
    def range(self):
        return self.high - self.low

    def text(self, digits=0):
        """`12 (11 to 14)`; the median alone where there is nothing to tell apart."""
        said = [f"{value:,.{digits}f}" for value in (self.median, self.low, self.high)]
        return said[0] if len(self.values) == 1 or said[1] == said[2] else f"{said[0]} ({said[1]} to {said[2]})"


def differ(a, b):
    """Whether between the two ranges lies more than both of them together: of two sets of three from the same normal
    distribution 3 in 1,000 do. Never with fewer than three repeats."""
    if min(len(a.values), len(b.values)) < 3:
        return False
    return max(a.low - b.high, b.low - a.high) > a.range + b.range


def by(rows, column, *keys):
    """Keys -> Spread of the column over the rows that have them."""
    groups = {}
    for row in rows:
        if isinstance(row.get(column), (int, float)):
            groups.setdefault(tuple(row[key] for key in keys), []).append(row[column])
    return {key: Spread(values) for key, values in groups.items()}
