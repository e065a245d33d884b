"""Which datagrams of the server have arrived and when: what Feedback says."""
from collections import deque

from datagrams import MOST_AGES, age

EVERY_US = 10_000
AT_ONCE = 64
TIMES = 3


class Arrivals:
    def __init__(self):
        self.at = {}  # microseconds, by sequence number
        self.newest = 0
        self.since_last = 0
        self.last_us = None
        self.told = deque([0] * TIMES, maxlen=TIMES)  # the newest at the last Feedbacks

    def note(self, sequence, time_us):
        self.at[sequence] = time_us
        self.newest = max(self.newest, sequence)
        self.since_last += 1

    def due(self, now_us):
        if not self.since_last:
            return False
        return self.since_last >= AT_ONCE or self.last_us is None or now_us - self.last_us >= EVERY_US

    def report(self, now_us):
        """First sequence number and ages."""
        first = max(self.told[0] + 1, self.newest - MOST_AGES + 1)
        ages = [age(self.at.get(s), now_us) for s in range(first, self.newest + 1)]
        self.at = {s: at for s, at in self.at.items() if s >= first}
        self.told.append(self.newest)
        self.since_last, self.last_us = 0, now_us
        return first, ages
