"""Which arms of a fleet change: histories against their own baselines, without what temperature and load explain.

``history`` reads the data set, ``conditions`` explains temperature and load away, ``threshold`` is what chance reaches, ``alarms``
finds the changes and their causes, ``forecast`` continues a trend, and ``page`` and ``session`` show it all.
"""
